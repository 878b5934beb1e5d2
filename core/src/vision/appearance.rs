//! What one ball looks like in one camera, and how its colours follow the light.
//!
//! The typical and background colours are taken anew from every clean detection (eq. 1: "both taken
//! from the previous tracking iteration"), the reference colour only after several validated frames
//! in a row (section 3.5), slowly, and never far from the colour that was taught.

use super::centre::Blob;
use super::colour::{ColourError, FRACTION, FULL_SCALE, Matcher, Reference, matching};
use super::frame::{FrameView, Rgb};
use super::learn::Learnt;
use super::rim::aspect_of_pixels;
use crate::config::{MAX_DIAMETER, Retry, ValidationConfig};
use crate::geometry::{DIRECTIONS, ImagePoint, round_to_i32};
use core::fmt;
use serde::{Deserialize, Serialize};

/// The smallest ball that can be tracked, pixels across.
pub const MIN_DIAMETER: f32 = 3.0;

/// The largest height / width (or its inverse) a ball may show: pixels need not be square.
pub const MAX_ASPECT: f32 = 2.0;

/// One ball as it was taught in one camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LearntBall {
    /// The colours of eq. 1.
    pub reference: Reference,
    /// Width in pixels.
    pub diameter: f32,
    /// Height / width: 1 for square pixels.
    pub aspect: f32,
}

/// How far off the outline's the middle of the lit side is at least, in diameters.
const LIT_SIDE_OFF: f32 = 0.05;

/// The largest height / width (or its inverse) that the rim's search takes for that of square pixels.
const LIT_SIDE_ASPECT: f32 = 1.19;

impl LearntBall {
    /// What the tracker takes of what was learnt: the size as eq. 1 shows it where it shows the ball, else
    /// the outline's.
    #[must_use]
    pub fn of(learnt: &Learnt) -> Self {
        let (diameter, aspect) = match &learnt.blob {
            Ok(blob) if !blob.cut => as_seen(learnt, blob),
            _ => (learnt.diameter, 1.0),
        };
        Self { reference: learnt.reference, diameter, aspect }
    }
}

/// Width, and height / width, as eq. 1 shows the ball. Where it shows the lit side alone, whose middle is
/// off the outline's, it is the light that makes the height differ so much from the width: no more of it
/// is told than may be taken for the light's doing, or the tracker would think that pixels are not square.
fn as_seen(learnt: &Learnt, blob: &Blob) -> (f32, f32) {
    let aspect = blob.height / blob.diameter;
    let off = learnt.centre.distance(blob.centre);
    let stretched = aspect_of_pixels(aspect, blob.diameter) != 1.0;
    if !stretched || off <= LIT_SIDE_OFF * learnt.diameter {
        (blob.diameter, aspect)
    } else if aspect > 1.0 {
        (blob.height / LIT_SIDE_ASPECT, LIT_SIDE_ASPECT)
    } else {
        (blob.diameter, 1.0 / LIT_SIDE_ASPECT)
    }
}

/// Why a taught ball cannot be tracked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LearntBallError {
    /// The diameter is not a number between [`MIN_DIAMETER`] and [`MAX_DIAMETER`].
    Diameter,
    /// The aspect is not a number between 1 / [`MAX_ASPECT`] and [`MAX_ASPECT`].
    Aspect,
    /// The colours give no threshold.
    Colour(ColourError),
}

impl fmt::Display for LearntBallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diameter => {
                write!(f, "the ball's diameter must lie between {MIN_DIAMETER} and {MAX_DIAMETER} pixels")
            }
            Self::Aspect => {
                write!(f, "the ball's height may differ from its width at most {MAX_ASPECT} times")
            }
            Self::Colour(e) => e.fmt(f),
        }
    }
}

impl core::error::Error for LearntBallError {}

/// How far outside the rim the background is looked at: this share of the radius ...
const RING_SHARE: f32 = 1.3;
/// ... and so many pixels more, beyond the blur of the rim.
const RING_PIXELS: f32 = 2.0;

