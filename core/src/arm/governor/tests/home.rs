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
    for _ in 0..10 {
        let start = anywhere(&mut random, &config, 0.05);
        let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
        let mut governor = Governor::new(&arm, &config).unwrap();
        assert_eq!(governor.home(), Some(&arm.forward(&HOME)));
        governor.start(&start).unwrap();
        // in the posture of the start there may be no way to the very pose; then it rests as near as it goes
        let mut rests = 0;
        for _ in 0..20_000 {
            let governed = governor.step(&Order::Home, None);
            rests = if governed.at_rest { rests + 1 } else { 0 };
            if governed.at_home || rests > 500 {
                break;
            }
        }
        assert!(rests > 0, "it does not come to rest: {start:?}");
    }
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
