use super::*;
use crate::hand::synthetic::{Camera, arms, cameras, difference, number, pose, two_cameras};
use crate::observation::ObservationState;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::{string::ToString, vec::Vec};

fn tracker() -> MotionTracker {
    MotionTracker::new(arms(), HandConfig::default())
}

fn observe(cameras: &[Camera], hand: &Pose) -> Vec<Observations> {
    cameras.iter().map(|camera| camera.observe(hand)).collect()
}

/// A hand in front of the cameras, and a small step of it.
fn start() -> Pose {
    let tilt = nalgebra::Rotation3::from_euler_angles(0.4, -0.3, 0.2);
    Pose { rotation: *tilt.matrix(), translation: Vector3::new(0.03, -0.02, 0.05) }
}

fn step() -> Pose {
    let turn = nalgebra::Rotation3::from_euler_angles(0.02, -0.01, 0.03);
    Pose { rotation: *turn.matrix(), translation: Vector3::new(0.004, 0.003, -0.005) }
}

fn hide(views: &mut [Observations], view: usize, ball: Ball, state: ObservationState) {
    views[view][ball.index()].state = state;
}

proptest! {
    #[test]
    fn a_rigid_motion_is_recovered(cameras in cameras(), hand in pose(3.1, 0.2), step in pose(0.5, 0.1)) {
        let mut tracker = tracker();
        let first = tracker.update(&observe(&cameras, &hand)).unwrap();
        prop_assert_eq!(first.spans, 0);
        prop_assert_eq!(difference(&first.since_engage, &Pose::identity()), 0.0);
        let motion = tracker.update(&observe(&cameras, &hand.compose(&step))).unwrap();
        let solved = Pose { rotation: motion.phi, translation: motion.alpha };
        // 3e-4 is 0.02 degrees: centres of a few hundred px carry 3e-5 px in f32, an arm 25 to 70 px
        prop_assert!((solved.translation - step.translation).norm() < 1e-5, "{}", difference(&solved, &step));
        prop_assert!((solved.rotation - step.rotation).norm() < 3e-4, "{}", difference(&solved, &step));
        prop_assert!((motion.phi.transpose() * motion.phi - Matrix3::identity()).norm() < 1e-6);
        prop_assert!((motion.phi.determinant() - 1.0).abs() < 1e-6);
        prop_assert!(motion.residual_px < 2e-3);
        prop_assert_eq!(motion.spans, 1);
        prop_assert!(difference(&motion.since_engage, &solved) < 1e-6);
    }

    #[test]
    fn a_constant_motion_is_predicted(cameras in cameras(), hand in pose(3.1, 0.2), step in pose(0.2, 0.03)) {
        let mut tracker = tracker();
        let next = hand.compose(&step);
        tracker.update(&observe(&cameras, &hand)).unwrap();
        tracker.update(&observe(&cameras, &next)).unwrap();
        for (view, camera) in cameras.iter().enumerate() {
            for (predicted, true_centre) in tracker.predict(view).iter().zip(camera.centres(&next.compose(&step))) {
                prop_assert!(predicted.unwrap().distance(true_centre) < 0.02);
            }
        }
        prop_assert_eq!(tracker.predict(cameras.len()), [None; BALLS]);
    }

    #[test]
    fn any_numbers_are_taken_or_refused(
        values in prop::collection::vec(number(), 48),
        states in prop::collection::vec(0_u8..4, 24),
    ) {
        let mut tracker = tracker();
        let mut known = tracker.update(&observe(&two_cameras(), &start())).unwrap().since_engage;
        for frame in 0..3 {
            let views: Vec<Observations> = (0..2)
                .map(|view| {
                    core::array::from_fn(|ball| {
                        let i = frame * 8 + view * 4 + ball;
                        let state = [ObservationState::Visible, ObservationState::Occluded, ObservationState::Visible,
                            ObservationState::Lost][usize::from(states[i])];
                        crate::observation::Observation {
                            state,
                            centre: ImagePoint::new(values[2 * i], values[2 * i + 1]),
                            diameter: 9.0, ..Default::default() }
                    })
                })
                .collect();
            match tracker.update(&views) {
                Ok(motion) => {
                    known = motion.since_engage;
                    prop_assert!(motion.alpha.iter().chain(motion.phi.iter()).all(|x| x.is_finite()));
                    prop_assert!(known.translation.iter().chain(known.rotation.iter()).all(|x| x.is_finite()));
                }
                Err(_) => prop_assert_eq!(tracker.since_engage(), &known),
            }
            prop_assert!(tracker.predict(0).iter().flatten().all(|p| p.is_finite()));
        }
    }
}

