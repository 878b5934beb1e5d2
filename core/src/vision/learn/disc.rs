//! The ball's outline: the circle whose rim separates best the ball's colour from what is around.
//!
//! The point the operator gives lies anywhere inside the ball and nothing is known of its size, so
//! circles of every size that hold the point are compared by the contrast across their rims: how
//! saturated in the ball's colour pixels are just inside against just outside, in 32 directions. The
//! same idea locates the iris of an eye (Daugman's integro-differential operator). It needs no
//! threshold, which is what learning is about to find; it bridges highlights, which lie inside; and a
//! finger or a like-coloured neighbour at some directions costs only those.
//!
//! Saturation and not M, because shading leaves it alone. V is brightness as much as colour: the
//! shadow side of a yellow ball has the M of light grey, and an outline by M ends at the shadow.

use super::probe::{Probe, brightness, chroma, saturation};
use crate::config::{LearnConfig, MAX_DIAMETER};
use crate::geometry::ImagePoint;
use crate::vision::colour::Primary;
use crate::vision::frame::Rgb;

/// Directions in which a rim is examined.
pub(super) const DIRECTIONS: usize = 32;

/// A circle in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Disc {
    pub(super) u: f32,
    pub(super) v: f32,
    pub(super) radius: f32,
}

impl Disc {
    pub(super) const fn centre(&self) -> ImagePoint {
        ImagePoint::new(self.u, self.v)
    }

    /// Whether a point lies within `slack` radii and `pixels` of the centre.
    pub(super) fn holds(&self, point: ImagePoint, slack: f32, pixels: f32) -> bool {
        self.centre().distance(point) <= self.radius * slack + pixels
    }
}

/// What a rim showed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rim {
    /// Mean over the directions of contrast / (contrast + half): 0 none, towards 1 strong everywhere.
    pub(super) score: f32,
    /// Directions with a contrast above the least one that counts.
    pub(super) support: u16,
}

/// Judges rims by the ball's colour as far as it is known.
pub(super) struct RimFinder<'c> {
    primary: Primary,
    reference: Rgb,
    config: &'c LearnConfig,
    directions: [(f32, f32); DIRECTIONS],
}

impl<'c> RimFinder<'c> {
    pub(super) fn new(primary: Primary, reference: Rgb, config: &'c LearnConfig) -> Self {
        let mut directions = [(0.0, 0.0); DIRECTIONS];
        let step = 2.0 * core::f32::consts::PI / DIRECTIONS as f32;
        for (k, direction) in directions.iter_mut().enumerate() {
            let (sin, cos) = libm::sincosf(k as f32 * step);
            *direction = (cos, sin);
        }
        Self { primary, reference, config, directions }
    }

    /// Whether a pixel inside the rim may be the ball: colourful enough, and with enough of the
    /// reference's saturation. Without this, a black curtain before a white wall or a hand around
    /// the ball has a rim of its own, since both are nearer to the ball than what is behind them.
    pub(super) fn belongs(&self, p: Rgb) -> bool {
        let chroma_here = chroma(self.primary, p);
        // chroma / brightness >= share * chroma_ref / brightness_ref, without dividing
        let here = chroma_here * brightness(self.reference) * 256;
        let share = i32::from(self.config.saturation_share_256.min(256));
        let wanted = chroma(self.primary, self.reference) * brightness(p) * share;
        chroma_here >= self.config.least_chroma && here >= wanted
    }

    /// The contrast across a circle's rim, two pixels a side at `gap` and twice `gap` from it.
    /// Directions that leave the picture count as without contrast.
    pub(super) fn rim(&self, probe: &mut Probe<'_, '_>, disc: Disc, gap: f32) -> Rim {
        let mut rim = Rim::default();
        for &direction in &self.directions {
            let Some(contrast) = self.contrast(probe, disc, gap, direction) else {
                continue;
            };
            if contrast > 0.0 {
                rim.score += contrast / (contrast + self.config.half_contrast);
            }
            if contrast >= self.config.least_contrast {
                rim.support += 1;
            }
        }
        rim.score /= DIRECTIONS as f32;
        rim
    }

    /// Saturation inside less saturation outside in one direction, -1 to 1; `None` where the inside is
    /// not the ball's or the picture ends.
    fn contrast(
        &self,
        probe: &mut Probe<'_, '_>,
        disc: Disc,
        gap: f32,
        (cos, sin): (f32, f32),
    ) -> Option<f32> {
        let mut at = |radius: f32| probe.near(disc.u + radius * cos, disc.v + radius * sin);
        let [inner, deep] = [at((disc.radius - gap).max(0.0))?, at((disc.radius - 2.0 * gap).max(0.0))?];
        if !self.belongs(inner) || !self.belongs(deep) {
            return None;
        }
        let [outer, far] = [at(disc.radius + gap)?, at(disc.radius + 2.0 * gap)?];
        let [inner, deep, outer, far] = [inner, deep, outer, far].map(|p| saturation(self.primary, p));
        Some((inner + deep - outer - far) / 2.0)
    }

