//! What was seen against what is true, for simulated scenes.

use crate::output::Spread;
use crate::pipeline::Step;
use nalgebra::{Matrix3, Vector3};
use tetrad_core::geometry::Pose;
use tetrad_core::observation::{BALLS, ObservationState};
use tetrad_fixtures::{BallTruth, HandTruth};

/// From which share of a ball in sight on it ought to be seen.
pub const OUGHT_TO_BE_SEEN: f64 = 0.7;

/// Errors gathered frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    centre_px: Vec<f64>,
    position_mm: Vec<f64>,
    angle_deg: Vec<f64>,
    step_mm: Vec<f64>,
    frames: u64,
    tracked: u64,
    expected: u64,
    missed: u64,
    /// The hand in the first complete frame, which the pose is told from.
    first: Option<HandTruth>,
    /// The hand in the last complete frame, which the increment is told from.
    last: Option<HandTruth>,
}

impl Comparison {
    /// Adds a step with the truth of its frame: of the balls in each camera and of the hand.
    pub fn add(&mut self, step: &Step, balls: &[[BallTruth; BALLS]], hand: HandTruth) {
        self.frames += 1;
        for (camera, truths) in step.cameras.iter().zip(balls) {
            for (seen, truth) in camera.report.observations.iter().zip(truths) {
                if truth.visible_fraction >= OUGHT_TO_BE_SEEN {
                    self.expected += 1;
                    self.missed += u64::from(!seen.state.is_measured());
                }
                if seen.state == ObservationState::Visible {
                    let (u, v) = truth.outline_centre;
                    self.centre_px.push((f64::from(seen.centre.u) - u).hypot(f64::from(seen.centre.v) - v));
                }
            }
        }
        let Some(hand_step) = &step.hand else { return };
        let (Ok(motion), Some(pose)) = (&hand_step.motion, &hand_step.pose) else { return };
        self.tracked += 1;
        let first = *self.first.get_or_insert(hand);
        let (position_m, angle_rad) = difference(pose, &first, &hand);
        self.position_mm.push(position_m * 1e3);
        self.angle_deg.push(angle_rad.to_degrees());
        if let Some(last) = self.last.replace(hand) {
            let increment = Pose { rotation: motion.phi, translation: motion.alpha };
            self.step_mm.push(difference(&increment, &last, &hand).0 * 1e3);
        }
    }

    /// Frames compared.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Frames in which the hand's motion was solved.
    #[must_use]
    pub const fn tracked(&self) -> u64 {
        self.tracked
    }

    /// Balls that ought to be seen (in sight by [`OUGHT_TO_BE_SEEN`]), and how many of them were not.
    #[must_use]
    pub const fn expected_and_missed(&self) -> (u64, u64) {
        (self.expected, self.missed)
    }

    /// From a visible ball's centre to that of its true outline, pixels.
    #[must_use]
    pub fn centre_px(&self) -> Option<Spread> {
        Spread::of(self.centre_px.iter().copied())
    }

    /// From the pose to the true one, both in the first complete feature frame, millimetres.
    #[must_use]
    pub fn position_mm(&self) -> Option<Spread> {
        Spread::of(self.position_mm.iter().copied())
    }

    /// The angle between the pose and the true one, degrees.
    #[must_use]
    pub fn angle_deg(&self) -> Option<Spread> {
        Spread::of(self.angle_deg.iter().copied())
    }

    /// From the increment alpha to the true one, millimetres.
    #[must_use]
    pub fn step_mm(&self) -> Option<Spread> {
        Spread::of(self.step_mm.iter().copied())
    }
}

/// `base_from_now` out of two poses in the world.
#[must_use]
pub fn relative(base: &HandTruth, now: &HandTruth) -> (Matrix3<f64>, Vector3<f64>) {
    let base_from_world = base.rotation.transpose();
    (base_from_world * now.rotation, base_from_world * (now.translation - base.translation))
}

/// Metres and radians between a measured `base_from_now` and the true one.
fn difference(measured: &Pose, base: &HandTruth, now: &HandTruth) -> (f64, f64) {
    let (rotation, translation) = relative(base, now);
    let off = measured.translation.cast::<f64>() - translation;
    let turn = rotation.transpose() * measured.rotation.cast::<f64>();
    // |R - I| = 2 sqrt 2 sin(angle / 2): exact for small angles, where the arc cosine is not
    let half_sine = (turn - Matrix3::identity()).norm() / 8.0_f64.sqrt();
    (off.norm(), 2.0 * half_sine.min(1.0).asin())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn hand(x: f64, turn: f64) -> HandTruth {
        let axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5));
        HandTruth {
            rotation: *Rotation3::from_axis_angle(&axis, turn).matrix(),
            translation: Vector3::new(x, -x, 0.5 * x),
        }
    }

    #[test]
    fn a_pose_that_is_right_has_no_error_whatever_the_base() {
        for turn in [0.0, 0.3, 3.0] {
            let (base, now) = (hand(0.1, turn), hand(0.3, turn + 0.7));
            let (rotation, translation) = relative(&base, &now);
            let measured = Pose { rotation: rotation.cast(), translation: translation.cast() };
            let (metres, radians) = difference(&measured, &base, &now);
            assert!(metres < 1e-7 && radians < 1e-6, "{metres} {radians}");
        }
    }

    #[test]
    fn errors_are_metres_and_radians() {
        let base = hand(0.2, 0.4);
        let still = Pose { translation: nalgebra::Vector3::new(0.003, 0.0, 0.004), ..Pose::identity() };
        let (metres, radians) = difference(&still, &base, &base);
        assert!((metres - 0.005).abs() < 1e-9 && radians < 1e-9, "{metres} {radians}");
        for turn in [1e-4, 0.2, 3.1] {
            let (_, radians) = difference(&Pose::identity(), &hand(0.2, 0.4), &hand(0.2, 0.4 + turn));
            assert!((radians - turn).abs() < 1e-6, "{turn}: {radians}");
        }
    }
}