#[test]
fn perspective_costs_a_single_step_less_than_a_millimetre() {
    // 640x480 pictures at 1 m, hands 5 cm about the middle, steps of 8 mm (0.25 m/s at 30 frames/s):
    // what weak perspective itself costs, with perfect centres (DESIGN section 4: 0.5 mm a step)
    let cameras = [Camera::perspective(-0.6, 0.3, 600.0, 1.0), Camera::perspective(0.6, 0.3, 600.0, 1.0)];
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut worst_m, mut sum_m, mut worst_turn) = (0.0_f32, 0.0, 0.0_f32);
    let cases = 1000;
    for _ in 0..cases {
        let (hand, step) = (pose(0.5, 0.05), pose(0.03, 0.0046)).new_tree(&mut runner).unwrap().current();
        let mut tracker = tracker();
        tracker.update(&observe(&cameras, &hand)).unwrap();
        let motion = tracker.update(&observe(&cameras, &hand.compose(&step))).unwrap();
        let error_m = (motion.alpha - step.translation).norm();
        sum_m += error_m;
        worst_m = worst_m.max(error_m);
        worst_turn = worst_turn.max((motion.phi - step.rotation).norm() / core::f32::consts::SQRT_2);
    }
    let mean_m = sum_m / cases as f32;
    assert!(mean_m < 0.3e-3 && worst_m < 1e-3, "mean {mean_m} m, worst {worst_m} m");
    assert!(worst_turn < 0.015, "{worst_turn} rad");
}

#[test]
fn ten_thousand_steps_stay_a_rotation_and_close() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    // a closed path: after each 200 steps the hand is back
    let at = |i: u32| {
        let t = i as f32 * core::f32::consts::TAU / 200.0;
        let turn =
            nalgebra::Rotation3::from_euler_angles(0.5 * t.sin(), 0.4 * t.cos(), 0.3 * (2.0 * t).sin());
        let place = Vector3::new(0.1 * t.cos(), 0.1 * t.sin(), 0.05 * (3.0 * t).sin());
        Pose { rotation: *turn.matrix(), translation: place }
    };
    let mut last = Pose::identity();
    let mut worst_rotation = 0.0_f32;
    for i in 0..=10_000 {
        let motion = tracker.update(&observe(&cameras, &at(i))).unwrap();
        last = motion.since_engage;
        let r = last.rotation;
        worst_rotation = worst_rotation.max((r.transpose() * r - Matrix3::identity()).norm());
        assert!((r.determinant() - 1.0).abs() < 1e-6, "step {i}");
    }
    assert!(worst_rotation < 1e-6, "{worst_rotation}");
    // what is left is the rounding of 10,000 increments, a few micrometres each
    assert!(difference(&last, &Pose::identity()) < 5e-3, "{}", difference(&last, &Pose::identity()));
}

#[test]
fn a_gap_is_bridged_and_nothing_is_lost() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    let mut hand = start();
    tracker.update(&observe(&cameras, &hand)).unwrap();
    for lost in 1..=3 {
        hand = hand.compose(&step());
        let mut views = observe(&cameras, &hand);
        hide(&mut views, 1, Ball::Blue, ObservationState::Predicted);
        let refusal = MotionRefusal::BallMissing { view: 1, ball: Ball::Blue };
        assert_eq!(tracker.update(&views), Err(refusal), "frame {lost}");
        assert_eq!(refusal.to_string(), "the blue ball was not measured in view 1");
    }
    hand = hand.compose(&step());
    let motion = tracker.update(&observe(&cameras, &hand)).unwrap();
    assert_eq!(motion.spans, 4);
    let whole = start().inverse().compose(&hand);
    assert!(difference(&motion.since_engage, &whole) < 1e-4);
    assert!(difference(&Pose { rotation: motion.phi, translation: motion.alpha }, &whole) < 1e-4);
}

