//! The way home: from wherever the arm is, slowly, within every limit.

use super::*;
use crate::arm::governor::tests::anywhere;

const HOME: Joints<f64> = [0.3, 1.9, -2.6, 0.4, 0.9, -0.5];

/// Cycles until the arm is home.
fn bring_home<T: Real>(arm: &mut Checked<T>) -> u32 {
    for cycle in 0..10_000 {
        if arm.step(&Order::Home).at_home {
            return cycle;
        }
    }
    panic!("not home: {:?} of {:?}", arm.governor.pose(), arm.governor.home());
}

fn comes_home<T: Real>() {
    let mut random = Random::new(71);
    let config = GovernorConfig::default();
    for _ in 0..10 {
        let mut arm = Checked::<T>::new(&config, &HOME);
        let home = *arm.governor.pose();
        let goal = Pose {
            rotation: random.rotation(0.5).map(T::of) * home.rotation,
            translation: home.translation + random.vector(0.15).map(T::of),
        };
        for _ in 0..300 {
            arm.follow(&goal);
        }
        assert_ne!(*arm.governor.pose(), home);
        arm.fastest_m_s = 0.0;
        // what the hand had of speed is gone first
        for _ in 0..100 {
            arm.step(&Order::Stop);
        }
        arm.fastest_m_s = 0.0;
        bring_home(&mut arm);
        let most = config.max_tool_speed_m_s * config.home_speed_share;
        assert!(arm.fastest_m_s > 0.0 && arm.fastest_m_s <= most, "{} m/s", arm.fastest_m_s);
        let governed = arm.step(&Order::Home);
        assert!(governed.at_rest && governed.at_home, "it stays there: {governed:?}");
    }
}

#[test]
fn home_is_where_the_arm_was_first_started_and_it_comes_there_slowly() {
    comes_home::<f64>();
    comes_home::<f32>();
}

#[test]
fn a_second_start_changes_nothing_of_home() {
    let config = GovernorConfig::default();
    let mut arm = Checked::<f64>::new(&config, &HOME);
    let home = *arm.governor.pose();
    let mut elsewhere = HOME;
    elsewhere[0] += 0.4;
    arm.governor.start(&elsewhere).unwrap();
    assert_eq!(arm.governor.home(), Some(&home));
    assert_ne!(*arm.governor.pose(), home);
}

#[test]
fn home_can_be_set_and_is_reached_from_anywhere() {
    let mut random = Random::new(72);
    let config = GovernorConfig { home_rad: Some(HOME), ..GovernorConfig::default() };
    let mut homes = 0;
    for _ in 0..20 {
        let start = anywhere(&mut random, &config, 0.05);
        let mut arm = Checked::<f64>::new(&config, &start);
        let home = arm.arm.forward(&HOME);
        assert_eq!(arm.governor.home(), Some(&home));
        let there_m = (arm.governor.pose().translation - home.translation).norm();
        // in the posture of the start there may be no way to the very pose; then it rests as near as it goes
        let (mut rests, mut is_home) = (0, false);
        while rests < 500 && !is_home {
            let governed = arm.step(&Order::Home);
            rests = if governed.at_rest { rests + 1 } else { 0 };
            is_home = governed.at_home;
            assert!(arm.cycles < 20_000, "it does not come to rest: {start:?}");
        }
        let left_m = (arm.governor.pose().translation - home.translation).norm();
        assert!(is_home || left_m < there_m, "{left_m} m left of {there_m} m: {start:?}");
        homes += u32::from(is_home);
    }
    assert!(homes >= 10, "{homes} of 20");
}

/// Whoever sees that the joints were not where they said does not go back to where the arm never was.
#[test]
fn home_is_forgotten_unless_it_is_set() {
    let mut arm = Checked::<f64>::new(&GovernorConfig::default(), &HOME);
    arm.governor.forget_home();
    assert_eq!(arm.governor.home(), None);
    let mut elsewhere = HOME;
    elsewhere[0] += 0.4;
    arm.governor.start(&elsewhere).unwrap();
    assert_eq!(arm.governor.home(), Some(arm.governor.pose()));
    let set = GovernorConfig { home_rad: Some(HOME), ..GovernorConfig::default() };
    let mut arm = Checked::<f64>::new(&set, &HOME);
    arm.governor.forget_home();
    assert!(arm.governor.home().is_some());
}

/// An arm that was first started outside of its workspace is home where it comes nearest to that.
#[test]
fn an_arm_that_began_outside_comes_home_at_the_face() {
    let mut config = GovernorConfig::default();
    let place = Puma560::<f64>::new(&PumaConfig::default()).unwrap().forward(&HOME).translation;
    config.workspace.min_m[2] = place.z + 0.05;
    let mut arm = Checked::<f64>::unheld(&config, &HOME);
    let home = *arm.governor.pose();
    let up = Pose { translation: home.translation + Vector3::z() * 0.15, ..home };
    for _ in 0..500 {
        arm.follow(&up);
    }
    bring_home(&mut arm);
    let at = arm.governor.pose().translation;
    assert!((at.z - config.workspace.min_m[2]).abs() < 1e-3, "{at:?}");
}

/// However little speed there is, a straight way that is free is gone straight.
#[test]
fn slowness_is_no_bar() {
    let config = GovernorConfig { speed_share: 0.1, home_speed_share: 0.05, ..GovernorConfig::default() };
    let mut arm = Checked::<f64>::new(&config, &HOME);
    let home = *arm.governor.pose();
    let turned = Pose { rotation: so3::exp(&Vector3::new(0.0, 0.0, 0.8)) * home.rotation, ..home };
    for _ in 0..3_000 {
        arm.follow(&turned);
    }
    let mut off_m: f64 = 0.0;
    for _ in 0..10_000 {
        let governed = arm.step(&Order::Home);
        off_m = off_m.max((governed.pose.translation - home.translation).norm());
        if governed.at_home {
            break;
        }
    }
    assert!(arm.step(&Order::Home).at_home, "{off_m} m");
    assert!(off_m < 2e-3, "the tool leaves its place by {off_m} m to turn back in it");
}

#[test]
fn a_home_that_is_out_of_range_or_of_the_workspace_is_refused() {
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    let refused = |joints: Joints<f64>, top_m: f64| {
        let mut config = GovernorConfig { home_rad: Some(joints), ..GovernorConfig::default() };
        config.workspace.max_m[2] = top_m;
        Governor::new(&arm, &config).err()
    };
    assert_eq!(refused(HOME, 1.6), None);
    let mut joints = HOME;
    joints[4] = 3.0;
    assert_eq!(refused(joints, 1.6), Some(GovernorConfigError::Home(5)));
    joints[4] = f64::NAN;
    assert_eq!(refused(joints, 1.6), Some(GovernorConfigError::Home(5)));
    assert_eq!(refused(HOME, 0.05), Some(GovernorConfigError::HomeOutside));
}

#[test]
fn an_arm_that_was_never_started_has_no_home_to_go_to() {
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    let mut governor = Governor::new(&arm, &GovernorConfig::default()).unwrap();
    let before = governor.set_point();
    assert_eq!(governor.home(), None);
    assert_eq!(governor.step(&Order::Home, None).set_point, before);
}
