//! What the desktop makes of a tape: the bytes that a board has to send.

use crate::probes::{Arm, Hand};
use crate::tape::{Event, Tape};
use tetrad_core::config::LearnConfig;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{BadPicture, Decoder, MAX_FRAME_LEN, Notice, NoticePacket, Packet, encode};

/// The session of what is played from a tape.
const SESSION: u32 = 1;

/// A smart camera on the desktop, and all that it has put on its line.
#[derive(Clone, Debug)]
pub struct Camera {
    node: Node,
    decoder: Decoder,
    size: (u16, u16),
    format: PixelFormat,
    line: Vec<u8>,
}

impl Camera {
    /// The camera that a tape is made for.
    ///
    /// # Panics
    /// When core's own settings are refused.
    #[must_use]
    pub fn of(tape: &Tape) -> Self {
        Self::begun(tape, SESSION)
    }

    /// The same in another session.
    ///
    /// # Panics
    /// As [`Camera::of`].
    #[must_use]
    pub fn begun(tape: &Tape, session: u32) -> Self {
        let (tracker, learn) = (tape.mode.tracker(), LearnConfig::default());
        let config = NodeConfig { camera: 0, session, tracker, learn, started: false };
        let node = Node::new(&config).expect("core's own settings");
        Self { node, decoder: Decoder::new(), size: tape.size, format: tape.format, line: vec![0] }
    }

    /// Takes what comes next.
    ///
    /// # Panics
    /// When it says something that is not finite.
    pub fn take(&mut self, event: &Event) {
        let mut send = |packet: Packet| send(&mut self.line, &packet);
        match event {
            Event::Line(bytes) => {
                for received in self.decoder.packets(bytes) {
                    let notice = match received {
                        Ok(Packet::Command(command)) => self.node.command(&command),
                        _ => Some(self.node.not_understood()),
                    };
                    notice.into_iter().for_each(|notice| send(notice.into()));
                }
            }
            Event::Picture(capture_us, bytes) => {
                match FrameView::packed(bytes, self.size.0, self.size.1, self.format) {
                    Ok(view) => {
                        let seen = self.node.picture(&view, *capture_us, 0);
                        seen.notices.into_iter().for_each(|notice| send(notice.into()));
                        seen.observation.into_iter().for_each(|packet| send(packet.into()));
                        seen.preview.into_iter().for_each(|strip| send(strip.into()));
                    }
                    Err(error) => send(self.node.refuse(error.into()).into()),
                }
            }
            // the desktop has no watchdog to wait for
            Event::Pause(_) | Event::Case(_) => {}
        }
    }

    /// Takes what a line did to another camera, which has said so; whether it is something that lines do.
    ///
    /// # Panics
    /// Never: such notices have no numbers that could be none.
    pub fn suffer(&mut self, notice: Notice) -> bool {
        let notice: NoticePacket = match notice {
            Notice::PictureRefused { why: BadPicture::Overrun } => self.node.refuse(BadPicture::Overrun),
            Notice::NotUnderstood { .. } => self.node.not_understood(),
            Notice::LineOverrun { .. } => self.node.line_overrun(),
            _ => return false,
        };
        send(&mut self.line, &notice.into());
        true
    }

    /// The line's bytes so far.
    #[must_use]
    pub fn line(&self) -> &[u8] {
        &self.line
    }
}

fn send(line: &mut Vec<u8>, packet: &Packet) {
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(packet, &mut frame).expect("packets of a camera are finite");
    line.extend(&frame[..length]);
}

/// The serial line's bytes.
///
/// # Panics
/// As [`Camera`].
#[must_use]
pub fn line(tape: &Tape) -> Vec<u8> {
    let mut camera = Camera::of(tape);
    tape.events.iter().for_each(|event| camera.take(event));
    camera.line
}

/// What `mps2-probes` answers.
#[must_use]
pub fn answers(tape: &Tape) -> Vec<u8> {
    let (mut hand, arm) = (Hand::new(tape.mode.hand()), Arm::new());
    let mut answers = Vec::new();
    for event in &tape.events {
        let answer = |bytes: &[u8]| answers.extend(bytes);
        match event {
            Event::Line(bytes) => hand.take(bytes, answer),
            Event::Case(bytes) => arm.answer(bytes, answer),
            Event::Picture(..) | Event::Pause(_) => {}
        }
    }
    answers
}

/// The packets of a line's bytes.
///
/// # Panics
/// When they are not whole.
#[must_use]
pub fn packets(line: &[u8]) -> Vec<Packet> {
    Decoder::new().packets(line).map(|packet| packet.expect("a line without damage")).collect()
}
