//! How well a pixel matches a ball: V, D and M of section 2, and the threshold of eq. 1.
//!
//! The paper compares M = V - D with a threshold T, where D holds a square root. With T fixed,
//! M >= T is the same as V - T >= D, and, both sides being positive, (V - T)^2 >= D^2. In units of
//! 1 / (765 * [`FRACTION`]) every term is an integer, so a pixel is decided by one comparison of
//! integers: no root, no rounding, the same answer on every target.
//!
//! Scale: with components c in 0..=255, 765 V is an integer, and 765 D = sqrt(3 S) with S the sum
//! of the squared differences.

use super::frame::Rgb;
use crate::observation::Ball;
use core::fmt;
use serde::{Deserialize, Serialize};

/// Parts into which 1/765 of the metric's range is divided: the resolution of the threshold.
pub const FRACTION: i32 = 16;

/// The metric's range: V = 1 is this many units, D = 1 too.
pub const FULL_SCALE: i32 = 765 * FRACTION;

/// The six reference colours of section 2: three primaries and their three pairs. (The paper labels
/// the last three alike, all i = 4; they are i = 4, 5, 6.)
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Primary {
    /// i = 1
    Red = 1,
    /// i = 2
    Green = 2,
    /// i = 3
    Blue = 3,
    /// i = 4: red and green
    Yellow = 4,
    /// i = 5: red and blue
    Magenta = 5,
    /// i = 6: green and blue
    Cyan = 6,
}

impl Primary {
    /// All six, i = 1 to 6.
    pub const ALL: [Self; 6] = [Self::Red, Self::Green, Self::Blue, Self::Yellow, Self::Magenta, Self::Cyan];

    /// The reference colour a ball is painted with.
    #[must_use]
    pub const fn of(ball: Ball) -> Self {
        match ball {
            Ball::Red => Self::Red,
            Ball::Green => Self::Green,
            Ball::Blue => Self::Blue,
            Ball::Yellow => Self::Yellow,
        }
    }

    /// 765 V: each component as it is where the colour has it, its complement where it has not.
    /// From 0 to 765.
    #[inline]
    #[must_use]
    pub const fn luminance(self, p: Rgb) -> i32 {
        let [base, r, g, b] = self.coefficients();
        base + r * p.r as i32 + g * p.g as i32 + b * p.b as i32
    }

    /// 765 V as base + r c1 + g c2 + b c3: 1 for a component that the colour has, -1 and 255 in the
    /// base for one that it has not.
    const fn coefficients(self) -> [i32; 4] {
        match self {
            Self::Red => [510, 1, -1, -1],
            Self::Green => [510, -1, 1, -1],
            Self::Blue => [510, -1, -1, 1],
            Self::Yellow => [255, 1, 1, -1],
            Self::Magenta => [255, 1, -1, 1],
            Self::Cyan => [255, -1, 1, 1],
        }
    }
}

/// 3 S = (765 D)^2 for two colours: three times the sum of the squared differences. At most 585,225.
#[inline]
#[must_use]
pub const fn distance_squared(p: Rgb, reference: Rgb) -> i32 {
    let dr = p.r as i32 - reference.r as i32;
    let dg = p.g as i32 - reference.g as i32;
    let db = p.b as i32 - reference.b as i32;
    3 * (dr * dr + dg * dg + db * db)
}

/// D in units of 1 / [`FULL_SCALE`], rounded up, so that M is never overstated.
#[must_use]
pub const fn distance(p: Rgb, reference: Rgb) -> i32 {
    let squared = (distance_squared(p, reference) * FRACTION * FRACTION) as u32;
    let root = squared.isqrt();
    (if root * root == squared { root } else { root + 1 }) as i32
}

/// M = V - D in units of 1 / [`FULL_SCALE`]: from -[`FULL_SCALE`] to [`FULL_SCALE`].
#[must_use]
pub const fn matching(primary: Primary, p: Rgb, reference: Rgb) -> i32 {
    primary.luminance(p) * FRACTION - distance(p, reference)
}

/// What is known of one ball's colour in one camera: the three colours that eq. 1 needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reference {
    /// Which V judges it.
    pub primary: Primary,
    /// p_ref: from learning, or from the last validated update.
    pub reference: Rgb,
    /// p_typ: a typical pixel of the ball in the previous iteration.
    pub typical: Rgb,
    /// p_bkg: a pixel of its neighbourhood in the previous iteration.
    pub background: Rgb,
}

