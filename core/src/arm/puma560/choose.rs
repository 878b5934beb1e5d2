//! Which of the solutions to follow, and when not to.
//!
//! The branch nearest to where the joints are bound at constant velocity, 2 q(k-1) - q(k-2): the one
//! nearest to the last joints goes wrong beside a singularity, where two branches come near to each
//! other while the joints pass from one side to the other.
//!
//! Nothing happens silently. Where following leads through a singularity, so that the arm then
//! stands otherwise (another [`Configuration`]), the caller must have allowed that kind of
//! [`Passages`]; where it would lead out of a joint's range or of what an operator has
//! [fixed](Fixed), it is refused. Taking another solution than the one that follows is a
//! [`ChangeKind::Jump`]: the joints move far for a small movement of the tool, and only
//! [`Policy::jump`] permits it. What happened is told in [`Choice::change`].

use super::inverse::Unreachable;
use super::joint_set::JointSet;
use super::model::{Joints, Puma560};
use super::posture::{Configuration, Elbow, Shoulder, Signs, Singularity, Wrist};
use super::turns::nearest_turn;
use crate::config::JOINTS;
use crate::geometry::Pose;
use crate::real::Real;
use core::fmt;

/// What an operator has fixed of the configuration; `None` leaves it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fixed {
    /// Right or left.
    pub shoulder: Option<Shoulder>,
    /// Up or down.
    pub elbow: Option<Elbow>,
    /// No-flip or flip.
    pub wrist: Option<Wrist>,
}

impl Fixed {
    /// All three.
    #[must_use]
    pub const fn all(configuration: Configuration) -> Self {
        Self {
            shoulder: Some(configuration.shoulder),
            elbow: Some(configuration.elbow),
            wrist: Some(configuration.wrist),
        }
    }

    /// Whether a configuration is as fixed.
    #[must_use]
    pub fn admits(self, configuration: Configuration) -> bool {
        self.shoulder.is_none_or(|shoulder| shoulder == configuration.shoulder)
            && self.elbow.is_none_or(|elbow| elbow == configuration.elbow)
            && self.wrist.is_none_or(|wrist| wrist == configuration.wrist)
    }
}

/// Some of the three singularities: through which the joints may pass, or do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Passages {
    /// The wrist's: q5 changes its sign.
    pub wrist: bool,
    /// The elbow's: it is bent the other way.
    pub elbow: bool,
    /// The shoulder's: the arm goes over to its other side.
    pub shoulder: bool,
}

impl Passages {
    /// Through all of them.
    pub const ALL: Self = Self { wrist: true, elbow: true, shoulder: true };

    /// The singularities between two configurations.
    fn between(from: Configuration, to: Configuration) -> Self {
        let (from, to): (Signs, Signs) = (from.signs(), to.signs());
        Self {
            wrist: from.wrist != to.wrist,
            elbow: from.elbow != to.elbow,
            shoulder: from.shoulder != to.shoulder,
        }
    }

    /// One of those in this set that are not in the other.
    fn beyond(self, other: Self) -> Option<Singularity> {
        if self.wrist && !other.wrist {
            Some(Singularity::Wrist)
        } else if self.elbow && !other.elbow {
            Some(Singularity::Elbow)
        } else if self.shoulder && !other.shoulder {
            Some(Singularity::Shoulder)
        } else {
            None
        }
    }
}

/// What the caller allows. By default nothing but to follow in the same configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Policy {
    /// What the configuration must be.
    pub fixed: Fixed,
    /// Singularities through which the joints may pass.
    pub passages: Passages,
    /// Where following is not possible: whether the nearest solution that is in range and as fixed is
    /// given instead. The joints then move far; whoever asks for it moves them there slowly.
    pub jump: bool,
}

/// Where the joints were, the newest first: what is needed to follow them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recent<T> {
    last: Joints<T>,
    before: Option<Joints<T>>,
    configuration: Configuration,
}

