//! A camera at the other end of a line, which is shown a tape's pictures there, and compared with the desktop.
//!
//! What comes is compared frame by frame, as it comes: it has to be what the desktop says to the same, to the byte.
//! What the line itself does to strips of a picture is told apart: the board names it, the desktop is told the same,
//! and the picture is shown again.

use crate::desktop::Camera;
use crate::tape::{Event, Mode, Tape};
use std::io::{self, Read, Write};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tetrad_core::wire::{
    Command, CommandPacket, DecodeError, Decoder, MAX_FRAME_LEN, Notice, Packet, STRIP_BYTES, Shown,
    ShownPacket, Strip, encode,
};

/// How long an answer is waited for before the question is put again. A board in QEMU takes seconds to learn a ball.
const ANSWER: Duration = Duration::from_secs(5);

/// How often a camera is asked to begin.
const BEGINNINGS: u32 = 3;

/// How often an answer is waited for, and the look at a picture asked for again.
const WAITS: u32 = 24;

/// How often a picture is shown of which strips are lost.
const AGAIN: u32 = 5;

/// Nothing more comes once nothing has come for so long.
const QUIET: Duration = Duration::from_millis(300);

/// The longest that the line may take no byte.
const STUCK: Duration = Duration::from_secs(60);

/// Why there is nothing to compare, or what differs.
#[derive(Debug)]
pub enum Failure {
    /// The line cannot be written to or read from.
    Line(io::Error),
    /// No answer to this.
    Silent(String),
    /// What answers speaks another version of the wire format.
    Version(u8),
    /// What answers is another program, or another board.
    Stranger(Box<Packet>),
    /// What comes is no packet.
    Noise(DecodeError),
    /// The line spoilt what the camera was told here.
    Damaged(String),
    /// The board does not see what the desktop sees.
    Differs(String),
    /// The tape has what no camera is shown.
    Tape,
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(error) => write!(f, "{error}"),
            Self::Silent(what) => write!(
                f,
                "the board does not answer to {what}: see that it has power, that it runs stm32h743-streamed or \
                 mps2-streamed, and that `baud` is that of its line"
            ),
            Self::Version(version) => {
                let why = DecodeError::UnknownVersion(*version);
                write!(f, "{why}: build and load its program anew from this source")
            }
            Self::Stranger(packet) => write!(
                f,
                "what answers is not shown pictures: load stm32h743-streamed or mps2-streamed; it said {packet:?}"
            ),
            Self::Noise(error) => {
                write!(f, "what comes is no packet ({error}): see that `baud` is that of the board's line")
            }
            Self::Damaged(what) => {
                write!(f, "the line spoilt {what}: see to its wires, or to a lower `baud` at both ends")
            }
            Self::Differs(what) => write!(f, "not as on the desktop: {what}"),
            Self::Tape => f.write_str("the tape has what no camera is shown"),
        }
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Line(error)
    }
}

/// What was the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Same {
    /// Pictures shown.
    pub pictures: u32,
    /// Packets that came.
    pub packets: u32,
    /// Pictures shown again, for the line had lost some of them.
    pub again: u32,
    /// Notices that something came which nobody had sent so.
    pub noise: u32,
}

/// Puts bytes on a line that may take its time.
///
/// # Errors
/// The line's, or that it takes nothing any more.
pub fn put(line: &mut impl Write, mut bytes: &[u8]) -> io::Result<()> {
    let mut since = Instant::now();
    while !bytes.is_empty() {
        match line.write(bytes) {
            Ok(count) if count > 0 => {
                bytes = bytes.get(count..).unwrap_or_default();
                since = Instant::now();
            }
            Err(error) if !is_a_wait(&error) => return Err(error),
            _ if since.elapsed() > STUCK => return Err(io::Error::other("the line takes no byte any more")),
            _ => {}
        }
    }
    Ok(())
}

/// Nothing came, or there was no room, for as long as the line waits at a time.
#[must_use]
pub fn is_a_wait(error: &io::Error) -> bool {
    use io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), Interrupted | TimedOut | WouldBlock)
}

/// Whoever shows pictures. The line's reads wait a little and not for ever.
#[derive(Debug)]
pub struct Sender<L> {
    line: L,
    received: Vec<u8>,
    session: u32,
    picture: u32,
}