/// A pixel that stands for the neighbourhood of a ball at `centre`, `width` x `height` pixels: of
/// sixteen around it, the one of rank `rank` in M among those that stay under `ceiling` (in the
/// matcher's units: what is above it is the ball itself). `None` when there is none.
#[must_use]
pub fn background_around(
    frame: &FrameView<'_>,
    centre: ImagePoint,
    (width, height): (f32, f32),
    matcher: &Matcher,
    ceiling: i32,
    rank: usize,
    tested: &mut u32,
) -> Option<Rgb> {
    let mut ring: heapless::Vec<(i32, Rgb), 16> = heapless::Vec::new();
    let (a, b) = (width * 0.5 * RING_SHARE + RING_PIXELS, height * 0.5 * RING_SHARE + RING_PIXELS);
    for (cos, sin) in DIRECTIONS {
        let x = round_to_i32(centre.u + a * cos);
        let y = round_to_i32(centre.v + b * sin);
        if let Some(colour) = frame.pixel(x, y) {
            *tested += 1;
            let m = matcher.matching(colour);
            if m < ceiling {
                // DIRECTIONS has as many places as the vector
                let _ = ring.push((m, colour));
            }
        }
    }
    // With fewer samples the rank keeps its proportion. It is found by counting: sorting a slice
    // has a panic path.
    let at = rank * ring.len() / 16;
    let below = |i: usize, m: i32| ring.iter().enumerate().filter(|(j, (n, _))| (*n, *j) < (m, i)).count();
    ring.iter().enumerate().find(|(i, (m, _))| below(*i, *m) == at).map(|(_, (_, colour))| *colour)
}

/// The colours of one ball as they are now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Appearance {
    learnt: LearntBall,
    current: Reference,
    /// The reference colour in 1/256: small steps must not be lost to rounding.
    fine: [u16; 3],
    confirmed: u8,
}

impl Appearance {
    /// The colours of a ball that was just taught.
    ///
    /// # Errors
    /// [`LearntBallError`] when it cannot be tracked with them.
    pub fn new(learnt: LearntBall) -> Result<Self, LearntBallError> {
        if !(MIN_DIAMETER..=MAX_DIAMETER).contains(&learnt.diameter) {
            return Err(LearntBallError::Diameter);
        }
        if !(1.0 / MAX_ASPECT..=MAX_ASPECT).contains(&learnt.aspect) {
            return Err(LearntBallError::Aspect);
        }
        Matcher::new(&learnt.reference, 128).map_err(LearntBallError::Colour)?;
        let fine = fine_of(learnt.reference.reference);
        Ok(Self { learnt, current: learnt.reference, fine, confirmed: 0 })
    }

    /// The ball as it was taught.
    #[must_use]
    pub const fn learnt(&self) -> &LearntBall {
        &self.learnt
    }

    /// The colours of eq. 1 as they are now.
    #[must_use]
    pub const fn current(&self) -> &Reference {
        &self.current
    }

    /// Eq. 1 with today's colours.
    #[must_use]
    pub fn matcher(&self, alpha_256: u16) -> Matcher {
        self.or_learnt(Matcher::new(&self.current, alpha_256), alpha_256)
    }

    /// Eq. 1 with the colours that were taught: the way back when today's find nothing.
    #[must_use]
    pub fn learnt_matcher(&self, alpha_256: u16) -> Matcher {
        self.or_learnt(Matcher::new(&self.learnt.reference, alpha_256), alpha_256)
    }

    fn or_learnt(&self, matcher: Result<Matcher, ColourError>, alpha_256: u16) -> Matcher {
        matcher.or_else(|_| Matcher::new(&self.learnt.reference, alpha_256)).unwrap_or_else(|_| {
            // `new` has refused colours without contrast, so this is not reached; a matcher that
            // accepts nothing is the harmless answer all the same.
            let reference = self.learnt.reference;
            Matcher::with_threshold(reference.primary, reference.reference, i32::MAX)
        })
    }

