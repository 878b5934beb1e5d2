//! Stops, starts, still hands, unusable goals and hands that are not known well.

use super::*;
use crate::arm::puma560::{ChangeKind, Policy};

/// One that the arm is fond of: every joint well inside, every singularity far.
const MIDDLE: Joints<f64> = [0.3, 1.9, -2.6, 0.4, 0.9, -0.5];

/// Some way off in every joint.
fn elsewhere(arm: &Checked<f64>) -> Pose<f64> {
    let off = [0.3, -0.2, 0.3, 0.1, -0.2, 0.3];
    arm.arm.forward(&core::array::from_fn(|i| MIDDLE[i] + off[i]))
}

fn still_hand<T: Real>() {
    let mut random = Random::new(31);
    let config = GovernorConfig::default();
    for _ in 0..20 {
        let mut arm = Checked::<T>::new(&config, &anywhere(&mut random, &config, 0.0));
        let started = arm.governor.set_point();
        for cycle in 0..1_000 {
            // engage where the arm is, let go, and so on
            let goal = *arm.governor.pose();
            let governed = if cycle % 3 == 2 { arm.step(&Order::Stop) } else { arm.follow(&goal) };
            assert!(governed.at_rest && governed.set_point == started, "{governed:?}");
            assert_eq!(
                (governed.verdict, governed.limits, governed.change),
                (Verdict::Pass, Limits::NONE, None)
            );
        }
    }
}

#[test]
fn a_still_hand_moves_nothing_to_the_bit() {
    still_hand::<f64>();
    still_hand::<f32>();
}

/// Goals that jump, wander, are out of reach or nonsense, between stops; the bounds are checked with
/// each set-point.
fn anything<T: Real>(sequences: u64) {
    let mut random = Random::new(32);
    let (mut passed, mut clamped, mut rejected, mut rests, mut fastest) = (0, 0, 0, 0, 0.0f64);
    for sequence in 0..sequences {
        let config = GovernorConfig {
            cycle_us: if T::EPSILON.to_f64() > 1e-10 {
                10_000
            } else {
                [2_000, 10_000, 10_000, 50_000][(sequence % 4) as usize]
            },
            ..GovernorConfig::default()
        };
        let mut arm = Checked::<T>::new(&config, &anywhere(&mut random, &config, 0.0));
        let mut goal = *arm.governor.pose();
        let mut order = Order::Stop;
        let mut uncertainty = None;
        for _ in 0..400 {
            if random.chance(0.3) {
                goal.translation += random.vector(0.02).map(T::of);
                goal.rotation = random.rotation(0.1).map(T::of) * goal.rotation;
            }
            if random.chance(0.01) {
                goal.translation += random.vector(0.8).map(T::of);
            }
            if random.chance(0.01) {
                let joints = anywhere(&mut random, &config, 0.0);
                goal = arm.arm.forward(&joints.map(T::of));
            }
            if random.chance(0.02) {
                order = Order::Stop;
            } else if random.chance(0.3) {
                order = Order::Follow(goal);
            }
            if random.chance(0.01) {
                let mut bad = goal;
                match random.bits() % 4 {
                    0 => bad.translation.x = T::of(f64::NAN),
                    1 => bad.translation.z = T::of(f64::INFINITY),
                    2 => bad.rotation *= T::of(1.1),
                    _ => bad.rotation.m12 = T::of(f64::NAN),
                }
                order = Order::Follow(bad);
            }
            if random.chance(0.05) {
                let most = random.within(0.0, 0.05);
                uncertainty = random
                    .chance(0.7)
                    .then(|| Uncertainty { place_m: T::of(most), turn_rad: T::of(most * 8.0) });
            }
            let governed = arm.step_knowing(&order, uncertainty.as_ref());
            match governed.verdict {
                Verdict::Pass => passed += 1,
                Verdict::Clamp => clamped += 1,
                Verdict::Reject => rejected += 1,
            }
            assert_eq!(
                governed.verdict == Verdict::Clamp,
                order != Order::Stop && governed.verdict != Verdict::Reject && !governed.limits.is_empty()
            );
            rests += u64::from(governed.at_rest);
        }
        fastest = fastest.max(arm.fastest_m_s);
        let mut cycles = 0;
        while !arm.step(&Order::Stop).at_rest {
            cycles += 1;
            assert!(cycles < 2_000_000 / u64::from(config.cycle_us), "no rest after 2 s");
        }
    }
    std::println!(
        "{passed} passed, {clamped} clamped, {rejected} rejected, {rests} at rest, {fastest:.3} m/s"
    );
    assert!(passed > 100 && clamped > 100 && rejected > 20 && rests > 20);
}