/// Why a reference gives no threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ColourError {
    /// A typical pixel of the ball matches no better than its background does.
    NoContrast,
}

impl fmt::Display for ColourError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoContrast => {
                f.write_str("the ball's typical colour matches no better than its background")
            }
        }
    }
}

impl core::error::Error for ColourError {}

/// Eq. 1 made ready: decides for one pixel after the other whether it belongs to a ball.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Matcher {
    primary: Primary,
    reference: Rgb,
    threshold: i32,
    /// 1 for M = V - D, 0 for V alone.
    distance_weight: i32,
    /// [`FRACTION`] (765 V) - threshold as base + r c1 + g c2 + b c3: made ready for every pixel.
    excess: [i32; 4],
}

impl Matcher {
    /// Eq. 1 with `alpha` in 1/256 (the paper: 0 < alpha <= 1).
    ///
    /// # Errors
    /// [`ColourError::NoContrast`] when the typical colour matches no better than the background.
    pub const fn new(reference: &Reference, alpha_256: u16) -> Result<Self, ColourError> {
        let of_background = matching(reference.primary, reference.background, reference.reference);
        let of_typical = matching(reference.primary, reference.typical, reference.reference);
        if of_typical <= of_background {
            return Err(ColourError::NoContrast);
        }
        let threshold = of_background + (of_typical - of_background) * alpha_256 as i32 / 256;
        Ok(Self::with_threshold(reference.primary, reference.reference, threshold))
    }

    /// A matcher with a threshold given outright, in units of 1 / [`FULL_SCALE`]; values beyond the
    /// range of M are brought to its ends.
    #[must_use]
    pub const fn with_threshold(primary: Primary, reference: Rgb, threshold: i32) -> Self {
        let threshold = if threshold > FULL_SCALE {
            FULL_SCALE
        } else if threshold < -FULL_SCALE {
            -FULL_SCALE
        } else {
            threshold
        };
        let [base, r, g, b] = primary.coefficients();
        let excess = [base * FRACTION - threshold, r * FRACTION, g * FRACTION, b * FRACTION];
        Self { primary, reference, threshold, distance_weight: 1, excess }
    }

    /// A matcher by V alone, with a threshold in units of 1 / [`FULL_SCALE`]: for when nothing is
    /// known of the ball's colour but its primary.
    #[must_use]
    pub const fn luminance_only(primary: Primary, threshold: i32) -> Self {
        Self { distance_weight: 0, ..Self::with_threshold(primary, Rgb::new(0, 0, 0), threshold) }
    }

    /// The right-hand side of eq. 1, in units of 1 / [`FULL_SCALE`].
    #[must_use]
    pub const fn threshold(&self) -> i32 {
        self.threshold
    }

    /// p_ref.
    #[must_use]
    pub const fn reference(&self) -> Rgb {
        self.reference
    }

    /// Which V judges the pixel.
    #[must_use]
    pub const fn primary(&self) -> Primary {
        self.primary
    }

    /// Eq. 1: whether M(p) reaches the threshold. Exact.
    #[inline]
    #[must_use]
    pub const fn accepts(&self, p: Rgb) -> bool {
        let [base, r, g, b] = self.excess;
        let excess = base + r * p.r as i32 + g * p.g as i32 + b * p.b as i32;
        // excess <= 2 * 12,240 and 3 S <= 585,225: the squares stay below 6e8, inside an i32
        excess >= 0
            && excess * excess
                >= distance_squared(p, self.reference) * (FRACTION * FRACTION * self.distance_weight)
    }

