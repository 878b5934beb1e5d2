//! From the planes of a film to the packed formats core reads.

use tetrad_core::vision::frame::PixelFormat;

use super::header::{Chroma, Header};

/// Turns Y, U and V planes, one after the other, into one packed picture.
pub(super) struct Repack {
    chroma: Chroma,
    luma_bytes: usize,
    /// Bytes of one chroma plane.
    chroma_bytes: usize,
    /// For films of full range, what each luma and each chroma sample becomes in the limited range
    /// that core reads.
    to_limited: Option<Box<([u8; 256], [u8; 256])>>,
}

impl Repack {
    pub(super) fn new(header: &Header) -> Self {
        let luma_bytes = usize::from(header.width) * usize::from(header.height);
        let chroma_bytes = match header.chroma {
            Chroma::Quarter => luma_bytes / 4,
            Chroma::Half => luma_bytes / 2,
            Chroma::Full => luma_bytes,
        };
        let to_limited = header.full_range.then(|| {
            Box::new((
                // Rounded; 219 and 224 steps are BT.601's.
                std::array::from_fn(|y| (16 + (y * 219 + 127) / 255) as u8),
                std::array::from_fn(|c| (128.0 + (c as f64 - 128.0) * 224.0 / 255.0).round() as u8),
            ))
        });
        Self { chroma: header.chroma, luma_bytes, chroma_bytes, to_limited }
    }

    pub(super) const fn format(&self) -> PixelFormat {
        match self.chroma {
            Chroma::Quarter => PixelFormat::Nv12,
            Chroma::Half => PixelFormat::Yuyv,
            Chroma::Full => PixelFormat::Rgb888,
        }
    }

    /// Bytes of a frame in the film.
    pub(super) const fn plane_bytes(&self) -> usize {
        self.luma_bytes + 2 * self.chroma_bytes
    }

    /// Bytes of a packed picture: the same samples, in another order.
    pub(super) const fn picture_bytes(&self) -> usize {
        self.plane_bytes()
    }

    /// Packs `planes` into `picture`, whose lengths are those given above. The planes are left in
    /// limited range.
    pub(super) fn run(&self, planes: &mut [u8], picture: &mut [u8]) {
        let (luma, chroma) = planes.split_at_mut(self.luma_bytes);
        if let Some(tables) = &self.to_limited {
            luma.iter_mut().for_each(|sample| *sample = tables.0[usize::from(*sample)]);
            chroma.iter_mut().for_each(|sample| *sample = tables.1[usize::from(*sample)]);
        }
        let (u, v) = chroma.split_at(self.chroma_bytes);
        match self.chroma {
            Chroma::Quarter => {
                let (y_out, uv_out) = picture.split_at_mut(self.luma_bytes);
                y_out.copy_from_slice(luma);
                for ((out, u), v) in uv_out.chunks_exact_mut(2).zip(u).zip(v) {
                    out.copy_from_slice(&[*u, *v]);
                }
            }
            Chroma::Half => {
                let pairs = luma.chunks_exact(2);
                for (((out, y), u), v) in picture.chunks_exact_mut(4).zip(pairs).zip(u).zip(v) {
                    out.copy_from_slice(&[y[0], *u, y[1], *v]);
                }
            }
            Chroma::Full => {
                for (((out, y), u), v) in picture.chunks_exact_mut(3).zip(&*luma).zip(u).zip(v) {
                    out.copy_from_slice(&rgb(*y, *u, *v));
                }
            }
        }
    }
}

/// The conversion core uses for its YUV formats (BT.601, limited range, 8.8 fixed point), so that a
/// film gives the same colours whatever its sampling.
fn rgb(y: u8, u: u8, v: u8) -> [u8; 3] {
    let c = 298 * (i32::from(y) - 16);
    let d = i32::from(u) - 128;
    let e = i32::from(v) - 128;
    [c + 409 * e, c - 100 * d - 208 * e, c + 516 * d].map(|sum| ((sum + 128) >> 8).clamp(0, 255) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::vision::frame::{FrameView, Rgb};

    #[test]
    fn colours_are_those_core_computes() {
        for y in (0..=255).step_by(5) {
            for u in (0..=255).step_by(15) {
                for v in (0..=255).step_by(15) {
                    let [r, g, b] = rgb(y, u, v);
                    let pixels = [y, u, y, v];
                    let view = FrameView::packed(&pixels, 2, 1, PixelFormat::Yuyv).unwrap();
                    assert_eq!(view.pixel(0, 0), Some(Rgb { r, g, b }), "{y} {u} {v}");
                }
            }
        }
    }

    #[test]
    fn full_range_is_squeezed_into_limited_range() {
        let header = Header { width: 2, height: 1, fps: None, chroma: Chroma::Full, full_range: true };
        let repack = Repack::new(&header);
        let mut planes = [0, 255, 128, 0, 128, 255];
        let mut picture = [0; 6];
        repack.run(&mut planes, &mut picture);
        assert_eq!(planes, [16, 235, 128, 16, 128, 240]);
    }
}
