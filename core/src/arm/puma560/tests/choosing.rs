use super::super::{
    ChangeKind, ChooseRefusal, Configuration, Fixed, JointSet, Joints, Passages, Policy, Recent, Singularity,
    Unreachable, Wrist,
};
use super::{apart, arm, joints, turned};
use crate::config::PumaConfig;
use crate::geometry::Pose;
use proptest::prelude::*;
use std::string::ToString;

const HOME: Joints<f64> = [0.2, 1.0, -1.9, 0.3, 0.4, -0.5];
const FREE: Policy = Policy {
    fixed: Fixed { shoulder: None, elbow: None, wrist: None },
    passages: Passages::ALL,
    jump: false,
};

/// `from` plus `n` times `step`.
fn along(from: &Joints<f64>, step: &Joints<f64>, n: f64) -> Joints<f64> {
    core::array::from_fn(|i| from[i] + n * step[i])
}

/// An arm that came to `at` by `step`.
fn moving(at: &Joints<f64>, step: &Joints<f64>) -> Recent<f64> {
    let arm = arm();
    let mut recent = Recent::at_rest(&arm, &along(at, step, -1.0));
    recent.push(&arm, at);
    recent
}

#[test]
fn the_wrist_passes_its_singularity_only_when_allowed() {
    let arm = arm::<f64>();
    let step = [0.01, 0.0, 0.0, 0.02, -0.01, 0.03];
    let start = [0.2, 1.0, -1.9, 0.3, 0.035, -0.5];
    let mut recent = moving(&start, &step);
    for n in 1..=3 {
        let there = along(&start, &step, f64::from(n));
        let choice = arm.choose(&arm.forward(&there), &recent, &Policy::default()).expect("before");
        assert_eq!(choice.change, None);
        recent.push(&arm, &choice.joints);
    }
    let beyond = along(&start, &step, 4.0);
    let refused = arm.choose(&arm.forward(&beyond), &recent, &Policy::default());
    let from = recent.configuration();
    let to = Configuration { wrist: Wrist::NoFlip, ..from };
    assert_eq!(refused, Err(ChooseRefusal::Passage { singularity: Singularity::Wrist, from, to }));
    let allowed = Policy { passages: Passages { wrist: true, ..Passages::default() }, ..Policy::default() };
    let choice = arm.choose(&arm.forward(&beyond), &recent, &allowed).expect("allowed");
    assert!(turned(&choice.joints, &beyond) < 1e-9);
    let change = choice.change.expect("it is told");
    assert_eq!((change.kind, change.from, change.to), (ChangeKind::Passage, from, to));
    // and the way back is open
    let back = along(&start, &step, 2.0);
    assert!(arm.choose(&arm.forward(&back), &recent, &Policy::default()).is_ok());
}

#[test]
fn stopping_on_the_singularity_does_not_hide_the_passage() {
    let arm = arm::<f64>();
    let mut at = HOME;
    at[4] = 0.0;
    let mut recent = moving(&[0.2, 1.0, -1.9, 0.3, 0.01, -0.5], &[0.0, 0.0, 0.0, 0.0, -0.01, 0.0]);
    let from = recent.configuration();
    for _ in 0..3 {
        let choice = arm.choose(&arm.forward(&at), &recent, &Policy::default()).expect("it is no change yet");
        assert_eq!((choice.change, choice.configuration), (None, from));
        assert!(turned(&choice.joints, &at) < 1e-9, "{:?}", choice.joints);
        recent.push(&arm, &choice.joints);
    }
    at[4] = -0.002;
    let refused = arm.choose(&arm.forward(&at), &recent, &Policy::default());
    assert!(matches!(refused, Err(ChooseRefusal::Passage { singularity: Singularity::Wrist, .. })));
}

#[test]
fn a_fixed_configuration_is_kept_or_refused() {
    let arm = arm::<f64>();
    // q4 = 2 leaves room for the other way to bend the wrist, q4 = 2 - pi
    let at = [0.2, 1.0, -1.9, 2.0, 0.4, -0.5];
    let pose = arm.forward(&at);
    let recent = Recent::at_rest(&arm, &at);
    let here = recent.configuration();
    let kept = Policy { fixed: Fixed::all(here), ..FREE };
    assert!(arm.choose(&pose, &recent, &kept).is_ok());

    let other = Configuration { wrist: Wrist::NoFlip, ..here };
    let fixed = Policy { fixed: Fixed::all(other), ..FREE };
    let refused = arm.choose(&pose, &recent, &fixed);
    assert_eq!(refused, Err(ChooseRefusal::NotAsFixed { from: here, to: here }));

    let choice = arm.choose(&pose, &recent, &Policy { jump: true, ..fixed }).expect("in range");
    let change = choice.change.expect("it is told");
    assert_eq!((change.kind, change.from, change.to), (ChangeKind::Jump, here, other));
    assert_eq!(arm.configuration(&choice.joints), other);
    assert!(arm.outside(&choice.joints).is_empty());
}

