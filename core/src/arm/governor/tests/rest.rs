//! With a hand that is held still the arm comes to rest and stays there.

use super::*;

/// How far the tool goes in a cycle: metres and radians.
fn step<T: Real>(arm: &mut Checked<T>, goal: &Pose<T>) -> (f64, f64) {
    let before = *arm.governor.pose();
    arm.follow(goal);
    arm.off(&before)
}

/// The hand goes on by `place` and `turn`, no farther ahead of the arm than the law lets it.
fn led(goal: &mut Pose<f64>, arm: &Pose<f64>, place: &Vector3<f64>, turn: &Vector3<f64>) {
    goal.translation += place;
    let lead = goal.translation - arm.translation;
    if lead.norm() > 0.25 {
        goal.translation = arm.translation + lead * (0.25 / lead.norm());
    }
    goal.rotation = so3::exp(turn) * goal.rotation;
    let lead = so3::log(&(goal.rotation * arm.rotation.transpose()));
    if lead.norm() > 1.0 {
        goal.rotation = so3::exp(&(lead / lead.norm())) * arm.rotation;
    }
}

/// A hand that wanders six times for 0.6 s at 0.4 m/s and 2 rad/s at most, and is then held still.
fn wander(random: &mut Random, arm: &mut Checked<f64>) -> Pose<f64> {
    let mut goal = *arm.governor.pose();
    for _ in 0..6 {
        let (place, turn) = (random.vector(0.004), random.vector(0.02));
        for _ in 0..60 {
            led(&mut goal, &arm.governor.pose().clone(), &place, &turn);
            arm.follow(&goal);
        }
    }
    goal
}

/// A hand that is held still, as cameras see it.
fn trembling(random: &mut Random, goal: &Pose<f64>) -> Pose<f64> {
    Pose {
        rotation: random.rotation(0.0005) * goal.rotation,
        translation: goal.translation + random.vector(0.0001),
    }
}

#[test]
fn once_at_rest_it_stays_there_until_the_hand_moves() {
    let mut random = Random::new(78);
    let config = GovernorConfig::default();
    let (mut rested, mut short, mut worst) = (0u64, 0, (0.0f64, 0.0f64));
    let mut moved = std::vec::Vec::new();
    for case in 0..sequences(3_200) {
        let mut arm = Checked::<f64>::new(&config, &anywhere(&mut random, &config, 0.1));
        let home = *arm.governor.pose();
        let still_at = wander(&mut random, &mut arm);
        let is_seen = case % 2 == 1;
        let mut goal = still_at;
        // slow is at rest: less than 2 mm/s and 0.02 rad/s for 0.3 s
        let mut still = 0;
        let rests = (0..600).any(|_| {
            goal = if is_seen { trembling(&mut random, &still_at) } else { still_at };
            let (m, rad) = step(&mut arm, &goal);
            still = if m < 2e-5 && rad < 2e-4 { still + 1 } else { 0 };
            still >= 30
        });
        if !rests {
            continue;
        }
        rested += 1;
        let (there, changes) = (*arm.governor.pose(), arm.changes);
        let off = arm.off(&goal);
        short += u64::from(off.0.max(off.1) > 1e-3);
        for _ in 0..600 {
            goal = if is_seen { trembling(&mut random, &still_at) } else { still_at };
            arm.follow(&goal);
            let (m, rad) = arm.off(&there);
            worst = (worst.0.max(m), worst.1.max(rad));
            if m > 0.002 || rad > 0.02 || arm.changes != changes {
                moved.push((case, off, m, rad, arm.changes != changes));
                break;
            }
        }
        // it was not given up
        let moved = |off: (f64, f64)| off.0 > 1e-3 || off.1 > 1e-2;
        let is_elsewhere = moved(arm.off(&home));
        let came = (0..200).any(|_| {
            arm.follow(&home);
            moved(arm.off(&there))
        });
        assert!(came || !is_elsewhere, "case {case}: stays where it is with another goal");
    }
    std::println!("{rested} at rest, {short} of them short of the goal; at most {worst:?} from there");
    assert!(moved.is_empty(), "{} set off by themselves: {moved:#?}", moved.len());
    assert!(rested * 10 >= sequences(3_200) * 7 && short * 10 > rested, "{rested}, {short}");
}

#[test]
fn a_hand_that_holds_a_joint_against_its_end_does_not_turn_the_wrist_over() {
    for past in [0.05, 0.1, 0.3] {
        let mut joints = [0.3, 1.9, -2.6, -0.5, 0.5, 0.5];
        let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &joints);
        // through the wrist's singularity, which is allowed
        joints[4] = -0.5;
        assert!(arm.settle(&arm.arm.forward(&joints), 1e-9, 1_000).is_some());
        assert_eq!(arm.changes, 1);
        let end = arm.arm.config().joints[5].max_rad + past;
        while joints[5] < end {
            joints[5] = (joints[5] + 0.02).min(end);
            arm.follow(&arm.arm.forward(&joints));
        }
        let goal = arm.arm.forward(&joints);
        for _ in 0..200 {
            arm.follow(&goal);
        }
        let there = *arm.governor.pose();
        for _ in 0..2_000 {
            let governed = arm.follow(&goal);
            assert!(governed.at_rest && governed.limits.contains(Limit::JointRange(6)), "{governed:?}");
        }
        assert_eq!((arm.changes, *arm.governor.pose()), (1, there), "{past} past its end");
        // and from there back out
        joints[5] -= 1.0;
        assert!(arm.settle(&arm.arm.forward(&joints), 1e-9, 1_000).is_some());
        assert_eq!(arm.changes, 1);
    }
}
