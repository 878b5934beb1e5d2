//! Small pictures of shaded balls, in every format.

use crate::vision::frame::{FrameView, PixelFormat, Rgb};
use std::vec::Vec;

/// A ball as the tests draw it.
#[derive(Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) u: f32,
    pub(crate) v: f32,
    pub(crate) diameter: f32,
    pub(crate) colour: Rgb,
    /// Where the light comes from, radians in the picture.
    pub(crate) light: f32,
    /// Brightness of the side away from the light, 0 to 1.
    pub(crate) shadow: f32,
    /// Whether it has a white highlight, 0.2 of its diameter across.
    pub(crate) highlight: bool,
}

impl Ball {
    pub(crate) fn new(u: f32, v: f32, diameter: f32, colour: Rgb) -> Self {
        Self { u, v, diameter, colour, light: -2.0, shadow: 0.45, highlight: true }
    }

    /// Where the highlight is: 0.4 radii from the centre, towards the light.
    pub(crate) fn highlight_at(&self) -> (f32, f32) {
        let reach = 0.4 * self.diameter / 2.0;
        (self.u + reach * self.light.cos(), self.v + reach * self.light.sin())
    }

    fn colour_at(&self, x: f32, y: f32) -> Option<[f32; 3]> {
        let radius = self.diameter / 2.0;
        let (du, dv) = (x - self.u, y - self.v);
        if du.hypot(dv) > radius {
            return None;
        }
        let (hu, hv) = self.highlight_at();
        if self.highlight && (x - hu).hypot(y - hv) <= 0.2 * radius {
            return Some([255.0; 3]);
        }
        let along = (du * self.light.cos() + dv * self.light.sin()) / radius;
        let shade = self.shadow + (1.0 - self.shadow) * (along + 1.0) / 2.0;
        Some([self.colour.r, self.colour.g, self.colour.b].map(|c| f32::from(c) * shade))
    }
}

/// A picture in RGB888, with its size.
pub(crate) struct Picture {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) pixels: Vec<Rgb>,
}

impl Picture {
    /// A background, a function of column and row.
    pub(crate) fn new(width: usize, height: usize, mut background: impl FnMut(i32, i32) -> Rgb) -> Self {
        let pixels =
            (0..width * height).map(|i| background((i % width) as i32, (i / width) as i32)).collect();
        Self { width, height, pixels }
    }

    /// Draws a ball with 4 x 4 samples a pixel, so that its rim is soft as a camera's is.
    pub(crate) fn with(mut self, ball: Ball) -> Self {
        let (width, reach) = (self.width as i32, (ball.diameter / 2.0) as i32 + 2);
        let (cx, cy) = (ball.u as i32, ball.v as i32);
        for y in (cy - reach).max(0)..=(cy + reach).min(self.height as i32 - 1) {
            for x in (cx - reach).max(0)..=(cx + reach).min(width - 1) {
                let pixel = &mut self.pixels[(y * width + x) as usize];
                let under = [pixel.r, pixel.g, pixel.b].map(f32::from);
                let mut sum = [0.0; 3];
                for k in 0..16u8 {
                    let sample = |n: u8| (f32::from(n) + 0.5) / 4.0 - 0.5;
                    let (sx, sy) = (x as f32 + sample(k % 4), y as f32 + sample(k / 4));
                    let colour = ball.colour_at(sx, sy).unwrap_or(under);
                    for (s, c) in sum.iter_mut().zip(colour) {
                        *s += c / 16.0;
                    }
                }
                let [r, g, b] = sum.map(|s| s.round() as u8);
                *pixel = Rgb::new(r, g, b);
            }
        }
        self
    }

    /// Noise of up to `amount` levels either way, from a fixed seed.
    pub(crate) fn with_noise(mut self, amount: i32) -> Self {
        let mut random = Random(1);
        for pixel in &mut self.pixels {
            let [r, g, b] = [pixel.r, pixel.g, pixel.b]
                .map(|c| (i32::from(c) + random.below(2 * amount + 1) - amount).clamp(0, 255) as u8);
            *pixel = Rgb::new(r, g, b);
        }
        self
    }

    /// The bytes of the picture in `format`.
    pub(crate) fn encode(&self, format: PixelFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        let luma =
            |p: Rgb| (66 * i32::from(p.r) + 129 * i32::from(p.g) + 25 * i32::from(p.b) + 128) / 256 + 16;
        let chroma = |pixels: &[Rgb]| {
            let mean =
                |c: fn(&Rgb) -> u8| pixels.iter().map(|p| i32::from(c(p))).sum::<i32>() / pixels.len() as i32;
            let (r, g, b) = (mean(|p| p.r), mean(|p| p.g), mean(|p| p.b));
            let u = (-38 * r - 74 * g + 112 * b + 128) / 256 + 128;
            let v = (112 * r - 94 * g - 18 * b + 128) / 256 + 128;
            [u.clamp(0, 255) as u8, v.clamp(0, 255) as u8]
        };
        match format {
            PixelFormat::Rgb888 => self.pixels.iter().for_each(|p| bytes.extend([p.r, p.g, p.b])),
            PixelFormat::Bgr888 => self.pixels.iter().for_each(|p| bytes.extend([p.b, p.g, p.r])),
            PixelFormat::Rgba8888 => self.pixels.iter().for_each(|p| bytes.extend([p.r, p.g, p.b, 9])),
            PixelFormat::Rgb565Le | PixelFormat::Rgb565Be => {
                for p in &self.pixels {
                    let word = u16::from(p.r >> 3) << 11 | u16::from(p.g >> 2) << 5 | u16::from(p.b >> 3);
                    let le = format == PixelFormat::Rgb565Le;
                    bytes.extend(if le { word.to_le_bytes() } else { word.to_be_bytes() });
                }
            }
            PixelFormat::Yuyv | PixelFormat::Uyvy => {
                for pair in self.pixels.chunks_exact(2) {
                    let [u, v] = chroma(pair);
                    let (y0, y1) = (luma(pair[0]) as u8, luma(pair[1]) as u8);
                    let yuyv = format == PixelFormat::Yuyv;
                    bytes.extend(if yuyv { [y0, u, y1, v] } else { [u, y0, v, y1] });
                }
            }
            PixelFormat::Nv12 => {
                bytes.extend(self.pixels.iter().map(|p| luma(*p) as u8));
                for rows in self.pixels.chunks_exact(2 * self.width) {
                    let (above, below) = rows.split_at(self.width);
                    for (a, b) in above.chunks_exact(2).zip(below.chunks_exact(2)) {
                        bytes.extend(chroma(&[a[0], a[1], b[0], b[1]]));
                    }
                }
            }
        }
        bytes
    }

    /// Calls `f` with the picture as a frame in RGB888.
    pub(crate) fn frame<T>(&self, f: impl FnOnce(&FrameView<'_>) -> T) -> T {
        self.frame_in(PixelFormat::Rgb888, f)
    }

    /// Calls `f` with the picture as a frame in `format`.
    pub(crate) fn frame_in<T>(&self, format: PixelFormat, f: impl FnOnce(&FrameView<'_>) -> T) -> T {
        let bytes = self.encode(format);
        f(&FrameView::packed(&bytes, self.width as u16, self.height as u16, format).unwrap())
    }
}

/// Knuth's linear congruence: the same pictures on every machine.
pub(crate) struct Random(pub(crate) u32);

impl Random {
    /// From 0 to `limit` - 1.
    pub(crate) fn below(&mut self, limit: i32) -> i32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as i32 % limit.max(1)
    }
}
