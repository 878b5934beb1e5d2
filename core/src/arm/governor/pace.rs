//! How fast along the way: one factor for all joints, so that the tool keeps to it.

use super::axis::{Bounds, Span};
use super::goal::Bounded;
use super::limits::{Limit, Limits};
use super::way::{Kind, Way};
use crate::arm::puma560::{Jacobian, Joints, Puma560, Singularities};
use crate::arm::teleop::Uncertainty;
use crate::config::{AllowedPassages, GovernorConfig, JOINTS, SlowedByUncertainty};
use crate::real::Real;
use nalgebra::{Cholesky, Matrix3, Vector3, Vector6};

/// The share of its speed that a joint is asked for at most: what would just exceed it by rounding
/// would be refused by the step.
const SPEED_ASKED: f64 = 0.999;

/// The same of the tool: joints that change their speeds at different times make it faster than it is
/// asked to be, and every step that makes it too fast is refused (`fence`).
const TOOL_SPEED_ASKED: f64 = 0.86;

/// Joints that work against each other do not change their speeds alike: so much of what each does
/// alone is counted to the speed of the tool.
const WORKING_AGAINST: f64 = 0.15;

/// The share of the stopping speed that is used to come to rest at the goal, and to stay away from the
/// ends: the rest is for the lag of speeds behind what is asked.
const STOPPING_SHARE: f64 = 0.8;

/// A joint in the margin of its end slows all down to this share at most; beyond, only itself.
const WAITING_SHARE: f64 = 0.05;

/// What slows by less than this is not told.
const TOLD_SHARE: f64 = 0.98;

/// How far inside of the faces the tool keeps on its way by the joints, metres. Joints that bring it along
/// a face work against each other, and none of them can be stopped without the tool swinging out: at the
/// face itself hardly any speed is left that the fence lets pass.
const KEPT_FROM_FACES_M: f64 = 0.01;

/// With less to go the joints' way comes nearer to the faces, down to none at its end, radians.
const UP_TO_FACES_RAD: f64 = 0.2;

/// On how much the tool slows down that is nearer to a face, or farther out, than it should be, metres.
const SLOWED_AT_FACES_M: f64 = 0.01;

/// How often the faces are gone through in one cycle.
const FACE_ROUNDS: usize = 3;

/// Relative to joints that move the tool by a metre a radian: where two faces cannot both be kept to.
const FACE_DAMPING: f64 = 1e-6;

/// A correction at the edge of the workspace is told from this speed on, m/s.
const TOLD_SPEED_M_S: f64 = 0.001;

/// What does not change from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pace<T> {
    /// What is left of the way is gone by this share a second.
    pub(super) response: T,
    tool_speed: T,
    margin: T,
    singular_margin: T,
    creep: T,
    uncertainty: SlowedByUncertainty,
    home_share: T,
}

/// Who leads the arm to its goal.
#[derive(Clone, Copy)]
pub(super) enum Led<'a, T> {
    /// The hand, known so well; `None` where nobody says.
    ByHand(Option<&'a Uncertainty<T>>),
    /// Nobody: it goes home.
    Home,
}

/// How the arm stands.
pub(super) struct Stance<'a, T> {
    pub(super) arm: &'a Puma560<T>,
    pub(super) joints: &'a Joints<T>,
    pub(super) place: &'a Vector3<T>,
    pub(super) jacobian: &'a Jacobian<T>,
    /// The speeds that the joints come to by the acceleration that they have.
    pub(super) bound_for: &'a Joints<T>,
    pub(super) bounds: &'a [Bounds<T>; JOINTS],
    pub(super) ranges: &'a [Span<T>; JOINTS],
    pub(super) edges: &'a Bounded<T>,
    pub(super) passages: AllowedPassages,
}

/// What was decided.
pub(super) struct Paced<T> {
    /// The speeds asked of the joints, rad/s.
    pub(super) speeds: Joints<T>,
    /// How fast the tool is, beside how fast it might be if nothing but its own speed limited it.
    pub(super) share: T,
    /// Something had to be taken away for the tool to stay in the workspace.
    pub(super) at_face: bool,
}

/// Limits of the common factor and their names.
struct Factor<T> {
    least: T,
    named: [(Option<Limit>, T); JOINTS * 2 + 1],
}

