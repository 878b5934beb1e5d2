//! Driven straight into each singularity, each end of a joint, each face of the workspace and the edge
//! of reach: the arm always comes back to where it was, and keeps every bound on the way.

use super::*;
use crate::config::Workspace;
use core::f64::consts::PI;
use std::vec::Vec;

/// What the arm is driven into.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Into {
    Wrist,
    Elbow,
    Shoulder,
    Reach,
    End { joint: usize, upper: bool },
    Face { axis: usize, upper: bool },
}

/// What a drive came upon, so that a rule that is never tried shows.
#[derive(Default, Debug)]
struct Seen {
    drives: u64,
    met: u64,
    other_ways: u64,
    changes: u64,
    slowest: u32,
    out_m: f64,
    fastest_m_s: f64,
}

fn all() -> Vec<Into> {
    let mut all = std::vec![Into::Wrist, Into::Elbow, Into::Shoulder, Into::Reach];
    for upper in [false, true] {
        all.extend((0..JOINTS).map(|joint| Into::End { joint, upper }));
        all.extend((0..3).map(|axis| Into::Face { axis, upper }));
    }
    all
}

/// A goal beyond what is driven into.
fn beyond(
    into: Into,
    random: &mut Random,
    arm: &Puma560<f64>,
    config: &GovernorConfig,
    start: &Joints<f64>,
) -> Pose<f64> {
    let pose = arm.forward(start);
    let mut joints = *start;
    let mut goal = pose;
    match into {
        Into::Wrist => {
            // past it at some distance: q5 to the other side, with some of q4
            joints[4] *= random.within(-1.0, 0.0);
            joints[3] += random.within(-0.3, 0.3);
            goal = arm.forward(&joints);
        }
        Into::Elbow => {
            // to the stretched elbow and on along the upper arm
            let shoulder = Vector3::new(0.0, 0.0, arm.config().lengths.base_m);
            let out = pose.translation - shoulder;
            goal.translation += out / out.norm() * random.within(0.1, 0.6);
        }
        Into::Shoulder => {
            goal.translation.x *= random.within(-0.3, 0.3);
            goal.translation.y *= random.within(-0.3, 0.3);
        }
        Into::Reach => {
            goal.translation += random.vector(1.0).normalize() * random.within(0.3, 1.5);
        }
        Into::End { joint, upper } => {
            let range = &arm.config().joints[joint];
            let past = random.within(0.01, 0.5);
            joints[joint] = if upper { range.max_rad + past } else { range.min_rad - past };
            goal = arm.forward(&joints);
        }
        Into::Face { axis, upper } => {
            let w = &config.workspace;
            let past = random.within(0.01, 0.3);
            goal.translation[axis] = if upper { w.max_m[axis] + past } else { w.min_m[axis] - past };
            goal.translation += random.vector(0.1);
            goal.rotation = random.rotation(0.3) * goal.rotation;
        }
    }
    goal
}

fn is_met(into: Into, limits: Limits) -> bool {
    match into {
        Into::Wrist => limits.contains(Limit::WristSingularity),
        Into::Elbow => limits.contains(Limit::ElbowSingularity) || limits.contains(Limit::TooFar),
        Into::Shoulder => limits.contains(Limit::ShoulderSingularity) || limits.contains(Limit::TooNear),
        Into::Reach => limits.contains(Limit::TooFar) || limits.contains(Limit::TooNear),
        Into::End { joint, upper } => {
            let number = joint as JointNumber + 1;
            limits.contains(Limit::JointRange(number))
                || limits.contains(if upper {
                    Limit::NearUpperLimit(number)
                } else {
                    Limit::NearLowerLimit(number)
                })
        }
        Into::Face { .. } => limits.contains(Limit::WorkspaceEdge),
    }
}

