//! What the law is told of the arm, and what it decides.

use super::command::{BadCommand, is_rotation};
use super::status::{FaultReason, Notes, Status};
use crate::geometry::Pose;
use crate::real::Real;
use core::fmt;

/// The farthest place that is believed of an arm, metres.
const MAX_PLACE_M: f64 = 1000.0;

/// Whether the arm may be moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ArmCondition {
    /// Enabled, and it does what it is told.
    Ready,
    /// Not enabled, or its controller is not ready.
    #[default]
    NotReady,
    /// It reports a fault, or cannot be reached.
    Fault,
    /// It cannot start where it is: a joint is far outside its range, or its place is no number.
    CannotStart,
    /// It is not where it was sent.
    Astray,
    /// Its joints cannot be read.
    Blind,
}

/// The arm as it is now. Poses of the tool in the robot's base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmView<T> {
    /// Where the joints are measured to be: only `paper` mode moves from there.
    pub measured: Pose<T>,
    /// Where it was last sent: what the joints were last told, after all limits.
    pub set_point: Pose<T>,
    /// Whether it may be moved.
    pub condition: ArmCondition,
}

impl<T: Real> ArmView<T> {
    /// Whether the arm is in order, and what is known of it.
    ///
    /// # Errors
    /// The reason where it is not.
    pub(super) fn check(&self) -> Result<(), FaultReason> {
        match self.condition {
            ArmCondition::Ready => {}
            ArmCondition::NotReady => return Err(FaultReason::ArmNotReady),
            ArmCondition::Fault => return Err(FaultReason::Arm),
            ArmCondition::CannotStart => return Err(FaultReason::ArmCannotStart),
            ArmCondition::Astray => return Err(FaultReason::ArmAstray),
            ArmCondition::Blind => return Err(FaultReason::ArmBlind),
        }
        for pose in [&self.measured, &self.set_point] {
            check_pose(pose).map_err(|bad| match bad {
                BadCommand::NotFinite => FaultReason::ArmPoseNotFinite,
                BadCommand::NotARotation => FaultReason::ArmPoseNotARotation,
            })?;
        }
        Ok(())
    }
}

fn check_pose<T: Real>(pose: &Pose<T>) -> Result<(), BadCommand> {
    let most = T::of(MAX_PLACE_M);
    if !pose.translation.iter().all(|x| x.abs() <= most) || !pose.rotation.iter().all(|x| x.is_finite()) {
        Err(BadCommand::NotFinite)
    } else if is_rotation(&pose.rotation) {
        Ok(())
    } else {
        Err(BadCommand::NotARotation)
    }
}

/// What the arm shall do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order<T> {
    /// Go to this pose of the tool in the robot's base.
    Follow(Pose<T>),
    /// Go home, slowly, by whatever way there is ([`crate::config::GovernorConfig::home_rad`]).
    Home,
    /// Come to rest, within the limits of speed, acceleration and jerk, and stay.
    Stop,
}

impl<T> Order<T> {
    /// Where to go; `None` to stop, and home, which the limits know.
    pub const fn goal(&self) -> Option<&Pose<T>> {
        match self {
            Self::Follow(goal) => Some(goal),
            Self::Home | Self::Stop => None,
        }
    }
}

/// How well the goal is known: standard deviations, scaled like the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty<T> {
    /// Of the place, metres: the root of the summed variances along the three axes.
    pub place_m: T,
    /// Of the orientation, radians: likewise.
    pub turn_rad: T,
}

/// What is decided for one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision<T> {
    /// What the arm shall do.
    pub order: Order<T>,
    /// State and reason.
    pub status: Status,
    /// What limits the following.
    pub notes: Notes,
    /// How well the goal is known; `None` while stopped, and where the sender does not say.
    pub uncertainty: Option<Uncertainty<T>>,
    /// Metres of the tool for one of the hand: of the press that is on, or of the next.
    pub scale: T,
    /// How old the newest command is on this receiver's clock, microseconds; `None` before the first.
    pub command_age_us: Option<u64>,
}

/// Why a reset was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ResetRefusal {
    /// Hold-to-run is pressed.
    Pressed,
    /// Nothing has been heard of hold-to-run for longer than its timeout.
    NoHoldToRun,
    /// The arm, or what is known of it, is not in order.
    Arm(FaultReason),
}

impl fmt::Display for ResetRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Pressed => f.write_str("no reset while hold-to-run is pressed; let go of it first"),
            Self::NoHoldToRun => f.write_str(
                "no reset while hold-to-run is not heard; check the pedal or button and its cable",
            ),
            Self::Arm(reason) => write!(f, "no reset: {reason}"),
        }
    }
}

impl core::error::Error for ResetRefusal {}
