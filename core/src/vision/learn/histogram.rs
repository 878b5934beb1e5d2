//! Clustering: the histogram of the ball against that of its immediate neighbourhood (section 3.1).
//!
//! Two histograms of 8 x 8 x 8 cells hold the colours of the disc and of the ring around it. A cell
//! belongs to the ball where the disc has more of it than the ring, as shares. The mean of those
//! pixels is the reference; then M of both populations, in a histogram of one dimension, gives the
//! threshold that separates them best, and the typical and background pixels that put eq. 1 there.

use super::disc::Disc;
use super::probe::Probe;
use crate::vision::colour::{FULL_SCALE, Primary, Reference, distance_squared, matching};
use crate::vision::frame::Rgb;
use core::num::NonZeroU32;

/// Cells along one component; 8^3 counts of 16 bits are one kibibyte, small enough for the stack of a
/// microcontroller and coarse enough that a ball of 20 pixels fills its cells.
const SIDE: usize = 8;
const CELLS: usize = SIDE * SIDE * SIDE;
/// Levels of M between -1 and 1: 1.6 % each.
const LEVELS: usize = 128;

/// Where a sample lies.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Ball,
    Ring,
}

/// Visits the pixels of the disc (up to `INNER` of its radius) and of the ring around it, on a grid
/// wide enough that there are at most about `SAMPLES_ACROSS` squared of them.
fn visit(probe: &mut Probe<'_, '_>, disc: Disc, mut each: impl FnMut(Side, (i32, i32), Rgb)) {
    let ring = (disc.radius * RING_INNER).max(disc.radius + RIM_PIXELS);
    let reach = (disc.radius * RING_OUTER).max(ring + RIM_PIXELS);
    let step = libm::ceilf(2.0 * reach / SAMPLES_ACROSS).max(1.0) as i32;
    let half = libm::ceilf(reach) as i32;
    let (cx, cy) = (libm::roundf(disc.u) as i32, libm::roundf(disc.v) as i32);
    let inner = disc.radius * INNER;
    let mut y = cy - half;
    while y <= cy + half {
        let mut x = cx - half;
        while x <= cx + half {
            let (du, dv) = (x as f32 - disc.u, y as f32 - disc.v);
            let squared = du * du + dv * dv;
            let side = if squared <= inner * inner {
                Some(Side::Ball)
            } else if squared >= ring * ring && squared <= reach * reach {
                Some(Side::Ring)
            } else {
                None
            };
            if let Some(side) = side
                && let Some(p) = probe.pixel(x, y)
            {
                each(side, (x, y), p);
            }
            x += step;
        }
        y += step;
    }
}

const SAMPLES_ACROSS: f32 = 96.0;
/// The rim itself is mixed with the background: left out.
const INNER: f32 = 0.9;
/// Pixels that a soft rim, and an outline that is not quite right, take at least.
const RIM_PIXELS: f32 = 1.5;
const RING_INNER: f32 = 1.15;
const RING_OUTER: f32 = 1.8;

fn cell(p: Rgb) -> usize {
    let [r, g, b] = [p.r, p.g, p.b].map(|c| usize::from(c >> 5));
    (r * SIDE + g) * SIDE + b
}

fn level(m: i32) -> usize {
    let from_bottom = (m + FULL_SCALE).max(0) as usize * LEVELS / (2 * FULL_SCALE as usize + 1);
    from_bottom.min(LEVELS - 1)
}

fn count<const N: usize>(table: &mut [u16; N], at: usize) {
    if let Some(slot) = table.get_mut(at) {
        *slot = slot.saturating_add(1);
    }
}

/// The mean colour of the cells of which the disc holds a greater share than the ring does; `None`
/// when either has no pixels or no cell belongs to the ball.
pub(super) fn reference(probe: &mut Probe<'_, '_>, disc: Disc) -> Option<Rgb> {
    let mut ball = [0u16; CELLS];
    let mut ring = [0u16; CELLS];
    let (mut of_ball, mut of_ring) = (0u32, 0u32);
    visit(probe, disc, |side, _, p| match side {
        Side::Ball => {
            count(&mut ball, cell(p));
            of_ball += 1;
        }
        Side::Ring => {
            count(&mut ring, cell(p));
            of_ring += 1;
        }
    });
    if of_ball == 0 {
        return None;
    }
    let mut sum = [0u32; 3];
    let mut members = 0u32;
    visit(probe, disc, |side, _, p| {
        let at = cell(p);
        let (b, r) = (ball.get(at).copied().unwrap_or(0), ring.get(at).copied().unwrap_or(0));
        if side == Side::Ball && u32::from(b) * of_ring.max(1) > u32::from(r) * of_ball {
            for (s, c) in sum.iter_mut().zip([p.r, p.g, p.b]) {
                *s += u32::from(c);
            }
            members += 1;
        }
    });
    let all = NonZeroU32::new(members)?;
    let [r, g, b] = sum.map(|s| ((s + members / 2) / all).min(255) as u8);
    Some(Rgb::new(r, g, b))
}

/// M of the disc's and of the ring's pixels for one reference colour.
pub(super) struct Populations {
    disc: Disc,
    primary: Primary,
    reference: Rgb,
    ball: [u16; LEVELS],
    ring: [u16; LEVELS],
    of_ball: u32,
    of_ring: u32,
}

