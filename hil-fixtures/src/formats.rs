//! A rendered picture as a camera would send it.

use tetrad_core::vision::frame::PixelFormat;

/// Converts packed rows of RGB888 to packed rows of another format. YUV formats are BT.601, limited
/// range, the inverse of what `tetrad-core` decodes; pixels that share chroma share the mean of their
/// colours' chroma.
///
/// # Panics
/// When `rgb` is not `width` x `height` pixels, or the format needs even sides and has odd ones.
#[must_use]
pub fn to_format(rgb: &[u8], width: u16, height: u16, format: PixelFormat) -> Vec<u8> {
    let (width, height) = (usize::from(width), usize::from(height));
    assert_eq!(rgb.len(), width * height * 3, "the picture is not {width} x {height} pixels of RGB888");
    let pixels = || rgb.as_chunks::<3>().0.iter().copied();
    let pairs = || {
        assert!(width.is_multiple_of(2), "{format:?} needs an even width, not {width}");
        rgb.as_chunks::<6>().0.iter().map(|&[r, g, b, s, h, c]| {
            let (p, q) = ([r, g, b], [s, h, c]);
            let (u, v) = chroma(&[p, q]);
            (luma(p), luma(q), u, v)
        })
    };
    match format {
        PixelFormat::Rgb888 => rgb.to_vec(),
        PixelFormat::Bgr888 => pixels().flat_map(|[r, g, b]| [b, g, r]).collect(),
        PixelFormat::Rgba8888 => pixels().flat_map(|[r, g, b]| [r, g, b, 255]).collect(),
        PixelFormat::Rgb565Le => pixels().flat_map(|p| to_565(p).to_le_bytes()).collect(),
        PixelFormat::Rgb565Be => pixels().flat_map(|p| to_565(p).to_be_bytes()).collect(),
        PixelFormat::Yuyv => pairs().flat_map(|(a, b, u, v)| [a, u, b, v]).collect(),
        PixelFormat::Uyvy => pairs().flat_map(|(a, b, u, v)| [u, a, v, b]).collect(),
        PixelFormat::Nv12 => {
            assert!(
                width.is_multiple_of(2) && height.is_multiple_of(2),
                "{format:?} needs even sides, not {width} x {height}"
            );
            let mut out: Vec<u8> = pixels().map(luma).collect();
            for two in rgb.chunks_exact(6 * width) {
                let (upper, lower) = two.split_at(3 * width);
                for (p, q) in upper.as_chunks::<6>().0.iter().zip(lower.as_chunks::<6>().0) {
                    let [a, b, c, d, e, f] = *p;
                    let [g, h, i, j, k, l] = *q;
                    let (u, v) = chroma(&[[a, b, c], [d, e, f], [g, h, i], [j, k, l]]);
                    out.extend([u, v]);
                }
            }
            out
        }
    }
}

/// Five, six and five bits, each the nearest that widens back.
fn to_565([r, g, b]: [u8; 3]) -> u16 {
    let nearest = |value: u8, most: u32| ((u32::from(value) * most + 127) / 255) as u16;
    nearest(r, 31) << 11 | nearest(g, 63) << 5 | nearest(b, 31)
}

/// BT.601 luma in 16 to 235, in 16.16 fixed point.
fn luma([r, g, b]: [u8; 3]) -> u8 {
    let sum = 16_829 * i32::from(r) + 33_039 * i32::from(g) + 6_416 * i32::from(b);
    (16 + ((sum + (1 << 15)) >> 16)) as u8
}

/// BT.601 chroma (U, V) in 16 to 240 of the mean of some colours, in 16.16 fixed point.
fn chroma(pixels: &[[u8; 3]]) -> (u8, u8) {
    let sum = |i: usize| pixels.iter().map(|p| i32::from(p[i])).sum::<i32>();
    let (r, g, b) = (sum(0), sum(1), sum(2));
    let whole = (pixels.len() as i32) << 16;
    // the sum is at most 4 * 255 * 28,784 in size, far inside an i32
    let level = |weighted: i32| (128 + (weighted + whole / 2).div_euclid(whole)) as u8;
    (level(-9_714 * r - 19_070 * g + 28_784 * b), level(28_784 * r - 24_103 * g - 4_681 * b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::vision::frame::FrameView;

    /// 2 x 2 blocks of one colour, so that shared chroma costs nothing.
    fn blocks(width: u16, height: u16) -> Vec<u8> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x / 2, y / 2)));
        pixels
            .flat_map(|(x, y)| [(x * 37 % 256) as u8, (y * 61 % 256) as u8, (x * y * 17 % 256) as u8])
            .collect()
    }

    #[test]
    fn every_format_reads_back_as_what_it_was() {
        let (width, height) = (32, 24);
        let rgb = blocks(width, height);
        for format in PixelFormat::ALL {
            let bytes = to_format(&rgb, width, height, format);
            let view = FrameView::packed(&bytes, width, height, format).expect("a whole picture");
            // eight bits of limited-range YUV keep colours to 2 or 3 levels, five bits to 4
            let most = match format {
                PixelFormat::Rgb888 | PixelFormat::Bgr888 | PixelFormat::Rgba8888 => 0,
                PixelFormat::Rgb565Le | PixelFormat::Rgb565Be => 4,
                PixelFormat::Yuyv | PixelFormat::Uyvy | PixelFormat::Nv12 => 3,
            };
            for (i, pixel) in rgb.chunks_exact(3).enumerate() {
                let (x, y) = (i % usize::from(width), i / usize::from(width));
                let read = view.pixel(x as i32, y as i32).expect("inside");
                for (was, is) in pixel.iter().zip([read.r, read.g, read.b]) {
                    assert!(was.abs_diff(is) <= most, "{format:?} at {x}, {y}: {pixel:?} read as {read:?}");
                }
            }
        }
    }

    #[test]
    fn shared_chroma_is_the_mean() {
        let red_and_blue = [255, 0, 0, 0, 0, 255];
        let [_, u, _, v] = to_format(&red_and_blue, 2, 1, PixelFormat::Yuyv)[..] else {
            panic!("two pixels are four bytes");
        };
        // red is U 90, V 240 and blue U 240, V 110
        assert_eq!((u, v), (165, 175));
    }

    #[test]
    #[should_panic(expected = "even width")]
    fn odd_width_is_refused() {
        let _ = to_format(&[0; 9], 3, 1, PixelFormat::Yuyv);
    }
}