impl<T: Real> Factor<T> {
    fn at_most(&mut self, place: usize, limit: Limit, factor: T) {
        self.least = self.least.min(factor);
        if let Some(named) = self.named.get_mut(place) {
            *named = (Some(limit), factor);
        }
    }
}

impl<T: Real> Pace<T> {
    pub(super) fn new(config: &GovernorConfig, response: T) -> Self {
        Self {
            response,
            tool_speed: T::of(config.max_tool_speed_m_s * TOOL_SPEED_ASKED),
            margin: T::of(config.limit_margin_rad),
            singular_margin: T::of(config.singularity_margin),
            creep: T::of(config.creep_share),
            uncertainty: config.uncertainty,
            home_share: T::of(config.home_speed_share),
        }
    }

    /// The most of its speed that the tool has, whatever else slows it.
    pub(super) fn most(&self, led: Led<'_, T>) -> T {
        match led {
            Led::ByHand(_) => T::one(),
            Led::Home => self.home_share,
        }
    }

    /// The speeds of the joints along the way.
    pub(super) fn along(
        &self,
        way: &Way<T>,
        now: &Stance<'_, T>,
        led: Led<'_, T>,
        limits: &mut Limits,
    ) -> Paced<T> {
        let mut left = way.left;
        self.keep_outside_joints_from_leaving(&mut left, now);
        let tool = tool_speed(now.jacobian, &left);
        let known = match led {
            Led::ByHand(uncertainty) => self.known_share(uncertainty, limits),
            Led::Home => self.home_share,
        };
        let ideal = per(self.tool_speed, tool).min(self.response);
        let mut share = known;
        let mut factor = self.factor(&left, tool, share, now);
        let (singular, most) = self.near_singularities(&left, factor.least, way.kind, now, limits);
        if singular < T::one() {
            share *= singular;
            factor = self.factor(&left, tool, share, now);
        }
        factor.least = factor.least.min(most);
        if factor.least < self.response * T::of(TOLD_SHARE) {
            let binding = factor.least / T::of(TOLD_SHARE);
            for (limit, _) in factor.named.iter().filter(|(_, at_most)| *at_most <= binding) {
                limit.iter().for_each(|limit| limits.add(*limit));
            }
        }
        // the tool as fast as it is bound to be: what is too much of it is asked back three times
        let fast = (tool_speed(now.jacobian, now.bound_for) / self.tool_speed).max(T::one());
        let mut speeds = left.map(|way| way * factor.least / (fast * fast * fast));
        self.keep_from_ends(&mut speeds, now);
        let (at_face, along_face) = self.keep_in_box(&mut speeds, &left, way.kind, now);
        if at_face {
            limits.add(Limit::WorkspaceEdge);
        }
        Paced { speeds, share: (factor.least / ideal).min(T::one()) * along_face, at_face }
    }

    fn keep_outside_joints_from_leaving(&self, left: &mut Joints<T>, now: &Stance<'_, T>) {
        for (way, (angle, range)) in left.iter_mut().zip(now.joints.iter().zip(now.ranges)) {
            if *angle < range.min {
                *way = way.max(T::zero());
            } else if *angle > range.max {
                *way = way.min(T::zero());
            }
        }
    }

    /// By which `left` becomes speeds, 1/s.
    fn factor(&self, left: &Joints<T>, tool: T, share: T, now: &Stance<'_, T>) -> Factor<T> {
        let mut factor = Factor { least: self.response, named: [(None, self.response); JOINTS * 2 + 1] };
        factor.at_most(JOINTS * 2, Limit::ToolSpeed, per(self.tool_speed * share, tool));
        let joints = left.iter().zip(now.bounds).zip(now.joints.iter().zip(now.ranges));
        for (place, ((way, bounds), (angle, range))) in joints.enumerate() {
            let number = place as u8 + 1;
            let size = way.abs();
            let speed = per(bounds.speed * share * T::of(SPEED_ASKED), size);
            let stopping = per(bounds.stoppable(size) * T::of(STOPPING_SHARE), size);
            if speed < stopping {
                factor.at_most(place, Limit::JointSpeed(number), speed);
            } else {
                factor.at_most(place, Limit::JointAcceleration(number), stopping);
            }
            let up = *way > T::zero();
            let room = if up { range.max - *angle } else { *angle - range.min };
            let floor = bounds.speed * T::of(WAITING_SHARE);
            let near_end = per(self.near_end(room, bounds).max(floor), size);
            let limit = if up { Limit::NearUpperLimit(number) } else { Limit::NearLowerLimit(number) };
            factor.at_most(JOINTS + place, limit, near_end);
        }
        factor
    }

