//! The refined centre: a ball's rim to a small part of a pixel, and the centre it has.
//!
//! ```text
//! row-edge blob -> first circle -> scans across the rim -> sub-pixel edges -> robust fit -> centre
//!                 (warm or rays)   (rows and columns)      (unmixing)         (circle + 2 harmonics)
//! ```
//! The row-edge centre of section 3.3 rests on a threshold, and a threshold half way between ball and
//! background lies at the rim only where the ball is evenly lit. Here every pixel near the rim is
//! taken apart into a share of ball, however bright, and a share of background (`unmix`), and the sum
//! of the shares along a row or column (`scan`) is where the rim lies: shading does not move it, the
//! pixel raster does not, motion during the exposure leaves it in the middle of the motion, and two
//! pixels that share their chroma have the right sum between them. A fit (`fit`) that gives way to what
//! does not lie on one curve leaves out fingers, highlights and other balls.
//!
//! Work is bounded: at most [`MAX_SCANS`] scans of [`MAX_SCAN_PIXELS`] pixels, at most
//! [`CentreConfig::passes`] times. No pixel is interpolated and no angle computed.

mod fit;
mod rays;
mod scan;
mod unmix;

use super::centre::Blob;
use super::colour::Matcher;
use super::frame::FrameView;
use crate::config::CentreConfig;
use crate::geometry::{ImagePoint, round_to_i32};
use crate::observation::ImageCovariance;
use core::f32::consts::PI;
use core::fmt;
use fit::{Curve, Fit, Prior, fit};
use rays::Rays;
pub use scan::{MAX_SCAN_PIXELS, MAX_SCANS};
use scan::{Reach, Scanner};
use unmix::Palette;

/// A height / width this near to 1 is taken for 1 ...
const SQUARE_SHARE: f32 = 0.2;

/// ... and where it is so many pixels.
const SQUARE_PIXELS: f32 = 2.0;

/// Share of its area under which a part of a ball is a sliver: a few pixels thick.
const SLIVER_SHARE: f32 = 0.3;

/// How much less of a rim is needed each frame to replace the remembered one.
const FADING: f32 = 0.01;

/// Less of a rim than this never replaces the remembered one: it says too little of the radius.
const HALF: f32 = 0.5;

/// The most frames for which a radius is thought to change.
const OLDEST: f32 = 30.0;

/// How much less well a radius is known for each frame that passes, as a share.
const AGEING: f32 = 0.1;

/// Frames further apart than this, microseconds, count as the frames that are missing between them:
/// 15 a second is the least that is called footage.
const FRAME_US: f32 = 67_000.0;

/// The most frames that count as missing: then the radius is as good as unknown.
const MOST_MISSING: f32 = 30.0;

/// What a rim says of its ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rim {
    /// The centre of the outline.
    pub centre: ImagePoint,
    /// The outline's width, pixels.
    pub diameter: f32,
    /// Of the centre, pixels squared.
    pub covariance: ImageCovariance,
    /// The share of the rim that was seen and lies on the curve, 0 to 1.
    pub visible: f32,
    shape: Shape,
}

/// Why a rim gives no centre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum RimRefusal {
    /// The ball is nearly black: it has no hue to tell it by.
    NoColour,
    /// Too little of the rim is in sight, or it does not look like one.
    TooLittle,
    /// The curve that fits best is not where the ball is, or not of its size.
    Elsewhere,
}

impl fmt::Display for RimRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoColour => "the ball is too dark to have a hue",
            Self::TooLittle => "too little of the ball's rim is in sight",
            Self::Elsewhere => "the curve that fits best is not this ball's rim",
        })
    }
}

impl core::error::Error for RimRefusal {}

/// What a curve is but for its place.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Shape {
    radius: f32,
    a: f32,
    b: f32,
}

impl Shape {
    /// From its left-most to its right-most point, pixels.
    const fn width(&self) -> f32 {
        2.0 * (self.radius + self.a)
    }
}

