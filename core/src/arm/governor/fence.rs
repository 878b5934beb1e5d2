//! The workspace as a bound: no set-point takes the tool farther out than [`OVER_FACE_M`].
//!
//! As with a joint's range (`axis`): there is one way to stop all joints, and a step is taken only if on
//! that whole way, set-point by set-point, the tool stays within. The stop's own first step always
//! does, because the step before it was tested the same way.
//!
//! Between two set-points that are within, the tool bends out by less than 1 mm: at 100 Hz it goes 5 mm.

use super::axis::{Axis, Bounds, MAX_STOP_CYCLES};
use super::goal::Bounded;
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
}

impl<T: Real> Fence<T> {
    pub(super) fn new(arm: &Puma560<T>, edges: &Bounded<T>) -> Self {
        let config = arm.config();
        let tool = config.tool.translation.map(T::of).norm();
        let offset = T::of(config.lengths.offset_m);
        let whole = arm.reach() + offset + tool;
        let plain = Hull { min: edges.min, max: edges.max }.widened(T::of(OVER_FACE_M));
        let levers = [whole, whole, whole, tool, tool, tool].map(|lever| lever * T::of(IN_HAND));
        Self { plain, held: plain, levers }
    }

    /// The tool is at rest here.
    pub(super) fn start(&mut self, place: &Vector3<T>) {
        self.held = self.plain.with(&Hull { min: *place, max: *place }.widened(T::of(ROOM_TO_TURN_M)));
    }

    /// Whether the tool, stopped from here on, stays where it may be. If so and it was outside, it may
    /// from now on not go farther out than on this way.
    pub(super) fn admits(
        &mut self,
        arm: &Puma560<T>,
        axes: &[Axis<T>; JOINTS],
        bounds: &[Bounds<T>; JOINTS],
    ) -> bool {
        let Some(way) = self.stopping(arm, axes, bounds) else { return false };
        if self.held != self.plain {
            let turning = way.widened(T::of(ROOM_TO_TURN_M));
            self.held = self.held.common(&self.plain.with(&turning));
        }
        true
    }

    /// Where the tool goes if all joints are stopped, as far as it comes near to where it may not be;
    /// `None` if it goes there.
    fn stopping(
        &self,
        arm: &Puma560<T>,
        axes: &[Axis<T>; JOINTS],
        bounds: &[Bounds<T>; JOINTS],
    ) -> Option<Hull<T>> {
        let mut axes = *axes;
        let mut way: Option<Hull<T>> = None;
        // cycles in which the tool cannot get from where it was last looked for to the fence
        let mut blind = T::zero();
        for _ in 0..MAX_STOP_CYCLES {
            let at_rest = axes.iter().all(Axis::is_at_rest);
            if blind < T::one() || at_rest {
                let place = arm.forward(&axes.map(|axis| axis.angle)).translation;
                // written so that NaN is nowhere
                let within = self.held.depth(&place) >= T::zero();
                if !within {
                    return None;
                }
                let here = Hull { min: place, max: place };
                let met = way.map_or(here, |way| way.with(&here));
                let depth = self.plain.depth(&place);
                if at_rest || self.farthest(&axes, bounds) < depth {
                    return Some(met);
                }
                way = Some(met);
                blind = (depth / self.farthest_a_cycle(&axes, bounds)).max(T::zero());
            } else {
                blind -= T::one();
            }
            for (axis, bounds) in axes.iter_mut().zip(bounds) {
                *axis = axis.stopped(bounds);
            }
        }
        None
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
