//! The governor: what the arm is told in each cycle, so that it goes where the law says and never
//! farther, faster or more abruptly than it may.
//!
//! | job | file |
//! |---|---|
//! | what limits, by name | `limits` |
//! | the goal: usable, in the box, within reach | `goal` |
//! | which way the joints go | `way` |
//! | as near as it goes: damped least squares | `least_squares` |
//! | how fast along it | `pace` |
//! | one joint: speed, acceleration, jerk, range | `axis` |
//!
//! - **Exact.** Where the arm can be at the goal it comes to be there, by the closed-form inverse; a
//!   goal that is where the arm is told to be already moves nothing, to the bit.
//! - **Bounded.** The differences of the set-points keep the bounds of speed, acceleration and jerk in
//!   every cycle, and a stop within the joint's range is possible from each of them (`axis`).
//! - **No wind-up.** All is told anew from the set-point in each cycle. A goal that cannot be reached
//!   is replaced by the nearest that can; nothing is added up, the way back begins at once.
//! - **Always a way back.** See `way`: to where the arm stood before, in the posture in which it
//!   stands, there is always one. Slowing at ends and singularities knows the direction.
//! - **Aimed at, not proved.** Speed of the tool and workspace: goals are in the box and straight ways do
//!   not leave it; where the tool goes by the joints or as near as it can, it may swing out by centimetres
//!   before the joints, within their accelerations, have stopped it.
//! - **Never silent.** What limits is in [`Governed::limits`], a change of posture in
//!   [`Governed::change`].
//!
//! [`Governor`] is plain data, a copy of it behaves alike. Nothing here panics or allocates.

mod limits;

mod goal;

mod axis;

mod least_squares;

mod way;

mod pace;

pub use limits::{JointNumber, Limit, Limits};

use super::puma560::{Change, ChangeKind, Configuration, Jacobian, JointSet, Joints, Puma560, Recent};
use super::teleop::{Order, Uncertainty};
use crate::config::{AllowedPassages, GovernorConfig, GovernorConfigError, JOINTS};
use crate::geometry::Pose;
use crate::real::Real;
use axis::{Axis, Bounds, Span};
use core::fmt;
use goal::Bounded;
use pace::{Pace, Stance};
use way::{Kind, Situation, Way, Ways};

#[cfg(test)]
mod tests;

/// The most of what is left of a way that goes in one cycle.
const MOST_A_CYCLE: f64 = 0.2;

/// How much quicker speeds follow what is asked than the way is gone: the two make a motion that
/// comes to its end without passing it.
const SPEED_RESPONSE: f64 = 4.0;

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

/// The governor of one arm, in f32 or f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governor<T> {
    config: GovernorConfig,
    ways: Ways<T>,
    pace: Pace<T>,
    edges: Bounded<T>,
    bounds: [Bounds<T>; JOINTS],
    ranges: [Span<T>; JOINTS],
    /// The ranges, or out to where a joint was at the start until it has come back.
    spans: [Span<T>; JOINTS],
    axes: [Axis<T>; JOINTS],
    recent: Recent<T>,
    pose: Pose<T>,
    /// The posture that is kept. What passed a singularity by a little because it could not stop in
    /// time comes back to it.
    posture: Configuration,
    /// The one in which the arm was started.
    first_posture: Configuration,
    by_joints: bool,
    /// The goal was not to be reached, and the arm is not at one yet: off the way that it was asked
    /// to go, where a passage might lead to where there is no way back from.
    barred: bool,
    /// Cycles for which it has been so.
    barred_cycles: u32,
    stalled: u16,
}