/// What is remembered of a rim from one frame to the next: the next starts from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RimMemory {
    /// When most of it was last in sight, and how much of it was.
    whole: Shape,
    seen: f32,
    /// Frames since then.
    age: f32,
    /// Frames that are missing between the last rim and the present frame.
    missing: f32,
    /// From the row-edge centre to the rim's, and the blob that had it.
    offset: ImagePoint,
    diameter: f32,
    height: f32,
}

impl RimMemory {
    /// What to remember after `rim` was measured of `blob`.
    #[must_use]
    pub fn after(former: Option<&Self>, rim: &Rim, blob: &Blob, config: &CentreConfig) -> Self {
        let (whole, seen, age) = match former {
            // a first look that went wrong must not be held against every later one
            Some(former) if rim.visible < former.seen.min(config.whole_visible) => {
                let frames = 1.0 + former.missing;
                let fading = if rim.visible < HALF { 0.0 } else { FADING * frames };
                (former.whole, former.seen - fading, (former.age + frames).min(OLDEST))
            }
            _ => (rim.shape, rim.visible, 0.0),
        };
        let offset = rim.centre - blob.centre;
        Self { whole, seen, age, missing: 0.0, offset, diameter: blob.diameter, height: blob.height }
    }

    /// What it is worth `elapsed_us` after the last rim was measured: a hand that was not watched for
    /// half a second may hold the ball much nearer or farther.
    #[must_use]
    pub fn later(self, elapsed_us: u64) -> Self {
        let frames = (elapsed_us as f32 / FRAME_US - 1.0).min(MOST_MISSING);
        let missing = frames.max(0.0);
        Self { missing, ..self }
    }

    /// The standard deviation of the radius, pixels.
    fn radius_sigma(&self, config: &CentreConfig) -> f32 {
        let share = config.radius_share * (1.0 + AGEING * self.age) * (1.0 + self.missing);
        config.radius_pixels + share.min(config.unknown_share) * self.whole.radius
    }

    /// How far the radius may be from the remembered one, a ratio.
    fn radius_range(&self, config: &CentreConfig) -> f32 {
        (config.known_range + config.radius_share * self.missing).min(config.unknown_range)
    }

    /// The diameter when most of the rim was last in sight, pixels.
    #[must_use]
    pub fn diameter(&self) -> f32 {
        self.whole.width()
    }

    /// Whether a blob is so much like the last one that its rim lies where that one's did.
    fn resembles(&self, blob: &Blob, config: &CentreConfig) -> bool {
        let limit = config.warm_pixels + config.warm_share * self.diameter;
        libm::fabsf(blob.diameter - self.diameter) <= limit && libm::fabsf(blob.height - self.height) <= limit
    }
}

/// One ball whose rim is sought.
#[derive(Clone, Copy, Debug)]
pub struct Sought<'a> {
    /// What the row edges gave.
    pub blob: &'a Blob,
    /// What gave them.
    pub matcher: &'a Matcher,
    /// What is remembered from the frame before.
    pub memory: Option<&'a RimMemory>,
    /// Where it must be, if a part of it is hidden and others say so.
    pub expected: Option<ImagePoint>,
    /// The diameter when it was last seen whole (the paper's measure), pixels.
    pub diameter: f32,
    /// Height / width, as learnt.
    pub aspect: f32,
    /// How far it is thought to have moved since the last frame, pixels.
    pub speed: f32,
}

/// Finds the rim of a ball. `tested` grows by the pixels read.
///
/// # Errors
/// [`RimRefusal`]: then the row-edge centre is all there is.
pub fn find_rim(
    frame: &FrameView<'_>,
    sought: &Sought<'_>,
    config: &CentreConfig,
    tested: &mut u32,
) -> Result<Rim, RimRefusal> {
    let search = Search { frame, sought, config };
    let mut best: Result<Rim, RimRefusal> = Err(RimRefusal::TooLittle);
    for start in [Start::Expected, Start::Memory, Start::Blob, Start::Rays] {
        let found = search.from(start, tested);
        if let Ok(rim) = &found
            && !search.is_suspicious(rim)
        {
            return found;
        }
        best = match (best, found) {
            (Ok(best), Ok(found)) if best.visible >= found.visible => Ok(best),
            (Ok(best), Err(_)) => Ok(best),
            (_, found) => found,
        };
    }
    best
}

