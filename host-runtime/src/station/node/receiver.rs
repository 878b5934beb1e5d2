//! From the bytes of a serial line to observations with this station's times, and to what is shown. Knows no port and
//! is told the time.

use super::thumbnails::{Pieced, Thumbnails};
use crate::link::Received;
use std::collections::VecDeque;
use std::path::Path;
use tetrad_core::wire::{DecodeError, Decoder, NoticePacket, ObservationPacket, Packet, PreviewPacket};

/// The least lateness is kept of each stretch of this length, microseconds...
const STRETCH_US: u64 = 500_000;

/// ...and so many of them are looked at: two clocks that part by 100 ppm are 0.5 ms wrong by then.
const STRETCHES: usize = 10;

/// What became of what a node sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NodeCounts {
    /// Observations that were newer than all before.
    pub taken: u64,
    /// Observations that are missing in their numbers.
    pub lost: u64,
    /// Frames that were damaged, or are no packet of this version.
    pub damaged: u64,
    /// Packets that are neither observations nor shown, or come twice.
    pub other: u64,
}

/// How long a line needs for a byte.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    byte_us: f64,
}

impl Line {
    /// A start bit, eight bits and a stop bit on a wire; nothing to speak of where the port is a USB
    /// device itself (`ttyACM`), whose rate means nothing, or a pseudo terminal.
    #[must_use]
    pub fn of(device: &Path, baud: u32) -> Self {
        let real = device.canonicalize().unwrap_or_else(|_| device.to_owned());
        let name = real.file_name().unwrap_or_default().to_string_lossy();
        let wire = !name.starts_with("ttyACM") && !real.starts_with("/dev/pts");
        Self { byte_us: if wire { 10.0 * 1e6 / f64::from(baud.max(1)) } else { 0.0 } }
    }
}

/// What a node's bytes come to. It takes any bytes, cut anywhere, and its memory does not grow with them.
#[derive(Debug, Default)]
pub struct Receiver {
    decoder: Decoder,
    /// Bytes since the frame before ended.
    bytes: usize,
    /// Whether a whole frame has come since the port was opened: what is before it was cut.
    begun: bool,
    session: Option<u32>,
    /// A session that one packet has named: damage that the check does not see, or a node that has
    /// begun anew.
    doubted: Option<u32>,
    sequence: u32,
    lateness: Lateness,
    counts: NodeCounts,
    /// The newest observations.
    last: Option<Received<ObservationPacket>>,
    thumbnails: Thumbnails,
    /// The newest answer to a command that was not taken.
    answer: Option<NoticePacket>,
    /// The version that was told.
    version: Option<u8>,
    notice: Option<String>,
}

impl Receiver {
    /// The port was opened, perhaps within a frame.
    pub fn open(&mut self) {
        self.decoder = Decoder::default();
        self.bytes = 0;
        self.begun = false;
        self.thumbnails.forget();
    }

    /// Takes what was read at a time; the newest observations in it, if there are any.
    pub fn take(&mut self, read: &[u8], line: Line, now_us: u64) -> Option<Received<ObservationPacket>> {
        let mut newest = None;
        // a frame ends with a zero byte, and that is in no other place
        for piece in read.split_inclusive(|byte| *byte == 0) {
            self.bytes += piece.len();
            if piece.last() != Some(&0) {
                // nothing ends here
                self.decoder.packets(piece).for_each(drop);
                continue;
            }
            let length = std::mem::take(&mut self.bytes);
            let frame = self.decoder.packets(piece).next();
            let first = !std::mem::replace(&mut self.begun, true);
            match frame {
                None => {}
                Some(Ok(Packet::Observation(packet))) => {
                    let wire_us = (length as f64 * line.byte_us).round() as u64;
                    newest = self.observation(packet, now_us, wire_us).or(newest);
                }
                Some(Ok(Packet::Notice(notice))) if notice.answers.is_some() => self.answer = Some(notice),
                Some(Ok(Packet::Preview(strip))) => self.preview(&strip),
                Some(Ok(_)) => self.counts.other += 1,
                Some(Err(DecodeError::UnknownVersion(version))) => self.other_version(version),
                Some(Err(_)) if first => {}
                Some(Err(_)) => self.counts.damaged += 1,
            }
        }
        newest
    }

    /// What became of it so far.
    #[must_use]
    pub const fn counts(&self) -> NodeCounts {
        self.counts
    }

    /// The picture of what the camera shows of its balls, where that is another than before.
    pub fn take_picture(&mut self) -> Option<Pieced> {
        self.thumbnails.take_picture()
    }

    /// What answers a command, once.
    pub fn take_answer(&mut self) -> Option<NoticePacket> {
        self.answer.take()
    }

    /// What there is to tell, once.
    pub fn take_notice(&mut self) -> Option<String> {
        self.notice.take()
    }

    fn preview(&mut self, strip: &PreviewPacket) {
        if self.session == Some(strip.session) {
            self.thumbnails.take(strip, self.last.as_ref());
        } else {
            self.counts.other += 1;
        }
    }

    fn other_version(&mut self, version: u8) {
        self.counts.damaged += 1;
        if self.version.replace(version) != Some(version) {
            self.notice = Some(DecodeError::UnknownVersion(version).to_string());
        }
    }

    fn observation(
        &mut self,
        packet: ObservationPacket,
        now_us: u64,
        wire_us: u64,
    ) -> Option<Received<ObservationPacket>> {
        if self.session != Some(packet.session) {
            // there is one sender, so a session is believed when it is named twice in a row
            if self.session.is_some() && self.doubted.replace(packet.session) != Some(packet.session) {
                self.counts.other += 1;
                return None;
            }
            self.session = Some(packet.session);
            self.sequence = packet.sequence.wrapping_sub(1);
            // another session counts the time from another beginning
            self.lateness = Lateness::default();
            self.thumbnails.forget();
        }
        self.doubted = None;
        let ahead = packet.sequence.wrapping_sub(self.sequence);
        if ahead == 0 || ahead > u32::MAX / 2 {
            self.counts.other += 1;
            return None;
        }
        self.sequence = packet.sequence;
        self.counts.lost += u64::from(ahead - 1);
        self.counts.taken += 1;
        let sent_us = packet.capture_us.saturating_add(packet.observed_us.into());
        let left_us = now_us.saturating_sub(wire_us);
        let offset_us = self.lateness.least(difference(left_us, sent_us), now_us);
        let captured_us = packet.capture_us.saturating_add_signed(offset_us);
        self.last = Some(Received { what: packet, received_us: now_us, captured_us: Some(captured_us) });
        self.last
    }
}

/// How far the time of `b` is behind that of `a`.
fn difference(a: u64, b: u64) -> i64 {
    i64::try_from(i128::from(a) - i128::from(b)).unwrap_or(0)
}

/// The least of the differences between when a packet came and when it was made: that of the packet
/// that was held up least. What it needed all the same is taken for the clocks' difference.
#[derive(Debug, Default)]
struct Lateness {
    /// When each stretch began, and its least; the last still grows.
    stretches: VecDeque<(u64, i64)>,
}

impl Lateness {
    fn least(&mut self, difference_us: i64, now_us: u64) -> i64 {
        match self.stretches.back_mut() {
            Some((began_us, least)) if now_us.saturating_sub(*began_us) < STRETCH_US => {
                *least = difference_us.min(*least);
            }
            _ => self.stretches.push_back((now_us, difference_us)),
        }
        if self.stretches.len() > STRETCHES {
            self.stretches.pop_front();
        }
        self.stretches.iter().map(|(_, least)| *least).min().unwrap_or(difference_us)
    }
}

#[cfg(test)]
mod tests;