    /// The best circle that holds the point: every radius of a ladder, centres on a grid of
    /// 21 around the point, then a descent from the best.
    pub(super) fn search(&self, probe: &mut Probe<'_, '_>, at: ImagePoint) -> (Disc, Rim) {
        let ImagePoint { u, v } = at;
        let mut radius = self.least_radius();
        let mut best = (Disc { u, v, radius }, Rim::default());
        // One rung beyond the largest ball, so that a larger one is refused and not cut to size.
        let most = self.most_radius() * RADIUS_RATIO;
        let mut rung = 0;
        while radius <= most && rung < MOST_RUNGS {
            let gap = (radius * COARSE_GAP).max(1.0);
            for row in -2i8..=2 {
                for column in -2i8..=2 {
                    if row.abs() == 2 && column.abs() == 2 {
                        continue;
                    }
                    let pitch = radius * CENTRE_PITCH;
                    let disc =
                        Disc { u: u + f32::from(column) * pitch, v: v + f32::from(row) * pitch, radius };
                    let rim = self.rim(probe, disc, gap);
                    if rim.score > best.1.score {
                        best = (disc, rim);
                    }
                }
            }
            radius *= RADIUS_RATIO;
            rung += 1;
        }
        self.refine(probe, best.0)
    }

    /// Whether the ball's colour goes on all around a point as far as the largest ball would reach.
    pub(super) fn fills(&self, probe: &mut Probe<'_, '_>, at: ImagePoint) -> bool {
        let (mut seen, mut like) = (0u32, 0u32);
        for step in 1..=FILL_RINGS {
            let radius = self.most_radius() * step as f32 / FILL_RINGS as f32;
            for &(cos, sin) in &self.directions {
                if let Some(p) = probe.near(at.u + radius * cos, at.v + radius * sin) {
                    seen += 1;
                    like += u32::from(self.belongs(p));
                }
            }
        }
        like * 4 > seen * 3
    }

    /// Two rungs below the smallest ball, so that a smaller one is refused and not blown up.
    fn least_radius(&self) -> f32 {
        bounded(self.config.least_diameter) / 2.0 / (RADIUS_RATIO * RADIUS_RATIO)
    }

    fn most_radius(&self) -> f32 {
        bounded(self.config.most_diameter) / 2.0
    }

    /// Moves the centre and the radius while the rim's contrast grows, in ever smaller steps.
    pub(super) fn refine(&self, probe: &mut Probe<'_, '_>, from: Disc) -> (Disc, Rim) {
        let mut disc = from;
        let mut step = from.radius * COARSE_GAP;
        let mut rim = Rim::default();
        for _ in 0..MOST_HALVINGS {
            let gap = step.max(disc.radius * FINE_GAP).max(1.0);
            rim = self.rim(probe, disc, gap);
            for _ in 0..MOST_MOVES {
                let mut best = (disc, rim);
                for (du, dv, dr) in MOVES {
                    let moved = Disc {
                        u: disc.u + du * step,
                        v: disc.v + dv * step,
                        radius: (disc.radius + dr * step).max(self.least_radius()),
                    };
                    let there = self.rim(probe, moved, gap);
                    if there.score > best.1.score {
                        best = (moved, there);
                    }
                }
                if best.0 == disc {
                    break;
                }
                (disc, rim) = best;
            }
            step /= 2.0;
            if step < LEAST_STEP {
                break;
            }
        }
        (disc, rim)
    }
}

/// A diameter that can be worked with, whatever the configuration says.
fn bounded(diameter: f32) -> f32 {
    // The comparison is false for NaN.
    if diameter > LEAST_DIAMETER { diameter.min(MAX_DIAMETER) } else { LEAST_DIAMETER }
}

/// Nine pixels: less is a speck.
const LEAST_DIAMETER: f32 = 3.0;
/// Ratio of one radius of the ladder to the one before: the rim is felt within 12 % on either side.
const RADIUS_RATIO: f32 = 1.15;
/// Rungs enough for a ratio of 1.15 from the least to any diameter a picture can hold.
const MOST_RUNGS: u8 = 48;
/// Distance between the centres tried, in radii.
const CENTRE_PITCH: f32 = 0.35;
/// Half-width of the coarse rim, in radii.
const COARSE_GAP: f32 = 0.12;
/// Half-width of the finest rim, in radii.
const FINE_GAP: f32 = 0.04;
/// Pixels; finer steps are below what one pixel a direction can tell.
const LEAST_STEP: f32 = 0.2;
const MOST_HALVINGS: u8 = 8;
const MOST_MOVES: u8 = 6;
/// Rings looked at to tell a ball that fills the picture from a background.
const FILL_RINGS: u8 = 4;
const MOVES: [(f32, f32, f32); 6] =
    [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)];
