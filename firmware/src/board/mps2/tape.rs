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
//! | 1 | 0 played at once, to the end of the run; 1 live: see [`Asked`] |
//!
//! and then records: 4 bytes kind (1 a picture, 2 bytes of the serial line, 3 a pause, 4 a case of the arm), 4
//! bytes length, 8 bytes capture time (or how long the pause is) and 4 bytes until it was ready, microseconds (0
//! where it is no picture), and as many bytes as the length says.

use crate::capture::{NoPicture, Sensor};
use crate::handover::{Captured, Inputs, PictureBuffer};
use crate::receive::Listener;
use core::cell::Cell;
use core::ffi::CStr;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::Timer;
use semihosting::fs::File;
use semihosting::io::{self, Read as _};
use tetrad_core::config::TrackerConfig;
use tetrad_core::hand::tracker::HandMode;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{BadPicture, Command, CommandPacket};

/// The file, in the folder that QEMU runs in.
pub const NAME: &CStr = c"tetrad.tape";

const MAGIC: &[u8; 8] = b"TETRADT1";
const PICTURE: u32 = 1;
const LINE: u32 = 2;
const PAUSE: u32 = 3;
const CASE: u32 = 4;

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
    /// How the hand's pose is computed.
    pub hand: HandMode,
    /// The camera's place in the list of views.
    pub camera: u8,
    /// Whether the serial line decides when it is played.
    pub live: bool,
}

/// What the serial line asks of a live tape: each learning a look at the first picture, the first start the
/// whole tape from there on. A picture is shown behind the command that asked for it, so that a run comes out
/// the same however fast the line is; and the line stays open behind the last.
pub struct Asked {
    so_far: Mutex<CriticalSectionRawMutex, Cell<SoFar>>,
    more: Signal<CriticalSectionRawMutex, ()>,
}

/// What was asked for so far.
#[derive(Clone, Copy, Default)]
struct SoFar {
    /// Its session and number: the same again asks for nothing.
    newest: Option<(u32, u32)>,
    /// Looks at the first picture that are still to come.
    looks: u32,
    started: bool,
}

impl Asked {
    /// Nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        let nothing = SoFar { newest: None, looks: 0, started: false };
        Self { so_far: Mutex::new(Cell::new(nothing)), more: Signal::new() }
    }

    /// A command is on its way to the tracker.
    pub fn hear(&self, packet: &CommandPacket) {
        let name = Some((packet.session, packet.sequence));
        self.so_far.lock(|cell| {
            let mut so_far = cell.get();
            if so_far.newest == name {
                return;
            }
            so_far.newest = name;
            match packet.command {
                Command::Learn { .. } => so_far.looks = so_far.looks.wrapping_add(1),
                Command::Start => so_far.started = true,
                _ => {}
            }
            cell.set(so_far);
        });
        self.more.signal(());
    }

    /// Waits for a look that is asked for, until the tape is to be played.
    async fn look(&self) -> bool {
        loop {
            let so_far = self.so_far.lock(|cell| {
                let so_far = cell.get();
                cell.set(SoFar { looks: so_far.looks.saturating_sub(1), ..so_far });
                so_far
            });
            // the answers to these come with the looks: they were asked for before the start
            if so_far.looks > 0 {
                return true;
            }
            if so_far.started {
                return false;
            }
            self.more.wait().await;
        }
    }
}

impl Default for Asked {
    fn default() -> Self {
        Self::new()
    }
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
        let [m0, m1, m2, m3, m4, m5, m6, m7, w0, w1, h0, h1, format, mode, camera, live] = bytes;
        if [m0, m1, m2, m3, m4, m5, m6, m7] != *MAGIC {
            return None;
        }
        let (tracker, hand) = match mode {
            0 => (TrackerConfig::paper(), HandMode::Paper),
            _ => (TrackerConfig::default(), HandMode::Refined),
        };
        let head = Head {
            width: u16::from_le_bytes([w0, w1]),
            height: u16::from_le_bytes([h0, h1]),
            format: *PixelFormat::ALL.get(usize::from(format))?,
            tracker,
            hand,
            camera,
            live: live == 1,
        };
        Some(Self { file, head })
    }

    /// What the head says.
    #[must_use]
    pub const fn head(&self) -> &Head {
        &self.head
    }

    /// Plays it: its pictures are the sensor's, its bytes the serial line's. What a live one waits for comes
    /// through `asked`.
    #[must_use]
    pub fn play(self, inputs: &'static Inputs, asked: &'static Asked) -> Player {
        let waits = self.head.live;
        Player { tape: self, listener: Listener::default(), inputs, asked, waits }
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
            CASE => Record::Case(length),
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
    /// So many bytes of a case of the arm, which a camera has nothing to do with.
    Case(usize),
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
    asked: &'static Asked,
    /// It is live, and was not started.
    waits: bool,
}

impl Player {
    /// The next picture of the tape.
    async fn next(&mut self, buffer: &mut PictureBuffer) -> Result<Captured, NoPicture> {
        loop {
            match self.tape.next(buffer).map_err(|_| NoPicture::End)? {
                Record::Picture(captured) => return Ok(captured),
                Record::Line(length) => {
                    let bytes = buffer.0.get(..length).unwrap_or_default();
                    self.listener.take(bytes, self.inputs, |_| {}).await;
                }
                Record::Pause(us) => Timer::after_micros(us).await,
                Record::TooLong => return Err(NoPicture::Bad(BadPicture::Length)),
                Record::Case(_) | Record::Unknown => {}
            }
        }
    }
}

impl Sensor for Player {
    async fn capture(&mut self, buffer: &mut PictureBuffer) -> Result<Captured, NoPicture> {
        if self.waits {
            self.waits = self.asked.look().await;
            if self.waits {
                // from its beginning, each time
                let first = self.next(buffer).await;
                self.tape = Tape::open().ok_or(NoPicture::End)?;
                return first;
            }
        }
        match self.next(buffer).await {
            Err(NoPicture::End) if self.tape.head.live => core::future::pending().await,
            shown => shown,
        }
    }
}
