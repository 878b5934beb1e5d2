//! What is true of a frame.

use crate::outline::{LINES_PER_ROW, Outline};
use crate::scene::Scene;
use nalgebra::{Matrix3, Vector3};
use tetrad_core::observation::{BALLS, Ball};

/// One ball in one picture, at the middle of the exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallTruth {
    /// Where the sphere's centre appears, pixels: what a pose is computed from.
    pub centre: (f64, f64),
    /// The centre of the sphere's outline, pixels: what a camera can measure. Perspective puts it
    /// farther from the middle of the picture than `centre`, by 0.01 px for a ball of 16 px.
    pub outline_centre: (f64, f64),
    /// The diameter of the disc that has the outline's area, pixels.
    pub diameter: f64,
    /// The share of the outline's area that is inside the picture and in front of everything else,
    /// 0 to 1.
    pub visible_fraction: f64,
}

/// The pose of the feature frame, `world_from_hand`: the red ball is its origin, the green, blue and
/// yellow balls lie on its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandTruth {
    /// Columns are E1, E2, E3 in the world: a proper rotation.
    pub rotation: Matrix3<f64>,
    /// The red ball's centre in the world, metres.
    pub translation: Vector3<f64>,
}

impl Scene {
    /// The hand's pose at the middle of a frame's exposure.
    #[must_use]
    pub fn hand(&self, frame: usize) -> HandTruth {
        self.hand_at(self.time_s(frame))
    }

    /// Where the four balls are in a picture: red, green, blue, yellow. A ball behind the camera has
    /// no finite centre and is not visible.
    ///
    /// # Panics
    /// When there is no such camera.
    #[must_use]
    pub fn truth(&self, frame: usize, camera: usize) -> [BallTruth; BALLS] {
        let time_s = self.time_s(frame);
        let things = self.things(camera, time_s);
        let centres = self.balls_at(time_s);
        Ball::ALL.map(|ball| {
            let nowhere = (f64::NAN, f64::NAN);
            let found = things.iter().enumerate().find_map(|(i, thing)| match thing.outline {
                Outline::Sphere(sphere) if thing.ball == Some(ball) => Some((i, thing, sphere)),
                _ => None,
            });
            let Some((i, thing, sphere)) = found else {
                return BallTruth {
                    centre: nowhere,
                    outline_centre: nowhere,
                    diameter: 0.0,
                    visible_fraction: 0.0,
                };
            };
            let nearer: Vec<Outline> = things[i + 1..].iter().map(|other| other.outline).collect();
            BallTruth {
                centre: self.cameras[camera].project(&centres[ball.index()]).unwrap_or(nowhere),
                outline_centre: sphere.centre,
                diameter: sphere.diameter,
                visible_fraction: visible(&thing.outline, &nearer, self.width, self.height),
            }
        })
    }
}

/// The share of an outline that is in the picture and not behind any of `nearer`.
fn visible(outline: &Outline, nearer: &[Outline], width: u16, height: u16) -> f64 {
    let [.., top, bottom] = outline.bounds();
    let (left_border, right_border) = (-0.5, f64::from(width) - 0.5);
    let (top_border, bottom_border) = (-0.5, f64::from(height) - 0.5);
    // lines as the renderer has, but at least 64 across the outline
    let lines = ((bottom - top) * LINES_PER_ROW as f64).max(64.0) as usize;
    let (mut whole, mut seen) = (0.0, 0.0);
    let mut hidden: Vec<(f64, f64)> = Vec::with_capacity(nearer.len());
    for line in 0..lines {
        let y = top + (bottom - top) * (line as f64 + 0.5) / lines as f64;
        let Some((left, right)) = outline.interval(y) else { continue };
        whole += right - left;
        if y < top_border || y >= bottom_border {
            continue;
        }
        hidden.clear();
        hidden.extend(nearer.iter().filter_map(|other| other.interval(y)));
        hidden.sort_by(|a, b| a.0.total_cmp(&b.0));
        // what is left of the interval between one hidden stretch and the next
        let (mut at, end) = (left.max(left_border), right.min(right_border));
        for &(from, to) in &hidden {
            seen += (from.min(end) - at).max(0.0);
            at = at.max(to);
        }
        seen += (end - at).max(0.0);
    }
    if whole > 0.0 { seen / whole } else { 0.0 }
}
