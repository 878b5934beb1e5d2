//! Packets for the tests of the link.

use tetrad_core::wire::{
    ButtonsPacket, Covariance, MAX_BODY_LEN, MotionPacket, ObservationPacket, Packet, encode_body,
};
use tetrad_fixtures::packets;

/// With a covariance: as long as motion gets.
pub(super) fn motion(session: u32, sequence: u32) -> Packet {
    MotionPacket {
        capture_us: u64::from(sequence) * 1_000,
        covariance: Some(Covariance { upper: [0.0; 21] }),
        ..packets::motion_to(session, sequence, [sequence as f32 * 1e-3, 0.0, 0.0])
    }
    .into()
}

pub(super) fn buttons(session: u32, sequence: u32, pressed: bool) -> Packet {
    ButtonsPacket { pressed, ..packets::buttons(session, sequence) }.into()
}

pub(super) fn observation(session: u32, sequence: u32, camera: u8) -> Packet {
    ObservationPacket { camera, capture_us: 5, ..packets::observation(session, sequence) }.into()
}

pub(super) fn body(packet: &Packet) -> Vec<u8> {
    let mut out = [0; MAX_BODY_LEN];
    let length = encode_body(packet, &mut out).unwrap();
    out[..length].to_vec()
}
