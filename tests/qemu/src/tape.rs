//! Pictures and commands as the firmware reads them: firmware/src/board/mps2/tape.rs has the format.

use crate::clip::{Clip, FORMAT, Sequence};
use tetrad_core::config::TrackerConfig;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{Command, CommandPacket, MAX_FRAME_LEN, encode};

/// How balls are tracked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// By the paper's methods.
    Paper,
    /// By the finer ones.
    Refined,
}

impl Mode {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Paper, Self::Refined];

    /// The settings.
    #[must_use]
    pub fn tracker(self) -> TrackerConfig {
        match self {
            Self::Paper => TrackerConfig::paper(),
            Self::Refined => TrackerConfig::default(),
        }
    }
}

/// Where the head says whether a tape is live.
const LIVE_AT: usize = 15;

/// The frame of a command of the one host that there is.
///
/// # Panics
/// When a number in it is not finite.
#[must_use]
pub fn command_frame(sequence: u32, command: Command) -> Vec<u8> {
    let packet = CommandPacket { session: 9, sequence, command };
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(&packet.into(), &mut frame).expect("a command of numbers");
    frame[..length].to_vec()
}

/// Something that comes to the camera.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A picture, and when it was taken, microseconds.
    Picture(u64, Vec<u8>),
    /// Bytes of the serial line.
    Line(Vec<u8>),
    /// Nothing, for so many microseconds.
    Pause(u64),
}

/// What a board and the desktop are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// Width and height of all pictures, pixels.
    pub size: (u16, u16),
    /// How balls are tracked.
    pub mode: Mode,
    /// What comes, in order.
    pub events: Vec<Event>,
}

impl Tape {
    /// The balls taught and the sequence shown; in the end the camera is told to test itself and to stop.
    ///
    /// # Panics
    /// When there is no such scene.
    #[must_use]
    pub fn of(sequence: &Sequence) -> Self {
        let clip = Clip::named(sequence.scene).unwrap_or_else(|| panic!("no scene {}", sequence.scene));
        let mut commands = 0..;
        let mut told = |command| Event::Line(command_frame(commands.next().unwrap_or(0), command));
        let mut events: Vec<Event> =
            clip.places(0).into_iter().map(|(ball, at)| told(Command::Learn { ball, at })).collect();
        events.push(told(Command::Start));
        events.extend(
            std::iter::once(0)
                .chain(sequence.frames.iter().copied())
                .map(|frame| Event::Picture(clip.time_us(frame), clip.picture(frame))),
        );
        events.push(told(Command::SelfTest));
        events.push(told(Command::Stop));
        // nothing comes of it: the camera was stopped
        events.push(Event::Picture(clip.time_us(0), clip.picture(0)));
        Self { size: clip.size(), mode: Mode::Refined, events }
    }

    /// The pictures of a sequence and nothing else: what a live tape has, whose commands come over the line.
    ///
    /// # Panics
    /// When there is no such scene.
    #[must_use]
    pub fn of_pictures(sequence: &Sequence) -> Self {
        let mut tape = Self::of(sequence);
        // the last is there to show that a stopped camera says nothing
        tape.events.pop();
        tape.events.retain(|event| matches!(event, Event::Picture(..)));
        tape
    }

    /// The bytes of a tape that waits for what the line asks for: firmware/src/board/mps2/tape.rs says how.
    #[must_use]
    pub fn live_bytes(&self) -> Vec<u8> {
        let mut bytes = self.bytes();
        bytes[LIVE_AT] = 1;
        bytes
    }

    /// The file's bytes.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = b"TETRADT1".to_vec();
        bytes.extend(self.size.0.to_le_bytes());
        bytes.extend(self.size.1.to_le_bytes());
        let format = PixelFormat::ALL.iter().position(|format| *format == FORMAT).unwrap_or_default();
        bytes.extend([format as u8, u8::from(self.mode == Mode::Refined), 0, 0]);
        for event in &self.events {
            let (kind, time_us, content): (u32, u64, &[u8]) = match event {
                Event::Picture(capture_us, content) => (1, *capture_us, content),
                Event::Line(content) => (2, 0, content),
                Event::Pause(us) => (3, *us, &[]),
            };
            bytes.extend(kind.to_le_bytes());
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(time_us.to_le_bytes());
            bytes.extend(0_u32.to_le_bytes());
            bytes.extend(content);
        }
        bytes
    }
}
