//! One cycle of all joints: from the speeds that they have towards those that are asked.

use super::Governor;
use super::axis::Axis;
use super::detour::Detour;
use super::limits::Limit;
use crate::arm::puma560::{Change, ChangeKind, Joints};
use crate::config::JOINTS;
use crate::real::Real;

/// How much quicker speeds follow what is asked than the way is gone: the two make a motion that
/// comes to its end without passing it.
const SPEED_RESPONSE: f64 = 4.0;

/// Halvings between a stop and the step that is wished for.
const HALVINGS: u32 = 4;

impl<T: Real> Governor<T> {
    /// One cycle of a stop.
    pub(super) fn stop(&mut self) {
        self.brake();
        self.by_joints = false;
        self.winds_back = false;
        self.detour = Detour::none();
        self.stalled = 0;
    }

    /// The same, and what was to be done next stays as it is.
    pub(super) fn brake(&mut self) {
        for (axis, bounds) in self.axes.iter_mut().zip(&self.bounds) {
            *axis = axis.stopped(bounds);
        }
    }

    /// One cycle from the speeds that are towards those that are asked. One factor for the
    /// accelerations of all joints, and one for what changes of them: the speeds come to what is asked
    /// straight, so that the tool does not swing out while one joint waits for another. What was in the
    /// way, if anything.
    pub(super) fn turn_to(&mut self, speeds: &Joints<T>) -> Option<Limit> {
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
        let mut next = self.axes;
        let joints = next.iter_mut().zip(&self.bounds).zip(&self.spans);
        for ((wish, asked), ((axis, bounds), span)) in wishes.iter().zip(speeds).zip(joints) {
            let waiting = axis.acceleration + (*wish - axis.acceleration) / jerk;
            // what would pass the speed that is asked by waiting does not wait
            let passes = axis.peak_speed_with(waiting, bounds) - *asked;
            let waits = passes * (*asked - axis.speed) <= T::zero();
            *axis = axis.stepped(if waits { waiting } else { *wish }, bounds, *span);
        }
        self.take(&next)
    }

    /// Takes these steps, or ones between them and those of a stop: from where they lead to the tool
    /// can be stopped within the workspace, and is never too fast. What forbids the steps themselves.
    fn take(&mut self, next: &[Axis<T>; JOINTS]) -> Option<Limit> {
        let Some(limit) = self.fence.forbids(&self.ways.arm, &self.pose.translation, next, &self.bounds)
        else {
            self.axes = *next;
            return None;
        };
        let mut stopped = self.axes;
        for (axis, bounds) in stopped.iter_mut().zip(&self.bounds) {
            *axis = axis.stopped(bounds);
        }
        let mut best = stopped;
        let (mut good, mut bad) = (T::zero(), T::one());
        for _ in 0..HALVINGS {
            let share = (good + bad) * T::of(0.5);
            let mut tried = self.axes;
            let mut is_safe = true;
            let joints = tried.iter_mut().zip(&self.bounds).zip(&self.spans);
            for (((axis, bounds), span), (stopped, next)) in joints.zip(stopped.iter().zip(next)) {
                let more = next.acceleration - stopped.acceleration;
                *axis = axis.moved(stopped.acceleration + more * share, bounds);
                is_safe &= axis.is_safe(bounds, *span);
            }
            let place = &self.pose.translation;
            if is_safe && self.fence.forbids(&self.ways.arm, place, &tried, &self.bounds).is_none() {
                (best, good) = (tried, share);
            } else {
                bad = share;
            }
        }
        self.axes = best;
        Some(limit)
    }

    /// The arm is taken to be at the new set-points.
    pub(super) fn arrive(&mut self) -> Option<Change> {
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
        if self.braking > 0 {
            self.braking = if self.axes.iter().all(Axis::is_at_rest) { 0 } else { self.braking - 1 };
            self.posture = to;
        }
        let kind = if self.by_joints { ChangeKind::Jump } else { ChangeKind::Passage };
        (from != to).then_some(Change { from, to, kind })
    }
}
