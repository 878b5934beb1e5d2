use super::super::{Configuration, JointSet, Joints, Unreachable, Wrist};
use super::{apart, arm, joints, turned};
use crate::geometry::Pose;
use core::f64::consts::{PI, TAU};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;

/// The arm's place with the tool pointing down at a distance from the first axis.
fn reaching(out: f64, up: f64) -> Pose<f64> {
    Pose {
        rotation: Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)),
        translation: Vector3::new(out, 0.0, up),
    }
}

#[test]
fn what_is_out_of_reach_is_refused_with_its_reason() {
    let solve = |pose| arm::<f64>().inverse(&pose, &[0.0; 6]).map(|_| ());
    // the flange hangs 56 mm below the wrist centre
    let shoulder = 0.67183 - 0.05625;
    assert_eq!(solve(reaching(0.5, shoulder)), Ok(()));
    assert_eq!(solve(reaching(0.8771, shoulder)), Err(Unreachable::TooFar));
    assert_eq!(solve(reaching(f64::MAX, shoulder)), Err(Unreachable::TooFar));
    assert_eq!(solve(reaching(0.15, shoulder + 0.4)), Err(Unreachable::InsideShoulderCylinder));
    assert_eq!(solve(reaching(0.150_050_3, shoulder)), Err(Unreachable::TooNear));
    let mut pose = reaching(0.5, shoulder);
    pose.rotation[(1, 1)] = 1.0;
    assert_eq!(solve(pose), Err(Unreachable::NotARotation));
    pose.rotation[(1, 1)] = -1.1;
    assert_eq!(solve(pose), Err(Unreachable::NotARotation));
    pose.rotation[(1, 1)] = f64::NAN;
    assert_eq!(solve(pose), Err(Unreachable::PoseNotFinite));
    assert_eq!(solve(reaching(f64::INFINITY, 0.0)), Err(Unreachable::PoseNotFinite));
    let lost = arm().inverse(&reaching(0.5, shoulder), &[0.0, f64::NAN, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(lost.map(|_| ()), Err(Unreachable::JointsNotFinite));
}

#[test]
fn a_rotation_of_few_digits_is_taken_for_the_nearest_one() {
    let arm = arm::<f64>();
    let q = [0.3, 0.9, -1.4, 0.6, 0.7, -0.8];
    let mut pose = arm.forward(&q);
    let exact = pose;
    pose.rotation.apply(|x| *x = (*x * 1e4).round() / 1e4);
    let solutions = arm.inverse(&pose, &q).expect("within reach");
    let found = solutions.get(arm.configuration(&q)).expect("the posture it came from");
    let back = arm.forward(&found.joints);
    assert!((back.rotation.tr_mul(&back.rotation) - Matrix3::identity()).norm() < 1e-14);
    assert!(apart(&back, &exact) < 2e-4);
}

#[test]
fn whole_turns_follow_the_reference_as_far_as_the_range_goes() {
    let arm = arm::<f64>();
    let q: Joints<f64> = [0.3, 0.9, -1.4, 0.6, 0.7, 2.5];
    let pose = arm.forward(&q);
    let of = |near: Joints<f64>| {
        let solutions = arm.inverse(&pose, &near).expect("within reach");
        *solutions.get(arm.configuration(&q)).expect("the posture it came from")
    };
    // 2.5 and 2.5 - TAU are both in the range of joint 6
    assert!((of(q).joints[5] - 2.5).abs() < 1e-12);
    let other = of([0.0, 0.0, 0.0, 0.0, 0.0, -2.0]);
    assert!((other.joints[5] - (2.5 - TAU)).abs() < 1e-12 && other.outside.is_empty());
    // 2.5 + TAU is the nearest to 8, but beyond the range
    assert!((of([0.0, 0.0, 0.0, 0.0, 0.0, 8.0]).joints[5] - 2.5).abs() < 1e-12);
    assert!((of([100.0, 0.0, 0.0, 0.0, 0.0, 0.0]).joints[0] - 0.3).abs() < 1e-12);
}

#[test]
fn joints_without_a_place_in_their_range_are_named() {
    let arm = arm::<f64>();
    let q: Joints<f64> = [3.0, 0.9, -1.4, 0.6, 1.9, 0.0];
    let solutions = arm.inverse(&arm.forward(&q), &q).expect("within reach");
    let found = solutions.get(arm.configuration(&q)).expect("the posture it came from");
    assert_eq!(found.outside, JointSet::EMPTY.with(1).with(5));
    assert_eq!(arm.outside(&q), found.outside);
    assert!(turned(&found.joints, &q) < 1e-12);
    assert!(solutions.within_ranges().all(|solution| arm.outside(&solution.joints).is_empty()));
}

#[test]
fn at_the_wrists_singularity_the_last_joints_decide() {
    let arm = arm::<f64>();
    for (q5, wrist) in [(0.0, Wrist::NoFlip), (0.0, Wrist::Flip), (PI, Wrist::Flip)] {
        let q = [0.3, 0.9, -1.4, 0.6, q5, -0.8];
        let bent = if wrist == Wrist::Flip { 0.01 } else { -0.01 };
        let near = [0.3, 0.9, -1.4, 0.7, q5 + bent, -0.7];
        let solutions = arm.inverse(&arm.forward(&q), &near).expect("within reach");
        let found = solutions.get(Configuration { wrist, ..arm.configuration(&q) }).expect("that posture");
        // the sum (the difference, bent back on itself) is that of the pose; each goes half of the way
        let expected = if q5 == 0.0 { [0.6, -0.8] } else { [0.7, -0.7] };
        assert!((found.joints[3] - expected[0]).abs() < 1e-12, "{:?}", found.joints);
        assert!((found.joints[5] - expected[1]).abs() < 1e-12, "{:?}", found.joints);
        assert_eq!(solutions.iter().count(), 8);
    }
}

proptest! {
    #[test]
    fn every_pose_of_the_arm_is_solved_eight_times(q in joints()) {
        let arm = arm::<f64>();
        let pose = arm.forward(&q);
        let solutions = arm.inverse(&pose, &q).expect("the arm was there");
        prop_assert_eq!(solutions.iter().count(), 8);
        for (solution, configuration) in solutions.iter().zip(Configuration::ALL) {
            prop_assert_eq!(solution.configuration, configuration);
            prop_assert!(apart(&arm.forward(&solution.joints), &pose) < 1e-9);
            prop_assert_eq!(arm.outside(&solution.joints), solution.outside);
        }
        let nearest = solutions.iter().map(|s| turned(&s.joints, &q)).fold(f64::MAX, f64::min);
        prop_assert!(nearest < 1e-6, "{nearest}");
    }

    #[test]
    fn single_precision_comes_back_to_the_pose(q in joints()) {
        let arm = arm::<f32>();
        let q = q.map(|x| x as f32);
        let pose = arm.forward(&q);
        let solutions = arm.inverse(&pose, &q).expect("the arm was there");
        prop_assert_eq!(solutions.iter().count(), 8);
        for solution in solutions.iter() {
            prop_assert!(apart(&arm.forward(&solution.joints), &pose) < 4e-5);
        }
    }

    #[test]
    fn out_of_an_exact_pose_single_precision_finds_what_double_does(q in joints(), q5 in -1e-3..1e-3) {
        let (single, double) = (arm::<f32>(), arm::<f64>());
        for q in [q, [q[0], q[1], q[2], q[3], q5, q[5]]] {
            let pose = double.forward(&q);
            let found = single.inverse(&pose, &q.map(|x| x as f32)).expect("the arm was there");
            let exact = double.inverse(&pose, &q).expect("the arm was there");
            prop_assert_eq!(found.iter().count(), 8);
            for (found, exact) in found.iter().zip(exact.iter()) {
                prop_assert_eq!(found.configuration, exact.configuration);
                prop_assert!(turned(&found.joints.map(f64::from), &exact.joints) < 1e-6);
            }
        }
    }

    #[test]
    fn nothing_is_too_strange_to_be_answered(numbers in proptest::array::uniform32(proptest::num::f64::ANY)) {
        let [a, b, c, d, e, f, g, h, i, x, y, z, q1, q2, q3, q4, q5, q6, ..] = numbers;
        let pose = Pose { rotation: Matrix3::new(a, b, c, d, e, f, g, h, i), translation: Vector3::new(x, y, z) };
        let upright = Pose { rotation: Matrix3::identity(), ..pose };
        for pose in [pose, upright] {
            for near in [[q1, q2, q3, q4, q5, q6], [0.0; 6]] {
                if let Ok(solutions) = arm::<f64>().inverse(&pose, &near) {
                    prop_assert!(solutions.iter().all(|s| s.joints.iter().all(|angle| angle.is_finite())));
                }
                if let Ok(solutions) = arm::<f32>().inverse(&pose, &near.map(|angle| angle as f32)) {
                    prop_assert!(solutions.iter().all(|s| s.joints.iter().all(|angle| angle.is_finite())));
                }
            }
        }
    }
}
