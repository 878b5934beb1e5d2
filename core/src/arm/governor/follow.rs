//! One cycle towards a goal: which way, how fast, and when it is given up for another.

use super::Governor;
use super::axis::Axis;
use super::detour::{Around, Detour};
use super::limits::{JointNumber, Limit, Limits};
use super::pace::Stance;
use super::way::{Kind, Situation, Way};
use crate::arm::puma560::{Jacobian, Joints};
use crate::arm::teleop::Uncertainty;
use crate::config::AllowedPassages;
use crate::geometry::Pose;
use crate::real::Real;

/// Units of rounding within which a joint is where it shall be: 6e-14 rad in f64, 3e-5 in f32.
const ARRIVED_ROUNDINGS: f64 = 256.0;

/// The same where the arm cannot go to the goal itself, radians, in [`Real::SLACK`].
const NEAREST_SLACKS: f64 = 10.0;

/// A straight way on which the tool goes at less than this share of its speed for so many cycles is
/// taken for barred.
const STALLED_SHARE: f64 = 0.02;
const STALLED_CYCLES: u16 = 100;

/// How long the arm is kept from a goal before it goes back to the posture in which it was started,
/// microseconds: time enough to read what is told and to move back oneself.
const TURN_BACK_US: u64 = 1_000_000;

/// How far from where it was started a joint may be to which the arm goes back by itself, radians.
const AS_STARTED_RAD: f64 = 1.5;

impl<T: Real> Governor<T> {
    /// One cycle towards a goal within reach; how fast the tool is asked to be.
    pub(super) fn follow(
        &mut self,
        goal: &Pose<T>,
        uncertainty: Option<&Uncertainty<T>>,
        limits: &mut Limits,
    ) -> T {
        for number in self.ways.arm.outside(&self.set_point()).numbers() {
            limits.add(Limit::OutsideRange(number as JointNumber));
        }
        if self.axes.iter().all(Axis::is_at_rest) && is_same(goal, &self.pose) {
            self.by_joints = false;
            self.detour = Detour::none();
            self.barred = false;
            return T::one();
        }
        let joints = self.set_point();
        let jacobian = self.ways.arm.jacobian(&joints);
        let way = self.way(goal, &jacobian, limits);
        let arrived = match way.kind {
            Kind::AsNearAsItGoes => T::SLACK * T::of(NEAREST_SLACKS),
            Kind::Straight | Kind::ByJoints => T::EPSILON * T::of(ARRIVED_ROUNDINGS),
        };
        let ends_here = way.to_the_end || way.kind == Kind::AsNearAsItGoes;
        if ends_here && way.left.iter().all(|left| left.abs() <= arrived) {
            self.stop();
            self.watch(&way, T::one());
            self.turn_back(goal);
            return T::one();
        }
        let mut bound_for = joints;
        for (speed, (axis, bounds)) in bound_for.iter_mut().zip(self.axes.iter().zip(&self.bounds)) {
            *speed = axis.peak_speed(bounds);
        }
        let stance = Stance {
            arm: &self.ways.arm,
            joints: &joints,
            place: &self.pose.translation,
            jacobian: &jacobian,
            bound_for: &bound_for,
            bounds: &self.bounds,
            ranges: &self.ranges,
            edges: &self.edges,
            passages: self.passages(),
        };
        let paced = self.pace.along(&way, &stance, uncertainty, limits);
        self.watch(&way, paced.share);
        self.turn_back(goal);
        let is_free = self.turn_to(&paced.speeds);
        if !is_free {
            limits.add(Limit::WorkspaceEdge);
        }
        self.go_round(goal, &way, paced.at_face || !is_free);
        paced.share
    }

    fn way(&self, goal: &Pose<T>, jacobian: &Jacobian<T>, limits: &mut Limits) -> Way<T> {
        let situation = Situation {
            recent: &self.recent,
            pose: &self.pose,
            jacobian,
            spans: &self.spans,
            goal,
            posture: self.posture,
            passages: self.passages(),
            by_joints: self.by_joints,
            via: self.detour.via,
            winds_back: self.winds_back,
        };
        self.ways.choose(&situation, limits)
    }

    pub(super) fn passages(&self) -> AllowedPassages {
        let none = AllowedPassages { wrist: false, elbow: false, shoulder: false };
        if self.barred { none } else { self.config.passages }
    }

    /// Keeps to the joints' way until it is at its end, and takes it up where the straight one hardly
    /// gets on.
    fn watch(&mut self, way: &Way<T>, share: T) {
        let crawls = way.kind == Kind::Straight && !way.to_the_end && share < T::of(STALLED_SHARE);
        self.stalled = if crawls { self.stalled.saturating_add(1) } else { 0 };
        self.barred = way.kind == Kind::AsNearAsItGoes || self.barred && !way.to_the_end;
        self.by_joints = way.kind == Kind::ByJoints && !way.to_the_end || self.stalled >= STALLED_CYCLES;
        self.winds_back &= self.by_joints;
    }

    /// Looks for a way round where the tool is held at a face on its way by the joints.
    fn go_round(&mut self, goal: &Pose<T>, way: &Way<T>, at_face: bool) {
        let cycle = T::of(f64::from(self.config.cycle_us) * 1e-6);
        if !self.detour.is_due(way, at_face, cycle) {
            return;
        }
        let around = Around {
            arm: &self.ways.arm,
            edges: &self.edges,
            ranges: &self.ranges,
            posture: self.posture,
            turned: self.detour.turned(),
            round: self.detour.round(),
        };
        let target = self.ways.solution(goal, &self.recent, self.posture, self.winds_back);
        self.detour.via = target.and_then(|target| around.via(&self.set_point(), &target));
    }

    /// Where the arm has been kept from the goal for a while, though standing as it was started it could go
    /// there: back to that, by the joints. Without it, who went out through a singularity and back beside
    /// it would not come home; nor who turned the tool round by about a turn, against the end of a joint.
    ///
    /// A joint is wound back only to about where it was at the start: whoever rests against its end is not
    /// turned round.
    fn turn_back(&mut self, goal: &Pose<T>) {
        self.barred_cycles = if self.barred { self.barred_cycles.saturating_add(1) } else { 0 };
        let waited_us = u64::from(self.barred_cycles) * u64::from(self.config.cycle_us);
        if waited_us < TURN_BACK_US || self.by_joints {
            return;
        }
        let solution = |posture, winds_back| self.ways.solution(goal, &self.recent, posture, winds_back);
        if solution(self.posture, false).is_some() {
            return;
        }
        let passed = self.posture != self.first_posture;
        if passed && solution(self.first_posture, false).is_some() {
            self.posture = self.first_posture;
            self.by_joints = true;
        } else if solution(self.first_posture, true).is_some_and(|joints| self.is_as_started(&joints)) {
            self.posture = self.first_posture;
            self.by_joints = true;
            self.winds_back = true;
        }
    }

    /// Whether no joint is far from where it was at the start.
    fn is_as_started(&self, joints: &Joints<T>) -> bool {
        let most = T::of(AS_STARTED_RAD);
        joints.iter().zip(&self.first_joints).all(|(angle, first)| (*angle - *first).abs() <= most)
    }
}

/// Whether two poses are the same but for rounding.
fn is_same<T: Real>(a: &Pose<T>, b: &Pose<T>) -> bool {
    (a.translation - b.translation)
        .iter()
        .chain((a.rotation - b.rotation).iter())
        .all(|x| x.abs() <= T::SLACK)
}