#[test]
fn whatever_is_ordered_the_bounds_are_kept() {
    anything::<f64>(sequences(2_000));
}

#[test]
fn also_in_single_precision() {
    anything::<f32>(sequences(1_000));
}

#[test]
fn a_stop_ends_at_rest_and_following_goes_on_from_there() {
    let config = GovernorConfig::default();
    let mut arm = Checked::<f64>::new(&config, &MIDDLE);
    let home = *arm.governor.pose();
    let goal = elsewhere(&arm);
    for _ in 0..40 {
        arm.follow(&goal);
    }
    let mut cycles = 0;
    loop {
        let governed = arm.step(&Order::Stop);
        cycles += 1;
        if governed.at_rest {
            assert_eq!((governed.verdict, governed.limits), (Verdict::Pass, Limits::NONE));
            break;
        }
        assert!(governed.limits.contains(Limit::Stopping) && governed.speed_share == 0.0);
        assert!(cycles < 60, "{governed:?}");
    }
    assert!(cycles > 5, "stopped at once");
    assert!(arm.settle(&goal, 1e-9, 1_000).is_some());
    assert!(arm.settle(&home, 1e-9, 1_000).is_some());
}

#[test]
fn what_cannot_be_used_is_rejected_by_name_and_the_arm_comes_to_rest() {
    let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &MIDDLE);
    let home = *arm.governor.pose();
    let goal = elsewhere(&arm);
    for _ in 0..40 {
        arm.follow(&goal);
    }
    for (bad, limit) in [
        (Pose { translation: home.translation * f64::NAN, ..home }, Limit::GoalNotFinite),
        (Pose { translation: home.translation * 1e9, ..home }, Limit::GoalNotFinite),
        (Pose { rotation: home.rotation * 1.1, ..home }, Limit::GoalNotARotation),
        (Pose { rotation: -home.rotation, ..home }, Limit::GoalNotARotation),
    ] {
        for _ in 0..60 {
            let governed = arm.follow(&bad);
            assert_eq!(governed.verdict, Verdict::Reject);
            assert!(governed.limits.contains(limit), "{}", governed.limits);
        }
        assert!(arm.governor.axes.iter().all(Axis::is_at_rest));
    }
}

#[test]
fn the_less_is_known_of_the_hand_the_slower_the_arm() {
    let mut times = std::vec::Vec::new();
    for (place_m, turn_rad, slowed) in [
        (0.001, 0.01, false),
        (0.01, 0.01, true),
        (0.02, 0.01, true),
        (0.001, 0.4, true),
        (f64::NAN, 0.01, true),
    ] {
        let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &MIDDLE);
        let goal = elsewhere(&arm);
        let uncertainty = Uncertainty { place_m, turn_rad };
        let (mut cycles, mut named) = (0, false);
        while arm.off(&goal).0 > 1e-3 {
            let governed = arm.step_knowing(&Order::Follow(goal), Some(&uncertainty));
            named |= governed.limits.contains(Limit::HandUncertain);
            cycles += 1;
            assert!(cycles < 2_000);
        }
        assert_eq!(named, slowed, "{place_m} m, {turn_rad} rad");
        times.push(cycles);
    }
    // close to full speed it is the last millimetres that count
    assert!(times[0] < times[2] && times[1] < times[2] && times[2] < times[3], "{times:?}");
    assert_eq!(times[3], times[4], "NaN is the least known");
}

#[test]
fn a_start_is_refused_by_joint() {
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    let mut governor = Governor::new(&arm, &GovernorConfig::default()).unwrap();
    let mut joints = MIDDLE;
    joints[3] = f64::NAN;
    assert_eq!(governor.start(&joints), Err(StartRefusal::NotFinite(JointSet::EMPTY.with(4))));
    joints = MIDDLE;
    joints[0] = 3.0;
    joints[5] = -5.0;
    assert_eq!(governor.start(&joints), Err(StartRefusal::OutsideRange(JointSet::EMPTY.with(1).with(6))));
    assert_eq!(governor.start(&MIDDLE), Ok(()));
    assert_eq!(governor.set_point(), MIDDLE);
}

