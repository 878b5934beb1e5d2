//! A goal a little ahead of the hand, so that an arm that follows its goal late follows the hand less
//! late.
//!
//! A goal that moves on is told where it will be after [`lead_us`](crate::config::SlaveConfig::lead_us),
//! at the speed it had between the last two commands. It is a goal like any other: the limits hold
//! for it, and a hand at rest has none ahead of it, so the arm ends where it was commanded, to the bit.

use crate::arm::teleop::{Decision, Note, Order};
use crate::geometry::Pose;
use crate::hand::so3;
use crate::real::Real;
use nalgebra::Vector3;

/// The share of a new speed that is believed at once; the rest is that of before. Halves the noise of
/// a camera and is half a frame late.
const NEW_SHARE: f64 = 0.5;

/// Slower than this a hand is at rest, m/s and rad/s: what noise of 0.03 mm and 0.02 degrees makes of
/// a hand that does not move, at 60 frames/s.
const REST_M_S: f64 = 0.004;
const REST_RAD_S: f64 = 0.04;

/// Commands nearer to one another than this tell no speed, microseconds: 500 a second.
const MIN_STEP_US: u64 = 2_000;

/// The goal of a command, and when its pictures were taken.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Told<T> {
    goal: Pose<T>,
    capture_us: u64,
}

/// How fast the goal moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lead<T> {
    lead_s: T,
    told: Option<Told<T>>,
    speed: Vector3<T>,
    turning: Vector3<T>,
}

impl<T: Real> Lead<T> {
    pub(super) fn new(lead_us: u32) -> Self {
        let lead_s = T::of(f64::from(lead_us) * 1e-6);
        Self { lead_s, told: None, speed: Vector3::zeros(), turning: Vector3::zeros() }
    }

    /// The order with its goal where it will be. `capture_us` is that of the newest command,
    /// `standing` for how long no newer one has come, as a share of how long a command stands.
    pub(super) fn ahead(&mut self, decision: &Decision<T>, capture_us: u64, standing: T) -> Order<T> {
        let Order::Follow(goal) = decision.order else {
            self.forget();
            return decision.order;
        };
        // where the goal is not the hand's, its speed is not either
        let apart = [Note::Latched, Note::HandJumped, Note::WorkspaceEdge, Note::AheadOfArm]
            .iter()
            .any(|note| decision.notes.contains(*note));
        if apart {
            self.forget();
        }
        match self.told {
            Some(told) if told.capture_us != capture_us => self.learn(&told, &goal, capture_us),
            Some(_) => {}
            None => self.told = Some(Told { goal, capture_us }),
        }
        // a hand of which nothing is heard is carried on less and less
        let lead_s = self.lead_s * (T::one() - standing).max(T::zero());
        let go = beyond_rest(&self.speed, REST_M_S) * lead_s;
        let turn = beyond_rest(&self.turning, REST_RAD_S) * lead_s;
        if go == Vector3::zeros() && turn == Vector3::zeros() {
            return decision.order;
        }
        Order::Follow(Pose { translation: goal.translation + go, rotation: so3::exp(&turn) * goal.rotation })
    }

    fn learn(&mut self, told: &Told<T>, goal: &Pose<T>, capture_us: u64) {
        let Some(step_us) = capture_us.checked_sub(told.capture_us).filter(|us| *us >= MIN_STEP_US) else {
            return;
        };
        // a step of over an hour is one of an hour
        let step_s = T::of(f64::from(u32::try_from(step_us).unwrap_or(u32::MAX)) * 1e-6);
        let speed = (goal.translation - told.goal.translation) / step_s;
        let turning = so3::log(&(goal.rotation * told.goal.rotation.transpose())) / step_s;
        let share = T::of(NEW_SHARE);
        self.speed += (speed - self.speed) * share;
        self.turning += (turning - self.turning) * share;
        self.told = Some(Told { goal: *goal, capture_us });
    }

    fn forget(&mut self) {
        *self = Self { told: None, speed: Vector3::zeros(), turning: Vector3::zeros(), ..*self };
    }
}

/// What of a speed is beyond that of a hand at rest; it grows from nothing, without a step.
fn beyond_rest<T: Real>(speed: &Vector3<T>, rest: f64) -> Vector3<T> {
    let (size, rest) = (speed.norm(), T::of(rest));
    if size > rest { speed * ((size - rest) / size) } else { Vector3::zeros() }
}