impl<L: Read + Write> Sender<L> {
    /// At the other end of this line.
    #[must_use]
    pub fn new(line: L) -> Self {
        // another one each time, so that no old answer is taken for one to this
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
        Self { line, received: Vec::new(), session: since.as_millis() as u32, picture: 0 }
    }

    /// Shows a tape, and compares what comes with what the desktop says to `same`: the same tape, or one that
    /// shows that a difference is seen.
    ///
    /// # Errors
    /// What differs, or why nothing can be compared.
    pub fn compare(&mut self, shown: &Tape, same: &Tape) -> Result<Same, Failure> {
        let (mut desktop, mut checked) = self.begin(shown)?;
        let mut report = Same { packets: 1, ..Same::default() };
        // a command that is answered with the next picture, and with no other packet before
        let mut unanswered = false;
        for (event, expected) in shown.events.iter().zip(&same.events) {
            self.tell(shown, event)?;
            let mut before = desktop.clone();
            desktop.take(expected);
            let is_picture = matches!(event, Event::Picture(..));
            let (mut waits, mut shows, mut doubtful) = (WAITS, AGAIN, false);
            while let Some(ours) = next_frame(&desktop, checked) {
                let Some(frame) = self.frame(ANSWER)? else {
                    waits = waits.checked_sub(1).ok_or_else(|| Failure::Silent(words(event, &report)))?;
                    if let Event::Picture(capture_us, bytes) = event {
                        // it may have been lost; if it was not, this one changes nothing
                        let look = self.look(shown, *capture_us, bytes.len());
                        put(&mut self.line, &look)?;
                    }
                    continue;
                };
                report.packets += 1;
                if frame == ours {
                    checked += frame.len();
                    continue;
                }
                let place = words(event, &report);
                let Some((why, spoilt)) = suffered(&before, checked, &frame) else {
                    return Err(if doubtful {
                        Failure::Damaged(place)
                    } else {
                        Failure::Differs(difference(&place, &frame, &ours))
                    });
                };
                if !is_picture {
                    return Err(Failure::Damaged(place));
                }
                // it may have been the command and not the picture
                doubtful |= unanswered;
                checked += frame.len();
                before = spoilt;
                desktop = before.clone();
                if matches!(why, Notice::PictureRefused { .. }) {
                    shows = shows.checked_sub(1).ok_or(Failure::Damaged(place))?;
                    report.again += 1;
                    self.tell(shown, event)?;
                } else {
                    report.noise += 1;
                }
                desktop.take(expected);
            }
            report.pictures += u32::from(is_picture);
            unanswered = !is_picture && (unanswered || desktop.line().len() == before.line().len());
        }
        match self.frame(QUIET)? {
            None => Ok(report),
            Some(more) => Err(Failure::Differs(difference("behind the last", &more, &[]))),
        }
    }

    /// Has the camera begin anew; the desktop's beside it, and how many of its bytes came.
    fn begin(&mut self, tape: &Tape) -> Result<(Camera, usize), Failure> {
        let mut heard = None;
        for _ in 0..BEGINNINGS {
            self.session = self.session.wrapping_add(1);
            let mut desktop = Camera::begun(tape, self.session);
            let begun = desktop.line().len();
            let refined = tape.mode == Mode::Refined;
            let command = CommandPacket { session: self.session, sequence: 0, command: Command::Stop };
            let stop = frame_of(&command.into());
            // the zero byte ends whatever was on the line before
            let hello = [vec![0], self.part(Shown::Begin { refined }), stop.clone()].concat();
            put(&mut self.line, &hello)?;
            desktop.take(&Event::Line(stop));
            let expected = next_frame(&desktop, begun);
            let asked = Instant::now();
            while let Some(frame) = self.frame(ANSWER.saturating_sub(asked.elapsed()))? {
                if Some(&frame) == expected.as_ref() {
                    return Ok((desktop, begun + frame.len()));
                }
                match decoded(&frame) {
                    Err(DecodeError::UnknownVersion(version)) => return Err(Failure::Version(version)),
                    // it may be what the camera said before it was asked
                    packet => heard = Some(packet),
                }
            }
        }
        Err(match heard {
            None => Failure::Silent("a sender that begins".into()),
            Some(Ok(packet)) => Failure::Stranger(Box::new(packet)),
            Some(Err(error)) => Failure::Noise(error),
        })
    }

