//! Promise: the same packets of an operator and the same frames of drives give the same states of the arm and
//! the same frames for the drives, to the byte, on the desktop, on a Cortex-M4F and on a Cortex-M7.

use std::io;
use tetrad_qemu::board::Target;
use tetrad_qemu::desktop::packets;
use tetrad_qemu::slave::{Event, Said, SlaveTape, frames};

/// Compares what a board says with what the desktop says; what differs is told in words.
fn assert_same(theirs: &Said, ours: &Said, target: Target) {
    for (their, our) in frames(&theirs.bus).iter().zip(&frames(&ours.bus)) {
        assert_eq!(their, our, "{target:?}: for the drives");
    }
    for (their, our) in packets(&theirs.line).iter().zip(&packets(&ours.line)) {
        assert_eq!(their, our, "{target:?}: to the operator");
    }
    assert!(theirs == ours, "{target:?}: the number of frames or packets, or bytes between them");
}

#[test]
fn on_each_board_as_on_the_desktop() -> io::Result<()> {
    let tape = SlaveTape::recorded();
    let ours = tape.on_the_desktop();
    for target in [Target::OWN[0], Target::OWN[1], Target::FOREIGN] {
        assert_same(&tape.on_a_board(target)?, &ours, target);
    }
    Ok(())
}

#[test]
fn a_flipped_bit_of_one_motion_is_noticed() -> io::Result<()> {
    let mut tape = SlaveTape::recorded();
    let ours = tape.on_the_desktop();
    // while the hand is followed, in the middle of a motion's frame: it is not believed any more
    let line = tape.events.iter_mut().find_map(|event| match event {
        Event::Line(at_us, bytes) if *at_us > 3_500_000 => Some(bytes),
        _ => None,
    });
    line.ok_or(io::ErrorKind::NotFound)?[60] ^= 1;
    let theirs = tape.on_a_board(Target::OWN[0])?;
    assert!(theirs.line != ours.line, "the comparison of states is blind");
    assert!(theirs.bus != ours.bus, "the comparison of set-points is blind");
    Ok(())
}
