//! Promise: what slaves on boards are compared with is worth comparing, and is safe.

use tetrad_core::arm::canopen::Frame;
use tetrad_core::arm::canopen::frame::{RPDO1, SYNC};
use tetrad_core::wire::{ArmReason, ArmState, ArmStatePacket, ControllerState, Packet};
use tetrad_qemu::desktop::packets;
use tetrad_qemu::slave::{SlaveTape, frames};

fn states(line: &[u8]) -> Vec<ArmStatePacket> {
    let only = |packet| if let Packet::ArmState(state) = packet { Some(state) } else { None };
    packets(line).into_iter().filter_map(only).collect()
}

/// What a drive is told: controlword and target.
fn target(frame: &Frame) -> Option<(u16, i32)> {
    let &[a, b, c, d, e, f] = frame.data() else { return None };
    (frame.function() == RPDO1).then(|| (u16::from_le_bytes([a, b]), i32::from_le_bytes([c, d, e, f])))
}

/// The states between two times, milliseconds.
fn between(states: &[ArmStatePacket], from_ms: u64, to_ms: u64) -> Vec<&ArmStatePacket> {
    let within = |state: &&ArmStatePacket| (from_ms * 1_000..to_ms * 1_000).contains(&state.time_us);
    states.iter().filter(within).collect()
}

fn moves(states: &[&ArmStatePacket]) -> bool {
    states.windows(2).any(|pair| pair[0].set_point != pair[1].set_point)
}

#[test]
fn it_goes_through_every_state_and_moves_only_where_it_may() {
    let states = states(&SlaveTape::recorded().on_the_desktop().line);
    assert!(states.len() > 1_200, "{}", states.len());
    for state in ArmState::ALL {
        assert!(states.iter().any(|told| told.state == state), "never {state:?}");
    }
    let at = |from_ms, to_ms| between(&states, from_ms, to_ms);
    let mut places =
        at(0, 2_500).into_iter().filter_map(|told| told.measured.map(|measured| measured.joints));
    let first = places.next().expect("drives are set up within seconds");
    assert!(places.all(|place| place == first), "moved before the first reset and a fresh press");
    assert!(at(2_400, 2_500).iter().all(|told| told.controller == ControllerState::Ready));
    assert!(moves(&at(2_700, 4_000)), "the hand is followed");
    assert!(at(3_100, 4_000).iter().all(|told| told.state == ArmState::Engaged), "noise is passed over");
    assert!(!moves(&at(4_500, 4_600)), "at rest within 0.4 s of silence");
    assert!(!moves(&at(4_600, 5_500)), "a press that was held through silence is none");
    assert!(moves(&at(5_700, 6_500)), "a fresh one is");
    let stopped = at(6_520, 7_000);
    assert!(stopped.iter().all(|told| (told.state, told.reason) == (ArmState::Stopped, ArmReason::Asked)));
    assert!(!moves(&at(7_000, 7_800)), "a reset moves nothing");
    assert!(moves(&at(8_000, 8_500)));
    assert!(!moves(&at(8_900, 9_300)), "another operator, whose press was not fresh");
    assert!(moves(&at(9_500, 10_500)));
    let failed = at(10_550, 11_800);
    let of_joint_3 =
        |told: &&ArmStatePacket| matches!(told.controller, ControllerState::Fault { joint: 3, .. });
    assert!(failed.iter().all(|told| told.state == ArmState::Fault) && failed.iter().all(of_joint_3));
    assert!(!moves(&at(11_000, 13_000)));
}

#[test]
fn drives_are_told_where_to_go_with_every_sync() {
    let frames = frames(&SlaveTape::recorded().on_the_desktop().bus);
    let syncs = frames.iter().filter(|frame| frame.id() == SYNC).count();
    let targets: Vec<_> = frames.iter().filter_map(target).collect();
    assert!(syncs > 1_000, "{syncs}");
    assert_eq!(targets.len(), 6 * syncs);
    // enable operation, and quick stop behind a stop and a fault
    assert!(targets.iter().any(|(control, _)| *control == 0x0F));
    assert!(targets.iter().any(|(control, _)| *control == 0x02));
}
