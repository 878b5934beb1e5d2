//! Packets for the tests of the link.

use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::Observation;
use tetrad_core::wire::{
    ButtonsPacket, Covariance, MAX_BODY_LEN, MotionPacket, ObservationPacket, Packet, Transform, encode_body,
};

pub(super) fn motion(session: u32, sequence: u32) -> Packet {
    let x_m = sequence as f32 * 1e-3;
    MotionPacket {
        session,
        sequence,
        capture_us: u64::from(sequence) * 1_000,
        engaged: true,
        engagements: 1,
        state: PoseState::Both,
        spans: 1,
        views: 2,
        seen_in: [2; 4],
        residual_px: 0.1,
        increment: Transform::IDENTITY,
        since_engage: Transform { translation: [x_m, 0.0, 0.0], ..Transform::IDENTITY },
        covariance: Some(Covariance { upper: [0.0; 21] }),
    }
    .into()
}

pub(super) fn buttons(session: u32, sequence: u32, pressed: bool) -> Packet {
    ButtonsPacket { session, sequence, time_us: 0, pressed, stop: false, resets: 0 }.into()
}

pub(super) fn observation(session: u32, sequence: u32, camera: u8) -> Packet {
    ObservationPacket {
        camera,
        session,
        sequence,
        capture_us: 5,
        ready_us: 6,
        observed_us: 7,
        width: 640,
        height: 480,
        pixels_tested: 100,
        balls: [Observation::default(); 4],
    }
    .into()
}

pub(super) fn body(packet: &Packet) -> Vec<u8> {
    let mut out = [0; MAX_BODY_LEN];
    let length = encode_body(packet, &mut out).unwrap();
    out[..length].to_vec()
}
