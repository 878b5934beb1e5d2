//! A smart camera that one program has for itself: told what to do, and every observation of it taken in
//! order.

use super::commander::{Commander, Unanswered};
use super::{CHUNK, open};
use crate::exit::{Exit, Failure};
use crate::robot::clock::Clock;
use crate::scene_file::Seeds;
use serialport::{ClearBuffer, SerialPort};
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::path::Path;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::wire::{
    BadPicture, Command, DecodeError, Decoder, NotTaught, Notice, ObservationPacket, Packet,
};

/// A started camera that says nothing for so long is taken for lost, microseconds: longer than one with 16
/// million instructions a second looks for four balls everywhere.
const SILENCE_US: u64 = 15_000_000;

/// What came of one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// What was observed.
    pub packet: ObservationPacket,
    /// Observations that are missing before it.
    pub missed: u32,
}

/// Why a smart camera cannot be used, or no longer.
#[derive(Debug, thiserror::Error)]
pub enum SmartCameraError {
    /// The port is not there, or belongs to another program.
    #[error("the port cannot be opened ({0}): plug the camera in; `tetrad devices` lists the ports")]
    NotOpen(serialport::Error),
    /// The port went away.
    #[error("the port went away ({0}): plug the camera in again")]
    Lost(io::Error),
    /// It does not answer.
    #[error("{0}: is this port a smart camera's, and its rate right (?baud=N)?{1}")]
    Unanswered(Unanswered, String),
    /// Nothing more came.
    #[error("no observation for {} s: see to the camera and its cable", SILENCE_US / 1_000_000)]
    Silent,
    /// It has another session.
    #[error("the camera began anew, and what it was taught is gone: see to its power, and run this again")]
    BeganAnew,
    /// It computes something else than this program would.
    #[error("the camera's self-test failed: its numbers are not to be trusted")]
    SelfTestFailed,
    /// A ball was not learnt, or its colours not taken.
    #[error("the {} ball: {}", .0.name(), in_words(.1))]
    NotTaught(Ball, NotTaught),
    /// It answered something that is no answer to that.
    #[error("the camera's answer is none to what it was told: {0:?}")]
    OtherAnswer(Notice),
}

impl SmartCameraError {
    /// How a command that meets this error ends.
    #[must_use]
    pub const fn exit(&self) -> Exit {
        match self {
            Self::NotTaught(_, NotTaught::Outside) => Exit::BadArguments,
            Self::NotTaught(..) | Self::SelfTestFailed => Exit::Failed,
            _ => Exit::DeviceLost,
        }
    }

    /// The failure of a command whose camera is `source`.
    #[must_use]
    pub fn of(self, source: &str) -> Failure {
        let exit = self.exit();
        Failure::new(exit, anyhow::Error::new(self).context(format!("{source}: the smart camera")))
    }
}

/// An open port, and who is at its other end.
pub struct SmartCamera {
    port: Box<dyn SerialPort>,
    clock: Clock,
    decoder: Decoder,
    commander: Commander,
    /// Observations that were not taken yet.
    came: VecDeque<ObservationPacket>,
    /// Session and number of the newest that was taken.
    newest: Option<(u32, u32)>,
    /// A session that one packet has named: damage that the check does not see, or a camera begun anew.
    doubted: Option<u32>,
    /// Why it may not be understood.
    version: Option<DecodeError>,
    notices: Vec<String>,
}

impl SmartCamera {
    /// Opens the port, stops the camera that is there and lets it test itself.
    ///
    /// # Errors
    /// [`SmartCameraError`]: the port, no answer, or a self-test that failed.
    pub fn open(device: &Path, baud: u32, session: u32) -> Result<Self, SmartCameraError> {
        let port = open(device, baud).map_err(SmartCameraError::NotOpen)?;
        // what came while nobody listened is old
        port.clear(ClearBuffer::Input).map_err(SmartCameraError::NotOpen)?;
        let mut camera = Self {
            port,
            clock: Clock::wall(),
            decoder: Decoder::new(),
            commander: Commander::new(session),
            came: VecDeque::new(),
            newest: None,
            doubted: None,
            version: None,
            notices: Vec::new(),
        };
        camera.told(Command::Stop)?;
        match camera.ask(Command::SelfTest)? {
            Notice::Done => Ok(camera),
            Notice::SelfTestFailed => Err(SmartCameraError::SelfTestFailed),
            other => Err(SmartCameraError::OtherAnswer(other)),
        }
    }