fn drive<T: Real>(into: Into, seed: u64, exact: f64, seen: &mut Seen) {
    let mut random = Random::new(seed);
    let mut config = GovernorConfig::default();
    if let Into::Face { .. } = into {
        config.workspace = Workspace { min_m: [-0.5, -0.5, 0.3], max_m: [0.5, 0.5, 1.1] };
    }
    let mut start = anywhere(&mut random, &config, 0.1);
    if let Into::End { joint, upper } = into {
        let range = &PumaConfig::default().joints[joint];
        let away = random.within(0.0, 0.5);
        start[joint] = if upper { range.max_rad - away } else { range.min_rad + away };
        let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
        let place = arm.forward(&start).translation;
        let w = &config.workspace;
        let (_, nearness) = arm.nearest_singularity(&arm.singularities(&start));
        if nearness < 0.1 || !(0..3).all(|i| place[i] > w.min_m[i] && place[i] < w.max_m[i]) {
            return;
        }
    }
    let precise = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    let target = beyond(into, &mut random, &precise, &config, &start);
    let mut arm = Checked::<T>::new(&config, &start);
    let home = arm.governor.pose;
    let from = precise.forward(&start);
    let left = goal::Left::between(&from, &target);
    // at once, or as a hand leads it there
    let frames = if random.chance(0.3) { 1.0 } else { random.within(10.0, 60.0) };
    let push = random.within(0.0, 200.0) as u64;
    let (mut met, mut other_way, mut frame) = (false, false, 0.0f64);
    for cycle in 0..(frames as u64 * 3 + push) {
        if cycle % 3 == 0 {
            frame = (frame + 1.0).min(frames);
        }
        let pose = left.along(&from, frame / frames);
        let goal = Pose { rotation: pose.rotation.map(T::of), translation: pose.translation.map(T::of) };
        let governed = arm.follow(&goal);
        met |= is_met(into, governed.limits);
        other_way |= governed.limits.contains(Limit::AnotherWay);
    }
    let cycles = arm.settle(&home, exact, 3_000);
    let (m, rad) = arm.off(&home);
    assert!(
        cycles.is_some(),
        "{into:?}, seed {seed}: {m:.1e} m, {rad:.1e} rad after {cycles:?} from {start:?} at {:?}: {}",
        arm.governor.set_point(),
        arm.follow(&home).limits,
    );
    seen.drives += 1;
    seen.met += u64::from(met);
    seen.other_ways += u64::from(other_way);
    seen.changes += arm.changes;
    seen.slowest = seen.slowest.max(cycles.unwrap_or(0));
    seen.out_m = seen.out_m.max(arm.out_m);
    seen.fastest_m_s = seen.fastest_m_s.max(arm.fastest_m_s);
}

fn drive_into_all<T: Real>(drives: u64, exact: f64) {
    for (number, into) in all().into_iter().enumerate() {
        let mut seen = Seen::default();
        for seed in 0..drives {
            drive::<T>(into, seed * 1000 + number as u64, exact, &mut seen);
        }
        std::println!("{into:?}: {seen:?}");
        assert!(seen.met * 3 > seen.drives && seen.drives * 10 > drives, "{into:?}: {seen:?}");
    }
}

#[test]
fn from_everything_it_is_driven_into_the_arm_comes_back() {
    drive_into_all::<f64>(sequences(2_000), 1e-9);
}

#[test]
fn also_in_single_precision() {
    drive_into_all::<f32>(sequences(500), 1e-4);
}

/// An arm whose tool was turned from q6 = `first` on to the upper end of joint 6, in steps that a straight
/// way follows.
fn wound_up(first: f64) -> (Checked<f64>, Joints<f64>) {
    let mut joints = [0.3, 1.9, -2.6, 0.4, 0.9, first];
    let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &joints);
    let end = arm.arm.config().joints[5].max_rad;
    while joints[5] < end {
        joints[5] = (joints[5] + 0.5).min(end);
        let goal = arm.arm.forward(&joints);
        assert!(arm.settle(&goal, 1e-9, 1_000).is_some());
    }
    assert!((arm.governor.set_point()[5] - end).abs() < 1e-6);
    (arm, joints)
}

#[test]
fn a_tool_turned_by_about_a_turn_comes_home_and_says_so() {
    let (mut arm, mut joints) = wound_up(-1.3);
    joints[5] = -1.3;
    let home = arm.arm.forward(&joints);
    let mut other_way = 0;
    let cycles = (0..2_000).find(|_| {
        let governed = arm.follow(&home);
        other_way += u64::from(governed.limits.contains(Limit::AnotherWay));
        governed.at_rest && arm.off(&home).1 < 1e-9
    });
    assert!(cycles.is_some() && other_way > 50, "{cycles:?}, {other_way}");
    assert!((arm.governor.set_point()[5] + 1.3).abs() < 1e-6);
}

