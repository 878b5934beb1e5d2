//! Packets to bytes and back.

use divan::{Bencher, black_box};
use tetrad_core::wire::{Decoder, Feed, MAX_FRAME_LEN, ObservationPacket, Packet, encode};
use tetrad_fixtures::packets;

const KINDS: [&str; 2] = ["observations", "motion"];

fn packet(kind: &str) -> Packet {
    if kind == "motion" {
        packets::motion(7, 8).into()
    } else {
        ObservationPacket { capture_us: u64::MAX, ..packets::observation(7, u32::MAX) }.into()
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
