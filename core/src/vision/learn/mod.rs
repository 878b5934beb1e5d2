//! Teaching a colour: from one point inside a ball to all that eq. 1 needs (section 3.1).
//!
//! 1. The colour at the point; on a highlight, the most colourful pixel near it (`seed`).
//! 2. The outline: the circle around the point with the most contrast of saturation across its rim
//!    (`disc`).
//! 3. The histogram of the disc against that of the ring around it: the reference colour
//!    (`histogram`), with which the outline is sought once more.
//! 4. M of both populations: the threshold that separates them best, and from it the typical and the
//!    background pixel of eq. 1, made stricter until the rows that eq. 1 matches are the ball that the
//!    outline shows.
//! 5. The clash score: how much of the rest of the picture passes eq. 1 as well.
//!
//! Worst case, whatever the picture, in pixels read: twice 21 centres x 29 radii x 32 directions x 4
//! (156,000) and their refinement (74,000), eleven visits of the ball's surroundings (at most 97 x 97
//! each) and four spirals of three diameters (at most 387 x 387 each): under a million. A ball of 16
//! pixels takes some 180,000. About 4 KiB of stack: two histograms of 1 KiB, the rows of a ball 1.5.

mod disc;
mod histogram;
mod probe;
pub mod propose;
mod scan;
mod seed;
mod settle;

use super::centre::Blob;
use super::colour::{Primary, Reference};
use super::edges::Abandoned;
use super::frame::FrameView;
use crate::config::LearnConfig;
use crate::geometry::ImagePoint;
use core::fmt;
use disc::RimFinder;
use probe::Probe;
pub use scan::{HorizontalScan, ScanColumn};
use seed::seed_colour;
use settle::Settled;

/// What one ball taught.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learnt {
    /// Reference, typical and background colours: eq. 1 for this ball in this camera.
    pub reference: Reference,
    /// The centre of the outline, pixels.
    pub centre: ImagePoint,
    /// The diameter of the outline, pixels.
    pub diameter: f32,
    /// What the tracker will see of it: the rows that eq. 1 matches with the learnt colours, or why
    /// they have no bound (what touches the ball matches too).
    pub blob: Result<Blob, Abandoned>,
    /// Contrast across the rim, 0 to 1, averaged over its directions.
    pub rim: f32,
    /// Directions of 32 in which the rim shows.
    pub support: u16,
    /// Share of the ball less share of its neighbourhood above the best threshold, 0 to 1.
    pub separation: f32,
    /// Of 1000 pixels elsewhere in the picture, how many pass eq. 1 too.
    pub clash_permille: u16,
    /// Pixels read to learn all this.
    pub pixels_tested: u32,
}

/// Why a point teaches nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LearnError {
    /// The point is not in the picture.
    Outside,
    /// At the point there is nothing of this colour, or nothing with an outline.
    Background,
    /// The ball is smaller than can be told from noise.
    TooSmall,
    /// The outline is larger than a ball may be, or than the picture.
    TooLarge,
    /// White or black all around the point.
    Saturated,
    /// The ball's colour is not told from its neighbourhood.
    NoContrast,
    /// With the colours that all balls taught the tracker does not find this one in the picture they
    /// were learnt from. For who teaches several balls: [`learn`] knows of one.
    NotFoundAgain,
}

impl fmt::Display for LearnError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Outside => "the point is outside the picture",
            Self::Background => "there is no ball of this colour at the point; point inside the ball",
            Self::TooSmall => "the ball is too small; bring it nearer to the camera or zoom in",
            Self::TooLarge => "the ball is too large or fills the picture; move it away from the camera",
            Self::Saturated => "the picture is blown out or black at the point; change exposure or light",
            Self::NoContrast => "the ball looks like what is around it; change the background or the light",
            Self::NotFoundAgain => {
                "the ball looks like another one, and would not be found; change the light or the ball"
            }
        })
    }
}

impl core::error::Error for LearnError {}

/// Learns one ball from a point inside it.
///
/// # Errors
/// [`LearnError`] says why nothing was learnt.
pub fn learn(
    frame: &FrameView<'_>,
    primary: Primary,
    at: ImagePoint,
    config: &LearnConfig,
) -> Result<Learnt, LearnError> {
    learn_with(&mut Probe::new(frame), primary, at, config)
}

/// [`learn`], counting what is read whether or not it succeeds.
fn learn_with(
    probe: &mut Probe<'_, '_>,
    primary: Primary,
    at: ImagePoint,
    config: &LearnConfig,
) -> Result<Learnt, LearnError> {
    let before = probe.tested();
    let (x, y) = (libm::roundf(at.u) as i32, libm::roundf(at.v) as i32);
    if !at.is_finite() || !probe.frame().contains(x, y) {
        return Err(LearnError::Outside);
    }
    let seed = seed_colour(probe, primary, at, config)?;
    let finder = RimFinder::new(primary, seed, config);
    let (mut disc, mut rim) = finder.search(probe, at);
    for _ in 0..config.passes {
        // Again with the colour of the whole ball instead of that of one spot.
        let colour = histogram::reference(probe, disc).ok_or(LearnError::NoContrast)?;
        (disc, rim) = RimFinder::new(primary, colour, config).search(probe, disc.centre());
    }
    if rim.support < config.least_support || rim.score < config.least_rim {
        let everywhere = finder.fills(probe, at);
        return Err(if everywhere { LearnError::TooLarge } else { LearnError::Background });
    }
    if !disc.holds(at, POINT_SLACK, 1.0) {
        return Err(LearnError::Background);
    }
    if 2.0 * disc.radius > config.most_diameter {
        return Err(LearnError::TooLarge);
    }
    // A speck of two or three pixels may leave nothing to cluster.
    let tiny = 2.0 * disc.radius < config.least_diameter;
    let unsettled = if tiny { LearnError::TooSmall } else { LearnError::NoContrast };
    let mut settled = Settled::of(probe, disc, primary, config).ok_or(unsettled)?;
    if 2.0 * disc.radius < config.area_diameter {
        settled = settled.by_area(probe, primary, config).unwrap_or(settled);
    }
    let diameter = 2.0 * settled.disc.radius;
    if diameter < config.least_diameter {
        return Err(LearnError::TooSmall);
    }
    if settled.separation < config.least_separation {
        return Err(LearnError::NoContrast);
    }
    let clash_permille = settle::clash(probe, &settled, config.clash_samples);
    Ok(Learnt {
        reference: settled.reference,
        centre: settled.disc.centre(),
        diameter,
        blob: settled.blob,
        rim: rim.score,
        support: rim.support,
        separation: settled.separation,
        clash_permille,
        pixels_tested: probe.tested().saturating_sub(before),
    })
}

/// The point may lie this many radii (and a pixel) from the centre: it is the operator's, and the rim
/// is soft.
const POINT_SLACK: f32 = 1.1;

#[cfg(test)]
mod tests;