/// Where the first curve comes from, in the order tried.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Start {
    /// A part of it is hidden, and it is known where it must be.
    Expected,
    /// The blob looks like the last one: its rim lies where that one's did.
    Memory,
    /// The blob is a ball in even light.
    Blob,
    /// Nothing of the kind.
    Rays,
}

/// The height / width that a rim is sought with: 1 unless `learnt` says clearly that pixels are not
/// square. It was measured in whole pixels of a ball of `diameter`, perhaps in side light; what is
/// between is left to the curve's second harmonics.
#[must_use]
pub fn aspect_of_pixels(learnt: f32, diameter: f32) -> f32 {
    let off = libm::fabsf(learnt - 1.0);
    if off <= SQUARE_SHARE || off * diameter <= SQUARE_PIXELS { 1.0 } else { learnt }
}

struct Search<'a> {
    frame: &'a FrameView<'a>,
    sought: &'a Sought<'a>,
    config: &'a CentreConfig,
}

impl Search<'_> {
    fn from(&self, start: Start, tested: &mut u32) -> Result<Rim, RimRefusal> {
        let Sought { blob, memory, diameter, aspect, .. } = *self.sought;
        let c = self.config;
        let (a, b) = memory.map_or((0.0, 0.0), |m| (m.whole.a, m.whole.b));
        let curve = match (start, memory) {
            (Start::Expected, Some(memory)) => {
                let centre = self.sought.expected.ok_or(RimRefusal::TooLittle)?;
                Curve { centre, radius: memory.whole.radius, a, b }
            }
            (Start::Memory, Some(memory)) if memory.resembles(blob, c) => {
                Curve { centre: blob.centre + memory.offset, radius: memory.whole.radius, a, b }
            }
            (Start::Blob, _) if blob.roundness >= c.round => {
                let radius = (blob.diameter + blob.height / aspect) * 0.25;
                Curve { centre: blob.centre, radius, a, b }
            }
            (Start::Rays, _) => {
                let radius = (blob.diameter.min(blob.height / aspect)) * 0.5;
                let palette = self.palette(blob.centre, radius, tested)?;
                let radius = memory.map_or(diameter * 0.5, |m| m.whole.radius);
                let radius_range = memory.map_or(c.unknown_range, |m| m.radius_range(c));
                let rays = Rays { frame: self.frame, palette: &palette, aspect, radius, radius_range };
                let circle = rays.circle(blob.centre, tested).ok_or(RimRefusal::TooLittle)?;
                Curve { centre: circle.centre, radius: circle.radius, a, b }
            }
            _ => return Err(RimRefusal::TooLittle),
        };
        let palette = self.palette(curve.centre, curve.radius, tested)?;
        self.follow(curve, matches!(start, Start::Memory | Start::Expected), &palette, tested)
    }

    fn palette(&self, centre: ImagePoint, radius: f32, tested: &mut u32) -> Result<Palette, RimRefusal> {
        let Sought { blob, matcher, .. } = self.sought;
        Palette::sample(self.frame, matcher, centre, (radius, self.sought.aspect), blob.colour, tested)
            .ok_or(RimRefusal::NoColour)
    }

    /// The share of a disc of `radius` that the blob fills.
    fn share_of(&self, radius: f32) -> f32 {
        self.sought.blob.area / (PI * radius * radius * self.sought.aspect).max(1.0)
    }

    /// Whether less of the rim was found than there is of the ball.
    fn is_suspicious(&self, rim: &Rim) -> bool {
        let share = self.share_of(rim.shape.radius);
        rim.visible < self.config.clear_visible && rim.visible < share - self.config.share_slack
    }

    /// Scans across the rim and fits, until the curve stays where it is.
    fn follow(
        &self,
        start: Curve,
        is_near: bool,
        palette: &Palette,
        tested: &mut u32,
    ) -> Result<Rim, RimRefusal> {
        let c = self.config;
        let aspect = self.sought.aspect;
        let prior = self.prior(&start);
        let mut curve = start;
        let mut near = is_near;
        let mut found: Option<(Fit, u32)> = None;
        for _ in 0..c.passes {
            let scanner = Scanner { frame: self.frame, palette, aspect, reach: self.reach(&curve, near) };
            let edges = scanner.scan(&curve, tested);
            let fitted = fit(&curve, &edges, aspect, &prior, near).ok_or(RimRefusal::TooLittle)?;
            let moved =
                fitted.curve.centre.distance(curve.centre) + libm::fabsf(fitted.curve.radius - curve.radius);
            curve = fitted.curve;
            found = Some((fitted, edges.tried));
            if !self.is_near(&curve, &prior) {
                return Err(RimRefusal::Elsewhere);
            }
            if near && moved <= c.settled_pixels {
                break;
            }
            near = moved <= c.near_pixels;
        }
        let (fitted, tried) = found.ok_or(RimRefusal::TooLittle)?;
        self.judge(&fitted, tried)
    }

    fn prior(&self, start: &Curve) -> Prior {
        let c = self.config;
        match self.sought.memory {
            Some(memory) => Prior {
                radius: memory.whole.radius,
                radius_sigma: memory.radius_sigma(c),
                a: memory.whole.a,
                b: memory.whole.b,
                harmonic_sigma: c.harmonic_share * memory.whole.radius,
            },
            None => Prior {
                radius: start.radius,
                radius_sigma: c.unknown_share * start.radius,
                a: 0.0,
                b: 0.0,
                harmonic_sigma: c.harmonic_share * start.radius,
            },
        }
    }

    /// How far scans reach: farther where the rim is less well known, and across the blur of a motion.
    fn reach(&self, curve: &Curve, near: bool) -> Reach {
        let c = self.config;
        let blur = round_to_i32((self.sought.speed * c.blur_share).min(c.most_blur));
        let more = blur + if near { 0 } else { 1 };
        // no farther in than half way to the centre, and hardly into a sliver
        let sliver = self.sought.expected.is_some() && self.share_of(curve.radius) < SLIVER_SHARE;
        let inside =
            if sliver { 1 } else { (c.inside_pixels + more).min(round_to_i32(curve.radius * 0.5).max(2)) };
        Reach { inside, outside: c.outside_pixels + more }
    }

    /// Whether a curve can be this ball's rim: near the blob, and of about its size.
    fn is_near(&self, curve: &Curve, prior: &Prior) -> bool {
        let blob = self.sought.blob;
        let range = self.config.unknown_range;
        let size = prior.radius.max(1.0);
        (size / range..=size * range).contains(&curve.radius)
            && curve.centre.distance(self.sought.expected.unwrap_or(blob.centre)) <= 1.2 * size + 2.0
    }

    fn judge(&self, fitted: &Fit, tried: u32) -> Result<Rim, RimRefusal> {
        let c = self.config;
        let visible = fitted.inliers as f32 / tried.max(1) as f32;
        let Curve { centre, radius, a, b } = fitted.curve;
        if fitted.inliers < c.least_edges || visible < c.least_visible {
            return Err(RimRefusal::TooLittle);
        }
        let aspect = self.sought.aspect;
        let shape = Shape { radius, a, b };
        let [uu, uv, vv] = fitted.covariance;
        let floor = c.floor_pixels * c.floor_pixels;
        let inflation = c.inflation + c.hidden_inflation * (1.0 - visible).max(0.0);
        let [uu, uv, vv] = [uu, uv, vv].map(|x| x * inflation);
        Ok(Rim {
            centre,
            diameter: shape.width(),
            covariance: ImageCovariance { uu: uu + floor, uv: uv * aspect, vv: vv * aspect * aspect + floor },
            visible: visible.min(1.0),
            shape,
        })
    }
}

#[cfg(test)]
mod tests;
