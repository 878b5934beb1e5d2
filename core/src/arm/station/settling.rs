//! Which motion the arm has reached: the last stage of a motion's way, told back to the operator.
//!
//! A motion is reached where the measured joints pass within [`REACHED_RAD`] of its goal, all joints at
//! one time. Two readings of a moving arm may lie on either side of a goal, so the way between them counts.

use crate::arm::puma560::Joints;
use crate::config::JOINTS;
use crate::real::Real;
use crate::wire::Settled;
use heapless::Deque;

/// How near every joint has to come, radians: 0.1 degree, some ten counts of a PUMA's encoders and 1.5 mm
/// at the end of a stretched arm.
const REACHED_RAD: f64 = 0.1 / 180.0 * core::f64::consts::PI;

/// A goal that was not reached within so long will not be, microseconds: the arm is at most a third of a
/// second behind. Where a hand goes round and round, the arm passes it again a round later.
const PASSED_US: u64 = 1_000_000;

/// Goals that are remembered: two seconds of a camera with 120 frames a second.
const GOALS: usize = 256;

/// A motion, and where it sends the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Goal<T> {
    sequence: u32,
    received_us: u64,
    joints: Joints<T>,
}

/// The goals that are still to be reached, of one sender's session.
#[derive(Clone, Debug)]
pub(super) struct Settling<T> {
    /// The oldest first.
    goals: Deque<Goal<T>, GOALS>,
    reading: Option<Joints<T>>,
    settled: Option<Settled>,
}

impl<T: Real> Settling<T> {
    pub(super) const fn new() -> Self {
        Self { goals: Deque::new(), reading: None, settled: None }
    }

    /// Another sender, or a sender that has begun anew.
    pub(super) fn restart(&mut self) {
        self.goals.clear();
        (self.reading, self.settled) = (None, None);
    }

    /// The hand is not followed any more: what was to be reached may never be.
    pub(super) fn let_go(&mut self) {
        self.goals.clear();
    }

    /// A motion that came at `received_us` sends the joints there.
    pub(super) fn goal(&mut self, sequence: u32, received_us: u64, joints: Joints<T>) {
        if self.goals.is_full() {
            self.goals.pop_front();
        }
        // there is room now
        let _ = self.goals.push_back(Goal { sequence, received_us, joints });
    }

    /// The joints were here at `at_us`.
    pub(super) fn measured(&mut self, joints: &Joints<T>, at_us: u64) {
        while self.goals.front().is_some_and(|goal| at_us.saturating_sub(goal.received_us) > PASSED_US) {
            self.goals.pop_front();
        }
        let from = self.reading.replace(*joints).unwrap_or(*joints);
        let newer = self.goals.iter().rev().position(|goal| passes(&from, joints, &goal.joints));
        let Some(newer) = newer else { return };
        // what is older has been overtaken, reached or not
        while self.goals.len() > newer + 1 {
            self.goals.pop_front();
        }
        if let Some(goal) = self.goals.pop_front() {
            let after_us = at_us.saturating_sub(goal.received_us);
            let after_us = u32::try_from(after_us).unwrap_or(u32::MAX);
            self.settled = Some(Settled { sequence: goal.sequence, after_us });
        }
    }

    /// The newest motion that was reached.
    pub(super) const fn settled(&self) -> Option<Settled> {
        self.settled
    }
}

/// Whether the straight way from one reading to the next comes near enough to a goal.
fn passes<T: Real>(from: &Joints<T>, to: &Joints<T>, goal: &Joints<T>) -> bool {
    let way = difference(to, from);
    let length = dot(&way, &way);
    // where the way is nearest to the goal
    let share = if length > T::zero() {
        (dot(&difference(goal, from), &way) / length).max(T::zero()).min(T::one())
    } else {
        T::one()
    };
    from.iter()
        .zip(&way)
        .zip(goal)
        .all(|((from, way), goal)| (*from + share * *way - *goal).abs() <= T::of(REACHED_RAD))
}

fn difference<T: Real>(a: &Joints<T>, b: &Joints<T>) -> [T; JOINTS] {
    let mut difference = *a;
    difference.iter_mut().zip(b).for_each(|(a, b)| *a -= *b);
    difference
}

fn dot<T: Real>(a: &[T; JOINTS], b: &[T; JOINTS]) -> T {
    a.iter().zip(b).fold(T::zero(), |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(q1: f64) -> Joints<f64> {
        [q1, 0.5, -1.0, 0.0, 1.0, 0.0]
    }

    #[test]
    fn the_newest_goal_on_the_way_is_reached() {
        let mut settling = Settling::new();
        settling.measured(&at(0.0), 1_000);
        settling.goal(5, 1_000, at(0.02));
        settling.goal(6, 2_000, at(0.04));
        settling.goal(7, 3_000, at(0.10));
        settling.measured(&at(0.01), 4_000);
        assert_eq!(settling.settled(), None);
        settling.measured(&at(0.06), 9_000);
        assert_eq!(
            settling.settled(),
            Some(Settled { sequence: 6, after_us: 7_000 }),
            "between two readings"
        );
        settling.measured(&at(0.02), 10_000);
        assert_eq!(settling.settled(), Some(Settled { sequence: 6, after_us: 7_000 }), "5 is overtaken");
        settling.measured(&at(0.0995), 20_000);
        assert_eq!(settling.settled(), Some(Settled { sequence: 7, after_us: 17_000 }), "within 0.1 degree");
    }

    #[test]
    fn every_joint_has_to_be_there_and_only_after_the_motion_came() {
        let mut settling = Settling::new();
        settling.measured(&at(0.1), 0);
        let mut aside = at(0.1);
        aside[5] += 0.002;
        settling.goal(1, 0, aside);
        settling.measured(&at(0.1), 1_000);
        settling.measured(&at(0.2), 2_000);
        assert_eq!(settling.settled(), None, "the last joint is 0.11 degrees away");
        settling.goal(2, 2_000, at(0.1));
        settling.measured(&at(0.3), 3_000);
        assert_eq!(settling.settled(), None, "where it was before does not count");
        settling.measured(&at(0.05), 4_000);
        assert_eq!(settling.settled(), Some(Settled { sequence: 2, after_us: 2_000 }));
    }

    #[test]
    fn what_is_let_go_is_not_reached_and_another_sender_begins_anew() {
        let mut settling = Settling::new();
        settling.goal(1, 0, at(0.1));
        settling.measured(&at(0.1), 10);
        settling.goal(2, 0, at(0.2));
        settling.let_go();
        settling.measured(&at(0.2), 20);
        assert_eq!(settling.settled(), Some(Settled { sequence: 1, after_us: 10 }));
        settling.restart();
        assert_eq!(settling.settled(), None);
    }

    #[test]
    fn what_is_remembered_is_bounded() {
        let mut settling = Settling::new();
        for sequence in 0..1_000 {
            settling.goal(sequence, 0, at(f64::from(sequence)));
        }
        assert_eq!(settling.goals.len(), GOALS);
        settling.measured(&at(999.0), 1);
        assert_eq!(settling.settled(), Some(Settled { sequence: 999, after_us: 1 }));
    }
}
