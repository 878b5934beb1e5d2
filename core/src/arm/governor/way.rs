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
    ChooseRefusal, Configuration, Jacobian, Joints, Passages, Policy, Puma560, Recent, Solution, Unreachable,
};
use crate::config::{AllowedPassages, JOINTS};
use crate::geometry::Pose;
use crate::real::Real;

/// A piece of the straight way is at most what the tool may do in a cycle, and this turn, radians a
/// second.
const TURN_RAD_S: f64 = 2.0;

/// How far a joint may have to go by the joints' way, radians: less than the half turn of a wrist that
/// is turned over and the whole turn of a joint that is wound back.
const FARTHEST_RAD: f64 = 3.0;

/// Where the wrist's passage is allowed: by how much q5 may go from one side to the other, radians. So
/// far the tool swings out while joints 4 and 6 go half a turn.
const SWING_RAD: f64 = 0.5;

/// The same for joints 4 and 6, a bit over half a turn.
const TURNED_OVER_RAD: f64 = 3.5;

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

/// What does not change from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ways<T> {
    pub(super) arm: Puma560<T>,
    /// How far the tool may go in a cycle, metres, and turn, radians.
    piece_m: T,
    piece_rad: T,
    policy: Policy,
}

/// How the arm stands and where it shall go.
pub(super) struct Situation<'a, T> {
    pub(super) recent: &'a Recent<T>,
    pub(super) pose: &'a Pose<T>,
    pub(super) jacobian: &'a Jacobian<T>,
    pub(super) spans: &'a [Span<T>; JOINTS],
    pub(super) goal: &'a Pose<T>,
    /// Whether the joints' way was taken up and is not at its end yet.
    pub(super) by_joints: bool,
}

impl<T: Real> Ways<T> {
    pub(super) fn new(arm: &Puma560<T>, tool_speed: T, cycle: T, passages: AllowedPassages) -> Self {
        let passages = Passages { wrist: passages.wrist, elbow: passages.elbow, shoulder: passages.shoulder };
        Self {
            arm: *arm,
            piece_m: tool_speed * cycle,
            piece_rad: T::of(TURN_RAD_S) * cycle,
            policy: Policy { passages, ..Policy::default() },
        }
    }

    pub(super) fn choose(&self, now: &Situation<'_, T>, limits: &mut Limits) -> Way<T> {
        let left = Left::between(now.pose, now.goal);
        let pieces = (left.place.norm() / self.piece_m).max(left.turn.norm() / self.piece_rad);
        let to_the_end = pieces <= T::one();
        let joints = now.recent.last();
        let mut refusal = None;
        if !now.by_joints {
            let pieces = pieces.max(T::one());
            let next = if to_the_end { *now.goal } else { left.along(now.pose, T::one() / pieces) };
            match self.arm.choose(&next, now.recent, &self.policy) {
                Ok(choice) => {
                    let left = difference(&choice.joints, joints).map(|way| way * pieces);
                    return Way { left, to_the_end, kind: Kind::Straight };
                }
                Err(reason) => refusal = Some(reason),
            }
        }
        if let Some(target) = self.solution(now.goal, now.recent) {
            if !to_the_end {
                limits.add(Limit::AnotherWay);
            }
            return Way { left: difference(&target, joints), to_the_end, kind: Kind::ByJoints };
        }
        // the way by the joints may end where the goal moved out of reach
        let refusal = refusal.or_else(|| self.arm.choose(now.goal, now.recent, &self.policy).err());
        tell(refusal, limits);
        let left = least_squares::approach(now.jacobian, &left, joints, now.spans);
        Way { left, to_the_end: false, kind: Kind::AsNearAsItGoes }
    }

    /// The joints that bring the tool to the goal and are nearest, all in range, in the configuration
    /// in which the arm stands; with the wrist bent the other way where that is little and allowed.
    fn solution(&self, goal: &Pose<T>, recent: &Recent<T>) -> Option<Joints<T>> {
        let stands = recent.configuration();
        let solutions = self.arm.inverse(goal, recent.last()).ok()?;
        let same =
            nearest(solutions.within_ranges().filter(|s| self.may_stand(stands, s, false)), recent, |_| {
                T::of(FARTHEST_RAD)
            });
        same.or_else(|| {
            let over = |joint: usize| match joint {
                4 | 6 => T::of(TURNED_OVER_RAD),
                5 => T::of(SWING_RAD),
                _ => T::of(FARTHEST_RAD),
            };
            nearest(solutions.within_ranges().filter(|s| self.may_stand(stands, s, true)), recent, over)
        })
    }

    fn may_stand(&self, from: Configuration, solution: &Solution<T>, turned_over: bool) -> bool {
        let to = solution.configuration;
        let passages = self.policy.passages;
        (to.shoulder == from.shoulder || passages.shoulder)
            && (to.elbow == from.elbow || passages.elbow)
            && (if turned_over { to.wrist != from.wrist && passages.wrist } else { to.wrist == from.wrist })
    }
}

/// The solution whose joints have the least to go, none of them farther than `farthest` of its number.
fn nearest<'a, T: Real>(
    solutions: impl Iterator<Item = &'a Solution<T>>,
    recent: &Recent<T>,
    farthest: impl Fn(usize) -> T,
) -> Option<Joints<T>> {
    let mut best: Option<(T, Joints<T>)> = None;
    for solution in solutions {
        let way = difference(&solution.joints, recent.last());
        let near = (1..).zip(&way).all(|(number, way)| way.abs() <= farthest(number));
        let length = way.iter().fold(T::zero(), |sum, way| sum + *way * *way);
        if near && best.is_none_or(|(least, _)| length < least) {
            best = Some((length, solution.joints));
        }
    }
    best.map(|(_, joints)| joints)
}

fn difference<T: Real>(to: &Joints<T>, from: &Joints<T>) -> Joints<T> {
    let mut way = *to;
    for (way, from) in way.iter_mut().zip(from) {
        *way -= *from;
    }
    way
}

/// Why the goal is not to be reached.
fn tell(refusal: Option<ChooseRefusal>, limits: &mut Limits) {
    use crate::arm::puma560::Singularity::{Elbow, Shoulder, Wrist};
    match refusal {
        Some(ChooseRefusal::OutsideRange(joints)) => {
            for number in joints.numbers() {
                limits.add(Limit::JointRange(number as u8));
            }
        }
        Some(ChooseRefusal::Passage { singularity: Wrist, .. }) => limits.add(Limit::WristSingularity),
        Some(ChooseRefusal::Passage { singularity: Elbow, .. }) => limits.add(Limit::ElbowSingularity),
        Some(ChooseRefusal::Passage { singularity: Shoulder, .. }) => limits.add(Limit::ShoulderSingularity),
        Some(ChooseRefusal::Unreachable(Unreachable::TooFar)) => limits.add(Limit::TooFar),
        _ => limits.add(Limit::TooNear),
    }
}