impl<T: Real> Recent<T> {
    /// An arm at rest.
    #[must_use]
    pub fn at_rest(arm: &Puma560<T>, joints: &Joints<T>) -> Self {
        Self { last: *joints, before: None, configuration: arm.configuration(joints) }
    }

    /// One step later, as long after the last joints as those after the ones before. Not across a
    /// jump: the arm is moved there by other means, and starts [at rest](Self::at_rest).
    pub fn push(&mut self, arm: &Puma560<T>, joints: &Joints<T>) {
        self.configuration = arm.singularities(joints).configuration(self.configuration);
        self.before = Some(self.last);
        self.last = *joints;
    }

    /// The last joints.
    #[must_use]
    pub const fn last(&self) -> &Joints<T> {
        &self.last
    }

    /// How the arm stands; at a singularity, how it stood before it came there.
    #[must_use]
    pub const fn configuration(&self) -> Configuration {
        self.configuration
    }

    /// Where the joints are next at constant velocity.
    #[must_use]
    pub fn predicted(&self) -> Joints<T> {
        let mut predicted = self.last;
        if let Some(before) = &self.before {
            for (angle, before) in predicted.iter_mut().zip(before) {
                *angle += *angle - *before;
            }
        }
        predicted
    }
}

/// How the configuration, or whole turns of a joint, changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChangeKind {
    /// The joints go on as they did, through a singularity.
    Passage,
    /// They do not go on: another solution is taken, or another turn of a joint.
    Jump,
}

/// What the caller has to know about a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Change {
    /// How the arm stood.
    pub from: Configuration,
    /// How it will.
    pub to: Configuration,
    /// Through a singularity, or by a jump.
    pub kind: ChangeKind,
}

/// The joints to go to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice<T> {
    /// The angles.
    pub joints: Joints<T>,
    /// How the arm then stands.
    pub configuration: Configuration,
    /// What is not as before; `None` in an ordinary step.
    pub change: Option<Change>,
}

/// Why no joints are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ChooseRefusal {
    /// No joints bring the tool there.
    Unreachable(Unreachable),
    /// Following would take these joints out of their ranges, or farther out.
    OutsideRange(JointSet),
    /// Following would lead through a singularity that is not allowed.
    Passage {
        /// Which one.
        singularity: Singularity,
        /// How the arm stands.
        from: Configuration,
        /// How it would.
        to: Configuration,
    },
    /// In the fixed configuration the arm does not follow: it stands otherwise, or would.
    NotAsFixed {
        /// How the arm stands.
        from: Configuration,
        /// How it would.
        to: Configuration,
    },
    /// A jump is allowed, but in no solution that is as fixed are all joints in their ranges.
    NowhereToJump,
}

impl fmt::Display for ChooseRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreachable(reason) => reason.fmt(f),
            Self::OutsideRange(joints) => write!(f, "the pose would take {joints} out of range"),
            Self::Passage { singularity, from, to } => {
                let name = match singularity {
                    Singularity::Wrist => "wrist",
                    Singularity::Elbow => "elbow",
                    Singularity::Shoulder => "shoulder",
                };
                let (from, to) = (from.code(), to.code());
                write!(
                    f,
                    "the pose leads through the {name}'s singularity ({from} to {to}); allow that passage"
                )
            }
            Self::NotAsFixed { from, to } => {
                let (from, to) = (from.code(), to.code());
                write!(
                    f,
                    "the arm would not stand as fixed ({from}, then {to}); fix another configuration or allow a jump"
                )
            }
            Self::NowhereToJump => {
                f.write_str("no configuration that is allowed reaches the pose with all joints in range")
            }
        }
    }
}

impl core::error::Error for ChooseRefusal {}

impl From<Unreachable> for ChooseRefusal {
    fn from(reason: Unreachable) -> Self {
        Self::Unreachable(reason)
    }
}

