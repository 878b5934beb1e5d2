//! What limits the arm: "why am I slow?". Each text says what to do about it.

use crate::config::JOINTS;
use core::fmt;

/// A joint's number as its maker counts: 1 to 6.
pub type JointNumber = u8;

/// What limits the following of the goal in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Limit {
    /// The goal has numbers that are not finite.
    GoalNotFinite,
    /// The goal's rotation is not orthonormal and right-handed.
    GoalNotARotation,
    /// The goal is beyond the workspace, or the tool is kept from leaving it.
    WorkspaceEdge,
    /// The goal is farther than the arm reaches.
    TooFar,
    /// The goal is nearer to the shoulder than the folded arm, or beside the first axis.
    TooNear,
    /// The goal would take this joint beyond its range.
    JointRange(JointNumber),
    /// This joint is slowed on its way to its lower limit.
    NearLowerLimit(JointNumber),
    /// The same of its upper limit.
    NearUpperLimit(JointNumber),
    /// This joint is outside its range; it may only come back.
    OutsideRange(JointNumber),
    /// Near the wrist's singularity.
    WristSingularity,
    /// Near the elbow's: stretched or folded.
    ElbowSingularity,
    /// Near the shoulder's: the wrist is beside the first axis.
    ShoulderSingularity,
    /// The straight way leads where the arm cannot go: it goes straight in its joints instead.
    AnotherWay,
    /// The tool is as fast as it may be.
    ToolSpeed,
    /// This joint is as fast as it may be, and the others wait for it.
    JointSpeed(JointNumber),
    /// This joint gathers or loses speed as fast as it may.
    JointAcceleration(JointNumber),
    /// The hand is not known well.
    HandUncertain,
    /// The arm was told to stop and comes to rest.
    Stopping,
}

const JOINT: u32 = JOINTS as u32;

/// Where each kind's first bit is.
mod first {
    use super::JOINT;
    pub(super) const RANGE: u32 = 16;
    pub(super) const LOWER: u32 = RANGE + JOINT;
    pub(super) const UPPER: u32 = LOWER + JOINT;
    pub(super) const OUTSIDE: u32 = UPPER + JOINT;
    pub(super) const SPEED: u32 = OUTSIDE + JOINT;
    pub(super) const ACCELERATION: u32 = SPEED + JOINT;
    pub(super) const END: u32 = ACCELERATION + JOINT;
}

impl Limit {
    const WITHOUT_JOINT: [Self; 12] = [
        Self::GoalNotFinite,
        Self::GoalNotARotation,
        Self::WorkspaceEdge,
        Self::TooFar,
        Self::TooNear,
        Self::WristSingularity,
        Self::ElbowSingularity,
        Self::ShoulderSingularity,
        Self::AnotherWay,
        Self::ToolSpeed,
        Self::HandUncertain,
        Self::Stopping,
    ];

    /// A word for files and reports, without the joint.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::GoalNotFinite => "goal_not_finite",
            Self::GoalNotARotation => "goal_not_a_rotation",
            Self::WorkspaceEdge => "workspace_edge",
            Self::TooFar => "too_far",
            Self::TooNear => "too_near",
            Self::JointRange(_) => "joint_range",
            Self::NearLowerLimit(_) => "near_lower_limit",
            Self::NearUpperLimit(_) => "near_upper_limit",
            Self::OutsideRange(_) => "outside_range",
            Self::WristSingularity => "wrist_singularity",
            Self::ElbowSingularity => "elbow_singularity",
            Self::ShoulderSingularity => "shoulder_singularity",
            Self::AnotherWay => "another_way",
            Self::ToolSpeed => "tool_speed",
            Self::JointSpeed(_) => "joint_speed",
            Self::JointAcceleration(_) => "joint_acceleration",
            Self::HandUncertain => "hand_uncertain",
            Self::Stopping => "stopping",
        }
    }

    /// Which joint, where one is meant.
    #[must_use]
    pub const fn joint(self) -> Option<JointNumber> {
        match self {
            Self::JointRange(n)
            | Self::NearLowerLimit(n)
            | Self::NearUpperLimit(n)
            | Self::OutsideRange(n)
            | Self::JointSpeed(n)
            | Self::JointAcceleration(n) => Some(n),
            _ => None,
        }
    }

    /// The place in the set; `None` for a joint that there is not.
    const fn place(self) -> Option<u32> {
        let first = match self {
            Self::GoalNotFinite => return Some(0),
            Self::GoalNotARotation => return Some(1),
            Self::WorkspaceEdge => return Some(2),
            Self::TooFar => return Some(3),
            Self::TooNear => return Some(4),
            Self::WristSingularity => return Some(5),
            Self::ElbowSingularity => return Some(6),
            Self::ShoulderSingularity => return Some(7),
            Self::AnotherWay => return Some(8),
            Self::ToolSpeed => return Some(9),
            Self::HandUncertain => return Some(10),
            Self::Stopping => return Some(11),
            Self::JointRange(_) => first::RANGE,
            Self::NearLowerLimit(_) => first::LOWER,
            Self::NearUpperLimit(_) => first::UPPER,
            Self::OutsideRange(_) => first::OUTSIDE,
            Self::JointSpeed(_) => first::SPEED,
            Self::JointAcceleration(_) => first::ACCELERATION,
        };
        match self.joint() {
            Some(number) if number >= 1 && number as u32 <= JOINT => Some(first + number as u32 - 1),
            _ => None,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GoalNotFinite => {
                f.write_str("refused: the goal is not made of finite numbers; check the operator station")
            }
            Self::GoalNotARotation => {
                f.write_str("refused: the goal has no proper rotation; check the operator station")
            }
            Self::WorkspaceEdge => f.write_str("at the edge of the workspace; move the hand back"),
            Self::TooFar => f.write_str("out of reach: too far; move the hand back"),
            Self::TooNear => f.write_str("out of reach: too near to the arm's own base; move the hand away"),
            Self::JointRange(n) => write!(f, "out of reach: joint {n} would leave its range; move back"),
            Self::NearLowerLimit(n) => write!(f, "slowed: joint {n} is near its lower limit; move back"),
            Self::NearUpperLimit(n) => write!(f, "slowed: joint {n} is near its upper limit; move back"),
            Self::OutsideRange(n) => write!(f, "joint {n} is outside its range and may only come back"),
            Self::WristSingularity => {
                f.write_str("slowed: wrist singularity (joints 4 and 6 in line); turn the tool away")
            }
            Self::ElbowSingularity => {
                f.write_str("slowed: elbow singularity (the arm is stretched or folded); move back")
            }
            Self::ShoulderSingularity => {
                f.write_str("slowed: shoulder singularity (the wrist is beside joint 1); move outwards")
            }
            Self::AnotherWay => {
                f.write_str("the straight way is barred; the tool goes another way, keep clear of it")
            }
            Self::ToolSpeed => f.write_str("slowed: the tool is as fast as it may be"),
            Self::JointSpeed(n) => write!(f, "slowed: joint {n} is as fast as it may be"),
            Self::JointAcceleration(n) => {
                write!(f, "slowed: joint {n} gathers or loses speed as fast as it may")
            }
            Self::HandUncertain => {
                f.write_str("slowed: the hand is not seen well; show the balls to the cameras")
            }
            Self::Stopping => f.write_str("stopping"),
        }
    }
}

