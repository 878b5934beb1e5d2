//! Pictures and commands as the firmware reads them: firmware/src/board/mps2/tape.rs has the format.

use crate::clip::{Clip, FORMAT, Sequence};
use tetrad_core::config::TrackerConfig;
use tetrad_core::hand::tracker::HandMode;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{Command, CommandPacket, MAX_FRAME_LEN, Packet, encode};

/// How balls are tracked, and the hand's pose is computed.
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

    /// How the hand's pose is computed.
    #[must_use]
    pub const fn hand(self) -> HandMode {
        match self {
            Self::Paper => HandMode::Paper,
            Self::Refined => HandMode::Refined,
        }
    }

    /// A camera's settings.
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

/// Something that comes to the board.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A picture, and when it was taken, microseconds.
    Picture(u64, Vec<u8>),
    /// Bytes of the serial line.
    Line(Vec<u8>),
    /// Nothing, for so many microseconds.
    Pause(u64),
    /// A case of the arm.
    Case(Vec<u8>),
}

impl Event {
    /// A packet that comes on the serial line.
    ///
    /// # Panics
    /// When the packet holds what may not be sent.
    #[must_use]
    pub fn packet(packet: &Packet) -> Self {
        let mut frame = [0; MAX_FRAME_LEN];
        let length = encode(packet, &mut frame).expect("a packet of numbers");
        Self::Line(frame[..length].to_vec())
    }
}

/// What a board and the desktop are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// Width and height of all pictures, pixels.
    pub size: (u16, u16),
    /// How their pixels lie.
    pub format: PixelFormat,
    /// How everything is computed.
    pub mode: Mode,
    /// What comes, in order.
    pub events: Vec<Event>,
}

impl Tape {
    /// What the scene's first camera is told and shown: the balls are taught and the sequence is shown; in the
    /// end the camera is told to test itself and to stop.
    ///
    /// # Panics
    /// When there is no such scene.
    #[must_use]
    pub fn of(sequence: &Sequence) -> Self {
        Self::of_camera(sequence, 0)
    }

    /// The same of any camera of the scene.
    ///
    /// # Panics
    /// When there is no such scene or camera.
    #[must_use]
    pub fn of_camera(sequence: &Sequence, camera: usize) -> Self {
        let clip = Clip::named(sequence.scene, camera)
            .unwrap_or_else(|| panic!("no scene {} of camera {camera}", sequence.scene));
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
        Self { size: clip.size(), format: FORMAT, mode: Mode::Refined, events }
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

    /// Its pictures, and when each was taken, microseconds.
    pub fn pictures(&self) -> impl Iterator<Item = (u64, &[u8])> {
        self.events.iter().filter_map(|event| match event {
            Event::Picture(at_us, bytes) => Some((*at_us, &bytes[..])),
            Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
        })
    }

    /// Ends it behind so many pictures, where there are more.
    pub fn end_behind(&mut self, pictures: usize) {
        let places = self.events.iter().enumerate();
        let mut places = places.filter(|(_, event)| matches!(event, Event::Picture(..)));
        if let Some((last, _)) = pictures.checked_sub(1).and_then(|before| places.nth(before))
            && places.next().is_some()
        {
            self.events.truncate(last + 1);
        }
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
        let format = PixelFormat::ALL.iter().position(|format| *format == self.format).unwrap_or_default();
        bytes.extend([format as u8, u8::from(self.mode == Mode::Refined), 0, 0]);
        for event in &self.events {
            let (kind, time_us, content): (u32, u64, &[u8]) = match event {
                Event::Picture(capture_us, content) => (1, *capture_us, content),
                Event::Line(content) => (2, 0, content),
                Event::Pause(us) => (3, *us, &[]),
                Event::Case(content) => (4, 0, content),
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
