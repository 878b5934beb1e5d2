//! What the arm is allowed to do and why: "why am I stopped?", "why am I slow?". Each text says what
//! to do about it.

use super::command::BadCommand;
use core::fmt;

/// The five states of the law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum State {
    /// Latched: it takes a reset.
    Stopped = 0,
    /// At rest, waiting for a fresh press.
    Armed = 1,
    /// The arm follows the hand.
    Engaged = 2,
    /// Engaged, but nothing may be followed now; it goes on by itself, within bounds.
    Hold = 3,
    /// Latched like a stop: the arm, or what is known of it, is not in order.
    Fault = 4,
}

impl State {
    /// The word written to files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Armed => "armed",
            Self::Engaged => "engaged",
            Self::Hold => "hold",
            Self::Fault => "fault",
        }
    }
}

/// Why it is stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StopReason {
    /// Nobody has released it since the start.
    Started,
    /// Somebody asked for it.
    Asked,
    /// Commands of two senders came at one time.
    TwoSenders,
    /// The arm's port refused a set-point: limits and port do not agree on what the arm can do.
    SetPointRefused,
    /// The slave's program ends.
    Ending,
}

/// Why there is a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FaultReason {
    /// The arm is not enabled, or its controller is not ready.
    ArmNotReady,
    /// The arm reports a fault.
    Arm,
    /// The arm cannot start where its joints are.
    ArmCannotStart,
    /// The arm is not where it was sent.
    ArmAstray,
    /// The arm's joints cannot be read.
    ArmBlind,
    /// A pose that is said to be the arm's is not made of finite numbers.
    ArmPoseNotFinite,
    /// The rotation of a pose that is said to be the arm's is not a rotation.
    ArmPoseNotARotation,
    /// This receiver's clock went back: nothing can be said of the age of a command.
    ClockWentBack,
}

/// Why the hand is not followed though the operator wants it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HoldReason {
    /// No command has come for longer than the timeout.
    NoCommand,
    /// The state of hold-to-run has not been heard for longer than its timeout.
    NoHoldToRun,
    /// The newest command cannot be used.
    BadCommand(BadCommand),
    /// The hand is not seen.
    HandNotSeen,
    /// The hand has only been predicted for too long, or is only predicted where it is to be latched.
    HandNotMeasured,
}

/// What keeps an armed law from engaging.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmedReason {
    /// A press.
    Press,
    /// Hold-to-run is pressed; the operator station does not engage the hand.
    Engage,
    /// A release, then a press: what was pressed is not fresh any more.
    LetGo(HoldReason),
    /// A release, then a press: the sender of commands has changed.
    NewSender,
    /// A release, then a press: the press went on for something else.
    PressChanged,
}

/// State and reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Status {
    /// See [`State::Stopped`].
    Stopped(StopReason),
    /// See [`State::Armed`].
    Armed(ArmedReason),
    /// See [`State::Engaged`]. What limits it is in [`Notes`].
    Engaged,
    /// See [`State::Hold`].
    Hold(HoldReason),
    /// See [`State::Fault`].
    Fault(FaultReason),
}

impl Status {
    /// The state without its reason.
    #[must_use]
    pub const fn state(self) -> State {
        match self {
            Self::Stopped(_) => State::Stopped,
            Self::Armed(_) => State::Armed,
            Self::Engaged => State::Engaged,
            Self::Hold(_) => State::Hold,
            Self::Fault(_) => State::Fault,
        }
    }
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Started => "just started; let go of hold-to-run and reset",
            Self::Asked => "stop was pressed; when all is clear, let go of hold-to-run and reset",
            Self::Ending => "the slave station ends",
            Self::SetPointRefused => {
                "the arm's port refused a set-point; make the limits and the rate of tetrad.toml those of \
                 the port, let go of hold-to-run and reset"
            }
            Self::TwoSenders => {
                "two operator stations send commands; end one of them, let go of hold-to-run and reset"
            }
        })
    }
}

impl fmt::Display for FaultReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ArmNotReady => "the arm is not ready; enable it, let go of hold-to-run and reset",
            Self::Arm => "the arm reports a fault; clear it at the arm, let go of hold-to-run and reset",
            Self::ArmCannotStart => {
                "the arm cannot start where its joints are; move it by hand or from its own panel into range"
            }
            Self::ArmAstray => {
                "the arm is not where it was sent; look for what holds it, let go of hold-to-run and reset"
            }
            Self::ArmBlind => {
                "the arm's joints cannot be read; check its encoders and its line, let go of hold-to-run and reset"
            }
            Self::ArmPoseNotFinite => {
                "the arm's pose is not made of finite numbers; check its encoders and configuration, then reset"
            }
            Self::ArmPoseNotARotation => {
                "the arm's pose has no proper rotation; check its encoders and configuration, then reset"
            }
            Self::ClockWentBack => {
                "the clock of this computer went back; use one that only goes forward, then reset"
            }
        })
    }
}

