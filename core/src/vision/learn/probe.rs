//! Reading pixels while counting them: every search of the core says how many it tested.

use crate::vision::colour::Primary;
use crate::vision::frame::{FrameView, Rgb};

/// A picture and how many of its pixels were asked for.
pub(super) struct Probe<'a, 'f> {
    frame: &'a FrameView<'f>,
    tested: u32,
}

impl<'a, 'f> Probe<'a, 'f> {
    pub(super) const fn new(frame: &'a FrameView<'f>) -> Self {
        Self { frame, tested: 0 }
    }

    /// The pixel in column `x`, row `y`, or `None` outside the picture. Counted either way: the
    /// bound on the work is a bound on the questions.
    #[inline]
    pub(super) fn pixel(&mut self, x: i32, y: i32) -> Option<Rgb> {
        self.tested = self.tested.saturating_add(1);
        self.frame.pixel(x, y)
    }

    /// The pixel nearest to a point given in pixels.
    #[inline]
    pub(super) fn near(&mut self, u: f32, v: f32) -> Option<Rgb> {
        self.pixel(libm::roundf(u) as i32, libm::roundf(v) as i32)
    }

    pub(super) const fn width(&self) -> i32 {
        self.frame.width() as i32
    }

    pub(super) const fn height(&self) -> i32 {
        self.frame.height() as i32
    }

    pub(super) const fn frame(&self) -> &'a FrameView<'f> {
        self.frame
    }

    /// Counts pixels that another module read.
    pub(super) const fn count(&mut self, pixels: u32) {
        self.tested = self.tested.saturating_add(pixels);
    }

    pub(super) const fn tested(&self) -> u32 {
        self.tested
    }
}

/// By how many levels the weakest component that a colour has exceeds the strongest that it has not:
/// zero and below for greys, whatever their brightness, so that black and white are told from a
/// dark ball where V alone cannot (V of black is 2/3 for red, green and blue). From -255 to 255.
#[inline]
pub(super) const fn chroma(primary: Primary, p: Rgb) -> i32 {
    let (r, g, b) = (p.r as i32, p.g as i32, p.b as i32);
    match primary {
        Primary::Red => r - max(g, b),
        Primary::Green => g - max(r, b),
        Primary::Blue => b - max(r, g),
        Primary::Yellow => min(r, g) - b,
        Primary::Magenta => min(r, b) - g,
        Primary::Cyan => min(g, b) - r,
    }
}

/// The strongest component, 0 to 255: chroma over it is the saturation.
#[inline]
pub(super) const fn brightness(p: Rgb) -> i32 {
    max(p.r as i32, max(p.g as i32, p.b as i32))
}

/// Chroma over brightness, 0 to 1: what shading leaves alone. Near black, where it would be the noise
/// over nothing, it goes to 0.
#[inline]
pub(super) fn saturation(primary: Primary, p: Rgb) -> f32 {
    max(chroma(primary, p), 0) as f32 / (brightness(p) + DARK) as f32
}

/// The brightness, in levels, at which saturation counts half: twice that of a black curtain.
const DARK: i32 = 32;

const fn max(a: i32, b: i32) -> i32 {
    if a > b { a } else { b }
}

const fn min(a: i32, b: i32) -> i32 {
    if a < b { a } else { b }
}
