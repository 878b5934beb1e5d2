//! Pictures for a camera without a sensor.

use super::super::body::SHOWN;
use super::pinned::{documented, hex};
use super::*;
use crate::vision::frame::PixelFormat;

fn strip(bytes: &[u8]) -> Strip {
    Strip::of(bytes).unwrap()
}

/// The packets of the examples in docs/wire.md.
fn examples() -> [Packet; 3] {
    let part = |picture, shown| ShownPacket { session: 300, picture, shown }.into();
    let format = PixelFormat::Rgb565Be;
    let look = Shown::Look { capture_us: 33_333, length: 153_600, width: 320, height: 240, format };
    [
        part(0, Shown::Begin { refined: true }),
        part(2, Shown::Strip { offset: 384, strip: strip(&[0x00, 0xF8, 0x1F]) }),
        part(2, look),
    ]
}

pub(super) fn packet() -> impl Strategy<Value = Packet> {
    let begin = any::<bool>().prop_map(|refined| Shown::Begin { refined });
    let strip = (any::<u32>(), prop::collection::vec(any::<u8>(), 0..=STRIP_BYTES))
        .prop_map(|(offset, bytes)| Shown::Strip { offset, strip: strip(&bytes) });
    let format = prop::sample::select(PixelFormat::ALL.to_vec());
    let look =
        (any::<(u64, u32, u16, u16)>(), format).prop_map(|((capture_us, length, width, height), format)| {
            Shown::Look { capture_us, length, width, height, format }
        });
    (any::<(u32, u32)>(), prop_oneof![begin, strip, look])
        .prop_map(|((session, picture), shown)| ShownPacket { session, picture, shown }.into())
}

#[test]
fn the_document_shows_what_a_camera_is_shown() {
    for (name, packet) in ["begin", "strip", "look"].into_iter().zip(examples()) {
        assert_eq!(hex(&documented(&format!("{name} body"))), hex(&body_of(&packet)));
    }
    let length = 2 + ShownPacket::MAX_LEN;
    let fact = format!("| shown | {length} | {} |", length + 4);
    assert!(super::pinned::DOCUMENT.contains(&fact), "docs/wire.md lacks: {fact}");
    let fact = format!("up to {STRIP_BYTES}");
    assert!(super::pinned::DOCUMENT.contains(&fact), "docs/wire.md lacks: {fact}");
}

#[test]
fn the_length_is_reached() {
    let shown = Shown::Strip { offset: u32::MAX, strip: strip(&[0xFF; STRIP_BYTES]) };
    let largest = ShownPacket { session: u32::MAX, picture: u32::MAX, shown };
    assert_eq!(body_of(&largest.into()).len(), 2 + ShownPacket::MAX_LEN);
    assert_eq!(decode_all(&frame_of(&largest.into())), [Ok(largest.into())]);
}

#[test]
fn the_numbers_are_pinned() {
    for (number, packet) in (0..).zip(examples()) {
        let body = body_of(&packet);
        assert_eq!((body[..2].to_vec(), body[5]), (vec![VERSION, SHOWN], number), "{packet:?}");
    }
    for (number, format) in (0..).zip(PixelFormat::ALL) {
        let look = Shown::Look { capture_us: 0, length: 0, width: 0, height: 0, format };
        let body = body_of(&ShownPacket { session: 0, picture: 0, shown: look }.into());
        assert_eq!(body.last(), Some(&number), "{format:?}");
    }
}

#[test]
fn a_strip_holds_what_it_has_room_for() {
    assert_eq!(strip(&[]).bytes(), [0; 0]);
    assert_eq!(strip(&[7; STRIP_BYTES]).bytes(), [7; STRIP_BYTES]);
    for too_many in [STRIP_BYTES + 1, 255, 256, 300] {
        assert_eq!(Strip::of(&vec![7; too_many]), None, "{too_many}");
    }
    let mut body = body_of(&examples()[1]);
    // the length before the last three bytes; as many follow as it says
    let length_at = body.len() - 4;
    assert_eq!(body[length_at], 3);
    body.splice(length_at.., [193, 1].into_iter().chain([7; 193]));
    assert_eq!(decode_body(&body), Err(DecodeError::MalformedBody));
    body[length_at] = 192;
    assert_eq!(decode_body(&body), Err(DecodeError::TrailingBytes));
    body.pop();
    assert!(decode_body(&body).is_ok());
}