    /// M(p) in units of 1 / [`FULL_SCALE`], with the square root: for scores and plots.
    #[must_use]
    pub const fn matching(&self, p: Rgb) -> i32 {
        self.primary.luminance(p) * FRACTION - distance(p, self.reference) * self.distance_weight
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's definition, in real numbers.
    fn m_by_definition(primary: Primary, p: Rgb, reference: Rgb) -> f64 {
        let c = [p.r, p.g, p.b].map(|x| f64::from(x) / 255.0);
        let n = c.map(|x| 1.0 - x);
        let v = match primary {
            Primary::Red => c[0] + n[1] + n[2],
            Primary::Green => n[0] + c[1] + n[2],
            Primary::Blue => n[0] + n[1] + c[2],
            Primary::Yellow => c[0] + c[1] + n[2],
            Primary::Magenta => c[0] + c[2] + n[1],
            Primary::Cyan => c[1] + c[2] + n[0],
        } / 3.0;
        let q = [reference.r, reference.g, reference.b].map(|x| f64::from(x) / 255.0);
        let s: f64 = c.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum();
        v - libm::sqrt(s / 3.0)
    }

    /// Every 5th value of each component for the pixel, six primaries, several references, and
    /// thresholds over the whole range: about 60 million comparisons.
    #[test]
    fn the_integer_test_equals_the_definition_everywhere() {
        let references =
            [Rgb::new(200, 30, 40), Rgb::new(0, 0, 0), Rgb::new(255, 255, 255), Rgb::new(90, 140, 20)];
        let thresholds = [-12_240, -4_000, -1, 0, 1, 2_500, 5_001, 7_777, 9_000, 12_239, 12_240];
        for primary in Primary::ALL {
            for reference in references {
                for r in (0..=255).step_by(5) {
                    for g in (0..=255).step_by(5) {
                        for b in (0..=255).step_by(5) {
                            let p = Rgb::new(r, g, b);
                            let m = m_by_definition(primary, p, reference) * f64::from(FULL_SCALE);
                            for t in thresholds {
                                // Real numbers cannot decide a tie that f64 cannot represent.
                                if (m - f64::from(t)).abs() > 1e-6 {
                                    let matcher = Matcher::with_threshold(primary, reference, t);
                                    assert_eq!(
                                        matcher.accepts(p),
                                        m >= f64::from(t),
                                        "{p:?} {reference:?} {t}"
                                    );
                                }
                            }
                        }
                    }
                }
            }
        }
    }

    /// A tie is decided exactly: where V - T equals D in integers, eq. 1 holds with equality.
    #[test]
    fn a_tie_is_accepted() {
        let reference = Rgb::new(200, 0, 0);
        // D: differences (a, a, a) give 765 D = 3 a exactly.
        for a in 0..50u8 {
            let p = Rgb::new(200 - a, a, a);
            let tie = Primary::Red.luminance(p) * FRACTION - 3 * i32::from(a) * FRACTION;
            assert!(Matcher::with_threshold(Primary::Red, reference, tie).accepts(p));
            assert!(!Matcher::with_threshold(Primary::Red, reference, tie + 1).accepts(p));
        }
    }

    #[test]
    fn accepts_agrees_with_matching() {
        let reference = Rgb::new(180, 60, 20);
        for t in (-FULL_SCALE..=FULL_SCALE).step_by(97) {
            let matcher = Matcher::with_threshold(Primary::Red, reference, t);
            for i in 0..=255u8 {
                let p = Rgb::new(i, 255 - i, i / 2);
                assert_eq!(matcher.accepts(p), matcher.matching(p) >= t, "{p:?} {t}");
            }
        }
    }

    #[test]
    fn luminance_alone_ignores_the_distance() {
        let matcher = Matcher::luminance_only(Primary::Green, 500 * FRACTION);
        for i in 0..=255u8 {
            let p = Rgb::new(i / 2, i, i / 3);
            assert_eq!(matcher.accepts(p), Primary::Green.luminance(p) >= 500);
            assert_eq!(matcher.accepts(p), matcher.matching(p) >= matcher.threshold());
        }
    }

    #[test]
    fn the_six_references_are_their_own_best_match() {
        let pure = [(255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0), (255, 0, 255), (0, 255, 255)];
        for (primary, (r, g, b)) in Primary::ALL.into_iter().zip(pure) {
            let p = Rgb::new(r, g, b);
            assert_eq!(matching(primary, p, p), FULL_SCALE);
            for other in Primary::ALL.into_iter().filter(|o| *o != primary) {
                assert!(other.luminance(p) < 765);
            }
        }
    }

    #[test]
    fn a_ball_like_its_background_is_refused() {
        let c = Rgb::new(120, 120, 120);
        let reference = Reference { primary: Primary::Red, reference: c, typical: c, background: c };
        assert_eq!(Matcher::new(&reference, 128), Err(ColourError::NoContrast));
    }
}
