//! The workspace and the speed of the tool as bounds: no set-point takes it farther out than
//! [`OVER_FACE_M`], nor farther in a cycle than it may go.
//!
//! As with a joint's range (`axis`): there is one way to stop all joints, and a step is taken only if on
//! that whole way, set-point by set-point, the tool stays within and slow enough. The stop's own first step always
//! does, because the step before it was tested the same way.
//!
//! Between two set-points that are within, the tool bends out by less than 1 mm: at 100 Hz it goes 5 mm.

use super::axis::{Axis, Bounds, MAX_STOP_CYCLES};
use super::goal::Bounded;
use super::limits::Limit;
use crate::arm::puma560::{Joints, Puma560};
use crate::config::JOINTS;
use crate::real::Real;
use nalgebra::Vector3;

/// How far the tool may be outside of a face, metres. Steering keeps it in; this is for what swings over
/// while the joints lose their speeds.
pub(super) const OVER_FACE_M: f64 = 0.005;

/// How much farther out than it was a tool may go that was outside at the start, metres: room to turn
/// round in.
const ROOM_TO_TURN_M: f64 = 0.001;

/// What sums of lengths and speeds are taken too large by.
const IN_HAND: f64 = 1.01;

/// A box about places.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hull<T> {
    min: Vector3<T>,
    max: Vector3<T>,
}

impl<T: Real> Hull<T> {
    fn widened(&self, by: T) -> Self {
        Self { min: self.min.map(|x| x - by), max: self.max.map(|x| x + by) }
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            min: self.min.zip_map(&other.min, |a, b| a.min(b)),
            max: self.max.zip_map(&other.max, |a, b| a.max(b)),
        }
    }

    fn common(&self, other: &Self) -> Self {
        Self {
            min: self.min.zip_map(&other.min, |a, b| a.max(b)),
            max: self.max.zip_map(&other.max, |a, b| a.min(b)),
        }
    }

    /// How far inside a place is, metres; below 0 where it is not.
    fn depth(&self, place: &Vector3<T>) -> T {
        let depths = (place - self.min).zip_map(&(self.max - place), |a, b| a.min(b));
        depths.x.min(depths.y).min(depths.z)
    }
}

/// Where the tool may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fence<T> {
    /// The workspace and what the tool may be outside of it.
    plain: Hull<T>,
    /// The same, or out to where the tool is on its way back in.
    held: Hull<T>,
    /// How far the tool is from each joint's axis at most, metres.
    levers: Joints<T>,
    /// How far the tool may go in a cycle, metres.
    step: T,
}

impl<T: Real> Fence<T> {
    pub(super) fn new(arm: &Puma560<T>, edges: &Bounded<T>, step: T) -> Self {
        let config = arm.config();
        let tool = config.tool.translation.map(T::of).norm();
        let offset = T::of(config.lengths.offset_m);
        let whole = arm.reach() + offset + tool;
        let plain = Hull { min: edges.min, max: edges.max }.widened(T::of(OVER_FACE_M));
        let levers = [whole, whole, whole, tool, tool, tool].map(|lever| lever * T::of(IN_HAND));
        Self { plain, held: plain, levers, step }
    }

    /// The tool is at rest here.
    pub(super) fn start(&mut self, place: &Vector3<T>) {
        self.held = self.plain.with(&Hull { min: *place, max: *place }.widened(T::of(ROOM_TO_TURN_M)));
    }

    /// What forbids this step from where the tool is, `from`: on it, or if all joints are stopped after it,
    /// the tool would be too fast or go where it may not be. If nothing does and the tool was outside, it
    /// may from now on not go farther out than on this way.
    pub(super) fn forbids(
        &mut self,
        arm: &Puma560<T>,
        from: &Vector3<T>,
        axes: &[Axis<T>; JOINTS],
        bounds: &[Bounds<T>; JOINTS],
    ) -> Option<Limit> {
        let way = match self.stopping(arm, from, axes, bounds) {
            Ok(way) => way,
            Err(limit) => return Some(limit),
        };
        if self.held != self.plain {
            let turning = way.widened(T::of(ROOM_TO_TURN_M));
            self.held = self.held.common(&self.plain.with(&turning));
        }
        None
    }

