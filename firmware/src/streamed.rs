//! Pictures over the serial line in place of a sensor's: the same camera, shown what a desktop has.
//!
//! Commands and parts of pictures come on one line and are handed on in their order. The sender waits for what
//! comes of a picture before it shows the next, so one buffer is enough, and nothing is overtaken.

use crate::handover::{Begin, Buffers, Captured, Input, Inputs, PICTURE_BYTES, Picture, PictureBuffer};
use embedded_io_async::Read;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::node::NodeConfig;
use tetrad_core::wire::{BadPicture, DecodeError, Decoder, Packet, Shown, ShownPacket};

/// Bytes taken from the line at a time.
const CHUNK: usize = 64;

/// The session until a sender has begun one.
const NOT_BEGUN: u32 = 0;

/// The camera before anybody begins.
pub const AT_FIRST: Begin = Begin { session: NOT_BEGUN, refined: true };

/// The camera that a sender begins with: it was taught nothing.
#[must_use]
pub fn config(begin: Begin) -> NodeConfig {
    let tracker = if begin.refined { TrackerConfig::default() } else { TrackerConfig::paper() };
    NodeConfig { camera: 0, session: begin.session, tracker, learn: LearnConfig::default(), started: false }
}

/// Listens to a line for ever.
pub async fn receive(mut line: impl Read, buffers: &Buffers, inputs: &Inputs) -> ! {
    let (mut decoder, mut screen) = (Decoder::new(), Screen::new(buffers, inputs));
    let mut bytes = [0; CHUNK];
    loop {
        match line.read(&mut bytes).await {
            Ok(count) => {
                for byte in bytes.get(..count).unwrap_or_default() {
                    let Some(result) = decoder.packets(core::slice::from_ref(byte)).next() else { continue };
                    screen.take(result).await;
                }
            }
            // what was lost is missing in a picture, or in a frame that is no packet then
            Err(_) => inputs.send(Input::LineOverrun).await,
        }
    }
}

/// What is shown: a picture as far as it has come.
struct Screen<'a> {
    buffers: &'a Buffers,
    inputs: &'a Inputs,
    session: Option<u32>,
    /// Which picture is in the buffer, and how many of its first bytes.
    picture: Option<u32>,
    filled: usize,
    /// No strip is missing so far.
    is_whole: bool,
    buffer: Option<&'static mut PictureBuffer>,
    /// The picture that was last to be looked at.
    looked_at: Option<u32>,
}

impl<'a> Screen<'a> {
    const fn new(buffers: &'a Buffers, inputs: &'a Inputs) -> Self {
        let (session, picture, looked_at, buffer) = (None, None, None, None);
        Self { buffers, inputs, session, picture, filled: 0, is_whole: false, buffer, looked_at }
    }

    async fn take(&mut self, result: Result<Packet, DecodeError>) {
        let input = match result {
            Ok(Packet::Command(command)) => Some(Input::Command(command)),
            Ok(Packet::Shown(shown)) => self.show(&shown).await,
            Ok(_) | Err(_) => Some(Input::NotUnderstood),
        };
        if let Some(input) = input {
            self.inputs.send(input).await;
        }
    }

    /// Takes a part of a picture; what comes of it for the tracker.
    async fn show(&mut self, packet: &ShownPacket) -> Option<Input> {
        match packet.shown {
            Shown::Begin { refined } => {
                self.session = Some(packet.session);
                (self.picture, self.looked_at) = (None, None);
                Some(Input::Begin(Begin { session: packet.session, refined }))
            }
            _ if self.session != Some(packet.session) => Some(Input::NotUnderstood),
            Shown::Strip { offset, strip } => {
                self.put(packet.picture, offset as usize, strip.bytes()).await;
                None
            }
            Shown::Look { capture_us, length, width, height, format } => {
                let captured =
                    Captured { length: length as usize, width, height, format, capture_us, ready_us: 0 };
                self.look(packet.picture, captured)
            }
        }
    }

    async fn put(&mut self, picture: u32, offset: usize, bytes: &[u8]) {
        if self.picture != Some(picture) {
            (self.picture, self.filled, self.is_whole) = (Some(picture), 0, true);
        }
        let buffer = match self.buffer.take() {
            Some(buffer) => buffer,
            None => self.buffers.receive().await,
        };
        let is_next = offset == self.filled;
        match buffer.0.get_mut(offset..offset.saturating_add(bytes.len())) {
            Some(room) if is_next => room.copy_from_slice(bytes),
            // what is longer than any picture is refused for that
            None if is_next => {}
            _ => self.is_whole = false,
        }
        self.filled = self.filled.saturating_add(bytes.len());
        self.buffer = Some(buffer);
    }

    fn look(&mut self, picture: u32, captured: Captured) -> Option<Input> {
        if self.looked_at == Some(picture) {
            // asked again by a sender that heard nothing: the answer is on its way
            return None;
        }
        self.looked_at = Some(picture);
        if captured.length > PICTURE_BYTES {
            return Some(Input::BadPicture(BadPicture::Length));
        }
        let has_come = self.picture == Some(picture) && self.is_whole && self.filled == captured.length;
        match self.buffer.take() {
            Some(buffer) if has_come => Some(Input::Picture(Picture { buffer, captured })),
            kept => {
                self.buffer = kept;
                Some(Input::BadPicture(BadPicture::Overrun))
            }
        }
    }
}

#[cfg(test)]
mod tests;
