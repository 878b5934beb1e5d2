//! What the desktop makes of a tape: the bytes that a board has to send.

use crate::clip::FORMAT;
use crate::tape::{Event, Tape};
use tetrad_core::config::LearnConfig;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::vision::frame::FrameView;
use tetrad_core::wire::{Decoder, MAX_FRAME_LEN, Packet, encode};

/// The session of what is played from a tape.
const SESSION: u32 = 1;

/// The serial line's bytes.
///
/// # Panics
/// When core's own settings are refused.
#[must_use]
pub fn line(tape: &Tape) -> Vec<u8> {
    let (tracker, learn) = (tape.mode.tracker(), LearnConfig::default());
    let config = NodeConfig { camera: 0, session: SESSION, tracker, learn, started: false };
    let mut node = Node::new(&config).expect("core's own settings");
    let mut decoder = Decoder::new();
    let mut line = vec![0];
    let mut send = |packet: Packet| {
        let mut frame = [0; MAX_FRAME_LEN];
        let length = encode(&packet, &mut frame).expect("packets of a camera are finite");
        line.extend(&frame[..length]);
    };
    for event in &tape.events {
        match event {
            Event::Line(bytes) => {
                for received in decoder.packets(bytes) {
                    let notice = match received {
                        Ok(Packet::Command(command)) => node.command(&command),
                        _ => Some(node.not_understood()),
                    };
                    notice.into_iter().for_each(|notice| send(notice.into()));
                }
            }
            // the desktop has no watchdog to wait for
            Event::Pause(_) => {}
            Event::Picture(capture_us, bytes) => {
                match FrameView::packed(bytes, tape.size.0, tape.size.1, FORMAT) {
                    Ok(view) => {
                        let seen = node.picture(&view, *capture_us, 0);
                        seen.notices.into_iter().for_each(|notice| send(notice.into()));
                        seen.observation.into_iter().for_each(|packet| send(packet.into()));
                    }
                    Err(error) => send(node.refuse(error.into()).into()),
                }
            }
        }
    }
    line
}

/// The packets of a line's bytes.
///
/// # Panics
/// When they are not whole.
#[must_use]
pub fn packets(line: &[u8]) -> Vec<Packet> {
    Decoder::new().packets(line).map(|packet| packet.expect("a line without damage")).collect()
}
