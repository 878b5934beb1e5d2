//! What the operator is told of a cycle.

use super::*;
use crate::arm::governor::Limit;
use crate::arm::port::PortFault;
use crate::wire::{
    ArmReason, ArmState, ArmVerdict, CommandEcho, ControllerState, MAX_BODY_LEN, Packet, Settled,
    decode_body, encode_body,
};

const STAMP: Stamp = Stamp {
    session: 5,
    sequence: 6,
    time_us: 7,
    command: Some(CommandEcho {
        session: 1,
        sequence: 2,
        received_us: 3,
        solved_after_us: 4,
        written_after_us: 5,
    }),
    settled: Some(Settled { sequence: 1, after_us: 9 }),
    buttons_age_us: Some(8),
};

#[test]
fn a_cycle_is_told_as_it_was() {
    let mut rig = Rig::<f64>::engaged(&SlaveConfig::default());
    rig.sender.hand = at(0.05, 0.0, 1.0);
    let step = rig.run(100_000);
    let packet = step.report(&rig.reading(), &STAMP);
    assert_eq!((packet.state, packet.reason), (ArmState::Engaged, ArmReason::None));
    assert_eq!(packet.controller, ControllerState::Ready);
    let governed = step.governed.unwrap();
    assert_eq!(packet.set_point, governed.set_point.map(|angle| angle as f32));
    assert_eq!(packet.tool.translation[0], governed.pose.translation.x as f32);
    assert_eq!(packet.measured.unwrap().joints, rig.joints.map(|angle| angle as f32));
    for limit in governed.limits.iter() {
        assert!(Limits::from_bits(packet.limits).contains(limit), "{limit}");
    }
    assert_eq!((packet.command, packet.settled), (STAMP.command, STAMP.settled));
    assert_eq!(packet.buttons_age_us, STAMP.buttons_age_us);
    let mut out = [0; MAX_BODY_LEN];
    let length = encode_body(&packet.into(), &mut out).unwrap();
    assert_eq!(decode_body(&out[..length]), Ok(Packet::from(packet)));
}

#[test]
fn an_arm_that_is_not_there_is_told_as_well() {
    let mut rig = Rig::<f32>::new(&SlaveConfig::default());
    (rig.status, rig.readable) = (PortStatus::Fault(PortFault { joint: Some(3), code: 99 }), false);
    let step = rig.step();
    let packet = step.report(&rig.reading(), &STAMP);
    assert_eq!((packet.state, packet.reason), (ArmState::Stopped, ArmReason::Started));
    assert_eq!((packet.measured, packet.verdict), (None, ArmVerdict::Pass));
    assert_eq!(packet.controller, ControllerState::Fault { joint: 3, code: 99 });
    let mut out = [0; MAX_BODY_LEN];
    assert!(encode_body(&packet.into(), &mut out).is_ok());
    rig.readable = true;
    rig.joints[2] = f32::NAN;
    let packet = rig.step().report(&rig.reading(), &STAMP);
    assert!(encode_body(&packet.into(), &mut out).is_ok(), "what is no number is not measured");
}

#[test]
fn the_bits_of_limits_and_notes_are_those_of_the_document() {
    const DOCUMENT: &str = include_str!("../../../../../docs/wire.md");
    for (bit, limit) in [
        (0, Limit::GoalNotFinite),
        (1, Limit::GoalNotARotation),
        (2, Limit::WorkspaceEdge),
        (3, Limit::TooFar),
        (4, Limit::TooNear),
        (5, Limit::WristSingularity),
        (6, Limit::ElbowSingularity),
        (7, Limit::ShoulderSingularity),
        (8, Limit::AnotherWay),
        (9, Limit::ToolSpeed),
        (10, Limit::HandUncertain),
        (11, Limit::Stopping),
        (16, Limit::JointRange(1)),
        (27, Limit::NearLowerLimit(6)),
        (28, Limit::NearUpperLimit(1)),
        (39, Limit::OutsideRange(6)),
        (40, Limit::JointSpeed(1)),
        (51, Limit::JointAcceleration(6)),
    ] {
        let only: std::vec::Vec<_> = Limits::from_bits(1 << bit).iter().collect();
        assert_eq!(only, [limit], "bit {bit}");
        assert_eq!(Limits::from_bits(1 << bit).bits(), 1 << bit);
    }
    assert!(DOCUMENT.contains("40 to 45 speed, 46 to 51 acceleration"));
}