    /// How fast a joint may go towards an end that is `room` radians away.
    fn near_end(&self, room: T, bounds: &Bounds<T>) -> T {
        let room = room.max(T::zero());
        let stopping = bounds.stoppable(room) * T::of(STOPPING_SHARE);
        if room < self.margin { stopping.min(bounds.speed * (room / self.margin)) } else { stopping }
    }

    fn keep_from_ends(&self, speeds: &mut Joints<T>, now: &Stance<'_, T>) {
        let joints = speeds.iter_mut().zip(now.bounds).zip(now.joints.iter().zip(now.ranges));
        for ((speed, bounds), (angle, range)) in joints {
            let upwards = self.near_end(range.max - *angle, bounds);
            let downwards = self.near_end(*angle - range.min, bounds);
            *speed = speed.min(upwards).max(-downwards);
        }
    }

    /// The share of speed that is left where the way leads nearer to a singularity, and the largest
    /// factor with which one that is not to be passed is still not passed.
    fn near_singularities(
        &self,
        left: &Joints<T>,
        factor: T,
        kind: Kind,
        now: &Stance<'_, T>,
        limits: &mut Limits,
    ) -> (T, T) {
        let mut ahead = *now.joints;
        for ((angle, way), bounds) in ahead.iter_mut().zip(left).zip(now.bounds) {
            *angle += *way * factor * bounds.cycle;
        }
        let here = self.nearness(now.arm, &now.arm.singularities(now.joints));
        let ahead = self.nearness(now.arm, &now.arm.singularities(&ahead));
        let names = [Limit::WristSingularity, Limit::ElbowSingularity, Limit::ShoulderSingularity];
        let mut share = T::one();
        let mut most = factor;
        let cycle = now.bounds.iter().fold(T::zero(), |_, bounds| bounds.cycle);
        let passages = [now.passages.wrist, now.passages.elbow, now.passages.shoulder]
            .map(|passage| passage && kind == Kind::Straight);
        for (((here, ahead), limit), passable) in here.into_iter().zip(ahead).zip(names).zip(passages) {
            let crosses = (here < T::zero()) != (ahead < T::zero());
            if !crosses && ahead.abs() >= here.abs() {
                continue;
            }
            let mut limits_it = here.abs() < self.singular_margin;
            if limits_it {
                share = share.min((here.abs() / self.singular_margin).max(self.creep));
            }
            // through what is not to be passed only the joints' way may lead, and back again
            if !passable && kind != Kind::ByJoints {
                let gone = (here - ahead).abs() / cycle;
                let allowed = here.abs() * self.response * T::of(0.5);
                if allowed < gone {
                    limits_it = true;
                    most = most.min(factor * allowed / gone);
                }
            }
            if limits_it {
                limits.add(limit);
            }
        }
        (share, most)
    }

    /// The factors of det J, each as a share of the largest that it can be; half of the reach is about
    /// the length of the lower arm.
    fn nearness(&self, arm: &Puma560<T>, at: &Singularities<T>) -> [T; 3] {
        [at.wrist, at.elbow_m / (arm.reach() * T::of(0.5)), at.shoulder_m / arm.reach()]
    }

    fn known_share(&self, uncertainty: Option<&Uncertainty<T>>, limits: &mut Limits) -> T {
        let Some(u) = uncertainty else { return T::one() };
        let by = &self.uncertainty;
        let falling = |x: T, full: f64, creep: f64| {
            let share = (T::of(creep) - x) / T::of(creep - full);
            // a number that is none is the least known of all
            if share >= self.creep { share.min(T::one()) } else { self.creep }
        };
        let place = falling(u.place_m, by.full_m, by.creep_m);
        let share = place.min(falling(u.turn_rad, by.full_rad, by.creep_rad));
        if share < T::one() {
            limits.add(Limit::HandUncertain);
        }
        share
    }

