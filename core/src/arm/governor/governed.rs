//! What the governor says.

use super::limits::Limits;
#[cfg(doc)]
use crate::arm::puma560::ChangeKind;
use crate::arm::puma560::{Change, JointSet, Joints};
use crate::geometry::Pose;
use core::fmt;

/// What became of the goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// It is gone to as it was asked. Also that of a stop.
    Pass,
    /// It is gone to slower, by another way, or only as near as the arm can: see
    /// [`Governed::limits`].
    Clamp,
    /// It cannot be used; the arm comes to rest.
    Reject,
}

/// What the governor says in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governed<T> {
    /// Where the joints shall be at the end of the cycle, radians.
    pub set_point: Joints<T>,
    /// Where the tool is there: `base_from_tool`.
    pub pose: Pose<T>,
    /// What became of the goal.
    pub verdict: Verdict,
    /// What limits: "why am I slow?".
    pub limits: Limits,
    /// How fast the tool is asked to be, beside how fast it might be if only its own speed limited
    /// it; 0 while stopping.
    pub speed_share: T,
    /// The posture changed in this cycle: the joints went through a singularity on the straight way, or
    /// on the way by the joints ([`ChangeKind::Jump`]; even then they go there within all limits).
    pub change: Option<Change>,
    /// Every joint is told to be where it was told to be before.
    pub at_rest: bool,
    /// And the tool is home.
    pub at_home: bool,
}

/// Why the arm is not moved from where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartRefusal {
    /// The angles of these joints are not finite numbers.
    NotFinite(JointSet),
    /// These joints are farther outside their range than is believed.
    OutsideRange(JointSet),
}

impl fmt::Display for StartRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(joints) => {
                write!(f, "{joints}: the angle measured is not a finite number; check the encoders")
            }
            Self::OutsideRange(joints) => write!(
                f,
                "{joints}: far outside the range; check homing and the ranges, or move the arm back by hand"
            ),
        }
    }
}

impl core::error::Error for StartRefusal {}