impl<T: Real> Governor<T> {
    /// A governor of this arm, at rest with every joint in the middle of its range. To be
    /// [started](Self::start) where the arm is.
    ///
    /// # Errors
    /// [`GovernorConfigError`] for a setting that cannot be worked with.
    pub fn new(arm: &Puma560<T>, config: &GovernorConfig) -> Result<Self, GovernorConfigError> {
        let joints = arm.config().joints;
        config.check(&joints.map(|joint| joint.max_speed_rad_s))?;
        let seconds = f64::from(config.cycle_us) * 1e-6;
        let cycle = T::of(seconds);
        let response = T::of(config.response_per_s.min(MOST_A_CYCLE / seconds));
        let mut bounds = joints.map(|joint| Bounds {
            cycle,
            speed: T::of(joint.max_speed_rad_s * config.speed_share),
            acceleration: T::zero(),
            jerk_cycle: T::zero(),
        });
        let limits = config.max_acceleration_rad_s2.iter().zip(&config.max_jerk_rad_s3);
        for (bounds, (acceleration, jerk)) in bounds.iter_mut().zip(limits) {
            bounds.acceleration = T::of(*acceleration);
            bounds.jerk_cycle = T::of(jerk * seconds);
        }
        let ranges = joints.map(|joint| Span { min: T::of(joint.min_rad), max: T::of(joint.max_rad) });
        let middle = ranges.map(|range| (range.min + range.max) * T::of(0.5));
        Ok(Self {
            config: *config,
            ways: Ways::new(arm, T::of(config.max_tool_speed_m_s), cycle),
            pace: Pace::new(config, response),
            edges: Bounded::new(arm, &config.workspace),
            bounds,
            ranges,
            spans: ranges,
            axes: middle.map(Axis::at),
            recent: Recent::at_rest(arm, &middle),
            pose: arm.forward(&middle),
            posture: arm.configuration(&middle),
            first_posture: arm.configuration(&middle),
            by_joints: false,
            barred: false,
            barred_cycles: 0,
            stalled: 0,
        })
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &GovernorConfig {
        &self.config
    }

    /// Where the joints were last told to be, radians.
    #[must_use]
    pub fn set_point(&self) -> Joints<T> {
        self.axes.map(|axis| axis.angle)
    }

    /// Where the tool is at the set-point: `base_from_tool`.
    #[must_use]
    pub const fn pose(&self) -> &Pose<T> {
        &self.pose
    }

    /// Begins at rest where the arm is. Joints that are a little outside their range may then come
    /// back and not go farther out.
    ///
    /// # Errors
    /// [`StartRefusal`]; the governor stays as it was.
    pub fn start(&mut self, joints: &Joints<T>) -> Result<(), StartRefusal> {
        let not_finite = JointSet::from_flags(joints.map(|angle| !angle.is_finite()));
        if !not_finite.is_empty() {
            return Err(StartRefusal::NotFinite(not_finite));
        }
        let most = T::of(self.config.max_outside_rad) + T::SLACK;
        let mut outside = [false; JOINTS];
        for ((outside, angle), range) in outside.iter_mut().zip(joints).zip(&self.ranges) {
            *outside = *angle > range.max + most || *angle < range.min - most;
        }
        let outside = JointSet::from_flags(outside);
        if !outside.is_empty() {
            return Err(StartRefusal::OutsideRange(outside));
        }
        self.spans = self.ranges;
        for (span, angle) in self.spans.iter_mut().zip(joints) {
            *span = Span { min: span.min.min(*angle), max: span.max.max(*angle) };
        }
        self.axes = joints.map(Axis::at);
        self.recent = Recent::at_rest(&self.ways.arm, joints);
        self.pose = self.ways.arm.forward(joints);
        self.posture = self.recent.configuration();
        self.first_posture = self.posture;
        self.by_joints = false;
        self.barred = false;
        self.barred_cycles = 0;
        self.stalled = 0;
        Ok(())
    }

    /// Decides where the joints shall be at the end of this cycle. To be called once a cycle.
    ///
    /// `uncertainty` is how well the goal is known; `None` where nobody says.
    pub fn step(&mut self, order: &Order<T>, uncertainty: Option<&Uncertainty<T>>) -> Governed<T> {
        let mut limits = Limits::NONE;
        let before = self.axes;
        let (verdict, speed_share) = match order {
            Order::Stop => {
                self.stop();
                (Verdict::Pass, T::zero())
            }
            Order::Follow(goal) => match self.edges.admit(goal, &mut limits) {
                Ok(goal) => {
                    let share = self.follow(&goal, uncertainty, &mut limits);
                    (if limits.is_empty() { Verdict::Pass } else { Verdict::Clamp }, share)
                }
                Err(limit) => {
                    limits.add(limit);
                    self.stop();
                    (Verdict::Reject, T::zero())
                }
            },
        };
        let at_rest = self.axes.iter().zip(&before).all(|(now, before)| now.angle == before.angle)
            && self.axes.iter().all(Axis::is_at_rest);
        if !at_rest && *order == Order::Stop {
            limits.add(Limit::Stopping);
        }
        let change = self.arrive();
        Governed {
            set_point: self.set_point(),
            pose: self.pose,
            verdict,
            limits,
            speed_share,
            change,
            at_rest,
        }
    }

    fn stop(&mut self) {
        for (axis, bounds) in self.axes.iter_mut().zip(&self.bounds) {
            *axis = axis.stopped(bounds);
        }
        self.by_joints = false;
        self.stalled = 0;
    }

    /// One cycle towards a goal within reach; how fast the tool is asked to be.
    fn follow(&mut self, goal: &Pose<T>, uncertainty: Option<&Uncertainty<T>>, limits: &mut Limits) -> T {
        for number in self.ways.arm.outside(&self.set_point()).numbers() {
            limits.add(Limit::OutsideRange(number as JointNumber));
        }
        if self.axes.iter().all(Axis::is_at_rest) && is_same(goal, &self.pose) {
            self.by_joints = false;
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
        let (mut bound_for, mut stop_way) = (joints, joints);
        let ahead = bound_for.iter_mut().zip(&mut stop_way);
        for ((speed, way), (axis, bounds)) in ahead.zip(self.axes.iter().zip(&self.bounds)) {
            *speed = axis.peak_speed(bounds);
            *way = axis.stop_way(bounds);
        }
        let stance = Stance {
            arm: &self.ways.arm,
            joints: &joints,
            place: &self.pose.translation,
            jacobian: &jacobian,
            bound_for: &bound_for,
            stop_way: &stop_way,
            bounds: &self.bounds,
            ranges: &self.ranges,
            edges: &self.edges,
            passages: self.passages(),
        };
        if self.pace.leaves_box(&stance) {
            limits.add(Limit::WorkspaceEdge);
            for (axis, bounds) in self.axes.iter_mut().zip(&self.bounds) {
                *axis = axis.stopped(bounds);
            }
            return T::zero();
        }
        let paced = self.pace.along(&way, &stance, uncertainty, limits);
        self.watch(&way, paced.share);
        self.turn_back(goal);
        self.turn_to(&paced.speeds);
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
        };
        self.ways.choose(&situation, limits)
    }

    fn passages(&self) -> AllowedPassages {
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
    }

    /// Where the arm has passed a singularity and now has been kept from the goal for a while, though
    /// in the posture in which it was started it could go there: back to that posture, by the joints.
    /// Without it, who went out through the singularity and back beside it would not come home.
    fn turn_back(&mut self, goal: &Pose<T>) {
        self.barred_cycles = if self.barred { self.barred_cycles.saturating_add(1) } else { 0 };
        let waited_us = u64::from(self.barred_cycles) * u64::from(self.config.cycle_us);
        if waited_us >= TURN_BACK_US
            && self.posture != self.first_posture
            && self.ways.solution(goal, &self.recent, self.posture).is_none()
            && self.ways.solution(goal, &self.recent, self.first_posture).is_some()
        {
            self.posture = self.first_posture;
            self.by_joints = true;
        }
    }

    /// One cycle from the speeds that are towards those that are asked. One factor for the
    /// accelerations of all joints, and one for what changes of them: the speeds come to what is asked
    /// straight, so that the tool does not swing out while one joint waits for another.
    fn turn_to(&mut self, speeds: &Joints<T>) {
        let mut wishes = *speeds;
        let mut factor = self.pace.response * T::of(SPEED_RESPONSE);
        for ((wish, axis), bounds) in wishes.iter_mut().zip(&self.axes).zip(&self.bounds) {
            *wish -= axis.speed;
            let most = bounds.landing(*wish).abs().min(bounds.acceleration);
            if wish.abs() * factor > most {
                factor = most / wish.abs();
            }
        }
        let mut jerk = T::one();
        for ((wish, axis), bounds) in wishes.iter_mut().zip(&self.axes).zip(&self.bounds) {
            *wish *= factor;
            jerk = jerk.max((*wish - axis.acceleration).abs() / bounds.jerk_cycle);
        }
        let joints = self.axes.iter_mut().zip(&self.bounds).zip(&self.spans);
        for ((wish, asked), ((axis, bounds), span)) in wishes.iter().zip(speeds).zip(joints) {
            let waiting = axis.acceleration + (*wish - axis.acceleration) / jerk;
            // what would pass the speed that is asked by waiting does not wait
            let passes = axis.peak_speed_with(waiting, bounds) - *asked;
            let waits = passes * (*asked - axis.speed) <= T::zero();
            *axis = axis.stepped(if waits { waiting } else { *wish }, bounds, *span);
        }
    }

    /// The arm is taken to be at the new set-points.
    fn arrive(&mut self) -> Option<Change> {
        let joints = self.set_point();
        let from = self.recent.configuration();
        self.recent.push(&self.ways.arm, &joints);
        self.pose = self.ways.arm.forward(&joints);
        let spans = self.spans.iter_mut().zip(&self.ranges).zip(self.axes.iter().zip(&self.bounds));
        for ((span, range), (axis, bounds)) in spans {
            if span != range && axis.is_safe(bounds, *range) {
                *span = *range;
            }
        }
        let to = self.recent.configuration();
        let passages = self.passages();
        if passages.wrist {
            self.posture.wrist = to.wrist;
        }
        if passages.elbow {
            self.posture.elbow = to.elbow;
        }
        if passages.shoulder {
            self.posture.shoulder = to.shoulder;
        }
        let kind = if self.by_joints { ChangeKind::Jump } else { ChangeKind::Passage };
        (from != to).then_some(Change { from, to, kind })
    }
}

/// Whether two poses are the same but for rounding.
fn is_same<T: Real>(a: &Pose<T>, b: &Pose<T>) -> bool {
    (a.translation - b.translation)
        .iter()
        .chain((a.rotation - b.rotation).iter())
        .all(|x| x.abs() <= T::SLACK)
}
