//! What was seen against what is true, for simulated scenes.

use crate::output::Spread;
use crate::pipeline::{HandStep, Step};
use nalgebra::{Matrix3, Vector3};
use tetrad_core::geometry::Pose;
use tetrad_core::observation::{BALLS, ObservationState};
use tetrad_fixtures::{BallTruth, HandTruth};

/// From which share of a ball in sight on it ought to be found.
pub const IN_SIGHT: f64 = 0.7;

/// How near its true place a ball must be to count as found: so many pixels ...
const FOUND_PX: f64 = 3.0;
/// ... or this share of its diameter, whichever is more.
const FOUND_DIAMETERS: f64 = 0.25;

/// How many balls were found, over all frames and cameras.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BallCounts {
    /// In sight by [`IN_SIGHT`].
    pub in_sight: u64,
    /// Of those, measured at their place: within 3 px or a quarter of the diameter.
    pub found: u64,
    /// Reported visible, and more than a diameter away from their place.
    pub false_detections: u64,
}

/// Errors gathered frame by frame.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    centre_px: Vec<f64>,
    position_mm: Vec<f64>,
    angle_deg: Vec<f64>,
    step_mm: Vec<f64>,
    frames: u64,
    tracked: u64,
    balls: BallCounts,
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
                let (u, v) = truth.outline_centre;
                let off_px = (f64::from(seen.centre.u) - u).hypot(f64::from(seen.centre.v) - v);
                if truth.visible_fraction >= IN_SIGHT {
                    let near = off_px <= FOUND_PX.max(FOUND_DIAMETERS * truth.diameter);
                    self.balls.in_sight += 1;
                    self.balls.found += u64::from(near && seen.state.is_measured());
                }
                if seen.state == ObservationState::Visible {
                    // a ball behind the camera has no place, and no distance to it
                    if off_px <= truth.diameter {
                        self.centre_px.push(off_px);
                    } else {
                        self.balls.false_detections += 1;
                    }
                }
            }
        }
        let Some(HandStep { report, .. }) = &step.hand else { return };
        let (Ok(motion), Some(pose)) = (&report.motion, &report.pose) else { return };
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

    /// How many balls were found.
    #[must_use]
    pub const fn balls(&self) -> BallCounts {
        self.balls
    }

    /// From a visible ball's centre to that of its true outline, pixels; false detections left out.
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
    use crate::pipeline::CameraStep;
    use nalgebra::Rotation3;
    use std::time::Duration;
    use tetrad_core::geometry::ImagePoint;
    use tetrad_core::observation::Observation;
    use tetrad_core::vision::tracker::StepReport;

    fn hand(x: f64, turn: f64) -> HandTruth {
        let axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5));
        HandTruth {
            rotation: *Rotation3::from_axis_angle(&axis, turn).matrix(),
            translation: Vector3::new(x, -x, 0.5 * x),
        }
    }

    /// A step of one camera that sees the red ball at (100, 100) and nothing else.
    fn step_with_red(state: ObservationState) -> Step {
        let mut report = StepReport::default();
        report.observations[0] = Observation {
            state,
            centre: ImagePoint::new(100.0, 100.0),
            diameter: 16.0,
            ..Observation::default()
        };
        Step { cameras: vec![CameraStep { report, tracking: Duration::ZERO }], hand: None }
    }

    /// The red ball at (u, 100), 20 px wide; the others are not in sight.
    fn red_at(u: f64, visible_fraction: f64) -> [BallTruth; BALLS] {
        let centre = (u, 100.0);
        let red = BallTruth { centre, outline_centre: centre, diameter: 20.0, visible_fraction };
        let hidden = BallTruth { visible_fraction: 0.0, ..red };
        [red, hidden, hidden, hidden]
    }

    #[test]
    fn a_ball_is_found_near_its_place_and_false_a_diameter_away() {
        use ObservationState::{Lost, Occluded, Predicted, Visible};
        // state, true u, share in sight -> in sight, found, false
        let cases = [
            (Visible, 104.9, 1.0, (1, 1, 0)),
            (Occluded, 104.9, 0.7, (1, 1, 0)),
            (Visible, 105.1, 1.0, (1, 0, 0)),
            (Visible, 120.1, 1.0, (1, 0, 1)),
            (Visible, 120.1, 0.1, (0, 0, 1)),
            (Occluded, 120.1, 0.1, (0, 0, 0)),
            (Predicted, 100.0, 1.0, (1, 0, 0)),
            (Lost, 100.0, 1.0, (1, 0, 0)),
        ];
        for (state, u, share, (in_sight, found, false_detections)) in cases {
            let mut comparison = Comparison::default();
            comparison.add(&step_with_red(state), &[red_at(u, share)], hand(0.0, 0.0));
            let counted = BallCounts { in_sight, found, false_detections };
            assert_eq!(comparison.balls(), counted, "{state:?} {u} {share}");
        }
        let mut comparison = Comparison::default();
        comparison.add(&step_with_red(Visible), &[red_at(103.0, 1.0)], hand(0.0, 0.0));
        comparison.add(&step_with_red(Visible), &[red_at(101.0, 1.0)], hand(0.0, 0.0));
        let centre = comparison.centre_px().unwrap();
        assert_eq!((centre.mean, centre.max), (2.0, 3.0));
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
