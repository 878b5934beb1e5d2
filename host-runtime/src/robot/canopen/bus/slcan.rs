//! A CAN adapter on a serial line that speaks the Lawicel protocol ("SLCAN"): USB adapters with that
//! firmware, or a pseudo terminal.
//!
//! Frames are lines of ASCII that end in CR: `t` and three digits of identifier, a digit of length, two
//! digits a byte. Adapters answer commands with CR or BEL and some add `z` or a time stamp; none of
//! that is waited for.

use super::super::frame::{Frame, MAX_DATA};
use super::{Bus, Receive, Transmit};
use crate::robot::serial;
use serialport::{ClearBuffer, SerialPort};
use std::io::{self, Read as _, Write as _};
use std::time::{Duration, Instant};

/// The longest line that means something: an extended frame with a time stamp.
const MAX_LINE: usize = 1 + 8 + 1 + 2 * MAX_DATA + 4;

/// How long a write may take. A line of 1 Mbaud needs 2 ms for a cycle's frames; one that takes none
/// for so long is stuck.
const WRITE_WITHIN: Duration = Duration::from_millis(20);

/// What a line from an adapter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A frame that CANopen uses.
    Frame(Frame),
    /// Anything else that adapters say: confirmations, extended and remote frames.
    Other,
    /// Bytes that are no line of the protocol.
    Garbage,
}

/// Writes a frame as a line.
pub fn encode(frame: &Frame, line: &mut Vec<u8>) {
    const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
    line.push(b't');
    let mut digit = |value: u16| line.push(DIGITS[usize::from(value & 0xF)]);
    for shift in [8, 4, 0] {
        digit(frame.id() >> shift);
    }
    digit(frame.data().len() as u16);
    for byte in frame.data() {
        digit(u16::from(byte >> 4));
        digit(u16::from(*byte));
    }
    line.push(b'\r');
}

/// Lines out of bytes that come in any pieces.
#[derive(Debug, Default)]
pub struct Decoder {
    line: Vec<u8>,
    overlong: bool,
    garbage: u64,
}

impl Decoder {
    /// Takes a byte; gives the line that it ends.
    pub fn push(&mut self, byte: u8) -> Option<Line> {
        match byte {
            b'\r' => {
                let line = if self.overlong { Line::Garbage } else { parse(&self.line) };
                if line == Line::Garbage {
                    self.garbage += self.line.len() as u64;
                }
                self.line.clear();
                self.overlong = false;
                Some(line)
            }
            // an error of the adapter: the answer to one command, not part of a line
            0x07 => None,
            _ if self.line.len() == MAX_LINE => {
                self.overlong = true;
                self.garbage += 1;
                None
            }
            _ => {
                self.line.push(byte);
                None
            }
        }
    }

    /// How many bytes belonged to no line of the protocol; those of a line that has not ended count from
    /// where it is too long to be one.
    #[must_use]
    pub const fn garbage(&self) -> u64 {
        self.garbage
    }
}

fn hex(digits: &[u8]) -> Option<u16> {
    digits.iter().try_fold(0u16, |value, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(value << 4 | digit as u16)
    })
}

fn parse(line: &[u8]) -> Line {
    let frame = match line {
        [] | [b'z' | b'Z', ..] | [b'T' | b'r' | b'R' | b'F' | b'V' | b'N', ..] => return Line::Other,
        [b't', rest @ ..] => standard(rest),
        _ => None,
    };
    frame.map_or(Line::Garbage, Line::Frame)
}

fn standard(rest: &[u8]) -> Option<Frame> {
    let (id, rest) = rest.split_at_checked(3)?;
    let (length, rest) = rest.split_at_checked(1)?;
    let length = usize::from(hex(length)?);
    let (digits, stamp) = rest.split_at_checked(2 * length)?;
    if !(stamp.is_empty() || stamp.len() == 4) {
        return None;
    }
    let mut data = [0; MAX_DATA];
    let data = data.get_mut(..length)?;
    for (byte, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = hex(pair)? as u8;
    }
    Frame::new(hex(id)?, data)
}

