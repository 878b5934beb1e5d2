//! The slave's answer: where the arm is, what it is told, and why it does not do what the hand does.
//!
//! Plain numbers, like every packet: the law and the governor, whose words these are, come later on the
//! path and turn theirs into these.

use super::BadValue;
use super::packet::{BYTE, F32, MAX_U32, MAX_U64, Transform};
use crate::config::JOINTS;
use serde::{Deserialize, Serialize};

/// The law's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmState {
    /// Latched: it takes a reset.
    Stopped,
    /// At rest, waiting for a fresh press.
    Armed,
    /// The arm follows the hand.
    Engaged,
    /// Engaged, but nothing may be followed now.
    Hold,
    /// Latched like a stop: the arm, or what is known of it, is not in order.
    Fault,
}

impl ArmState {
    /// Every state, in the order of their numbers.
    pub const ALL: [Self; 5] = [Self::Stopped, Self::Armed, Self::Engaged, Self::Hold, Self::Fault];
}

/// Why the law is in its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmReason {
    /// There is nothing to say: the arm follows.
    None,
    /// Stopped: nobody has released it since the start.
    Started,
    /// Stopped: somebody asked for it.
    Asked,
    /// Stopped: commands of two senders came at one time.
    TwoSenders,
    /// Fault: the arm is not enabled, or its controller is not ready.
    ArmNotReady,
    /// Fault: the arm reports one.
    Arm,
    /// Fault: the arm cannot start where its joints are.
    ArmCannotStart,
    /// Fault: the arm is not where it was sent.
    ArmAstray,
    /// Fault: the arm's joints cannot be read.
    ArmBlind,
    /// Fault: a pose that is said to be the arm's cannot be one.
    ArmPose,
    /// Fault: the slave's clock went back.
    ClockWentBack,
    /// Hold: no fresh motion.
    NoCommand,
    /// Hold: the operator's button is not heard.
    NoHoldToRun,
    /// Hold: the newest motion cannot be used.
    BadCommand,
    /// Hold: the hand is not seen.
    HandNotSeen,
    /// Hold: the hand has only been predicted for too long.
    HandNotMeasured,
    /// Armed: it takes a press.
    Press,
    /// Armed: it takes the hand to be engaged.
    Engage,
    /// Armed: it takes a release and a press, for what was pressed is not fresh any more.
    LetGo,
    /// Armed: it takes a release and a press, for the sender of motion has changed.
    NewSender,
    /// Stopped: the arm's port refused a set-point.
    SetPointRefused,
    /// Armed: it takes a release and a press, for the press went on for something else.
    PressChanged,
}

impl ArmReason {
    /// Every reason, in the order of their numbers.
    pub const ALL: [Self; 22] = [
        Self::None,
        Self::Started,
        Self::Asked,
        Self::TwoSenders,
        Self::ArmNotReady,
        Self::Arm,
        Self::ArmCannotStart,
        Self::ArmAstray,
        Self::ArmBlind,
        Self::ArmPose,
        Self::ClockWentBack,
        Self::NoCommand,
        Self::NoHoldToRun,
        Self::BadCommand,
        Self::HandNotSeen,
        Self::HandNotMeasured,
        Self::Press,
        Self::Engage,
        Self::LetGo,
        Self::NewSender,
        Self::SetPointRefused,
        Self::PressChanged,
    ];
}

/// What became of the goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmVerdict {
    /// It is gone to as it was asked.
    Pass,
    /// It is gone to slower, by another way, or only as near as the arm can.
    Clamp,
    /// It cannot be used; the arm comes to rest.
    Reject,
}

impl ArmVerdict {
    /// Every verdict, in the order of their numbers.
    pub const ALL: [Self; 3] = [Self::Pass, Self::Clamp, Self::Reject];
}

/// How the arm's controller stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControllerState {
    /// Connected, without power on the joints.
    Disabled,
    /// Being switched on.
    Enabling,
    /// It does not know where its joints are.
    NotHomed,
    /// Set-points are followed.
    Ready,
    /// At rest or coming to rest until it is enabled again.
    Stopped,
    /// It reports a fault.
    Fault {
        /// Which joint's drive, 1 to 6; 0 for the controller as a whole.
        joint: u8,
        /// The controller's own number.
        code: u32,
    },
    /// It does not answer.
    Lost,
}

