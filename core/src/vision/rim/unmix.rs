//! How much of a pixel is ball and how much is background.

use crate::geometry::{DIRECTIONS, ImagePoint, round_to_i32};
use crate::vision::colour::Matcher;
use crate::vision::frame::{FrameView, Rgb};

/// Three components, grey levels.
pub(super) type Colour = [f32; 3];

/// How far the ball's brightness may be off what it is just inside the rim against the sensor's
/// noise, as grey levels squared: noise of 2 levels and shading of a tenth give (2 / 0.1)^2. It decides
/// only where background and ball differ in brightness alone.
const SHADING_PRIOR: f32 = 400.0;

/// The colour is sampled on a ring of this share of the radius, where a highlight seldom is ...
const SAMPLED_SHARE: f32 = 0.8;

/// ... and at least so far inside the rim, pixels: these pixels are all ball.
const SAMPLED_INSIDE: f32 = 1.8;

/// Matched samples of [`DIRECTIONS`] from which on their mean is the ball's colour.
const LEAST_SAMPLES: f32 = 3.0;

/// How much of the ball's colour in a scan is that of its own inside, the rest being the whole ball's:
/// a highlight or a coloured light tints a part of it, and one pixel alone is noisy.
const LOCAL: f32 = 0.5;

/// The least length of a ball's colour, grey levels: below it there is no hue.
const LEAST_COLOUR: f32 = 8.0;

pub(super) fn dot(a: &Colour, b: &Colour) -> f32 {
    let [a0, a1, a2] = a;
    let [b0, b1, b2] = b;
    a0 * b0 + a1 * b1 + a2 * b2
}

pub(super) fn scaled(a: &Colour, k: f32) -> Colour {
    a.map(|x| x * k)
}

/// The colour of one ball: what it is made of, however bright it is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Palette {
    ball: Colour,
    ball2: f32,
    per_ball2: f32,
}

impl Palette {
    /// The mean of the matched pixels of a ring inside the rim, or `otherwise` where there are too few
    /// (a finger or a highlight over it). `None` for black.
    pub(super) fn sample(
        frame: &FrameView<'_>,
        matcher: &Matcher,
        centre: ImagePoint,
        (radius, aspect): (f32, f32),
        otherwise: Rgb,
        tested: &mut u32,
    ) -> Option<Self> {
        let ring = (radius - SAMPLED_INSIDE).min(radius * SAMPLED_SHARE).max(0.0);
        let (mut sum, mut count) = ([0.0; 3], 0.0);
        for (c, s) in DIRECTIONS {
            let x = round_to_i32(centre.u + ring * c);
            let y = round_to_i32(centre.v + ring * s * aspect);
            if let Some(colour) = frame.pixel(x, y).filter(|colour| matcher.accepts(*colour)) {
                sum = plus(&sum, &floats(colour));
                count += 1.0;
            }
        }
        *tested += DIRECTIONS.len() as u32;
        let ball = if count >= LEAST_SAMPLES { scaled(&sum, 1.0 / count) } else { floats(otherwise) };
        let ball2 = dot(&ball, &ball);
        (ball2 >= LEAST_COLOUR * LEAST_COLOUR).then(|| Self { ball, ball2, per_ball2: 1.0 / ball2 })
    }

    /// How bright `colour` is against the ball; `None` where it is of another hue: the square of the
    /// sine of the angle between the two is above `most_hue`.
    pub(super) fn brightness(&self, colour: &Colour, most_hue: f32) -> Option<f32> {
        let along = dot(colour, &self.ball);
        let of_the_hue = along > 0.0 && along * along >= (1.0 - most_hue) * dot(colour, colour) * self.ball2;
        of_the_hue.then_some(along * self.per_ball2)
    }

    /// The share of background in a pixel as a linear function of it, where the ball just inside is
    /// `inner`, about `brightness` times its usual self, and the background is `behind`.
    ///
    /// A pixel is p C + q B. Least squares with the wish that p / brightness + q = 1, weighed by
    /// [`SHADING_PRIOR`]: of no account where C and B are of different hue (then q does not depend on
    /// the shading at all), and all there is to go by where B is black or of C's hue.
    pub(super) fn unmixer(&self, brightness: f32, inner: &Colour, behind: &Colour) -> Option<Unmixer> {
        let ball = plus(&scaled(&self.ball, brightness * (1.0 - LOCAL)), &scaled(inner, LOCAL));
        let cc = dot(&ball, &ball) + SHADING_PRIOR;
        let cb = dot(&ball, behind) + SHADING_PRIOR;
        let bb = dot(behind, behind) + SHADING_PRIOR;
        let determinant = cc * bb - cb * cb;
        if determinant < 1.0 {
            return None;
        }
        let per = 1.0 / determinant;
        let (of_b, of_c) = (cc * per, cb * per);
        let [b0, b1, b2] = behind;
        let [c0, c1, c2] = &ball;
        Some(Unmixer {
            weights: [of_b * b0 - of_c * c0, of_b * b1 - of_c * c1, of_b * b2 - of_c * c2],
            offset: SHADING_PRIOR * (of_b - of_c),
        })
    }
}

/// The share of background in a pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Unmixer {
    weights: Colour,
    offset: f32,
}

impl Unmixer {
    /// The sum of the shares of `count` pixels that add up to `sum`.
    pub(super) fn shares(&self, sum: &Colour, count: f32) -> f32 {
        dot(&self.weights, sum) + self.offset * count
    }

    /// The variance of one pixel's share for a sensor noise of one grey level.
    pub(super) fn variance(&self) -> f32 {
        dot(&self.weights, &self.weights)
    }
}

pub(super) fn plus(a: &Colour, b: &Colour) -> Colour {
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    [a0 + b0, a1 + b1, a2 + b2]
}

pub(super) fn minus(a: &Colour, b: &Colour) -> Colour {
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    [a0 - b0, a1 - b1, a2 - b2]
}

pub(super) fn floats(colour: Rgb) -> Colour {
    [f32::from(colour.r), f32::from(colour.g), f32::from(colour.b)]
}