#[test]
fn an_occluded_ball_is_a_measurement() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    let mut views = observe(&cameras, &start());
    hide(&mut views, 0, Ball::Green, ObservationState::Occluded);
    assert!(tracker.update(&views).is_ok());
    hide(&mut views, 0, Ball::Green, ObservationState::Lost);
    assert_eq!(tracker.update(&views), Err(MotionRefusal::BallMissing { view: 0, ball: Ball::Green }));
}

#[cfg(feature = "eight-views")]
#[test]
fn a_third_camera_stands_in() {
    let cameras = [two_cameras()[0], two_cameras()[1], Camera::orthographic(1.6, -0.2, 500.0)];
    let mut tracker = tracker();
    tracker.update(&observe(&cameras, &start())).unwrap();
    let next = start().compose(&step());
    let mut views = observe(&cameras, &next);
    hide(&mut views, 0, Ball::Red, ObservationState::Lost);
    let motion = tracker.update(&views).unwrap();
    assert!(difference(&motion.since_engage, &step()) < 1e-4);
    assert_eq!(tracker.predict(0), [None; BALLS], "view 0 is not in the reference");
    assert!(tracker.predict(2).iter().all(Option::is_some));

    // views 0 and 1 complete, but only 1 and 2 were so in the reference
    let mut views = observe(&cameras, &next);
    hide(&mut views, 2, Ball::Red, ObservationState::Lost);
    assert_eq!(tracker.update(&views), Err(MotionRefusal::NoSharedViews));
    tracker.restart();
    assert_eq!(tracker.update(&views).map(|m| m.spans), Ok(0));
}

#[test]
fn refusals_leave_the_reference() {
    let cameras = two_cameras();
    let good = observe(&cameras, &start());
    let mut tracker = tracker();
    let before_any = tracker.update(&good[..1]);
    assert_eq!(before_any, Err(MotionRefusal::Affine(AffineRefusal::TooFewViews)));
    assert_eq!(tracker.update(&[]), Err(MotionRefusal::Affine(AffineRefusal::TooFewViews)));
    let same = [good[0], good[0]];
    assert_eq!(tracker.update(&same), Err(MotionRefusal::Affine(AffineRefusal::IllConditioned)));
    assert_eq!(tracker.update(&good).map(|m| m.spans), Ok(0), "a degenerate frame is no reference");

    assert_eq!(tracker.update(&[good[0]; 9]), Err(MotionRefusal::Affine(AffineRefusal::TooManyViews)));
    let swapped: Vec<Observations> = good.iter().map(|&[r, g, b, y]| [r, g, y, b]).collect();
    assert_eq!(tracker.update(&swapped), Err(MotionRefusal::Orientation(OrientationRefusal::LeftHanded)));
    let flat: Vec<Observations> = good.iter().map(|&[r, g, b, _]| [r, g, b, g]).collect();
    assert_eq!(tracker.update(&flat), Err(MotionRefusal::Orientation(OrientationRefusal::Collinear)));
    let point: Vec<Observations> = good.iter().map(|&[r, ..]| [r; 4]).collect();
    assert!(matches!(tracker.update(&point), Err(MotionRefusal::Orientation(_))));
    let mut broken = good.clone();
    broken[0][3].centre.u = f32::NAN;
    assert_eq!(tracker.update(&broken), Err(MotionRefusal::Affine(AffineRefusal::NotFinite)));

    let motion = tracker.update(&good).unwrap();
    assert_eq!(motion.spans, 6);
    assert!(difference(&motion.since_engage, &Pose::identity()) < 1e-5);
}