impl Populations {
    /// Counts both; `None` when either is empty.
    pub(super) fn count(
        probe: &mut Probe<'_, '_>,
        disc: Disc,
        primary: Primary,
        reference: Rgb,
    ) -> Option<Self> {
        let mut counted =
            Self { disc, primary, reference, ball: [0; LEVELS], ring: [0; LEVELS], of_ball: 0, of_ring: 0 };
        visit(probe, disc, |side, _, p| {
            let at = level(matching(primary, p, reference));
            match side {
                Side::Ball => {
                    count(&mut counted.ball, at);
                    counted.of_ball += 1;
                }
                Side::Ring => {
                    count(&mut counted.ring, at);
                    counted.of_ring += 1;
                }
            }
        });
        (counted.of_ball > 0 && counted.of_ring > 0).then_some(counted)
    }

    /// For each level as threshold, from the top down: the share of the ball that passes less
    /// `weight` times the share of the ring that does.
    fn gains(&self, weight: f32) -> impl Iterator<Item = (usize, f32)> + '_ {
        let (mut ball_above, mut ring_above) = (0u32, 0u32);
        self.ball.iter().zip(&self.ring).enumerate().rev().map(move |(at, (ball, ring))| {
            ball_above += u32::from(*ball);
            ring_above += u32::from(*ring);
            let (ball, ring) = (ball_above as f32, ring_above as f32);
            (at, ball / self.of_ball as f32 - weight * ring / self.of_ring as f32)
        })
    }

    /// The best share of the ball that passes less the share of the ring that does: 0 to 1.
    pub(super) fn separation(&self) -> f32 {
        self.gains(1.0).fold(0.0, |best, (_, gain)| best.max(gain))
    }

    /// The threshold with the best gain. Where a gap lies between the two populations every
    /// threshold in it is as good: its middle keeps most away from both.
    fn threshold(&self, weight: f32) -> i32 {
        let best = self.gains(weight).fold(0.0f32, |best, (_, gain)| best.max(gain));
        let near = self.gains(weight).filter(|(_, gain)| *gain >= best - PLATEAU);
        let (low, high) = near.fold((LEVELS, 0), |(low, high), (at, _)| (low.min(at), high.max(at)));
        (bound(low) + bound(high)) / 2
    }

    /// The middle of the level that holds the median of M over the ball.
    fn median(&self) -> i32 {
        let mut below = 0u32;
        let level = self.ball.iter().position(|count| {
            below += u32::from(*count);
            below * 2 >= self.of_ball
        });
        let level = level.unwrap_or(LEVELS - 1);
        (bound(level) + bound(level + 1)) / 2
    }

    /// The pixel that stands for the ball, with its place: one whose M is the median. Below its peak
    /// at the reference, M comes twice along the shades of a colour, on the bright side and on the dark
    /// one; a pixel far from the reference is a bad picture of the ball, whatever its M, and the tracker
    /// may take the whole ball for one of another colour. Then it is the one nearest to the reference of
    /// those that have the median's M.
    fn typical(&self, probe: &mut Probe<'_, '_>) -> Option<((i32, i32), Rgb)> {
        let median = self.median();
        let first = self.nearest(probe, Side::Ball, median)?;
        let length = distance_squared(self.reference, Rgb::new(0, 0, 0));
        let most = length * TYPICAL_SHARE_256 / 256 * TYPICAL_SHARE_256 / 256;
        if distance_squared(first.1, self.reference) <= most {
            return Some(first);
        }
        let mut best = first;
        visit(probe, self.disc, |side, at, p| {
            let off = (matching(self.primary, p, self.reference) - median).abs();
            if side == Side::Ball
                && off <= bound(1) - bound(0)
                && distance_squared(p, self.reference) < distance_squared(best.1, self.reference)
            {
                best = (at, p);
            }
        });
        Some(best)
    }

    /// The typical pixel of the ball, with its place, and the pixel of the ring that puts the
    /// threshold of eq. 1 where it separates best; `None` only when the picture has changed.
    pub(super) fn settle(
        &self,
        probe: &mut Probe<'_, '_>,
        weight: f32,
        alpha_256: u16,
    ) -> Option<(Reference, (i32, i32))> {
        let (at, typical) = self.typical(probe)?;
        let of_typical = matching(self.primary, typical, self.reference);
        // Eq. 1 is T = B + a (Y - B); solved for M(p_bkg): B = (T - a Y) / (1 - a).
        let threshold = self.threshold(weight);
        let alpha = i32::from(alpha_256);
        let wanted = match 256 - alpha {
            rest if rest > 0 => (256 * threshold - alpha * of_typical) / rest,
            _ => threshold,
        };
        let (_, background) = self.nearest(probe, Side::Ring, wanted)?;
        Some((Reference { primary: self.primary, reference: self.reference, typical, background }, at))
    }

    /// The pixel of one side whose M comes nearest to `wanted`; among equals the first.
    fn nearest(&self, probe: &mut Probe<'_, '_>, side: Side, wanted: i32) -> Option<((i32, i32), Rgb)> {
        let mut best = None;
        let mut least = i32::MAX;
        visit(probe, self.disc, |here, at, p| {
            if here == side {
                let off = (matching(self.primary, p, self.reference) - wanted).abs();
                if off < least {
                    least = off;
                    best = Some((at, p));
                }
            }
        });
        best
    }
}

/// How far a typical pixel may be from the reference, as a share (1/256) of the reference's distance from
/// black: two fifths brighter or darker. Red, green and yellow paint are half of it apart in any shade.
const TYPICAL_SHARE_256: i32 = 102;

/// Thresholds that separate as well as the best, within this share.
const PLATEAU: f32 = 0.01;

/// The least M of a level.
const fn bound(level: usize) -> i32 {
    level as i32 * (2 * FULL_SCALE + 1) / LEVELS as i32 - FULL_SCALE
}
