//! One cycle towards a goal: which way, how fast, and when it is given up for another.

use super::Governor;
use super::axis::{Axis, Bounds};
use super::detour::{Around, Detour};
use super::limits::{JointNumber, Limit, Limits};
use super::pace::{Led, Stance};
use super::way::{Kind, Situation, Way};
use crate::arm::puma560::{Jacobian, Joints};
use crate::config::AllowedPassages;
use crate::geometry::Pose;
use crate::real::Real;

/// Units of rounding within which a joint is where it shall be: 6e-14 rad in f64, 3e-5 in f32.
const ARRIVED_ROUNDINGS: f64 = 256.0;

/// The same where the arm cannot go to the goal itself, radians, in [`Real::SLACK`].
const NEAREST_SLACKS: f64 = 10.0;

/// A straight way on which the tool goes at less than this share of its speed, or of what it has on the way home, for
/// so many cycles is taken for barred.
const STALLED_SHARE: f64 = 0.02;
const STALLED_CYCLES: u16 = 100;

/// How far from where it was started a joint may be to which the arm goes back, radians.
const AS_STARTED_RAD: f64 = 0.5;

impl<T: Real> Governor<T> {
    /// One cycle towards a goal within reach; how fast the tool is asked to be.
    pub(super) fn follow(&mut self, goal: &Pose<T>, led: Led<'_, T>, limits: &mut Limits) -> T {
        for number in self.ways.arm.outside(&self.set_point()).numbers() {
            limits.add(Limit::OutsideRange(number as JointNumber));
        }
        if self.axes.iter().all(Axis::is_at_rest) && is_same(goal, &self.pose) {
            self.by_joints = false;
            self.detour = Detour::none();
            self.barred = false;
            return T::one();
        }
        if self.rest.regard(goal) {
            self.detour.try_again();
        }
        let joints = self.set_point();
        let jacobian = self.ways.arm.jacobian(&joints);
        let way = self.way(goal, &jacobian, limits);
        if self.rest.is_kept(&way) {
            self.brake();
            return T::zero();
        }
        let arrived = match way.kind {
            Kind::AsNearAsItGoes => T::SLACK * T::of(NEAREST_SLACKS),
            Kind::Straight | Kind::ByJoints => T::EPSILON * T::of(ARRIVED_ROUNDINGS),
        };
        let ends_here = way.to_the_end || way.kind == Kind::AsNearAsItGoes;
        if ends_here && way.left.iter().all(|left| left.abs() <= arrived) {
            self.stop();
            self.watch(&way, T::one());
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
        let paced = self.pace.along(&way, &stance, led, limits);
        self.watch(&way, paced.share / self.pace.most(led));
        let forbidden = self.turn_to(&paced.speeds);
        forbidden.iter().for_each(|limit| limits.add(*limit));
        self.come_to_rest(goal, &way, &jacobian);
        self.go_round(goal, &way, paced.at_face || forbidden == Some(Limit::WorkspaceEdge));
        paced.share
    }

    /// Nobody asks for a goal any more, or for one that can be used. A way by the joints that the arm was on has ended with that: whoever asks next
    /// does so for where the arm is then, and a posture that it was on its way to swings nothing on under a hand that
    /// is still.
    pub(super) fn let_go(&mut self) {
        if self.by_joints {
            self.braking = self.bounds.iter().map(Bounds::cycles_to_rest).max().unwrap_or(0);
        }
        self.stop();
    }

    /// What is done where the arm has come to rest short of its goal: the next way to it, if there is
    /// one. Else it stays there.
    fn come_to_rest(&mut self, goal: &Pose<T>, way: &Way<T>, jacobian: &Jacobian<T>) {
        let cycle = T::of(f64::from(self.config.cycle_us) * 1e-6);
        let speeds = self.axes.map(|axis| axis.speed);
        if !self.rest.has_come(way, jacobian, &speeds, cycle) {
            return;
        }
        let goes_on = match way.kind {
            Kind::ByJoints => self.detour.hurry(),
            Kind::Straight | Kind::AsNearAsItGoes => {
                self.by_joints = self.ways.solution(goal, &self.recent, self.posture, false).is_some();
                self.by_joints || self.turn_back(goal)
            }
        };
        if !goes_on {
            self.rest.keep();
        }
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

    /// Where the hand has come back to about where the arm was started, and only in the posture of then can
    /// the arm go there: back to that, by the joints. Without it, who went out through a singularity and
    /// back beside it would not come home; nor who turned the tool round by about a turn, against the end
    /// of a joint.
    ///
    /// Nothing else changes a posture that way, whoever rests against the end of a joint is not turned
    /// round; nor does time: an arm that has come to rest stays as it is until the hand moves.
    fn turn_back(&mut self, goal: &Pose<T>) -> bool {
        let solution = |winds_back| self.ways.solution(goal, &self.recent, self.first_posture, winds_back);
        let unwound = solution(false).is_some_and(|joints| self.is_as_started(&joints, true));
        let wound = solution(true).is_some_and(|joints| self.is_as_started(&joints, false));
        if unwound || wound {
            self.posture = self.first_posture;
            self.braking = 0;
            self.by_joints = true;
            self.winds_back = !unwound;
        }
        unwound || wound
    }

    /// Whether no joint is far from where it was at the start, or, if that does as well, a turn from there.
    fn is_as_started(&self, joints: &Joints<T>, or_a_turn: bool) -> bool {
        let most = T::of(AS_STARTED_RAD);
        joints.iter().zip(&self.first_joints).all(|(angle, first)| {
            let off = (*angle - *first).abs();
            off <= most || or_a_turn && (off - T::of(core::f64::consts::TAU)).abs() <= most
        })
    }
}

/// Whether two poses are the same but for rounding.
fn is_same<T: Real>(a: &Pose<T>, b: &Pose<T>) -> bool {
    (a.translation - b.translation)
        .iter()
        .chain((a.rotation - b.rotation).iter())
        .all(|x| x.abs() <= T::SLACK)
}
