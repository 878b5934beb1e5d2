//! A smart camera without its board: pictures and commands in, observations and notices out.
//!
//! | job | file |
//! |---|---|
//! | commands, pictures, what is answered | this one |
//! | what is known to come out right | `self_test` |
//! | thumbnails of the balls, for people | `preview` |
//!
//! It knows no sensor, no serial line and no clock: a microcontroller's tasks feed it, and so does a test
//! on a desktop, which then has the same packets to the byte.

mod preview;
mod self_test;

use crate::config::{LearnConfig, TrackerConfig};
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, Ball};
use crate::vision::appearance::{LearntBall, LearntBallError};
use crate::vision::colour::Primary;
use crate::vision::frame::{FrameError, FrameView};
use crate::vision::learn::{LearnError, learn};
use crate::vision::tracker::{CameraTracker, TrackerError};
use crate::wire::{
    BadPicture, Command, CommandPacket, NotTaught, Notice, NoticePacket, ObservationPacket, PreviewPacket,
};
use preview::Preview;

/// Who a smart camera is, and how it works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeConfig {
    /// Its place in the list of views.
    pub camera: u8,
    /// Chosen anew each time it starts, so that old packets are not taken for new ones.
    pub session: u32,
    /// How it tracks.
    pub tracker: TrackerConfig,
    /// How it learns.
    pub learn: LearnConfig,
    /// Whether it sends observations before it is told to.
    pub started: bool,
}

/// What came of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// What was observed; `None` while it is stopped. `observed_us` is for the caller to fill in, who has
    /// the clock.
    pub observation: Option<ObservationPacket>,
    /// Answers to what was to be learnt from this picture.
    pub notices: heapless::Vec<NoticePacket, BALLS>,
    /// What is to be shown with it, behind the observation; `None` where nothing is, or was asked for.
    pub preview: Option<PreviewPacket>,
}

/// Names a command: its sender's session and its number.
type Name = (u32, u32);

/// A ball that is to be learnt from the next picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Learning {
    at: ImagePoint,
    asked_by: Name,
}

/// One smart camera. No heap; the tracker, a thumbnail and little else.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    camera: u8,
    session: u32,
    observations: u32,
    notices: u32,
    not_understood: u32,
    overruns: u32,
    running: bool,
    tracker: CameraTracker,
    learn: LearnConfig,
    learning: [Option<Learning>; BALLS],
    /// The newest command, and its answer if it has one by now.
    newest: Option<(Name, Option<Notice>)>,
    preview: Preview,
}

impl Node {
    /// A camera that was taught nothing.
    ///
    /// # Errors
    /// A setting of the tracker cannot be worked with.
    pub fn new(config: &NodeConfig) -> Result<Self, TrackerError> {
        Ok(Self {
            camera: config.camera,
            session: config.session,
            observations: 0,
            notices: 0,
            not_understood: 0,
            overruns: 0,
            running: config.started,
            tracker: CameraTracker::new(config.tracker, [None; BALLS])?,
            learn: config.learn,
            learning: [None; BALLS],
            newest: None,
            preview: Preview::off(),
        })
    }

    /// Does what it is told, once: the same command again is answered again and not done again. What is
    /// to be learnt is answered with the next picture.
    pub fn command(&mut self, packet: &CommandPacket) -> Option<NoticePacket> {
        let name = (packet.session, packet.sequence);
        if let Some((newest, answer)) = self.newest
            && newest == name
        {
            return answer.map(|notice| self.notice(Some(packet.sequence), notice));
        }
        let answer = match packet.command {
            Command::Start => self.run(true),
            Command::Stop => self.run(false),
            Command::Learn { ball, at } => {
                if let Some(slot) = self.learning.get_mut(ball.index()) {
                    *slot = Some(Learning { at, asked_by: name });
                }
                self.newest = Some((name, None));
                return None;
            }
            Command::SetReference { ball, learnt } => self.teach(ball, learnt).err().unwrap_or(Notice::Done),
            Command::SetWindow { ball, at } => {
                if self.tracker.reference(ball).is_some() {
                    self.tracker.place(ball, at);
                    Notice::Done
                } else {
                    Notice::Untaught { ball }
                }
            }
            Command::SelfTest if self_test::passes() => Notice::Done,
            Command::SelfTest => Notice::SelfTestFailed,
            Command::Preview { every } => {
                self.preview.begin(every);
                Notice::Done
            }
        };
        self.newest = Some((name, Some(answer)));
        Some(self.notice(Some(packet.sequence), answer))
    }

