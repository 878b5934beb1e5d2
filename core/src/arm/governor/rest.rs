//! When the arm has come to rest short of its goal: while that goal stays where it is, so does the arm.
//!
//! What leads towards a goal that is not to be reached may carry on for long, ever slower, and come upon
//! another direction in the end: an arm that stood still would set off although nobody asked. So a rest
//! is kept. It ends when the goal moves: the hand did something.

use super::goal::Left;
use super::way::{Kind, Way};
use crate::arm::puma560::{Jacobian, Joints};
use crate::config::GovernorConfig;
use crate::geometry::Pose;
use crate::real::Real;
use nalgebra::Vector6;

/// A goal that is no farther from where it was is the same one, metres and radians: the noise of a hand
/// that is held still.
const SAME_GOAL_M: f64 = 0.002;
const SAME_GOAL_RAD: f64 = 0.02;

/// At most so fast, m/s and rad/s, is at rest, in shares of what the tool and the joints may do.
const REST_M_S: f64 = 0.002;
const REST_RAD_S: f64 = 0.02;
const REST_SHARE: f64 = 0.004;

/// After so long it has come to rest, seconds.
const REST_S: f64 = 0.2;

/// What is known of a rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest<T> {
    most_m_s: T,
    most_rad_s: T,
    /// The goal that counts as the same.
    goal: Option<Pose<T>>,
    /// For how long the tool has hardly moved on a way of this kind, seconds.
    waited: T,
    kind: Kind,
    is_kept: bool,
}

impl<T: Real> Rest<T> {
    pub(super) fn new(config: &GovernorConfig) -> Self {
        let turning = config.speed_share * REST_SHARE * 10.0;
        Self {
            most_m_s: T::of(REST_M_S.min(config.max_tool_speed_m_s * REST_SHARE)),
            most_rad_s: T::of(REST_RAD_S.min(turning)),
            goal: None,
            waited: T::zero(),
            kind: Kind::Straight,
            is_kept: false,
        }
    }

    /// Nothing is gone to any more.
    pub(super) fn end(&mut self) {
        (self.goal, self.waited, self.is_kept) = (None, T::zero(), false);
    }

    /// Ends with another goal. Whether it is another one.
    pub(super) fn regard(&mut self, goal: &Pose<T>) -> bool {
        let is_same = self.goal.is_some_and(|before| {
            let moved = Left::between(&before, goal);
            moved.place.norm() <= T::of(SAME_GOAL_M) && moved.turn.norm() <= T::of(SAME_GOAL_RAD)
        });
        if !is_same {
            self.end();
            self.goal = Some(*goal);
        }
        !is_same
    }

    /// Whether the arm stays where it is. Not where the goal has come within reach and is near.
    pub(super) fn is_kept(&mut self, way: &Way<T>) -> bool {
        self.is_kept &= !way.to_the_end;
        self.is_kept
    }

    /// From now on the arm stays where it is.
    pub(super) fn keep(&mut self) {
        self.is_kept = true;
    }

    /// Whether the arm has come to rest on its way, after one more cycle at these speeds.
    pub(super) fn has_come(
        &mut self,
        way: &Way<T>,
        jacobian: &Jacobian<T>,
        speeds: &Joints<T>,
        cycle: T,
    ) -> bool {
        let tool = jacobian * Vector6::from(*speeds);
        // joints that turn while the tool stands still are on their way past a singularity
        let turning = speeds.iter().fold(T::zero(), |most, speed| most.max(speed.abs()));
        let joints_rest = way.kind == Kind::AsNearAsItGoes || turning <= self.most_rad_s;
        let is_slow = joints_rest
            && tool.fixed_rows::<3>(0).norm() <= self.most_m_s
            && tool.fixed_rows::<3>(3).norm() <= self.most_rad_s
            && !way.to_the_end;
        // on another way it may get on
        self.waited = if is_slow && way.kind == self.kind { self.waited + cycle } else { T::zero() };
        self.kind = way.kind;
        let has_come = self.waited >= T::of(REST_S);
        if has_come {
            self.waited = T::zero();
        }
        has_come
    }
}
