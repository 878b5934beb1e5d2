//! Packets to bytes and back.

use divan::{Bencher, black_box};
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::wire::{
    Decoder, Feed, MAX_FRAME_LEN, MotionPacket, ObservationPacket, Packet, Transform, encode,
};

const KINDS: [&str; 2] = ["observations", "motion"];

fn packet(kind: &str) -> Packet {
    if kind == "motion" {
        Packet::from(MotionPacket {
            session: 7,
            sequence: 8,
            capture_us: 9,
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
    } else {
        Packet::from(ObservationPacket {
            camera: 1,
            session: 7,
            sequence: u32::MAX,
            capture_us: u64::MAX,
            ready_us: 2_000,
            observed_us: 2_500,
            width: 640,
            height: 480,
            pixels_tested: 4000,
            balls: [Observation::default(); BALLS],
        })
    }
}

/// A packet into the bytes that cross a cable.
#[divan::bench(args = KINDS)]
fn encoding(bencher: Bencher<'_, '_>, kind: &str) {
    let packet = packet(kind);
    let mut frame = [0; MAX_FRAME_LEN];
    bencher.bench_local(|| encode(black_box(&packet), &mut frame).expect("it fits"));
}

/// The bytes into a checked packet.
#[divan::bench(args = KINDS)]
fn decoding(bencher: Bencher<'_, '_>, kind: &str) {
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(&packet(kind), &mut frame).expect("it fits");
    let mut decoder: Decoder = Decoder::new();
    bencher.bench_local(|| {
        let fed = decoder.feed(black_box(&frame[..length]));
        assert!(matches!(fed, Feed::Frame { result: Ok(_), .. }));
    });
}