#[test]
fn the_residual_is_over_all_balls() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    let reference = cameras.map(|camera| camera.centres(&start()));
    tracker.update(&observe(&cameras, &start())).unwrap();
    // one ball in one view off by 2 px: the views no longer agree on it, and only on it
    let mut views = observe(&cameras, &start());
    views[1][Ball::Blue.index()].centre.v += 2.0;
    let motion = tracker.update(&views).unwrap();
    let blue = Ball::Blue.index();
    let points = [views[0][blue].centre, views[1][blue].centre];
    let frame = AffineFrame::new(&reference, arms(), &HandConfig::default()).unwrap();
    let of_blue_px = frame.locate(&points).unwrap().residual_px;
    assert!(of_blue_px > 0.5, "{of_blue_px}");
    assert!((motion.residual_px - of_blue_px / 2.0).abs() < 1e-3, "a quarter of the mean square is blue's");
}

#[test]
fn engage_latches_the_pose() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    let mut hand = start();
    tracker.update(&observe(&cameras, &hand)).unwrap();
    hand = hand.compose(&step());
    tracker.update(&observe(&cameras, &hand)).unwrap();
    tracker.engage();
    assert_eq!((tracker.engagements(), *tracker.since_engage()), (1, Pose::identity()));
    let motion = tracker.update(&observe(&cameras, &hand.compose(&step()))).unwrap();
    assert_eq!(motion.engagements, 1);
    assert!(difference(&motion.since_engage, &step()) < 1e-4, "only the motion after engage");
}

#[test]
fn engage_with_the_hand_unseen_waits_for_it() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    tracker.engage();
    assert_eq!(tracker.engagements(), 0, "nothing to latch yet");
    let mut hand = start();
    assert_eq!(tracker.update(&observe(&cameras, &hand)).unwrap().engagements, 1);

    hand = hand.compose(&step());
    let mut hidden = observe(&cameras, &hand);
    hide(&mut hidden, 0, Ball::Red, ObservationState::Predicted);
    tracker.update(&hidden).unwrap_err();
    tracker.engage();
    assert_eq!(tracker.engagements(), 1);
    hand = hand.compose(&step());
    let motion = tracker.update(&observe(&cameras, &hand)).unwrap();
    assert_eq!((motion.engagements, motion.since_engage, motion.spans), (2, Pose::identity(), 2));
    assert!(motion.alpha.norm() > 0.01, "the increment still tells what was moved");
}

#[test]
fn prediction_over_a_gap_carries_on_and_ends() {
    let cameras = two_cameras();
    let mut tracker = tracker();
    assert_eq!(tracker.predict(0), [None; BALLS], "nothing seen yet");
    let shift = Pose { rotation: Matrix3::identity(), translation: Vector3::new(0.01, 0.0, 0.0) };
    let mut hand = start();
    tracker.update(&observe(&cameras, &hand)).unwrap();
    for (predicted, centre) in tracker.predict(0).iter().zip(cameras[0].centres(&hand)) {
        assert!(predicted.unwrap().distance(centre) < 1e-3, "without a motion yet it stays");
    }
    let mut hidden = observe(&cameras, &hand);
    hide(&mut hidden, 0, Ball::Red, ObservationState::Lost);

    // one refused frame: the increment spans two, and its half is the next frame's motion
    hand = hand.compose(&shift);
    tracker.update(&hidden).unwrap_err();
    hand = hand.compose(&shift);
    assert_eq!(tracker.update(&observe(&cameras, &hand)).unwrap().spans, 2);
    for refused in 0..HandConfig::default().max_predicted_frames {
        hand = hand.compose(&shift);
        for (predicted, centre) in tracker.predict(0).iter().zip(cameras[0].centres(&hand)) {
            assert!(predicted.unwrap().distance(centre) < 0.02, "after {refused} refused frames");
        }
        tracker.update(&hidden).unwrap_err();
    }
    assert_eq!(tracker.predict(0), [None; BALLS], "too long ago to be worth a window");
}