    /// Takes typical and background colour from a detection, each unless it would leave no contrast,
    /// and the typical one unless it is of another hue than was taught (see `max_drift` in
    /// [`ValidationConfig`]): then the former stays.
    pub fn follow(&mut self, typical: Option<Rgb>, background: Option<Rgb>, max_drift: f32) {
        if let Some(typical) = typical
            && drift(self.learnt.reference.typical, typical) <= max_drift
        {
            self.take(Reference { typical, ..self.current });
        }
        if let Some(background) = background {
            self.take(Reference { background, ..self.current });
        }
    }

    fn take(&mut self, next: Reference) {
        if Matcher::new(&next, 128).is_ok() {
            self.current = next;
        }
    }

    /// Eq. 1 with another background: what surrounds the place where the ball is expected now.
    #[must_use]
    pub fn matcher_against(&self, background: Rgb, alpha_256: u16) -> Option<Matcher> {
        Matcher::new(&Reference { background, ..self.current }, alpha_256).ok()
    }

    /// A threshold near the typical colour, whatever the background.
    #[must_use]
    pub fn matcher_near(&self, retry: Retry) -> Matcher {
        near(&self.current, retry)
    }

    /// The same with the colours that were taught.
    #[must_use]
    pub fn learnt_matcher_near(&self, retry: Retry) -> Matcher {
        near(&self.learnt.reference, retry)
    }

    /// The M above which a pixel is rather the ball than what surrounds it: nine tenths of the
    /// way from background to typical.
    #[must_use]
    pub fn ceiling(&self) -> i32 {
        let of_background = self.matching(self.current.background);
        of_background + (self.matching(self.current.typical) - of_background) * 9 / 10
    }

    /// A frame in which every validation rule held: after enough of them in a row the reference
    /// goes a step towards the typical colour, unless that leads too far from what was taught.
    pub fn confirm(&mut self, config: &ValidationConfig) {
        self.confirmed = self.confirmed.saturating_add(1);
        if self.confirmed < config.confirmations {
            return;
        }
        let target = fine_of(self.current.typical);
        let mut fine = self.fine;
        for (value, goal) in fine.iter_mut().zip(target) {
            let step = (i32::from(goal) - i32::from(*value)) * i32::from(config.follow_256.min(256)) / 256;
            *value = (i32::from(*value) + step).clamp(0, i32::from(u16::MAX)) as u16;
        }
        let reference = coarse_of(fine);
        let next = Reference { reference, ..self.current };
        if drift(self.learnt.reference.reference, reference) <= config.max_drift
            && Matcher::new(&next, 128).is_ok()
        {
            self.fine = fine;
            self.current = next;
        }
    }

    /// A frame in which some rule did not hold: the count starts again.
    pub const fn doubt(&mut self) {
        self.confirmed = 0;
    }

    /// The ball has been lost for good: today's colours are given up for the taught ones.
    pub fn forget(&mut self) {
        self.current = self.learnt.reference;
        self.fine = fine_of(self.current.reference);
        self.confirmed = 0;
    }

    /// M of a colour under today's reference, in the matcher's units.
    #[must_use]
    pub const fn matching(&self, colour: Rgb) -> i32 {
        matching(self.current.primary, colour, self.current.reference)
    }
}

/// The typical colour is taken for the reference too: what the ball looked like a frame ago.
fn near(reference: &Reference, retry: Retry) -> Matcher {
    let best = reference.primary.luminance(reference.typical) * FRACTION;
    let threshold = best - (retry.margin * FULL_SCALE as f32) as i32;
    if retry.by_distance {
        Matcher::with_threshold(reference.primary, reference.typical, threshold)
    } else {
        Matcher::luminance_only(reference.primary, threshold)
    }
}

fn fine_of(colour: Rgb) -> [u16; 3] {
    [colour.r, colour.g, colour.b].map(|c| u16::from(c) << 8 | 0x80)
}