/// A set of [`Limit`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits(u64);

impl Limits {
    /// None.
    pub const NONE: Self = Self(0);

    /// A bit for each, as docs/wire.md lists them.
    #[must_use]
    pub const fn bits(self) -> u64 {
        self.0
    }

    /// The set that has these bits; those without a meaning are kept and mean nothing.
    #[must_use]
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// Whether it is in the set.
    #[must_use]
    pub const fn contains(self, limit: Limit) -> bool {
        match limit.place() {
            Some(place) => self.0 & (1 << place) != 0,
            None => false,
        }
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Those in the set: what keeps the goal from being reached first, what slows after it.
    pub fn iter(self) -> impl Iterator<Item = Limit> {
        let kinds: [fn(JointNumber) -> Limit; 6] = [
            Limit::JointRange,
            Limit::OutsideRange,
            Limit::NearLowerLimit,
            Limit::NearUpperLimit,
            Limit::JointSpeed,
            Limit::JointAcceleration,
        ];
        let of_joints = kinds.into_iter().flat_map(|kind| (1..=JOINTS as JointNumber).map(kind));
        Limit::WITHOUT_JOINT.into_iter().chain(of_joints).filter(move |limit| self.contains(*limit))
    }

    /// Those of either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(super) const fn add(&mut self, limit: Limit) {
        if let Some(place) = limit.place() {
            self.0 |= 1 << place;
        }
    }
}

const _: () = assert!(first::END <= u64::BITS, "the set is a u64");

/// The texts, ` / ` between them; nothing for an empty set.
impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (place, limit) in self.iter().enumerate() {
            if place > 0 {
                f.write_str(" / ")?;
            }
            limit.fmt(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use std::string::ToString;
    use std::vec::Vec;

    #[test]
    fn every_limit_has_a_place_a_name_and_a_text_of_its_own() {
        let all: Vec<Limit> = Limits(u64::MAX).iter().collect();
        assert_eq!(all.len(), 12 + 6 * 6);
        let places: HashSet<_> = all.iter().map(|limit| limit.place()).collect();
        let texts: HashSet<_> = all.iter().map(ToString::to_string).collect();
        assert_eq!((places.len(), texts.len()), (all.len(), all.len()));
        for limit in all {
            let mut one = Limits::NONE;
            one.add(limit);
            assert_eq!(one.iter().collect::<Vec<_>>(), [limit]);
        }
    }

    #[test]
    fn a_joint_that_there_is_not_is_in_no_set() {
        let mut set = Limits::NONE;
        set.add(Limit::JointSpeed(0));
        set.add(Limit::JointRange(7));
        assert!(set.is_empty() && !Limits(u64::MAX).contains(Limit::JointSpeed(7)));
    }

    #[test]
    fn a_set_tells_its_texts() {
        let mut set = Limits::NONE;
        set.add(Limit::NearUpperLimit(3));
        set.add(Limit::ToolSpeed);
        assert_eq!(
            set.to_string(),
            "slowed: the tool is as fast as it may be / slowed: joint 3 is near its upper limit; move back"
        );
    }
}
