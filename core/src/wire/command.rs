//! What a smart camera is told, and what it answers.
//!
//! A command is done once: a sender that had no answer repeats it under the same number, and the camera
//! answers again without doing it again. What a camera refuses, it refuses with a reason.

use super::BadValue;
use super::packet::{BYTE, F32, MAX_U32};
use crate::geometry::ImagePoint;
use crate::observation::Ball;
use crate::vision::appearance::LearntBall;
use serde::{Deserialize, Serialize};

/// One thing that a smart camera is told to do.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Command {
    /// Send observations of every picture from the next on.
    Start,
    /// Send no more of them.
    Stop,
    /// Learn a ball from the next picture, at a point inside it.
    Learn {
        /// Which.
        ball: Ball,
        /// A point of the picture, px.
        at: ImagePoint,
    },
    /// Take these colours and this size for a ball, as they were learnt before.
    SetReference {
        /// Which.
        ball: Ball,
        /// What it looks like.
        learnt: LearntBall,
    },
    /// Look for a ball around this point in the next picture.
    SetWindow {
        /// Which.
        ball: Ball,
        /// A point of the picture, px.
        at: ImagePoint,
    },
    /// Compute what is known to come out right, and say whether it did.
    SelfTest,
    /// Show what the windows around the balls hold, one ball after the other.
    Preview {
        /// A thumbnail begins every so many pictures; 0 for none, as it is before this was told.
        every: u16,
    },
}

/// Told to a smart camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommandPacket {
    /// Chosen anew each time the sender starts.
    pub session: u32,
    /// Counts the commands from 0, and wraps.
    pub sequence: u32,
    /// What to do.
    pub command: Command,
}

impl CommandPacket {
    /// The most bytes the fields take: a reference's.
    pub const MAX_LEN: usize = 2 * MAX_U32 + BYTE + BYTE + LEARNT_LEN;

    pub(super) fn check(&self) -> Result<(), BadValue> {
        let finite = match self.command {
            Command::Learn { at, .. } | Command::SetWindow { at, .. } => at.is_finite(),
            Command::SetReference { learnt, .. } => is_finite(&learnt),
            Command::Start | Command::Stop | Command::SelfTest | Command::Preview { .. } => true,
        };
        if finite { Ok(()) } else { Err(BadValue::NotFinite) }
    }
}

/// Why a ball was not learnt, or cannot be tracked as it was taught.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NotTaught {
    /// The point is not in the picture.
    Outside,
    /// At the point there is nothing of this colour, or nothing with an outline.
    Background,
    /// The ball is smaller than can be told from noise.
    TooSmall,
    /// The outline is larger than a ball may be, or than the picture.
    TooLarge,
    /// White or black all around the point.
    Saturated,
    /// The ball's colour is not told from its neighbourhood.
    NoContrast,
    /// The tracker would not find it again in the picture it was learnt from.
    NotFoundAgain,
    /// Its size is none that is tracked.
    Size,
    /// Its colours give no threshold.
    Colour,
}

/// Why a picture was not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BadPicture {
    /// It has not as many bytes as its size and format take.
    Length,
    /// Its size or format is none that is tracked in.
    Layout,
    /// It was not whole in time, or overwritten before it was.
    Overrun,
}

/// What a smart camera says beside its observations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Notice {
    /// The command was done.
    Done,
    /// A ball was learnt: to be kept, and given back with [`Command::SetReference`].
    Learnt {
        /// Which.
        ball: Ball,
        /// What it looks like.
        learnt: LearntBall,
    },
    /// A ball was not learnt or not taken; what was known of it stays.
    NotTaught {
        /// Which.
        ball: Ball,
        /// Why.
        why: NotTaught,
    },
    /// A ball that was never taught has no window.
    Untaught {
        /// Which.
        ball: Ball,
    },
    /// What came out of the self-test was not what is known to: this camera's numbers are not to be
    /// trusted.
    SelfTestFailed,
    /// A picture was refused. No answer to a command.
    PictureRefused {
        /// Why.
        why: BadPicture,
    },
    /// Bytes came that were no command for a camera: damaged, or meant for somebody else. No answer.
    NotUnderstood {
        /// Frames so far.
        count: u32,
    },
    /// The serial line brought bytes faster than they were taken. No answer.
    LineOverrun {
        /// Times so far.
        count: u32,
    },
}

/// Said by a smart camera: the answer to a command, or what the host should know.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NoticePacket {
    /// The camera's place in the list of views.
    pub camera: u8,
    /// The camera's session: that of its observations.
    pub session: u32,
    /// Counts the notices from 0, and wraps.
    pub sequence: u32,
    /// The number of the command that this answers; `None` where it answers none.
    pub answers: Option<u32>,
    /// What it says.
    pub notice: Notice,
}

impl NoticePacket {
    /// The most bytes the fields take: a learnt ball's.
    pub const MAX_LEN: usize = BYTE + 2 * MAX_U32 + (BYTE + MAX_U32) + BYTE + BYTE + LEARNT_LEN;

    pub(super) fn check(&self) -> Result<(), BadValue> {
        match self.notice {
            Notice::Learnt { learnt, .. } if !is_finite(&learnt) => Err(BadValue::NotFinite),
            _ => Ok(()),
        }
    }
}

/// Bytes of a learnt ball: which V, three colours, diameter and aspect.
const LEARNT_LEN: usize = BYTE + 9 * BYTE + 2 * F32;

fn is_finite(learnt: &LearntBall) -> bool {
    learnt.diameter.is_finite() && learnt.aspect.is_finite()
}
