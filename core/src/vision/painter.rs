//! Pictures for the tests of this crate: flat discs with anti-aliased rims on grey.

use super::frame::{FrameView, PixelFormat, Rgb};
use crate::observation::Ball;
use std::vec::Vec;

pub(crate) struct Painter {
    data: Vec<u8>,
}

impl Painter {
    pub(crate) const WIDTH: i32 = 240;
    pub(crate) const HEIGHT: i32 = 180;
    pub(crate) const BACKGROUND: Rgb = Rgb::new(110, 112, 108);

    pub(crate) const fn colour(ball: Ball) -> Rgb {
        match ball {
            Ball::Red => Rgb::new(200, 30, 35),
            Ball::Green => Rgb::new(30, 170, 60),
            Ball::Blue => Rgb::new(30, 60, 190),
            Ball::Yellow => Rgb::new(220, 200, 40),
        }
    }

    pub(crate) fn new() -> Self {
        let mut painter = Self { data: std::vec![0; (Self::WIDTH * Self::HEIGHT * 3) as usize] };
        painter.block(0, 0, Self::WIDTH, Self::HEIGHT, Self::BACKGROUND);
        painter
    }

    /// Columns `x0..x1`, rows `y0..y1`.
    pub(crate) fn block(&mut self, x0: i32, y0: i32, x1: i32, y1: i32, colour: Rgb) {
        for y in y0..y1 {
            for x in x0..x1 {
                self.mix(x, y, colour, 1.0);
            }
        }
    }

    pub(crate) fn ball(&mut self, ball: Ball, u: f32, v: f32, diameter: f32) {
        let r = diameter * 0.5;
        let reach = r as i32 + 2;
        for y in v as i32 - reach..=v as i32 + reach {
            for x in u as i32 - reach..=u as i32 + reach {
                let mut inside = 0;
                for i in 0..64 {
                    let (sx, sy) = ((i % 8) as f32 / 8.0 - 0.4375, (i / 8) as f32 / 8.0 - 0.4375);
                    let (du, dv) = (x as f32 + sx - u, y as f32 + sy - v);
                    inside += i32::from(du * du + dv * dv <= r * r);
                }
                self.mix(x, y, Self::colour(ball), inside as f32 / 64.0);
            }
        }
    }

    /// All of it in so much of the light.
    pub(crate) fn dim(&mut self, share: f32) {
        for value in &mut self.data {
            *value = (f32::from(*value) * share + 0.5) as u8;
        }
    }

    fn mix(&mut self, x: i32, y: i32, colour: Rgb, share: f32) {
        if x < 0 || y < 0 || x >= Self::WIDTH || y >= Self::HEIGHT {
            return;
        }
        let at = ((y * Self::WIDTH + x) * 3) as usize;
        for (old, new) in self.data[at..at + 3].iter_mut().zip([colour.r, colour.g, colour.b]) {
            *old = (f32::from(*old) * (1.0 - share) + f32::from(new) * share + 0.5) as u8;
        }
    }

    pub(crate) fn view(&self) -> FrameView<'_> {
        FrameView::packed(&self.data, Self::WIDTH as u16, Self::HEIGHT as u16, PixelFormat::Rgb888).unwrap()
    }
}