impl fmt::Display for HoldReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoCommand => f.write_str("no fresh command; check the link and the operator station"),
            Self::NoHoldToRun => {
                f.write_str("hold-to-run is not heard; check the pedal or button and its cable")
            }
            Self::BadCommand(bad) => bad.fmt(f),
            Self::HandNotSeen => f.write_str("the hand is not seen; show the balls to the cameras"),
            Self::HandNotMeasured => {
                f.write_str("the hand is only guessed at; show the balls to the cameras")
            }
        }
    }
}

impl fmt::Display for ArmedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Press => f.write_str("press hold-to-run to move the arm"),
            Self::Engage => f.write_str("engage the hand at the operator station to move the arm"),
            Self::LetGo(HoldReason::BadCommand(bad)) => write!(f, "{bad}; then let go and press again"),
            Self::LetGo(reason) => write!(f, "{reason}; then let go of hold-to-run and press again"),
            Self::NewSender => {
                f.write_str("another operator station has taken over; let go of hold-to-run and press again")
            }
            Self::PressChanged => f.write_str(
                "the button is held for something else than before; let go of hold-to-run and press again",
            ),
        }
    }
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.state().name())?;
        match self {
            Self::Stopped(reason) => write!(f, ": {reason}"),
            Self::Armed(reason) => write!(f, ": {reason}"),
            Self::Engaged => Ok(()),
            Self::Hold(reason) => write!(f, ": {reason}"),
            Self::Fault(reason) => write!(f, ": {reason}"),
        }
    }
}

/// What limits or changes the following of the hand in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Note {
    /// The goal is at the edge of the workspace; motion of the hand beyond it is let slip.
    WorkspaceEdge = 0,
    /// The goal is as far ahead of the arm as it may be; what the hand does beyond is let slip.
    AheadOfArm = 1,
    /// The same of turns.
    TurnedAheadOfArm = 2,
    /// The hand was latched in this step: from now on the arm follows it from where it is.
    Latched = 3,
    /// The hand was somewhere else all at once, so that it was latched anew where it is now.
    HandJumped = 4,
    /// The hand is not measured but carried on by its past motion.
    Predicted = 5,
    /// The arm goes home, whatever the hand does.
    GoesHome = 6,
    /// The arm is home.
    AtHome = 7,
}

impl Note {
    /// Every note, in the order of their numbers.
    pub const ALL: [Self; 8] = [
        Self::WorkspaceEdge,
        Self::AheadOfArm,
        Self::TurnedAheadOfArm,
        Self::Latched,
        Self::HandJumped,
        Self::Predicted,
        Self::GoesHome,
        Self::AtHome,
    ];

    const fn bit(self) -> u8 {
        1 << self as u8
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::WorkspaceEdge => "at the edge of the workspace; move the hand back",
            Self::AheadOfArm => "the arm cannot keep up; move the hand slower",
            Self::TurnedAheadOfArm => "the arm cannot turn as fast; turn the hand slower",
            Self::Latched => "the arm follows the hand from here",
            Self::HandJumped => {
                "the hand was lost and found somewhere else; the arm follows it from where it is now"
            }
            Self::Predicted => "the hand is carried on by its past motion; show the balls to the cameras",
            Self::GoesHome => "the arm goes home while the button is held; the hand is not followed",
            Self::AtHome => "the arm is home; let go",
        })
    }
}

/// A set of [`Note`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Notes(u8);

impl Notes {
    /// A bit for each, as docs/wire.md lists them.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// The set that has these bits; those without a meaning are kept and mean nothing.
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// Whether a note is in the set.
    #[must_use]
    pub const fn contains(self, note: Note) -> bool {
        self.0 & note.bit() != 0
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The notes in the set, in the order of their numbers.
    pub fn iter(self) -> impl Iterator<Item = Note> {
        Note::ALL.into_iter().filter(move |note| self.contains(*note))
    }

    pub(crate) const fn add(&mut self, note: Note) {
        self.0 |= note.bit();
    }
}
