//! A CAN adapter on a serial line that speaks the Lawicel protocol ("SLCAN"): USB adapters with that
//! firmware, or a pseudo terminal.
//!
//! What its lines are is [core's](tetrad_core::arm::canopen::slcan).

use super::{Bus, Receive, Transmit};
use crate::robot::serial;
use serialport::{ClearBuffer, SerialPort};
use std::io::{self, Read as _, Write as _};
use std::time::{Duration, Instant};
use tetrad_core::arm::canopen::Frame;
use tetrad_core::arm::canopen::slcan::{Decoder, Line, encode};

/// How long a write may take. A line of 1 Mbaud needs 2 ms for a cycle's frames; one that takes none
/// for so long is stuck.
const WRITE_WITHIN: Duration = Duration::from_millis(20);

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
    let receive = In { port: reader, decoder: Decoder::new(), bytes: [0; 256], filled: 0, taken: 0 };
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
            self.line.extend_from_slice(&encode(frame));
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