struct Out {
    port: Box<dyn SerialPort>,
    line: Vec<u8>,
    /// Whether the last write ended inside a line.
    torn: bool,
}

struct In {
    port: Box<dyn SerialPort>,
    decoder: Decoder,
    bytes: [u8; 256],
    filled: usize,
    taken: usize,
}

/// Opens the adapter at the serial port `path` and its channel at `bitrate` bit/s. `baud` is the speed
/// of the serial line; USB adapters do not mind it.
///
/// # Errors
/// A port that cannot be opened or is in use, a bit rate that the protocol has no letter for.
pub fn open(path: &str, baud: u32, bitrate: u32) -> io::Result<Bus> {
    let speed = match bitrate {
        10_000 => b'0',
        20_000 => b'1',
        50_000 => b'2',
        100_000 => b'3',
        125_000 => b'4',
        250_000 => b'5',
        500_000 => b'6',
        800_000 => b'7',
        1_000_000 => b'8',
        _ => {
            let problem = format!(
                "{bitrate} bit/s: an SLCAN adapter does 10000, 20000, 50000, 100000, 125000, 250000, \
                 500000, 800000 or 1000000"
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, problem));
        }
    };
    let mut port = serial::open(path, baud, WRITE_WITHIN)?;
    let reader = port.try_clone()?;
    // an adapter may have been left open, inside a line
    port.write_all(&[b'\r', b'\r', b'C', b'\r', b'S', speed, b'\r', b'O', b'\r'])?;
    port.clear(ClearBuffer::Input)?;
    let receive = In { port: reader, decoder: Decoder::default(), bytes: [0; 256], filled: 0, taken: 0 };
    let transmit = Out { port, line: Vec::new(), torn: false };
    Ok(Bus { transmit: Box::new(transmit), receive: Box::new(receive) })
}

impl Transmit for Out {
    fn send(&mut self, frames: &[Frame]) -> io::Result<usize> {
        self.line.clear();
        if self.torn {
            self.line.push(b'\r');
        }
        for frame in frames {
            encode(frame, &mut self.line);
        }
        let mut rest = &self.line[..];
        while !rest.is_empty() {
            match self.port.write(rest) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(written) => rest = &rest[written..],
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                    self.torn = true;
                    let unsent = rest.iter().filter(|byte| **byte == b'\r').count();
                    return Ok(frames.len().saturating_sub(unsent));
                }
                Err(error) => return Err(error),
            }
        }
        self.torn = false;
        Ok(frames.len())
    }
}

impl Drop for Out {
    fn drop(&mut self) {
        // the adapter leaves the bus; one that is gone already needs not be told
        let _ = self.port.write_all(b"\rC\r");
    }
}

impl In {
    /// The next frame among the bytes that have been read.
    fn decode(&mut self) -> Option<Frame> {
        while self.taken < self.filled {
            let byte = self.bytes[self.taken];
            self.taken += 1;
            if let Some(Line::Frame(frame)) = self.decoder.push(byte) {
                return Some(frame);
            }
        }
        None
    }
}

impl Receive for In {
    fn receive(&mut self, within: Duration) -> io::Result<Option<Frame>> {
        let deadline = Instant::now() + within;
        loop {
            if let Some(frame) = self.decode() {
                return Ok(Some(frame));
            }
            // an adapter at the wrong baud may send for ever what is no frame
            let left = deadline.saturating_duration_since(Instant::now());
            self.port.set_timeout(left)?;
            self.taken = 0;
            self.filled = 0;
            match self.port.read(&mut self.bytes) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(read) => self.filled = read,
                Err(error) if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) => {
                    return Ok(None);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
            if left.is_zero() {
                return Ok(self.decode());
            }
        }
    }

    fn garbage(&self) -> u64 {
        self.decoder.garbage()
    }
}

#[cfg(test)]
mod tests;