    /// Lets it learn each ball at its place, from the next pictures. What was learnt, to be kept.
    ///
    /// # Errors
    /// [`SmartCameraError::NotTaught`] names the first ball that was not.
    pub fn learn(&mut self, places: &Seeds) -> Result<[Option<LearntBall>; BALLS], SmartCameraError> {
        let mut taught = [None; BALLS];
        for (ball, (place, slot)) in Ball::ALL.into_iter().zip(places.iter().zip(&mut taught)) {
            let Some(at) = *place else { continue };
            match self.ask(Command::Learn { ball, at })? {
                Notice::Learnt { learnt, .. } => *slot = Some(learnt),
                Notice::NotTaught { ball, why } => return Err(SmartCameraError::NotTaught(ball, why)),
                other => return Err(SmartCameraError::OtherAnswer(other)),
            }
        }
        Ok(taught)
    }

    /// Gives it what was learnt before.
    ///
    /// # Errors
    /// [`SmartCameraError::NotTaught`] names the first ball that it does not take.
    pub fn teach(&mut self, balls: &[Option<LearntBall>; BALLS]) -> Result<(), SmartCameraError> {
        for (ball, learnt) in Ball::ALL.into_iter().zip(balls) {
            let Some(learnt) = *learnt else { continue };
            self.told(Command::SetReference { ball, learnt })?;
        }
        Ok(())
    }

    /// Says where balls are in the next picture, which were taught.
    ///
    /// # Errors
    /// [`SmartCameraError`].
    pub fn place(&mut self, places: &Seeds) -> Result<(), SmartCameraError> {
        for (ball, place) in Ball::ALL.into_iter().zip(places) {
            let Some(at) = *place else { continue };
            self.told(Command::SetWindow { ball, at })?;
        }
        Ok(())
    }

    /// Starts it: each picture from the next on gives an observation.
    ///
    /// # Errors
    /// [`SmartCameraError`].
    pub fn start(&mut self) -> Result<(), SmartCameraError> {
        // what came before is of another run
        self.came.clear();
        self.told(Command::Start)
    }

    /// Stops it.
    ///
    /// # Errors
    /// [`SmartCameraError`].
    pub fn stop(&mut self) -> Result<(), SmartCameraError> {
        self.told(Command::Stop)
    }

    /// Waits for the next observation; `None` once `ends` says so and all that came was taken.
    ///
    /// # Errors
    /// [`SmartCameraError`]: it went away, fell silent or began anew.
    pub fn next(&mut self, ends: impl Fn() -> bool) -> Result<Option<Seen>, SmartCameraError> {
        let since_us = self.clock.now_us();
        loop {
            while let Some(packet) = self.came.pop_front() {
                if let Some(seen) = self.in_order(packet)? {
                    return Ok(Some(seen));
                }
            }
            if ends() {
                return Ok(None);
            }
            if self.clock.now_us().saturating_sub(since_us) > SILENCE_US {
                return Err(SmartCameraError::Silent);
            }
            self.turn()?;
        }
    }

    /// What the user should know and was not told yet.
    pub fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    /// An observation that is newer than all before.
    fn in_order(&mut self, packet: ObservationPacket) -> Result<Option<Seen>, SmartCameraError> {
        let Some((session, sequence)) = self.newest else {
            self.newest = Some((packet.session, packet.sequence));
            return Ok(Some(Seen { packet, missed: 0 }));
        };
        if packet.session != session {
            if self.doubted.replace(packet.session) == Some(packet.session) {
                return Err(SmartCameraError::BeganAnew);
            }
            return Ok(None);
        }
        self.doubted = None;
        let ahead = packet.sequence.wrapping_sub(sequence);
        if ahead == 0 || ahead > u32::MAX / 2 {
            return Ok(None);
        }
        self.newest = Some((session, packet.sequence));
        Ok(Some(Seen { packet, missed: ahead - 1 }))
    }

