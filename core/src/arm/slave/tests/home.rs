//! Home, from the button to the joints.

use super::*;
use crate::arm::teleop::{ArmedReason, Status};

#[test]
fn the_arm_comes_home_while_the_button_is_held_and_says_so() {
    let mut rig = Rig::<f64>::engaged(&SlaveConfig::default());
    let home = rig.tool();
    for _ in 0..100 {
        rig.sender.hand.translation.x += 0.002;
        rig.cycle();
    }
    rig.release();
    rig.run(1_000_000);
    let there = rig.tool();
    assert!((there.translation - home.translation).norm() > 0.1);
    rig.slave.press_is_for(PressFor::Home, ScaleShare::FULL);
    rig.press();
    // half of the way, and a release in between
    rig.run(500_000);
    let between = rig.tool();
    assert!((between.translation - there.translation).norm() > 0.01, "it moves");
    rig.release();
    let step = rig.run(1_000_000);
    assert_eq!(step.decision.status, Status::Armed(ArmedReason::Press));
    assert!(step.governed.unwrap().at_rest);
    let rested = rig.tool();
    assert_eq!(rig.run(500_000).order, PortOrder::Write(rig.joints));
    assert_eq!(rig.tool(), rested, "it stays where it was let go");
    rig.press();
    let step = rig.run(5_000_000);
    assert!(step.decision.notes.contains(Note::GoesHome) && step.decision.notes.contains(Note::AtHome));
    assert!((rig.tool().translation - home.translation).norm() < 1e-6);
    let report = step.report(
        &rig.reading(),
        &Stamp {
            session: 1,
            sequence: 0,
            time_us: rig.now_us,
            command: None,
            settled: None,
            buttons_age_us: None,
        },
    );
    assert_eq!(report.notes >> 6, 0b11);
}

/// Somebody vouched for joints that were not homed; then they were.
#[test]
fn where_a_wrong_homing_began_is_not_home() {
    let mut rig = Rig::<f64>::armed(&SlaveConfig::default());
    let wrong = rig.tool();
    rig.status = PortStatus::NotHomed;
    rig.cycle();
    rig.joints[0] += 0.3;
    rig.status = PortStatus::Ready;
    rig.release();
    rig.run(100_000);
    rig.reset().unwrap();
    let home = rig.tool();
    assert!((home.translation - wrong.translation).norm() > 0.05);
    rig.slave.press_is_for(PressFor::Home, ScaleShare::FULL);
    rig.press();
    let step = rig.run(2_000_000);
    assert!(step.decision.notes.contains(Note::AtHome));
    assert!((rig.tool().translation - home.translation).norm() < 1e-6, "it stays");
}

#[test]
fn a_home_that_cannot_be_worked_with_makes_no_slave() {
    let mut config = SlaveConfig::default();
    config.governor.home_rad = Some([9.0; JOINTS]);
    assert!(Slave::<f64>::new(&config).is_err());
}