    /// Looks at one picture, taken at `capture_us` of the sender's clock and in memory `ready_us` later.
    pub fn picture(&mut self, frame: &FrameView<'_>, capture_us: u64, ready_us: u32) -> Seen {
        let mut seen = Seen::default();
        for (ball, slot) in Ball::ALL.into_iter().zip(0..BALLS) {
            let Some(learning) = self.learning.get_mut(slot).and_then(Option::take) else { continue };
            let notice = self.learn(frame, ball, learning.at);
            if let Some((newest, answer)) = &mut self.newest
                && *newest == learning.asked_by
            {
                *answer = Some(notice);
            }
            // there is room for an answer about each ball
            let _ = seen.notices.push(self.notice(Some(learning.asked_by.1), notice));
        }
        if self.running {
            let report = self.tracker.step(frame, capture_us, &[None; BALLS]);
            seen.observation = Some(ObservationPacket {
                camera: self.camera,
                session: self.session,
                sequence: self.observations,
                capture_us,
                ready_us,
                observed_us: 0,
                width: frame.width(),
                height: frame.height(),
                pixels_tested: report.tested,
                balls: report.observations,
            });
            let named = (self.camera, self.session, self.observations);
            seen.preview = self.preview.picture(frame, &report.observations, named);
            self.observations = self.observations.wrapping_add(1);
        }
        seen
    }

    /// A picture was none that can be looked at.
    pub fn refuse(&mut self, why: BadPicture) -> NoticePacket {
        self.notice(None, Notice::PictureRefused { why })
    }

    /// A frame came that is no command for a camera.
    pub fn not_understood(&mut self) -> NoticePacket {
        self.not_understood = self.not_understood.wrapping_add(1);
        self.notice(None, Notice::NotUnderstood { count: self.not_understood })
    }

    /// The serial line brought more than was taken.
    pub fn line_overrun(&mut self) -> NoticePacket {
        self.overruns = self.overruns.wrapping_add(1);
        self.notice(None, Notice::LineOverrun { count: self.overruns })
    }

    fn run(&mut self, running: bool) -> Notice {
        self.running = running;
        self.preview.forget();
        Notice::Done
    }

    fn learn(&mut self, frame: &FrameView<'_>, ball: Ball, at: ImagePoint) -> Notice {
        match learn(frame, Primary::of(ball), at, &self.learn) {
            Ok(found) => {
                let learnt = LearntBall::of(&found);
                match self.teach(ball, learnt) {
                    Ok(()) => {
                        self.tracker.place(ball, found.centre);
                        Notice::Learnt { ball, learnt }
                    }
                    Err(refused) => refused,
                }
            }
            Err(error) => Notice::NotTaught { ball, why: error.into() },
        }
    }

    fn teach(&mut self, ball: Ball, learnt: LearntBall) -> Result<(), Notice> {
        self.tracker.teach(ball, learnt).map_err(|error| {
            let why = match error {
                TrackerError::Ball(_, LearntBallError::Colour(_)) => NotTaught::Colour,
                TrackerError::Ball(..) | TrackerError::Config(_) => NotTaught::Size,
            };
            Notice::NotTaught { ball, why }
        })
    }

    fn notice(&mut self, answers: Option<u32>, notice: Notice) -> NoticePacket {
        let sequence = self.notices;
        self.notices = sequence.wrapping_add(1);
        NoticePacket { camera: self.camera, session: self.session, sequence, answers, notice }
    }
}

impl From<LearnError> for NotTaught {
    fn from(error: LearnError) -> Self {
        match error {
            LearnError::Outside => Self::Outside,
            LearnError::Background => Self::Background,
            LearnError::TooSmall => Self::TooSmall,
            LearnError::TooLarge => Self::TooLarge,
            LearnError::Saturated => Self::Saturated,
            LearnError::NoContrast => Self::NoContrast,
            LearnError::NotFoundAgain => Self::NotFoundAgain,
        }
    }
}

impl From<FrameError> for BadPicture {
    fn from(error: FrameError) -> Self {
        match error {
            FrameError::WrongLength { .. } => Self::Length,
            _ => Self::Layout,
        }
    }
}

#[cfg(test)]
mod tests;