    /// Puts an event on the line.
    fn tell(&mut self, tape: &Tape, event: &Event) -> Result<(), Failure> {
        match event {
            Event::Line(bytes) => put(&mut self.line, bytes)?,
            Event::Picture(capture_us, bytes) => {
                self.picture = self.picture.wrapping_add(1);
                let mut told = Vec::new();
                for (at, strip) in bytes.chunks(STRIP_BYTES).enumerate() {
                    let strip = Strip::of(strip).ok_or(Failure::Tape)?;
                    told.extend(self.part(Shown::Strip { offset: (at * STRIP_BYTES) as u32, strip }));
                }
                told.extend(self.look(tape, *capture_us, bytes.len()));
                put(&mut self.line, &told)?;
            }
            // nobody waits at a line that is answered
            Event::Pause(_) => {}
            Event::Case(_) => return Err(Failure::Tape),
        }
        Ok(())
    }

    fn look(&self, tape: &Tape, capture_us: u64, length: usize) -> Vec<u8> {
        let ((width, height), format) = (tape.size, tape.format);
        self.part(Shown::Look { capture_us, length: length as u32, width, height, format })
    }

    fn part(&self, shown: Shown) -> Vec<u8> {
        frame_of(&ShownPacket { session: self.session, picture: self.picture, shown }.into())
    }

    /// The next frame with its zero byte; `None` when none has come in this time.
    fn frame(&mut self, within: Duration) -> Result<Option<Vec<u8>>, Failure> {
        let asked = Instant::now();
        loop {
            match self.received.iter().position(|byte| *byte == 0) {
                Some(0) => {
                    self.received.remove(0);
                }
                Some(end) => return Ok(Some(self.received.drain(..=end).collect())),
                None if asked.elapsed() >= within => return Ok(None),
                None => {
                    let mut bytes = [0; 4096];
                    match self.line.read(&mut bytes) {
                        Ok(0) => return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into()),
                        Ok(count) => self.received.extend(bytes.get(..count).unwrap_or_default()),
                        Err(error) if is_a_wait(&error) => {}
                        Err(error) => return Err(error.into()),
                    }
                }
            }
        }
    }
}

fn frame_of(packet: &Packet) -> Vec<u8> {
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(packet, &mut frame).expect("there is room, and no number in it");
    frame[..length].to_vec()
}

fn decoded(frame: &[u8]) -> Result<Packet, DecodeError> {
    Decoder::new().packets(frame).next().unwrap_or(Err(DecodeError::TooShort))
}

/// What the desktop says behind the bytes that were checked, up to the next zero byte.
fn next_frame(desktop: &Camera, checked: usize) -> Option<Vec<u8>> {
    desktop.line().get(checked..)?.split_inclusive(|byte| *byte == 0).next().map(<[u8]>::to_vec)
}

/// The desktop's camera with what the line did to the board's, where that is what the board says.
fn suffered(before: &Camera, checked: usize, frame: &[u8]) -> Option<(Notice, Camera)> {
    let Ok(Packet::Notice(told)) = decoded(frame) else { return None };
    let mut camera = before.clone();
    (camera.suffer(told.notice) && camera.line().get(checked..) == Some(frame))
        .then_some((told.notice, camera))
}

fn words(event: &Event, so_far: &Same) -> String {
    let pictures = so_far.pictures;
    match event {
        Event::Picture(..) => format!("picture {}", pictures + 1),
        Event::Line(_) => format!("a command behind {pictures} pictures"),
        Event::Pause(_) | Event::Case(_) => format!("what is behind {pictures} pictures"),
    }
}

fn difference(place: &str, theirs: &[u8], ours: &[u8]) -> String {
    let said = |frame: &[u8]| match decoded(frame) {
        _ if frame.is_empty() => "nothing".to_owned(),
        Ok(packet) => format!("{packet:?}"),
        Err(error) => format!("{error}: {frame:02x?}"),
    };
    format!("{place}\nthe board says   {}\nthe desktop says {}", said(theirs), said(ours))
}
