//! From an outline to the colours of eq. 1, chosen so that the tracker will see the same ball.

use super::disc::Disc;
use super::histogram::{self, Populations};
use super::probe::Probe;
use crate::config::LearnConfig;
use crate::geometry::ImagePoint;
use crate::vision::centre::{Blob, row_edge_centre};
use crate::vision::colour::{Matcher, Primary, Reference};
use crate::vision::edges::{Abandoned, RowEdges, SpiralLimits};

/// An outline and what clustering made of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settled {
    pub(super) disc: Disc,
    pub(super) reference: Reference,
    pub(super) matcher: Matcher,
    pub(super) separation: f32,
    pub(super) blob: Result<Blob, Abandoned>,
}

impl Settled {
    /// Clusters the disc against its neighbourhood; `None` where the two are not told apart at all.
    pub(super) fn of(
        probe: &mut Probe<'_, '_>,
        disc: Disc,
        primary: Primary,
        config: &LearnConfig,
    ) -> Option<Self> {
        let colour = histogram::reference(probe, disc)?;
        let populations = Populations::count(probe, disc, primary, colour)?;
        let separation = populations.separation();
        let mut settled = None;
        // The threshold is set more and more against the neighbourhood until the rows are the ball
        // that the outline shows; where no threshold does that, it stays at the strictest.
        for weight in config.ring_weights {
            let Some((reference, from)) = populations.settle(probe, weight, config.alpha_256) else {
                continue;
            };
            let Ok(matcher) = Matcher::new(&reference, config.alpha_256) else {
                continue;
            };
            let blob = blob(probe, &matcher, disc, from);
            settled = Some(Self { disc, reference, matcher, separation, blob });
            if blob.is_ok_and(|b| agrees(&b, disc)) {
                break;
            }
        }
        settled
    }

    /// The same for a ball so small that its rim has fewer pixels than directions: there the area of
    /// the rows is the better measure, and the outline is set by it.
    pub(super) fn by_area(
        self,
        probe: &mut Probe<'_, '_>,
        primary: Primary,
        config: &LearnConfig,
    ) -> Option<Self> {
        let blob = self.blob.ok()?;
        let radius = libm::sqrtf(blob.area / core::f32::consts::PI);
        let disc = Disc { u: blob.centre.u, v: blob.centre.v, radius };
        let again = Self::of(probe, disc, primary, config)?;
        (again.separation >= config.least_separation).then_some(again)
    }
}

/// The rows the tracker would find, started on a pixel of the ball. Never a part of its caller: the table
/// is given back before anything else is counted.
#[inline(never)]
fn blob(
    probe: &mut Probe<'_, '_>,
    matcher: &Matcher,
    disc: Disc,
    from: (i32, i32),
) -> Result<Blob, Abandoned> {
    let mut edges = RowEdges::ZERO;
    edges.clear();
    let side = (SPIRAL_RADII * disc.radius).max(LEAST_SIDE);
    let limits = SpiralLimits { side, min_match_256: LEAST_MATCH_256 };
    let mut tested = 0;
    let collected = edges.collect(probe.frame(), matcher, from, limits, &mut tested);
    probe.count(tested);
    collected?;
    row_edge_centre(probe.frame(), &edges).ok_or(Abandoned::NoMatch)
}

/// Whether the rows make the same ball as the outline does.
fn agrees(blob: &Blob, disc: Disc) -> bool {
    let diameter = 2.0 * disc.radius;
    let slack = AGREEMENT * diameter + 1.0;
    let off = ImagePoint::new(disc.u, disc.v).distance(blob.centre);
    // Pixels that are not square, and blur, make the rows fewer or more than they are long.
    (blob.diameter - diameter).abs() <= slack && (blob.height - diameter).abs() <= 1.5 * slack && off <= slack
}

/// Of 1000 pixels of a grid over the picture, the ball left out, how many pass eq. 1.
pub(super) fn clash(probe: &mut Probe<'_, '_>, settled: &Settled, samples: u16) -> u16 {
    let pixels = (probe.width() * probe.height()) as f32;
    let step = libm::ceilf(libm::sqrtf(pixels / f32::from(samples.max(1)))).max(1.0) as i32;
    let (mut tested, mut passed) = (0u32, 0u32);
    let mut y = step / 2;
    while y < probe.height() {
        let mut x = step / 2;
        while x < probe.width() {
            if !settled.disc.holds(ImagePoint::new(x as f32, y as f32), CLASH_SLACK, 1.0)
                && let Some(p) = probe.pixel(x, y)
            {
                tested += 1;
                passed += u32::from(settled.matcher.accepts(p));
            }
            x += step;
        }
        y += step;
    }
    (passed * 1000).checked_div(tested).unwrap_or(0) as u16
}

/// The square of three diameters of section 3.2, in radii.
const SPIRAL_RADII: f32 = 6.0;
/// Pixels: what a ball taken for too small may need.
const LEAST_SIDE: f32 = 16.0;
/// The least share of matched pixels in a spiral, 1/256, as the tracker has it by default.
const LEAST_MATCH_256: u32 = 12;
/// How far the rows may be from the outline, in diameters.
const AGREEMENT: f32 = 0.25;
/// The ball and its soft rim, in radii, left out of the clash score.
const CLASH_SLACK: f32 = 1.3;
