//! The operator's share of the scale.

use super::*;

fn share(percent: u8) -> ScaleShare {
    ScaleShare::from_percent(percent).unwrap()
}

/// How far the tool is led by 0.1 m of the hand.
fn led(rig: &mut Rig<f64>) -> f64 {
    let before = rig.arm.set_point.translation.x;
    for _ in 0..10 {
        rig.move_hand(Vector3::new(0.01, 0.0, 0.0));
        rig.step();
    }
    rig.arm.set_point.translation.x - before
}

#[test]
fn it_counts_from_the_next_press_on_and_nothing_jumps() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig { scale: 0.5, ..TeleopConfig::default() });
    assert!((led(&mut rig) - 0.05).abs() < 1e-6);
    rig.teleop.press_is_for(PressFor::Follow, share(20));
    assert!((led(&mut rig) - 0.05).abs() < 1e-6, "this press goes on as it was");
    assert_eq!(rig.step().scale, 0.5);
    rig.release();
    assert_eq!(rig.step().scale, 0.1, "that of the next press");
    let before = rig.arm.set_point;
    rig.press();
    let decision = rig.step();
    assert_eq!((decision.order, decision.scale), (Order::Follow(before), 0.1));
    assert!((led(&mut rig) - 0.01).abs() < 1e-6);
    rig.teleop.press_is_for(PressFor::Follow, ScaleShare::FULL);
    assert!((led(&mut rig) - 0.01).abs() < 1e-6);
}

#[test]
fn turns_are_followed_in_full_and_the_goal_is_known_better_by_the_share() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
    rig.teleop.press_is_for(PressFor::Follow, share(10));
    rig.press();
    rig.step();
    let start = rig.arm.set_point.rotation;
    rig.sender.hand.rotation *= so3::exp(&Vector3::new(0.2, 0.0, 0.0));
    let mut known = PoseCovariance::zeros();
    (known.m11, known.m44) = (1e-4, 1e-4);
    rig.send(|command| command.covariance = Some(known)).unwrap();
    let decision = rig.step();
    assert!((law::angle(&decision.order.goal().unwrap().rotation, &start) - 0.2).abs() < 1e-6);
    let uncertainty = decision.uncertainty.unwrap();
    assert!((uncertainty.place_m - 0.001).abs() < 1e-9, "{uncertainty:?}");
    assert!((uncertainty.turn_rad - 0.01).abs() < 1e-9, "{uncertainty:?}");
}

#[test]
fn the_papers_law_knows_it_too() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::paper());
    rig.teleop.press_is_for(PressFor::Follow, share(50));
    rig.press();
    rig.step();
    assert!((led(&mut rig) - 0.05).abs() < 1e-6);
}

#[test]
fn what_is_no_share_is_none() {
    for percent in [0, 101, 255] {
        assert_eq!(ScaleShare::from_percent(percent), None);
    }
    assert_eq!(ScaleShare::from_percent(100), Some(ScaleShare::default()));
}
