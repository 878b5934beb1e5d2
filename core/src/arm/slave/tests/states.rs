//! Starts, losses, and an arm that does not do as it is told.

use super::*;
use crate::arm::port::PortFault;
use crate::arm::teleop::{FaultReason, State, Status};

fn state<T: Real>(step: &SlaveStep<T>) -> State {
    step.decision.status.state()
}

#[test]
fn nothing_is_written_to_a_port_that_is_not_ready() {
    for status in [PortStatus::Disabled, PortStatus::Enabling, PortStatus::NotHomed, PortStatus::Lost] {
        let mut rig = Rig::<f64>::new(&SlaveConfig::default());
        rig.status = status;
        let step = rig.run(100_000);
        assert_eq!((step.order, step.governed), (PortOrder::Nothing, None), "{status:?}");
        assert!(rig.reset().is_err(), "{status:?}");
    }
}

#[test]
fn the_set_point_begins_where_the_arm_is_and_stands_still() {
    let mut rig = Rig::<f64>::new(&SlaveConfig::default());
    let start = rig.joints;
    for _ in 0..100 {
        let step = rig.cycle();
        assert_eq!(step.order, PortOrder::Write(start));
        assert_eq!(state(&step), State::Stopped);
    }
    rig.reset().unwrap();
    assert_eq!(rig.run(500_000).order, PortOrder::Write(start));
    rig.press();
    assert_eq!(rig.run(500_000).order, PortOrder::Write(start), "a still hand moves nothing, to the bit");
}

#[test]
fn a_fault_in_motion_writes_nothing_more_and_starts_anew_where_the_arm_came_to_rest() {
    let mut rig = Rig::<f64>::engaged(&SlaveConfig::default());
    for _ in 0..30 {
        rig.sender.hand.translation.x += 0.002;
        rig.cycle();
    }
    rig.status = PortStatus::Fault(PortFault { joint: Some(2), code: 0x8611 });
    let step = rig.cycle();
    assert_eq!(step.decision.status, Status::Fault(FaultReason::Arm));
    assert_eq!(step.order, PortOrder::Nothing);
    // it sags while it is off
    rig.joints[1] -= 0.02;
    let sagged = rig.joints;
    rig.status = PortStatus::Ready;
    assert_eq!(rig.run(300_000).order, PortOrder::Write(sagged));
    assert!(rig.reset().is_err(), "the button is still held");
    rig.release();
    rig.run(100_000);
    rig.reset().unwrap();
    assert_eq!(rig.run(300_000).order, PortOrder::Write(sagged));
}

#[test]
fn an_arm_that_is_held_is_stopped_at_its_port() {
    let mut rig = Rig::<f64>::engaged(&SlaveConfig::default());
    let held = rig.joints;
    let mut told = None;
    for _ in 0..300 {
        rig.sender.hand.translation.y += 0.002;
        let step = rig.cycle();
        rig.joints = held;
        if step.order == PortOrder::Stop {
            told = Some(step.decision.status);
            break;
        }
    }
    assert_eq!(told, Some(Status::Fault(FaultReason::ArmAstray)));
    rig.status = PortStatus::Stopped;
    assert_eq!(rig.cycle().order, PortOrder::Nothing);
}

#[test]
fn an_arm_that_cannot_be_read_is_stopped_after_its_time() {
    let config = SlaveConfig::default();
    let mut rig = Rig::<f64>::engaged(&config);
    rig.readable = false;
    let blind_us = u64::from(config.blind_timeout_us);
    assert_eq!(state(&rig.run(blind_us)), State::Engaged);
    let step = rig.cycle();
    assert_eq!(step.decision.status, Status::Fault(FaultReason::ArmBlind));
    assert_eq!(step.order, PortOrder::Stop);
}

#[test]
fn nonsense_read_from_the_joints_is_no_place_to_be() {
    let mut rig = Rig::<f64>::engaged(&SlaveConfig::default());
    rig.joints[3] = f64::NAN;
    let step = rig.cycle();
    assert_eq!((state(&step), step.order), (State::Fault, PortOrder::Stop));

    let mut rig = Rig::<f64>::new(&SlaveConfig::default());
    rig.joints[3] = f64::NAN;
    let step = rig.cycle();
    assert_eq!(step.order, PortOrder::Nothing);
    assert!(step.refusal.is_some());
}

#[test]
fn an_arm_far_outside_its_range_does_not_start() {
    let mut rig = Rig::<f64>::new(&SlaveConfig::default());
    rig.joints[2] = 2.0;
    let step = rig.cycle();
    assert_eq!(step.order, PortOrder::Nothing);
    assert!(step.refusal.is_some());
    assert_eq!(rig.reset(), Err(ResetRefusal::Arm(FaultReason::ArmCannotStart)));
}