    /// Takes away what would carry the tool out of the workspace, by as little of the joints as does it.
    /// Whether it was worth telling, and the share of speed that is left along the faces.
    fn keep_in_box(
        &self,
        speeds: &mut Joints<T>,
        left: &Joints<T>,
        kind: Kind,
        now: &Stance<'_, T>,
    ) -> (bool, T) {
        // the straight way to a goal in the box does not lead out of it
        let response = if kind == Kind::Straight { self.response } else { self.response * T::of(0.5) };
        let inside = kept_from_faces(left, kind, now.edges);
        // what is out is asked back, gently
        let back = -self.tool_speed * self.creep;
        let rows = now.jacobian.fixed_rows::<3>(0).into_owned();
        let mut wished = Vector6::from(*speeds);
        let out = (inside - now.edges.depth(now.place)) / T::of(SLOWED_AT_FACES_M);
        let sides = now.edges.min.zip_zip_map(&now.edges.max, now.place, |min, max, place| {
            (((place - min - inside) * response).max(back), ((max - place - inside) * response).max(back))
        });
        let bounded = |speeds: &Vector3<T>| {
            speeds.zip_map(&sides, |speed, (down, up)| speed - speed.min(up).max(-down))
        };
        let mut share = T::one();
        if out > T::zero() && bounded(&(rows * wished)) != Vector3::zeros() {
            // along the face the slower the nearer to it, or the farther beyond
            share = (T::one() - out).max(self.creep);
            wished *= share;
        }
        let asked = rows * wished;
        let over = bounded(&asked);
        let told = over.iter().any(|over| over.abs() > T::of(TOLD_SPEED_M_S));
        // what one face takes away another may ask back: all of them at once that were met so far
        let mut met = Vector3::zeros();
        let mut kept = wished;
        for _ in 0..FACE_ROUNDS {
            let beyond = bounded(&(rows * kept));
            if beyond.iter().all(|beyond| beyond.abs() <= T::SLACK) {
                break;
            }
            met = met.zip_map(&beyond, |met, beyond| if beyond == T::zero() { met } else { T::one() });
            let active = Matrix3::from_diagonal(&met) * rows;
            let damping = Matrix3::identity() * T::SLACK.max(T::of(FACE_DAMPING));
            let target = bounded(&asked).component_mul(&met);
            let Some(inverse) = Cholesky::new(active * active.transpose() + damping) else { break };
            kept = wished - active.tr_mul(&inverse.solve(&target));
        }
        for (speed, kept) in speeds.iter_mut().zip(kept.iter()) {
            *speed = *kept;
        }
        let mut most = T::one();
        for (speed, bounds) in speeds.iter().zip(now.bounds) {
            most = most.max(speed.abs() / (bounds.speed * T::of(SPEED_ASKED)));
        }
        if most > T::one() {
            *speeds = speeds.map(|speed| speed / most);
        }
        (told, share)
    }
}

/// How far inside of the faces the tool is to keep, metres.
fn kept_from_faces<T: Real>(left: &Joints<T>, kind: Kind, edges: &Bounded<T>) -> T {
    // the straight way to a goal in the box does not lead out of it
    if kind == Kind::Straight {
        return T::zero();
    }
    let most = left.iter().fold(T::zero(), |most, left| most.max(left.abs()));
    let size = edges.max - edges.min;
    let kept = T::of(KEPT_FROM_FACES_M).min(size.x.min(size.y).min(size.z) * T::of(0.25));
    kept * (most / T::of(UP_TO_FACES_RAD)).min(T::one())
}

/// `most / size`; where there is nothing to be divided, as much as anything.
fn per<T: Real>(most: T, size: T) -> T {
    if size > T::zero() { most / size } else { T::of(1e12) }
}

/// How fast the tool goes at these speeds of the joints, m/s, and some of what it would gain if those
/// joints stopped first that now work against others.
fn tool_speed<T: Real>(jacobian: &Jacobian<T>, speeds: &Joints<T>) -> T {
    let rows = jacobian.fixed_rows::<3>(0);
    let (mut sum, mut alone) = (Vector3::zeros(), T::zero());
    for (column, speed) in rows.column_iter().zip(speeds) {
        let by_this = column * *speed;
        sum += by_this;
        alone += by_this.norm();
    }
    let together = sum.norm();
    together + (alone - together) * T::of(WORKING_AGAINST)
}
