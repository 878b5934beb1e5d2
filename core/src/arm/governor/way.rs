//! Which way the joints go to the goal.
//!
//! 1. Straight: the next piece of the straight way of the tool, solved in closed form, by the branch that
//!    follows. The goal itself where it is near.
//! 2. By the joints: where the straight way is barred (a joint's end, a singularity that may not be
//!    passed, a place out of reach) but the goal is not: straight in the joints. Between two joint
//!    vectors in range every other is in range, so this way is always open: whoever asks for a pose
//!    where the arm came from gets there.
//! 3. As near as it goes: damped least squares, where the goal is not to be reached.

use super::axis::Span;
use super::goal::Left;
use super::least_squares;
use super::limits::{Limit, Limits};
use crate::arm::puma560::{
    ChooseRefusal, Configuration, Fixed, Jacobian, Joints, Passages, Policy, Puma560, Recent, Unreachable,
};
use crate::config::{AllowedPassages, JOINTS, JointConfig};
use crate::geometry::Pose;
use crate::real::Real;

/// A piece of the straight way is at most what the tool may do in a cycle, and this turn, radians a
/// second.
const TURN_RAD_S: f64 = 2.0;

/// How far a joint with a range of more than a turn may have to go by the joints' way, radians: less than
/// the whole turn by which it would be wound back. The others have no other turn.
const FARTHEST_RAD: f64 = 5.2;

/// The joints' way is at its end when no joint has farther to go, radians.
const NEARLY_RAD: f64 = 0.05;

/// How the way was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Straight,
    ByJoints,
    AsNearAsItGoes,
}

/// Where the joints go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Way<T> {
    /// What is left of the way, as far as it can be told from its next piece, radians.
    pub(super) left: Joints<T>,
    /// Whether it ends at the goal itself, not at a piece of the way.
    pub(super) to_the_end: bool,
    pub(super) kind: Kind,
}

impl<T: Real> Way<T> {
    /// Whether no joint has far to go any more.
    pub(super) fn is_nearly_gone(&self) -> bool {
        self.left.iter().all(|left| left.abs() <= T::of(NEARLY_RAD))
    }
}

/// What does not change from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ways<T> {
    pub(super) arm: Puma560<T>,
    /// How far the tool may go in a cycle, metres, and turn, radians.
    piece_m: T,
    piece_rad: T,
}

/// How the arm stands and where it shall go.
pub(super) struct Situation<'a, T> {
    pub(super) recent: &'a Recent<T>,
    pub(super) pose: &'a Pose<T>,
    pub(super) jacobian: &'a Jacobian<T>,
    pub(super) spans: &'a [Span<T>; JOINTS],
    pub(super) goal: &'a Pose<T>,
    /// The posture that is kept, and what of it may change on the straight way.
    pub(super) posture: Configuration,
    pub(super) passages: AllowedPassages,
    /// Whether the joints' way was taken up and is not at its end yet.
    pub(super) by_joints: bool,
    /// By way of these, if so.
    pub(super) via: Option<Joints<T>>,
    /// Whether a joint may be wound back by about a turn.
    pub(super) winds_back: bool,
}

impl<T: Real> Ways<T> {
    pub(super) fn new(arm: &Puma560<T>, tool_speed: T, cycle: T) -> Self {
        Self { arm: *arm, piece_m: tool_speed * cycle, piece_rad: T::of(TURN_RAD_S) * cycle }
    }