const fn coarse_of([r, g, b]: [u16; 3]) -> Rgb {
    Rgb::new((r >> 8) as u8, (g >> 8) as u8, (b >> 8) as u8)
}

/// How far a colour has gone from the learnt one when both are brought to the same brightness: D of
/// section 2 between the two as shares of their sums, so that dimmer light alone is no drift.
fn drift(learnt: Rgb, now: Rgb) -> f32 {
    let share = |c: Rgb| {
        let sum = (f32::from(c.r) + f32::from(c.g) + f32::from(c.b)).max(1.0);
        [f32::from(c.r) / sum, f32::from(c.g) / sum, f32::from(c.b) / sum]
    };
    let sum: f32 = share(learnt).iter().zip(share(now)).map(|(a, b)| (a - b) * (a - b)).sum();
    libm::sqrtf(sum / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::TrackerConfig;
    use crate::vision::colour::Primary;

    fn red() -> LearntBall {
        LearntBall {
            reference: Reference {
                primary: Primary::Red,
                reference: Rgb::new(200, 30, 30),
                typical: Rgb::new(190, 35, 35),
                background: Rgb::new(120, 120, 120),
            },
            diameter: 16.0,
            aspect: 1.0,
        }
    }

    #[test]
    fn the_reference_waits_for_confirmations_and_starts_again_after_a_doubt() {
        let config = TrackerConfig::default().validation;
        let mut a = Appearance::new(red()).unwrap();
        a.follow(Some(Rgb::new(150, 25, 25)), None, 0.12);
        for _ in 1..config.confirmations {
            a.confirm(&config);
        }
        assert_eq!(a.current().reference, red().reference.reference);
        a.doubt();
        for _ in 1..config.confirmations {
            a.confirm(&config);
        }
        assert_eq!(a.current().reference, red().reference.reference);
        a.confirm(&config);
        assert!(a.current().reference.r < 200);
    }

    #[test]
    fn half_the_light_is_followed_all_the_way() {
        let config = TrackerConfig::default().validation;
        let mut a = Appearance::new(red()).unwrap();
        for _ in 0..200 {
            a.follow(Some(Rgb::new(95, 17, 17)), Some(Rgb::new(60, 60, 60)), 0.12);
            a.confirm(&config);
        }
        let r = a.current().reference;
        assert!((i32::from(r.r) - 95).abs() <= 2 && (i32::from(r.g) - 17).abs() <= 2, "{r:?}");
    }

    #[test]
    fn another_colour_is_not_followed() {
        let config = TrackerConfig::default().validation;
        let mut a = Appearance::new(red()).unwrap();
        for _ in 0..500 {
            a.follow(Some(Rgb::new(200, 160, 40)), None, 0.12);
            a.confirm(&config);
        }
        assert!(drift(red().reference.reference, a.current().reference) <= config.max_drift);
        a.forget();
        assert_eq!(*a.current(), red().reference);
    }

    #[test]
    fn colours_without_contrast_are_not_taken() {
        let mut a = Appearance::new(red()).unwrap();
        let before = *a.current();
        a.follow(Some(Rgb::new(120, 120, 120)), None, 0.12);
        a.follow(None, Some(Rgb::new(200, 30, 30)), 0.12);
        assert_eq!(*a.current(), before);
    }

    #[test]
    fn unusable_balls_are_refused() {
        for diameter in [f32::NAN, 0.0, 2.9, 1000.0, f32::INFINITY] {
            assert_eq!(Appearance::new(LearntBall { diameter, ..red() }), Err(LearntBallError::Diameter));
        }
        for aspect in [f32::NAN, 0.0, 3.0] {
            assert_eq!(Appearance::new(LearntBall { aspect, ..red() }), Err(LearntBallError::Aspect));
        }
        let mut flat = red();
        flat.reference.background = flat.reference.typical;
        assert_eq!(Appearance::new(flat), Err(LearntBallError::Colour(ColourError::NoContrast)));
    }
}
