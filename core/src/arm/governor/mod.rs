//! The governor: what the arm is told in each cycle, so that it goes where the law says and never
//! farther, faster or more abruptly than it may.
//!
//! | job | file |
//! |---|---|
//! | what limits, by name | `limits` |
//! | the goal: usable, in the box, within reach | `goal` |
//! | which way the joints go | `way` |
//! | as near as it goes: damped least squares | `least_squares` |
//! | a way round where the workspace bars that of the joints | `detour` |
//! | when it stays where it is | `rest` |
//! | how fast along it | `pace` |
//! | one joint: speed, acceleration, jerk, range | `axis` |
//! | the tool: workspace and speed | `fence` |
//! | one cycle of all that | `follow`, `motion` |
//!
//! - **Exact.** Where the arm can be at the goal it comes to be there, by the closed-form inverse; a
//!   goal that is where the arm is told to be already moves nothing, to the bit.
//! - **Bounded.** The differences of the set-points keep the bounds of speed, acceleration and jerk in
//!   every cycle, and a stop within the joint's range is possible from each of them (`axis`).
//! - **No wind-up.** All is told anew from the set-point in each cycle. A goal that cannot be reached
//!   is replaced by the nearest that can; nothing is added up, the way back begins at once.
//! - **Always a way back.** See `way`: to where the arm stood before, in the posture in which it
//!   stands, there is always one. Slowing at ends and singularities knows the direction. From every
//!   singularity, end and face the arm comes back by itself where it is asked to. Of 4,000 that
//!   went to three goals anywhere in a narrow workspace and were then asked home in one jump, all came;
//!   2 of them took more than 10 s, along the faces and by ways round, none more than 21 s.
//! - **At rest.** Short of a goal that cannot be reached the arm comes to rest, and stays there until the
//!   goal moves by more than 2 mm or 0.02 rad (`rest`): no other direction, way or posture is taken
//!   because time went by.
//! - **In the workspace.** No set-point takes the tool out of it by more than 5 mm, nor one that was
//!   outside at the start farther out (`fence`).
//! - **Slow enough.** No set-point takes the tool farther from the one before than its speed lets it,
//!   also while goals jump and joints are stopped that worked against each other (`fence`).
//! - **Never silent.** What limits is in [`Governed::limits`], a change of posture in
//!   [`Governed::change`].
//!
//! [`Governor`] is plain data, a copy of it behaves alike. Nothing here panics or allocates.

mod limits;

mod governed;

mod goal;

mod axis;

mod fence;

mod least_squares;

mod way;

mod detour;

mod pace;

mod rest;

mod follow;

mod motion;

pub use governed::{Governed, StartRefusal, Verdict};
pub use limits::{JointNumber, Limit, Limits};

use super::puma560::{Configuration, JointSet, Joints, Puma560, Recent};
use super::teleop::{Order, Uncertainty};
use crate::config::{GovernorConfig, GovernorConfigError, JOINTS};
use crate::geometry::Pose;
use crate::real::Real;
use axis::{Axis, Bounds, Span};
use detour::Detour;
use fence::Fence;
use goal::{Bounded, Left};
use pace::{Led, Pace};
use rest::Rest;
use way::Ways;

#[cfg(test)]
mod tests;

/// The most of what is left of a way that goes in one cycle.
const MOST_A_CYCLE: f64 = 0.2;

/// So near an arm that rests is home, metres and radians.
const AT_HOME_M: f64 = 0.0005;
const AT_HOME_RAD: f64 = 0.002;