    /// Tells it something whose only good answer is that it was done.
    fn told(&mut self, command: Command) -> Result<(), SmartCameraError> {
        match self.ask(command)? {
            Notice::Done => Ok(()),
            Notice::NotTaught { ball, why } => Err(SmartCameraError::NotTaught(ball, why)),
            other => Err(SmartCameraError::OtherAnswer(other)),
        }
    }

    /// Tells it something, and waits for the answer.
    fn ask(&mut self, command: Command) -> Result<Notice, SmartCameraError> {
        self.commander.tell(command);
        loop {
            if let Some((_, answer)) = self.turn()? {
                return Ok(answer);
            }
        }
    }

    /// Writes what is due and takes what has come, or waits a little for it; the answer, if it is in it.
    fn turn(&mut self) -> Result<Option<(Command, Notice)>, SmartCameraError> {
        let due = self.commander.due(self.clock.now_us()).map_err(|unanswered| {
            let version = self.version.map(|version| format!(" It says something else: {version}"));
            SmartCameraError::Unanswered(unanswered, version.unwrap_or_default())
        })?;
        if let Some(frame) = due {
            self.port.write_all(&frame).map_err(SmartCameraError::Lost)?;
        }
        let mut bytes = [0; CHUNK];
        let count = match self.port.read(&mut bytes) {
            Ok(0) => return Err(SmartCameraError::Lost(ErrorKind::UnexpectedEof.into())),
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(error) => return Err(SmartCameraError::Lost(error)),
        };
        let mut answer = None;
        for frame in self.decoder.packets(bytes.get(..count).unwrap_or_default()) {
            match frame {
                Ok(Packet::Observation(packet)) => self.came.push_back(packet),
                Ok(Packet::Notice(notice)) => match self.commander.heard(&notice) {
                    Some(heard) => answer = Some(heard),
                    None => self.notices.extend(unasked(notice.notice)),
                },
                Err(version @ DecodeError::UnknownVersion(_)) => self.version = Some(version),
                // damage costs what was in it: commands are told again, observations are counted
                Ok(_) | Err(_) => {}
            }
        }
        Ok(answer)
    }
}

/// What a camera says that nobody asked, for the user.
fn unasked(notice: Notice) -> Option<String> {
    match notice {
        Notice::PictureRefused { why } => Some(format!(
            "the camera refused a picture: {}",
            match why {
                BadPicture::Length => "it has not as many bytes as its size and format take",
                BadPicture::Layout => "its size or format is none that is tracked in",
                BadPicture::Overrun => "it was not whole in time",
            }
        )),
        Notice::NotUnderstood { count } => {
            Some(format!("the camera did not understand {count} frames so far: is the line disturbed?"))
        }
        Notice::LineOverrun { count } => {
            Some(format!("bytes came faster than the camera took them, {count} times so far"))
        }
        // second answers to what was told twice
        _ => None,
    }
}

/// Why a ball was not learnt.
pub(super) const fn in_words(why: &NotTaught) -> &'static str {
    match why {
        NotTaught::Outside => "the point is not in the picture",
        NotTaught::Background => "at the point there is nothing of this colour",
        NotTaught::TooSmall => "it is too small there",
        NotTaught::TooLarge => "it is larger than a ball may be (is the point inside the ball?)",
        NotTaught::Saturated => "it is white or black all around the point",
        NotTaught::NoContrast => {
            "its colour is not told from its neighbourhood (is the point inside the ball?)"
        }
        NotTaught::NotFoundAgain => "it would not be found again in the same picture",
        NotTaught::Size => "its size is none that is tracked",
        NotTaught::Colour => "its colours give no threshold",
    }
}

#[cfg(all(test, unix))]
mod tests;