    pub(super) fn choose(&self, now: &Situation<'_, T>, limits: &mut Limits) -> Way<T> {
        let left = Left::between(now.pose, now.goal);
        let pieces = (left.place.norm() / self.piece_m).max(left.turn.norm() / self.piece_rad);
        let to_the_end = pieces <= T::one();
        let joints = now.recent.last();
        let policy = now.policy();
        let mut refusal = None;
        if !now.by_joints {
            let pieces = pieces.max(T::one());
            let next = if to_the_end { *now.goal } else { left.along(now.pose, T::one() / pieces) };
            match self.arm.choose(&next, now.recent, &policy) {
                Ok(choice) => {
                    let left = difference(&choice.joints, joints).map(|way| way * pieces);
                    return Way { left, to_the_end, kind: Kind::Straight };
                }
                Err(reason) => refusal = Some(reason),
            }
        }
        if let Some(target) = self.solution(now.goal, now.recent, now.posture, now.winds_back) {
            let left = difference(&now.via.unwrap_or(target), joints);
            let mut way = Way { left, to_the_end: false, kind: Kind::ByJoints };
            way.to_the_end = now.via.is_none() && way.is_nearly_gone();
            if !way.to_the_end {
                limits.add(Limit::AnotherWay);
            }
            return way;
        }
        // the way by the joints may end where the goal moved out of reach
        let refusal = refusal.or_else(|| self.arm.choose(now.goal, now.recent, &policy).err());
        tell(refusal, now.posture, limits);
        let left = least_squares::approach(now.jacobian, &left, joints, now.spans);
        Way { left, to_the_end: false, kind: Kind::AsNearAsItGoes }
    }

    /// The joints that bring the tool to the goal in a posture, all in range and, unless that is asked
    /// for, none of them wound back.
    pub(super) fn solution(
        &self,
        goal: &Pose<T>,
        recent: &Recent<T>,
        posture: Configuration,
        winds_back: bool,
    ) -> Option<Joints<T>> {
        let solutions = self.arm.inverse(goal, recent.last()).ok()?;
        let solution = solutions.get(posture).filter(|solution| solution.outside.is_empty())?;
        let way = difference(&solution.joints, recent.last());
        let joints = way.iter().zip(&self.arm.config().joints);
        let is_wound = |way: &T, joint: &JointConfig| {
            let turns_round = joint.max_rad - joint.min_rad > core::f64::consts::TAU;
            turns_round && way.abs() > T::of(FARTHEST_RAD)
        };
        let wound = joints.into_iter().any(|(way, joint)| is_wound(way, joint));
        (winds_back || !wound).then_some(solution.joints)
    }
}

impl<T: Real> Situation<'_, T> {
    /// The joints follow through any singularity; what may not change has to be as before after it.
    fn policy(&self) -> Policy {
        let Configuration { shoulder, elbow, wrist } = self.posture;
        let fixed = Fixed {
            shoulder: (!self.passages.shoulder).then_some(shoulder),
            elbow: (!self.passages.elbow).then_some(elbow),
            wrist: (!self.passages.wrist).then_some(wrist),
        };
        Policy { fixed, passages: Passages::ALL, jump: false }
    }
}

fn difference<T: Real>(to: &Joints<T>, from: &Joints<T>) -> Joints<T> {
    let mut way = *to;
    for (way, from) in way.iter_mut().zip(from) {
        *way -= *from;
    }
    way
}

/// Why the goal is not to be reached.
fn tell(refusal: Option<ChooseRefusal>, posture: Configuration, limits: &mut Limits) {
    match refusal {
        Some(ChooseRefusal::OutsideRange(joints)) => {
            for number in joints.numbers() {
                limits.add(Limit::JointRange(number as u8));
            }
        }
        Some(ChooseRefusal::NotAsFixed { to, .. }) => limits.add(if to.shoulder != posture.shoulder {
            Limit::ShoulderSingularity
        } else if to.elbow != posture.elbow {
            Limit::ElbowSingularity
        } else {
            Limit::WristSingularity
        }),
        Some(ChooseRefusal::Unreachable(Unreachable::TooFar)) => limits.add(Limit::TooFar),
        Some(_) => limits.add(Limit::TooNear),
        // it could be followed to, but only with a joint wound back or out of the posture
        None => limits.add(Limit::AnotherWay),
    }
}