#[test]
fn who_rests_against_the_end_of_a_joint_is_not_turned_round() {
    for past in [0.01, 0.1, 0.5] {
        let (mut arm, mut joints) = wound_up(0.5);
        let end = joints[5];
        joints[5] += past;
        let goal = arm.arm.forward(&joints);
        for _ in 0..1_000 {
            let governed = arm.follow(&goal);
            assert!((governed.set_point[5] - end).abs() < 0.2, "{past} past: {:?}", governed.set_point);
        }
        joints[5] = end - 0.3;
        assert!(arm.settle(&arm.arm.forward(&joints), 1e-9, 1_000).is_some());
    }
}

/// An arm whose wrist was turned over since its start, and where it started: joint 4 has no room to go back there so.
fn turned_over<T: Real>() -> (Checked<T>, Pose<T>) {
    let first = [0.3, 1.9, -2.6, 1.0, 0.9, -0.5];
    let over = [0.3, 1.9, -2.6, 1.5 - PI, -0.9, -0.5 + PI];
    let mut arm = Checked::<T>::new(&GovernorConfig::default(), &over);
    let first = first.map(T::of);
    arm.governor.first_joints = first;
    arm.governor.first_posture = arm.arm.configuration(&first);
    let home = arm.arm.forward(&first);
    (arm, home)
}

/// Let go amid the way back, and pressed again whether the arm rests already or not: a hand that is still leaves the
/// arm where braking took it, and may be followed home all the same.
fn let_go_amid_the_way_back<T: Real>(swung: f64, stopped: u64, exact: f64) {
    let (mut arm, home) = turned_over::<T>();
    let began = double(&arm.governor.set_point());
    let swings = (0..2_000).any(|_| {
        let at = double(&arm.follow(&home).set_point);
        (at[4] - began[4]).abs() > swung
    });
    assert!(swings, "the wrist turns over again");
    for _ in 0..stopped {
        arm.step(&Order::Stop);
    }
    let (goal, pressed) = (*arm.governor.pose(), double(&arm.governor.set_point()));
    let mut braking = arm.governor;
    while !braking.step(&Order::Stop, None).at_rest {}
    // back from there it swings as far at most
    let most = 0.1 + 2.0 * farthest(&double(&braking.set_point()), &pressed);
    for _ in 0..1_000 {
        let off = farthest(&double(&arm.follow(&goal).set_point), &pressed);
        assert!(off < most, "{swung}, {stopped}: a joint went {off} rad of {most}");
    }
    let off = arm.off(&goal);
    assert!(off.0 < exact && off.1 < exact, "{swung}, {stopped}: {off:?} from there");
    assert_eq!(arm.governor.braking, 0, "what was let go is over");
    assert!((0..4_000).any(|_| arm.follow(&home).at_rest && arm.off(&home).1 < exact), "and comes home");
}

fn farthest(a: &Joints<f64>, b: &Joints<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Let go, or led by what is no goal, and asked home at once: it comes there as soon as if it had never been let go, but
/// for the braking.
#[test]
fn who_lets_go_and_asks_home_at_once_comes_home_all_the_same() {
    let home_after = |stopped: u64, order: &dyn Fn(&Pose<f64>) -> Order<f64>| {
        let (mut arm, home) = turned_over::<f64>();
        for _ in 0..60 {
            arm.follow(&home);
        }
        for _ in 0..stopped {
            let order = order(&home);
            arm.step(&order);
        }
        (0..4_000).find(|_| arm.follow(&home).at_rest && arm.off(&home).1 < 1e-9).expect("it comes home")
    };
    let never = home_after(0, &|_| Order::Stop);
    for stopped in [1, 5, 20, 100] {
        let let_go = home_after(stopped, &|_| Order::Stop);
        let no_goal = home_after(stopped, &|home| {
            Order::Follow(Pose { translation: home.translation * f64::NAN, ..*home })
        });
        for cycles in [let_go, no_goal] {
            assert!(cycles < never + 200, "{stopped}: {cycles} cycles, {never} without");
        }
    }
}

#[test]
fn what_is_let_go_amid_the_way_back_does_not_swing_on() {
    for swung in [0.1, 0.4, 0.8, 1.0, 1.4] {
        for stopped in [1, 3, 10, 200] {
            let_go_amid_the_way_back::<f64>(swung, stopped, 1e-9);
            let_go_amid_the_way_back::<f32>(swung, stopped, 1e-3);
        }
    }
}
