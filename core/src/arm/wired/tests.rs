//! What needs no drives: those are in tests/tests/canopen.

use super::*;
use crate::config::GovernorConfig;
use crate::hand::state::PoseState;
use crate::observation::BALLS;
use crate::wire::{ArmReason, ArmState, PressFor, ScaleShare, Transform};
use std::string::ToString as _;
use std::vec::Vec;

fn slave() -> WiredSlave {
    WiredSlave::new(&SlaveConfig::default(), &CanopenConfig::default(), 1).unwrap()
}

fn motion(session: u32, sequence: u32) -> Packet {
    Packet::Motion(MotionPacket {
        session,
        sequence,
        capture_us: 0,
        engaged: true,
        engagements: 1,
        state: PoseState::Both,
        spans: 1,
        views: 2,
        seen_in: [2; BALLS],
        residual_px: 0.1,
        increment: Transform::IDENTITY,
        since_engage: Transform::IDENTITY,
        covariance: None,
    })
}

fn buttons(session: u32, sequence: u32, pressed: bool) -> Packet {
    Packet::Buttons(ButtonsPacket {
        session,
        sequence,
        time_us: 0,
        pressed,
        stop: false,
        resets: 0,
        press_for: PressFor::Follow,
        scale: ScaleShare::FULL,
    })
}

#[test]
fn without_a_reset_nothing_is_said_on_the_bus_but_to_set_up_and_nothing_is_written() {
    let mut slave = slave();
    let mut frames: Vec<Frame> = Vec::new();
    for cycle in 1..100_u32 {
        let now_us = u64::from(cycle) * 10_000;
        slave.take(&motion(7, cycle), now_us);
        slave.take(&buttons(7, cycle, true), now_us);
        let state = slave.cycle(now_us, &mut frames).expect("told in each cycle of 10 ms");
        assert_eq!((state.state, state.reason), (ArmState::Stopped, ArmReason::Started));
        assert_eq!(state.sequence, cycle - 1);
    }
    assert!(frames.iter().all(|frame| frame.function() != 0x200), "{frames:?}");
    assert_eq!(slave.counts().taken, 99);
}

#[test]
fn old_packets_and_those_of_others_are_dropped() {
    let mut slave = slave();
    let mut frames: Vec<Frame> = Vec::new();
    for (session, sequence) in [(7, 5), (7, 5), (7, 4), (8, 1), (7, 6)] {
        slave.take(&motion(session, sequence), 10_000);
        slave.cycle(10_000, &mut frames);
    }
    assert_eq!(slave.counts().taken, 2, "7, 5 and 8, 1");
}

#[test]
fn cycles_that_differ_are_refused() {
    let governor = GovernorConfig { cycle_us: 20_000, ..GovernorConfig::default() };
    let config = SlaveConfig { governor, ..SlaveConfig::default() };
    let error = WiredSlave::new(&config, &CanopenConfig::default(), 1).unwrap_err();
    assert_eq!(error, WiredSlaveError::Cycles { slave_us: 20_000, bus_us: 10_000 });
    assert!(error.to_string().ends_with("set both alike"));
}