impl<T: Real> Puma560<T> {
    /// The joints that bring the tool to `base_from_tool`, following `recent`. In the precision in which
    /// the pose is told, as [`Self::inverse`].
    ///
    /// Joints that are outside their range already may stay where they are or come back, not go
    /// farther out.
    ///
    /// # Errors
    /// [`ChooseRefusal`]; the arm then stays where it is, and any other pose may be asked for.
    pub fn choose<P: Real>(
        &self,
        base_from_tool: &Pose<P>,
        recent: &Recent<T>,
        policy: &Policy,
    ) -> Result<Choice<T>, ChooseRefusal> {
        let predicted = recent.predicted();
        let mut nearest = Nearest::none(recent.last);
        self.solve(base_from_tool, &predicted, |_, joints| {
            nearest.offer(joints, distance(joints, &predicted));
        })?;
        let joints = self.carried(&nearest.joints, &predicted);
        let from = recent.configuration;
        let to = self.singularities(&joints).configuration(from);
        match self.obstacle(&joints, to, recent, policy) {
            None => {
                let change = (from != to).then_some(Change { from, to, kind: ChangeKind::Passage });
                Ok(Choice { joints, configuration: to, change })
            }
            Some(_) if policy.jump => self.jump(base_from_tool, recent, policy.fixed),
            Some(refusal) => Err(refusal),
        }
    }

    /// Why following to these joints is refused.
    fn obstacle(
        &self,
        joints: &Joints<T>,
        to: Configuration,
        recent: &Recent<T>,
        policy: &Policy,
    ) -> Option<ChooseRefusal> {
        let mut farther_out = [false; JOINTS];
        let places = farther_out.iter_mut().zip(joints).zip(&recent.last).zip(&self.ranges);
        for (((farther_out, angle), last), range) in places {
            *farther_out = range.excess(*angle) > range.excess(*last) + T::SLACK;
        }
        let farther_out = JointSet::from_flags(farther_out);
        if !farther_out.is_empty() {
            return Some(ChooseRefusal::OutsideRange(farther_out));
        }
        let from = recent.configuration;
        if !policy.fixed.admits(to) {
            return Some(ChooseRefusal::NotAsFixed { from, to });
        }
        let singularity = Passages::between(from, to).beyond(policy.passages)?;
        Some(ChooseRefusal::Passage { singularity, from, to })
    }

    /// The solution nearest to the last joints of those that are in range and as fixed.
    fn jump<P: Real>(
        &self,
        base_from_tool: &Pose<P>,
        recent: &Recent<T>,
        fixed: Fixed,
    ) -> Result<Choice<T>, ChooseRefusal> {
        let mut nearest = Nearest::none(recent.last);
        let mut to = None;
        self.solve(base_from_tool, &recent.last, |configuration, joints| {
            let (joints, outside) = self.fit(joints, &recent.last);
            if outside.is_empty()
                && fixed.admits(configuration)
                && nearest.offer(&joints, straight_distance(&joints, &recent.last))
            {
                to = Some(configuration);
            }
        })?;
        let to = to.ok_or(ChooseRefusal::NowhereToJump)?;
        let change = Change { from: recent.configuration, to, kind: ChangeKind::Jump };
        Ok(Choice { joints: nearest.joints, configuration: to, change: Some(change) })
    }
}

/// The nearest joints so far.
struct Nearest<T> {
    joints: Joints<T>,
    distance: Option<T>,
}

impl<T: Real> Nearest<T> {
    const fn none(joints: Joints<T>) -> Self {
        Self { joints, distance: None }
    }

    /// Takes the joints if they are nearer; whether they were.
    fn offer(&mut self, joints: &Joints<T>, distance: T) -> bool {
        let nearer = self.distance.is_none_or(|least| distance < least);
        if nearer {
            *self = Self { joints: *joints, distance: Some(distance) };
        }
        nearer
    }
}

/// The squared distance between two joint vectors, whole turns aside, rad^2.
fn distance<T: Real>(a: &Joints<T>, b: &Joints<T>) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (a, b)| {
        let off = nearest_turn(*a, *b) - *b;
        sum + off * off
    })
}

/// The squared distance that the joints have to go, rad^2.
fn straight_distance<T: Real>(a: &Joints<T>, b: &Joints<T>) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + (*a - *b) * (*a - *b))
}