impl ControllerState {
    const MAX_LEN: usize = BYTE + BYTE + MAX_U32;
}

/// Where the joints were measured to be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MeasuredJoints {
    /// Radians, from base to wrist.
    pub joints: [f32; JOINTS],
    /// How old the reading was at `time_us`, microseconds.
    pub age_us: u32,
}

impl MeasuredJoints {
    const MAX_LEN: usize = JOINTS * F32 + MAX_U32;
}

/// The newest motion the arm was moved by, and when it passed each stage of the slave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CommandEcho {
    /// The motion's session.
    pub session: u32,
    /// The motion's sequence.
    pub sequence: u32,
    /// When it came, on the slave's clock, microseconds.
    pub received_us: u64,
    /// Microseconds from then until the joints to go to were known.
    pub solved_after_us: u32,
    /// Microseconds from then until they were written to the arm's port.
    pub written_after_us: u32,
}

impl CommandEcho {
    const MAX_LEN: usize = 2 * MAX_U32 + MAX_U64 + 2 * MAX_U32;
}

/// The newest motion whose goal the arm has reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settled {
    /// The motion's sequence; its session is that of `command`.
    pub sequence: u32,
    /// Microseconds from when it came until the measured joints had reached its goal.
    pub after_us: u32,
}

impl Settled {
    const MAX_LEN: usize = 2 * MAX_U32;
}

/// Where the arm is, and why. The slave sends it again and again, whether or not anything moves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ArmStatePacket {
    /// Chosen anew each time the sender starts, so that old packets are not taken for new ones.
    pub session: u32,
    /// Counts the packets from 0, and wraps.
    pub sequence: u32,
    /// When this was so, on the slave's clock, microseconds.
    pub time_us: u64,
    /// The law's state.
    pub state: ArmState,
    /// Why it is in it.
    pub reason: ArmReason,
    /// What limits or changes the following of the hand: a bit for each note of the law.
    pub notes: u8,
    /// What became of the goal.
    pub verdict: ArmVerdict,
    /// What limits the arm: a bit for each limit of the governor.
    pub limits: u64,
    /// How fast the tool is asked to be, of what its own speed limit allows: 0 to 1.
    pub speed_share: f32,
    /// How the arm's controller stands.
    pub controller: ControllerState,
    /// Where the joints were measured to be; `None` before the first reading.
    pub measured: Option<MeasuredJoints>,
    /// What the joints were told last, radians.
    pub set_point: [f32; JOINTS],
    /// Where the tool is there: base_from_tool.
    pub tool: Transform,
    /// The newest motion that was used; `None` before the first.
    pub command: Option<CommandEcho>,
    /// The newest motion whose goal the measured joints have reached; `None` before the first of the
    /// session.
    pub settled: Option<Settled>,
    /// How long ago the state of the operator's button was heard, microseconds; `None`: never.
    pub buttons_age_us: Option<u32>,
    /// Metres of the tool for one of the hand: of the press that is on, or of the next.
    pub scale: f32,
}

impl ArmStatePacket {
    /// The most bytes the fields take.
    pub const MAX_LEN: usize = 2 * MAX_U32
        + MAX_U64
        + 4 * BYTE
        + MAX_U64
        + F32
        + ControllerState::MAX_LEN
        + BYTE
        + MeasuredJoints::MAX_LEN
        + JOINTS * F32
        + Transform::MAX_LEN
        + BYTE
        + CommandEcho::MAX_LEN
        + BYTE
        + Settled::MAX_LEN
        + BYTE
        + MAX_U32
        + F32;

    /// How old the newest motion was at `time_us`, by the slave's own clock, microseconds.
    #[must_use]
    pub fn command_age_us(&self) -> Option<u64> {
        self.command.map(|command| self.time_us.saturating_sub(command.received_us))
    }

    pub(super) fn check(&self) -> Result<(), BadValue> {
        let measured = self.measured.as_ref().map_or(&[][..], |measured| &measured.joints);
        if !self.set_point.iter().chain(measured).all(|angle| angle.is_finite()) {
            return Err(BadValue::NotFinite);
        }
        if !(0.0..=1.0).contains(&self.speed_share) {
            return Err(BadValue::NotAShare);
        }
        if !self.scale.is_finite() {
            return Err(BadValue::NotFinite);
        }
        self.tool.check()
    }
}