#[test]
fn a_joint_outside_its_range_may_only_come_back() {
    let config = GovernorConfig::default();
    let range = PumaConfig::default().joints[0];
    let mut joints = MIDDLE;
    joints[0] = range.max_rad + 0.05;
    let mut arm = Checked::<f64>::new(&config, &joints);
    let home = *arm.governor.pose();
    // where it is, it may stay
    let governed = arm.follow(&home);
    assert!(governed.at_rest, "{governed:?}");
    // farther out it does not go
    let mut outwards = joints;
    outwards[0] += 0.2;
    let goal = arm.arm.forward(&outwards);
    let mut before = joints[0];
    for _ in 0..300 {
        let governed = arm.follow(&goal);
        assert!(governed.set_point[0] <= joints[0]);
        assert_eq!(governed.limits.contains(Limit::OutsideRange(1)), before > range.max_rad);
        before = governed.set_point[0];
    }
    // back it comes, and then stays in
    let inside = arm.arm.forward(&MIDDLE);
    let mut back = joints;
    back[0] = range.max_rad - 0.3;
    assert!(arm.settle(&arm.arm.forward(&back), 1e-9, 2_000).is_some(), "{:?}", arm.follow(&inside));
    for _ in 0..300 {
        let governed = arm.follow(&goal);
        assert!(governed.set_point[0] <= range.max_rad);
    }
}

#[test]
fn out_of_reach_the_arm_comes_to_rest_as_near_as_it_goes() {
    let mut random = Random::new(33);
    let config = GovernorConfig::default();
    let (mut still, mut cases) = (0, 0);
    for _ in 0..sequences(400) {
        let mut arm = Checked::<f64>::new(&config, &anywhere(&mut random, &config, 0.2));
        let mut goal = *arm.governor.pose();
        goal.translation += random.vector(1.0).normalize() * 0.3;
        goal.rotation = random.rotation(0.8) * goal.rotation;
        for _ in 0..1_500 {
            arm.follow(&goal);
        }
        let before = arm.governor.pose().translation;
        let moved =
            (0..100).map(|_| (arm.follow(&goal).pose.translation - before).norm()).fold(0.0, f64::max);
        cases += 1;
        still += u64::from(moved < 1e-3);
    }
    std::println!("{still} of {cases} are still");
    assert!(still * 100 >= cases * 95, "{still} of {cases} are still");
}

#[test]
fn a_passage_is_told_and_one_that_is_not_allowed_is_not_made() {
    let mut joints = MIDDLE;
    joints[4] = 0.4;
    let mut beyond = joints;
    beyond[4] = -0.4;
    for wrist in [true, false] {
        let mut config = GovernorConfig::default();
        config.passages.wrist = wrist;
        let mut arm = Checked::<f64>::new(&config, &joints);
        let home = *arm.governor.pose();
        let goal = arm.arm.forward(&beyond);
        let mut changes = std::vec::Vec::new();
        let mut named = false;
        for _ in 0..600 {
            let governed = arm.follow(&goal);
            changes.extend(governed.change);
            named |= governed.limits.contains(Limit::WristSingularity);
        }
        assert!(named);
        if wrist {
            assert!(arm.off(&goal).0 < 1e-9 && changes.len() == 1, "{changes:?}");
            assert_eq!(changes[0].kind, ChangeKind::Passage);
            assert!(
                changes[0].from.wrist != changes[0].to.wrist && changes[0].from.elbow == changes[0].to.elbow
            );
        } else {
            assert!(changes.is_empty(), "{changes:?}");
        }
        assert!(arm.settle(&home, 1e-9, 2_000).is_some());
    }
    // what the default policy of the inverse says of the same way
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    assert!(arm.choose(&arm.forward(&beyond), &Recent::at_rest(&arm, &joints), &Policy::default()).is_err());
}

#[test]
fn away_from_a_singularity_nothing_is_slowed() {
    let mut joints = MIDDLE;
    joints[4] = 0.08;
    let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &joints);
    let (near, mut away) = (*arm.governor.pose(), joints);
    away[4] = 0.5;
    let goal = arm.arm.forward(&away);
    while arm.off(&goal).1 > 0.01 {
        let governed = arm.follow(&goal);
        assert!(!governed.limits.contains(Limit::WristSingularity), "{}", governed.limits);
        assert!(arm.cycles < 500);
    }
    // and towards it, it is
    assert!((0..500).any(|_| arm.follow(&near).limits.contains(Limit::WristSingularity)));
}
