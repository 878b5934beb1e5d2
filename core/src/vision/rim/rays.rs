//! A first circle where the row-edge blob says too little: hidden in part, or lit from one side.
//!
//! Sixteen rays leave the blob's centre and end where the ball's hue does; of the circles through two
//! or three of the ends the one with the most ends near it is taken.

use super::unmix::{Palette, floats};
use crate::geometry::{DIRECTIONS, ImagePoint, round_to_i32};
use crate::vision::frame::FrameView;

/// Rays.
const RAYS: usize = DIRECTIONS.len();

/// Outside the ball the hue is so far from its own: the sine squared of 14 degrees.
const OTHER_HUE: f32 = 0.06;

/// Or it is darker than this share of its middle.
const DARK: f32 = 0.25;

/// A ray goes on for so many expected radii.
const FARTHEST: f32 = 2.2;

/// How many rays further on the second and third of three ends lie.
const TRIPLE: (usize, usize) = (5, 10);

/// How many rays further on the second of two ends lie.
const PAIR: usize = 4;

/// An end supports a circle within this share of its radius and so many pixels more.
const NEAR_SHARE: f32 = 0.06;
const NEAR_PIXELS: f32 = 0.8;

/// A circle from rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Circle {
    pub(super) centre: ImagePoint,
    pub(super) radius: f32,
}

/// What the rays go by.
pub(super) struct Rays<'a> {
    pub(super) frame: &'a FrameView<'a>,
    pub(super) palette: &'a Palette,
    pub(super) aspect: f32,
    /// How large the ball should be, pixels.
    pub(super) radius: f32,
    /// How far the radius may be from that, as a ratio above 1.
    pub(super) radius_range: f32,
}

impl Rays<'_> {
    /// The circle with the most ends of rays from `from` near it. `None` where no two ends agree.
    pub(super) fn circle(&self, from: ImagePoint, tested: &mut u32) -> Option<Circle> {
        let mut ends: heapless::Vec<(f32, f32), RAYS> = heapless::Vec::new();
        for towards in DIRECTIONS {
            if let Some(end) = self.end(from, towards, tested) {
                // there are as many places as rays
                let _ = ends.push(end);
            }
        }
        let mut best: Option<((f32, f32, f32), f32)> = None;
        let mut consider = |(x, y, r): (f32, f32, f32)| {
            let support = self.support(&ends, x, y, r);
            if best.is_none_or(|(_, most)| support > most) {
                best = Some(((x, y, r), support));
            }
        };
        for i in 0..ends.len() {
            let at = |ahead: usize| ends.get((i + ahead) % ends.len().max(1)).copied();
            let Some(p) = at(0) else { continue };
            if let (Some(q), Some(s)) = (at(TRIPLE.0), at(TRIPLE.1))
                && let Some(circle) = through_three(p, q, s)
            {
                consider(circle);
            }
            if let Some(q) = at(PAIR)
                && let Some(circle) = through_two(p, q, self.radius)
            {
                consider(circle);
            }
        }
        let ((x, y, radius), support) = best?;
        (support > 3.0)
            .then(|| Circle { centre: ImagePoint::new(from.u + x, from.v + y * self.aspect), radius })
    }

    /// Where a ray leaves the ball, from its start; rows divided by the aspect.
    fn end(&self, from: ImagePoint, (c, s): (f32, f32), tested: &mut u32) -> Option<(f32, f32)> {
        let farthest = round_to_i32(self.radius * FARTHEST) + 2;
        let mut left_at = None;
        for step in 1..=farthest {
            let t = step as f32;
            let pixel =
                self.frame.pixel(round_to_i32(from.u + t * c), round_to_i32(from.v + t * s * self.aspect))?;
            *tested += 1;
            let brightness = self.palette.brightness(&floats(pixel), OTHER_HUE);
            if brightness.is_none_or(|brightness| brightness < DARK) {
                // two in a row, so that one noisy pixel ends no ray
                match left_at {
                    Some(t) => return Some((c * t, s * t)),
                    None => left_at = Some(t - 0.5),
                }
            } else {
                left_at = None;
            }
        }
        None
    }

    /// How many ends are near a circle, each by how near; a circle of an odd size has none.
    fn support(&self, ends: &[(f32, f32)], x: f32, y: f32, radius: f32) -> f32 {
        let (least, most) = (self.radius / self.radius_range, self.radius * self.radius_range);
        if !(least..=most).contains(&radius) {
            return 0.0;
        }
        let near = NEAR_SHARE * radius + NEAR_PIXELS;
        let off = |(p, q): &(f32, f32)| {
            let (dx, dy) = (p - x, q - y);
            (libm::sqrtf(dx * dx + dy * dy) - radius) / near
        };
        ends.iter().map(off).map(|t| (1.0 - t * t).max(0.0)).sum()
    }
}

/// Centre and radius of the circle through three points.
fn through_three(p: (f32, f32), q: (f32, f32), s: (f32, f32)) -> Option<(f32, f32, f32)> {
    let (ax, ay) = (q.0 - p.0, q.1 - p.1);
    let (bx, by) = (s.0 - p.0, s.1 - p.1);
    let d = 2.0 * (ax * by - ay * bx);
    if libm::fabsf(d) < 1.0 {
        return None;
    }
    let (a2, b2) = (ax * ax + ay * ay, bx * bx + by * by);
    let (x, y) = ((by * a2 - ay * b2) / d, (ax * b2 - bx * a2) / d);
    Some((p.0 + x, p.1 + y, libm::sqrtf(x * x + y * y)))
}

/// The circle of a known radius through two points of which the second is further round, so that the
/// centre lies on the side of the rays' start.
fn through_two(p: (f32, f32), q: (f32, f32), radius: f32) -> Option<(f32, f32, f32)> {
    let (hx, hy) = ((q.0 - p.0) * 0.5, (q.1 - p.1) * 0.5);
    let half2 = hx * hx + hy * hy;
    let rise2 = radius * radius - half2;
    if half2 < 1.0 || rise2 < 0.0 {
        return None;
    }
    let k = libm::sqrtf(rise2 / half2);
    // rows point down: with angles growing towards them the start lies to the right of p -> q
    Some((p.0 + hx - hy * k, p.1 + hy + hx * k, radius))
}
