//! Promise: what a board logs is what it tells the host, in words, and logging changes nothing of that.

use std::io;
use tetrad_core::wire::{Notice, Packet};
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::Sequence;
use tetrad_qemu::tape::{Event, Tape};
use tetrad_qemu::{desktop, log};

#[test]
fn every_notice_is_logged_and_nothing_else() -> io::Result<()> {
    let mut tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..3).collect() });
    // something to warn of
    tape.events.push(Event::Line(vec![1, 2, 3, 0]));
    tape.events.push(Event::Picture(0, vec![0; 7]));
    let (line, logged) = Target::LOGGING.play_logging(&tape)?;
    assert!(line == desktop::line(&tape), "as the desktop has it, and every board without a log");

    let messages = log::messages(&Target::LOGGING.build.program("mps2-camera")?, &logged)?;
    let told: Vec<String> = desktop::packets(&line).iter().filter_map(notice).collect();
    assert_eq!(messages, told);
    for level in ["info", "warn"] {
        assert!(messages.iter().any(|message| message.starts_with(level)), "{messages:?}");
    }
    Ok(())
}

/// What the log is to say of a packet: what the desktop's own words for it are.
fn notice(packet: &Packet) -> Option<String> {
    let Packet::Notice(packet) = packet else { return None };
    let level = match packet.notice {
        Notice::Done | Notice::Learnt { .. } => "info",
        Notice::SelfTestFailed => "error",
        _ => "warn",
    };
    Some(format!("{level} {packet:?}"))
}
