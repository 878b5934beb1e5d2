//! Recorded pictures and commands, read by semihosting: what stands for the sensor, and for the host, in
//! runs that have to come out the same.
//!
//! A tape is a file, all numbers with their lowest byte first:
//!
//! | bytes | of the head |
//! |---|---|
//! | 8 | `TETRADT1` |
//! | 2, 2 | width, height of all pictures, px |
//! | 1 | their format: its place in `PixelFormat::ALL` |
//! | 1 | mode: 0 paper, 1 refined |
//! | 1 | the camera's number |
//! | 1 | 0 |
//!
//! and then records: 4 bytes kind (1 a picture, 2 bytes of the serial line, 3 a pause), 4 bytes length, 8
//! bytes capture time (or how long the pause is) and 4 bytes until it was ready, microseconds (0 for bytes of
//! the line), and as many bytes as the length says.

use crate::capture::{NoPicture, Sensor};
use crate::handover::{Captured, Inputs, PictureBuffer};
use crate::receive::Listener;
use core::ffi::CStr;
use embassy_time::Timer;
use semihosting::fs::File;
use semihosting::io::{self, Read as _};
use tetrad_core::config::TrackerConfig;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::BadPicture;

/// The file, in the folder that QEMU runs in.
pub const NAME: &CStr = c"tetrad.tape";

const MAGIC: &[u8; 8] = b"TETRADT1";
const PICTURE: u32 = 1;
const LINE: u32 = 2;
const PAUSE: u32 = 3;

/// What the head says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Head {
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// How pixels lie.
    pub format: PixelFormat,
    /// How balls are tracked.
    pub tracker: TrackerConfig,
    /// The camera's place in the list of views.
    pub camera: u8,
}

/// A tape, at its first record.
pub struct Tape {
    file: File,
    head: Head,
}

impl Tape {
    /// Opens the tape; `None` where there is none, or none of this format.
    #[must_use]
    pub fn open() -> Option<Self> {
        let mut file = File::open(NAME).ok()?;
        let mut bytes = [0; 16];
        file.read_exact(&mut bytes).ok()?;
        let [m0, m1, m2, m3, m4, m5, m6, m7, w0, w1, h0, h1, format, mode, camera, _] = bytes;
        if [m0, m1, m2, m3, m4, m5, m6, m7] != *MAGIC {
            return None;
        }
        let head = Head {
            width: u16::from_le_bytes([w0, w1]),
            height: u16::from_le_bytes([h0, h1]),
            format: *PixelFormat::ALL.get(usize::from(format))?,
            tracker: if mode == 0 { TrackerConfig::paper() } else { TrackerConfig::default() },
            camera,
        };
        Some(Self { file, head })
    }

    /// What the head says.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// Plays it: its pictures are the sensor's, its bytes the serial line's.
    #[must_use]
    pub fn play(self, inputs: &'static Inputs) -> Player {
        Player { tape: self, listener: Listener::default(), inputs }
    }

    /// Reads over a record's bytes.
    fn skip(&mut self, mut length: usize) -> io::Result<()> {
        let mut bytes = [0; 256];
        while length > 0 {
            let (piece, _) = bytes.split_at_mut(length.min(256));
            self.file.read_exact(piece)?;
            length -= piece.len();
        }
        Ok(())
    }

    /// The next record, its bytes in `buffer`.
    ///
    /// # Errors
    /// The tape has ended.
    pub fn next(&mut self, buffer: &mut PictureBuffer) -> io::Result<Record> {
        let kind = u32::from_le_bytes(self.array()?);
        let length = u32::from_le_bytes(self.array()?) as usize;
        let capture_us = u64::from_le_bytes(self.array()?);
        let ready_us = u32::from_le_bytes(self.array()?);
        let Some(bytes) = buffer.0.get_mut(..length) else {
            self.skip(length)?;
            return Ok(Record::TooLong);
        };
        self.file.read_exact(bytes)?;
        let Head { width, height, format, .. } = self.head;
        Ok(match kind {
            PICTURE => Record::Picture(Captured { length, width, height, format, capture_us, ready_us }),
            LINE => Record::Line(length),
            PAUSE => Record::Pause(capture_us),
            _ => Record::Unknown,
        })
    }

    fn array<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

/// What a record is; its bytes are in the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// A picture.
    Picture(Captured),
    /// So many bytes of the serial line.
    Line(usize),
    /// Nothing, for so many microseconds.
    Pause(u64),
    /// There were more bytes than the buffer has room for.
    TooLong,
    /// Of another version of the format.
    Unknown,
}

/// A tape that plays.
pub struct Player {
    tape: Tape,
    listener: Listener,
    inputs: &'static Inputs,
}

impl Sensor for Player {
    async fn capture(&mut self, buffer: &mut PictureBuffer) -> Result<Captured, NoPicture> {
        loop {
            match self.tape.next(buffer).map_err(|_| NoPicture::End)? {
                Record::Picture(captured) => return Ok(captured),
                Record::Line(length) => {
                    let bytes = buffer.0.get(..length).unwrap_or_default();
                    self.listener.take(bytes, self.inputs).await;
                }
                Record::Pause(us) => Timer::after_micros(us).await,
                Record::TooLong => return Err(NoPicture::Bad(BadPicture::Length)),
                Record::Unknown => {}
            }
        }
    }
}