    /// Where the tool goes if all joints are stopped, as far as it comes near to where it may not be.
    fn stopping(
        &self,
        arm: &Puma560<T>,
        from: &Vector3<T>,
        axes: &[Axis<T>; JOINTS],
        bounds: &[Bounds<T>; JOINTS],
    ) -> Result<Hull<T>, Limit> {
        let look = |axes: &[Axis<T>; JOINTS]| arm.forward(&axes.map(|axis| axis.angle)).translation;
        let mut axes = *axes;
        let mut way: Option<Hull<T>> = None;
        // where the tool was a cycle before, if it was looked for, and how the joints were
        let mut before = (Some(*from), axes);
        // cycles in which the tool cannot get from where it was last looked for to the fence
        let mut blind = T::zero();
        for _ in 0..MAX_STOP_CYCLES {
            let at_rest = axes.iter().all(Axis::is_at_rest);
            let may_be_fast = self.most_gone(&axes, bounds) > self.step;
            let mut place = None;
            if blind < T::one() || at_rest || may_be_fast {
                let here = look(&axes);
                place = Some(here);
                if may_be_fast {
                    let from = before.0.unwrap_or_else(|| look(&before.1));
                    // written so that NaN is too fast
                    let is_slow = (here - from).norm() <= self.step;
                    if !is_slow {
                        return Err(Limit::ToolSpeed);
                    }
                }
                // written so that NaN is nowhere
                let within = self.held.depth(&here) >= T::zero();
                if !within {
                    return Err(Limit::WorkspaceEdge);
                }
                let met = Hull { min: here, max: here };
                let met = way.map_or(met, |way| way.with(&met));
                let depth = self.plain.depth(&here);
                let a_cycle = self.farthest_a_cycle(&axes, bounds);
                if at_rest || a_cycle <= self.step && self.farthest(&axes, bounds) < depth {
                    return Ok(met);
                }
                way = Some(met);
                blind = (depth / a_cycle).max(T::zero());
            } else {
                blind -= T::one();
            }
            before = (place, axes);
            for (axis, bounds) in axes.iter_mut().zip(bounds) {
                *axis = axis.stopped(bounds);
            }
        }
        Err(Limit::WorkspaceEdge)
    }

    /// How far the tool has gone at most in the cycle that led here, metres.
    fn most_gone(&self, axes: &[Axis<T>; JOINTS], bounds: &[Bounds<T>; JOINTS]) -> T {
        let joints = self.levers.iter().zip(axes.iter().zip(bounds));
        joints.fold(T::zero(), |sum, (lever, (axis, bounds))| sum + *lever * axis.speed.abs() * bounds.cycle)
    }

    /// How far the tool goes at most until all joints have stopped, metres.
    fn farthest(&self, axes: &[Axis<T>; JOINTS], bounds: &[Bounds<T>; JOINTS]) -> T {
        let joints = self.levers.iter().zip(axes.iter().zip(bounds));
        joints.fold(T::zero(), |sum, (lever, (axis, bounds))| sum + *lever * axis.farthest_stop(bounds))
    }

    /// The same in one of the cycles until then.
    fn farthest_a_cycle(&self, axes: &[Axis<T>; JOINTS], bounds: &[Bounds<T>; JOINTS]) -> T {
        let joints = self.levers.iter().zip(axes.iter().zip(bounds));
        joints.fold(T::EPSILON, |sum, (lever, (axis, bounds))| {
            let fastest = axis.speed.abs().max(axis.peak_speed(bounds).abs());
            sum + *lever * fastest * bounds.cycle
        })
    }
}
