//! Bytes, numbers and lengths that may change only together with [`VERSION`].

use super::*;

pub(super) const DOCUMENT: &str = include_str!("../../../../docs/wire.md");

/// The bytes of a fenced block `hex NAME` in docs/wire.md; what follows a `#` is a remark.
pub(super) fn documented(name: &str) -> Vec<u8> {
    let fence = format!("```hex {name}\n");
    let (_, block) =
        DOCUMENT.split_once(&fence).unwrap_or_else(|| panic!("docs/wire.md has no block {fence}"));
    let (block, _) = block.split_once("```").expect("the block ends");
    block
        .lines()
        .flat_map(|line| line.split('#').next().unwrap_or_default().split_whitespace())
        .map(|byte| u8::from_str_radix(byte, 16).expect("two hexadecimal digits"))
        .collect()
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x} ")).collect()
}

#[test]
fn the_document_shows_what_is_sent() {
    let [observation, motion] = examples();
    assert_eq!(hex(&documented("observation body")), hex(&body_of(&observation)));
    assert_eq!(hex(&documented("observation frame")), hex(&frame_of(&observation)));
    assert_eq!(hex(&documented("motion body")), hex(&body_of(&motion)));
    assert_eq!(hex(&documented("motion frame")), hex(&frame_of(&motion)));
    for (frame, packet) in [("observation frame", observation), ("motion frame", motion)] {
        assert_eq!(decode_all(&documented(frame)), [Ok(packet)]);
    }
    for fact in [
        format!("`VERSION` = {VERSION}"),
        format!(
            "| observation | {} | {} |",
            2 + ObservationPacket::MAX_LEN,
            2 + ObservationPacket::MAX_LEN + 4
        ),
        format!("| motion | {} | {} |", 2 + MotionPacket::MAX_LEN, 2 + MotionPacket::MAX_LEN + 4),
    ] {
        assert!(DOCUMENT.contains(&fact), "docs/wire.md lacks: {fact}");
    }
}

#[test]
fn the_lengths_are_reached_and_never_passed() {
    let [observation, motion] = largest();
    assert_eq!(body_of(&observation).len(), 2 + ObservationPacket::MAX_LEN);
    assert_eq!(body_of(&motion).len(), 2 + MotionPacket::MAX_LEN);
    assert_eq!((ObservationPacket::MAX_LEN, MotionPacket::MAX_LEN), (158, 222));
    assert_eq!((MAX_BODY_LEN, MAX_FRAME_LEN), (224, 228));
    assert_eq!(frame_of(&motion).len(), MAX_FRAME_LEN);
}

#[test]
fn the_numbers_of_states_are_pinned() {
    let [Packet::Observation(mut observation), Packet::Motion(mut motion)] = examples() else {
        unreachable!()
    };
    let states = [
        ObservationState::Visible,
        ObservationState::Occluded,
        ObservationState::Predicted,
        ObservationState::Lost,
    ];
    for (number, state) in (0..).zip(states) {
        observation.balls[0].state = state;
        let body = body_of(&observation.into());
        assert_eq!(body[body.len() - 116], number, "{state:?}");
    }
    for (number, state) in (0..).zip(PoseState::ALL) {
        motion.state = state;
        let body = body_of(&motion.into());
        assert_eq!(body[body.len() - 192], number, "{state:?}");
    }
    let [observation, motion] = examples().map(|packet| body_of(&packet));
    assert_eq!(
        (observation[..2].to_vec(), motion[..2].to_vec()),
        (vec![5, 1], vec![5, 2]),
        "version and kind"
    );
}

#[test]
fn the_check_is_crc_16_ibm_3740() {
    assert_eq!(CHECK.checksum(b"123456789"), 0x29B1, "the catalogue's check value");
    assert_eq!(CHECK.checksum(b""), 0xFFFF);
}
