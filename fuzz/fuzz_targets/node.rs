//! Any bytes from a smart camera's serial port, in pieces of any size and at any time: what comes of them
//! does not depend on how they were cut, only newer observations come through, what is shown is
//! a picture of the size that the observations say, and sound packets behind them are found.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use tetrad::station::node::{Line, Receiver};
use tetrad_core::wire::{MAX_FRAME_LEN, ObservationPacket, encode};
use tetrad_fixtures::packets;

fn frame(packet: ObservationPacket) -> Vec<u8> {
    let mut out = [0; MAX_FRAME_LEN];
    let length = encode(&packet.into(), &mut out).expect("it is sound");
    out[..length].to_vec()
}

fuzz_target!(|input: (u8, u32, u64, u32, &[u8])| {
    let (piece, baud, now_us, step_us, data) = input;
    let piece = usize::from(piece).max(1);
    let line = Line::of(Path::new("/dev/ttyUSB0"), baud);

    let mut whole = Receiver::default();
    whole.open();
    let at_once = whole.take(data, line, now_us);
    let mut cut = Receiver::default();
    cut.open();
    let came: Vec<_> = data.chunks(piece).filter_map(|piece| cut.take(piece, line, now_us)).collect();
    assert_eq!(came.last(), at_once.as_ref());
    assert_eq!(cut.counts(), whole.counts());
    let shown = whole.take_picture();
    assert_eq!(cut.take_picture(), shown);
    if let Some(view) = shown.as_ref().and_then(|shown| shown.view()) {
        let said = shown.as_ref().map(|shown| (shown.packet.width, shown.packet.height));
        assert_eq!(Some((view.width(), view.height())), said);
    }
    for pair in came.windows(2) {
        let ahead = pair[1].what.sequence.wrapping_sub(pair[0].what.sequence);
        let same = pair[0].what.session == pair[1].what.session;
        assert!(!same || (ahead != 0 && ahead <= u32::MAX / 2));
    }

    let mut late = Receiver::default();
    late.open();
    let mut at_us = now_us;
    for piece in data.chunks(piece) {
        if let Some(came) = late.take(piece, line, at_us) {
            assert_eq!(came.received_us, at_us);
            assert!(came.captured_us.is_some());
        }
        at_us = at_us.saturating_add(step_us.into());
    }
    assert_eq!(late.counts(), whole.counts());

    // what was cut off is ended by a zero byte; another session is believed at its second packet
    let session = at_once.map_or(1, |came| came.what.session.wrapping_add(1));
    late.take(&[0], line, at_us);
    late.take(&frame(packets::observation(session, 0)), line, at_us);
    let found = late.take(&frame(packets::observation(session, 1)), line, at_us);
    assert_eq!(found.map(|found| found.what), Some(packets::observation(session, 1)));
});