#[test]
fn a_joint_at_its_end_is_not_turned_round_silently() {
    let arm = arm::<f64>();
    let mut at = HOME;
    at[5] = 4.63;
    let recent = moving(&at, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.01]);
    at[5] = 4.65;
    let pose = arm.forward(&at);
    let refused = arm.choose(&pose, &recent, &FREE);
    assert_eq!(refused, Err(ChooseRefusal::OutsideRange(JointSet::EMPTY.with(6))));
    assert_eq!(refused.map(|_| ()).unwrap_err().to_string(), "the pose would take joint 6 out of range");
    let choice = arm.choose(&pose, &recent, &Policy { jump: true, ..FREE }).expect("there is another turn");
    assert_eq!(choice.change.expect("it is told").kind, ChangeKind::Jump);
    assert!(arm.outside(&choice.joints).is_empty());
}

#[test]
fn joints_out_of_range_may_come_back_but_not_go_farther() {
    let arm = arm::<f64>();
    let mut at = HOME;
    at[0] = 2.9;
    let recent = Recent::at_rest(&arm, &at);
    let to = |q1: f64| arm.choose(&arm.forward(&[q1, at[1], at[2], at[3], at[4], at[5]]), &recent, &FREE);
    assert!(to(2.9).is_ok());
    assert!(to(2.88).is_ok());
    assert_eq!(to(2.91), Err(ChooseRefusal::OutsideRange(JointSet::EMPTY.with(1))));
}

#[test]
fn what_is_out_of_reach_is_said() {
    let arm = arm::<f64>();
    let far = Pose { translation: nalgebra::Vector3::new(2.0, 0.0, 0.5), ..Pose::identity() };
    let refused = arm.choose(&far, &Recent::at_rest(&arm, &HOME), &Policy { jump: true, ..FREE });
    assert_eq!(refused, Err(ChooseRefusal::Unreachable(Unreachable::TooFar)));
}

/// `q` moved onto some of the singularities.
fn singular(q: &Joints<f64>, wrist: bool, elbow: bool, shoulder: bool) -> Joints<f64> {
    let [q1, q2, q3, q4, q5, q6] = *q;
    let lengths = PumaConfig::default().lengths;
    let q3 = if elbow { -lengths.forearm_m.atan2(lengths.elbow_m) } else { q3 };
    // a2 cos(q2) + a3 cos(q2 + q3) - d4 sin(q2 + q3) = a cos(q2) - b sin(q2)
    let a = lengths.upper_arm_m + lengths.elbow_m * q3.cos() - lengths.forearm_m * q3.sin();
    let b = lengths.elbow_m * q3.sin() + lengths.forearm_m * q3.cos();
    [q1, if shoulder { a.atan2(b) } else { q2 }, q3, q4, if wrist { 0.0 } else { q5 }, q6]
}

proptest! {
    #[test]
    fn an_arm_at_rest_on_singularities_stays_there(q in joints(), which in 1u8..8) {
        let arm = arm::<f64>();
        let at = singular(&q, which & 1 != 0, which & 2 != 0, which & 4 != 0);
        prop_assume!(arm.outside(&at).is_empty());
        let pose = arm.forward(&at);
        prop_assert_eq!(arm.inverse(&pose, &at).expect("the arm is there").iter().count(), 8);
        let choice = arm.choose(&pose, &Recent::at_rest(&arm, &at), &Policy::default()).expect("it is there");
        prop_assert_eq!(choice.change, None);
        prop_assert!(turned(&choice.joints, &at) < 1e-6, "{:?} {at:?}", choice.joints);
        prop_assert!(apart(&arm.forward(&choice.joints), &pose) < 1e-9);
    }

    #[test]
    fn a_straight_line_in_joints_is_followed_through_everything(
        from in joints(), to in joints(), first in 0u32..180
    ) {
        let arm = arm::<f64>();
        let step: Joints<f64> = core::array::from_fn(|i| (to[i] - from[i]) / 200.0);
        let at = |n: u32| along(&from, &step, f64::from(n));
        let mut recent = moving(&at(first), &step);
        for n in first + 1..first + 20 {
            let choice = arm.choose(&arm.forward(&at(n)), &recent, &FREE).expect("in range all the way");
            // an arm stretched or beside its axis to 1 nm is told from a pose by its root only
            prop_assert!(turned(&choice.joints, &at(n)) < 1e-5, "{:?} {:?}", choice.joints, at(n));
            prop_assert_eq!(choice.change.is_some(), choice.configuration != recent.configuration());
            recent.push(&arm, &at(n));
        }
    }
}