/// The governor of one arm, in f32 or f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Governor<T> {
    config: GovernorConfig,
    ways: Ways<T>,
    pace: Pace<T>,
    edges: Bounded<T>,
    fence: Fence<T>,
    bounds: [Bounds<T>; JOINTS],
    ranges: [Span<T>; JOINTS],
    /// The ranges, or out to where a joint was at the start until it has come back.
    spans: [Span<T>; JOINTS],
    axes: [Axis<T>; JOINTS],
    recent: Recent<T>,
    pose: Pose<T>,
    /// Where the tool is home; `None` before the first start, where no setting says.
    home: Option<Pose<T>>,
    /// The posture that is kept. What passed a singularity by a little because it could not stop in
    /// time comes back to it.
    posture: Configuration,
    /// The one in which the arm was started.
    first_posture: Configuration,
    /// Where its joints were then, radians.
    first_joints: Joints<T>,
    by_joints: bool,
    /// On that way a joint is wound back by about a turn.
    winds_back: bool,
    detour: Detour<T>,
    rest: Rest<T>,
    /// The goal was not to be reached, and the arm is not at one yet: off the way that it was asked
    /// to go, where a passage might lead to where there is no way back from.
    barred: bool,
    stalled: u16,
    /// For so many cycles yet the arm brakes from a way by the joints that was let go, and keeps the posture that
    /// braking brings it to.
    braking: u16,
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
        let edges = Bounded::new(arm, &config.workspace);
        let home = config.home_rad.map(|joints| home(arm, &edges, &joints)).transpose()?;
        let mut fence = Fence::new(arm, &edges, T::of(config.max_tool_speed_m_s * seconds));
        fence.start(&arm.forward(&middle).translation);
        Ok(Self {
            config: *config,
            ways: Ways::new(arm, T::of(config.max_tool_speed_m_s), cycle),
            pace: Pace::new(config, response),
            edges,
            fence,
            bounds,
            ranges,
            spans: ranges,
            axes: middle.map(Axis::at),
            recent: Recent::at_rest(arm, &middle),
            pose: arm.forward(&middle),
            home,
            posture: arm.configuration(&middle),
            first_posture: arm.configuration(&middle),
            first_joints: middle,
            by_joints: false,
            winds_back: false,
            detour: Detour::none(),
            rest: Rest::new(config),
            barred: false,
            stalled: 0,
            braking: 0,
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

    /// Where the tool is home: `base_from_tool`; `None` where that is where the arm is first started, and it
    /// was not yet.
    #[must_use]
    pub const fn home(&self) -> Option<&Pose<T>> {
        self.home.as_ref()
    }

    /// Where the arm was first started is not known any more: its joints were not where it said. Home that is set
    /// stays.
    pub const fn forget_home(&mut self) {
        if self.config.home_rad.is_none() {
            self.home = None;
        }
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
        self.home = self.home.or(Some(self.pose));
        self.fence.start(&self.pose.translation);
        self.posture = self.recent.configuration();
        self.first_posture = self.posture;
        self.first_joints = *joints;
        self.by_joints = false;
        self.winds_back = false;
        self.detour = Detour::none();
        self.rest.end();
        self.barred = false;
        self.stalled = 0;
        self.braking = 0;
        Ok(())
    }

    /// Decides where the joints shall be at the end of this cycle. To be called once a cycle.
    ///
    /// `uncertainty` is how well the goal is known; `None` where nobody says.
    pub fn step(&mut self, order: &Order<T>, uncertainty: Option<&Uncertainty<T>>) -> Governed<T> {
        let mut limits = Limits::NONE;
        let before = self.axes;
        let wished = match order {
            Order::Stop => None,
            Order::Follow(goal) => Some((*goal, Led::ByHand(uncertainty))),
            Order::Home => self.home.map(|home| (home, Led::Home)),
        };
        let (verdict, speed_share) = match wished {
            None => {
                self.let_go();
                self.rest.end();
                (Verdict::Pass, T::zero())
            }
            Some((goal, led)) => match self.edges.admit(&goal, &mut limits) {
                Ok(goal) => {
                    let share = self.follow(&goal, led, &mut limits);
                    (if limits.is_empty() { Verdict::Pass } else { Verdict::Clamp }, share)
                }
                Err(limit) => {
                    limits.add(limit);
                    self.let_go();
                    (Verdict::Reject, T::zero())
                }
            },
        };
        let at_rest = self.axes.iter().zip(&before).all(|(now, before)| now.angle == before.angle)
            && self.axes.iter().all(Axis::is_at_rest);
        if !at_rest && wished.is_none() {
            limits.add(Limit::Stopping);
        }
        let change = self.arrive();
        let at_home = at_rest && self.home.is_some_and(|home| is_home(&self.nearest(&home), &self.pose));
        Governed {
            set_point: self.set_point(),
            pose: self.pose,
            verdict,
            limits,
            speed_share,
            change,
            at_rest,
            at_home,
        }
    }

    /// Where the tool comes to that is to go there: an arm may be started a little outside of its workspace.
    fn nearest(&self, goal: &Pose<T>) -> Pose<T> {
        let mut limits = Limits::NONE;
        self.edges.admit(goal, &mut limits).unwrap_or(*goal)
    }
}

/// Whether the tool is home, but for what the last joints of an arm in f32 make of it.
fn is_home<T: Real>(home: &Pose<T>, pose: &Pose<T>) -> bool {
    let left = Left::between(pose, home);
    left.place.norm() <= T::of(AT_HOME_M) && left.turn.norm() <= T::of(AT_HOME_RAD)
}

/// Where the tool is with the joints at home.
fn home<T: Real>(
    arm: &Puma560<T>,
    edges: &Bounded<T>,
    joints_rad: &[f64; JOINTS],
) -> Result<Pose<T>, GovernorConfigError> {
    for (number, (angle, range)) in (1..).zip(joints_rad.iter().zip(&arm.config().joints)) {
        // NaN is in no range
        if !(range.min_rad..=range.max_rad).contains(angle) {
            return Err(GovernorConfigError::Home(number));
        }
    }
    let home = arm.forward(&joints_rad.map(T::of));
    if edges.depth(&home.translation) < T::zero() {
        return Err(GovernorConfigError::HomeOutside);
    }
    Ok(home)
}
