//! Any bytes from a cable, in pieces of any size: refused with a reason, or a packet that comes back
//! the same when it is sent again. What is received does not depend on how the bytes were cut.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tetrad_core::wire::{Decoder, MAX_BODY_LEN, MAX_FRAME_LEN, Packet, decode_body, encode, encode_body};

fn sent_again(packet: &Packet) {
    let mut body = [0; MAX_BODY_LEN];
    let length = encode_body(packet, &mut body).expect("what was received can be sent");
    assert_eq!(decode_body(&body[..length]).as_ref(), Ok(packet));
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(packet, &mut frame).expect("what was received can be sent");
    let received: Vec<_> = Decoder::new().packets(&frame[..length]).collect();
    assert_eq!(received, [Ok(*packet)]);
}

fuzz_target!(|input: (u8, &[u8])| {
    let (piece, data) = input;
    if let Ok(packet) = decode_body(data) {
        sent_again(&packet);
    }
    let at_once: Vec<_> = Decoder::new().packets(data).collect();
    for packet in at_once.iter().flatten() {
        sent_again(packet);
    }
    let mut decoder: Decoder = Decoder::new();
    let mut in_pieces = Vec::new();
    for piece in data.chunks(usize::from(piece).max(1)) {
        in_pieces.extend(decoder.packets(piece));
    }
    assert_eq!(in_pieces, at_once);
});
