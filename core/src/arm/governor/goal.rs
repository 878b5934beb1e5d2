//! Where the arm is asked to go, and the nearest that it can be asked.

use super::limits::{Limit, Limits};
use crate::arm::puma560::Puma560;
use crate::config::Workspace;
use crate::geometry::Pose;
use crate::hand::so3;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// How far R^T R of a goal's rotation may be from the identity, as in the inverse.
const MAX_SKEW: f64 = 0.01;

/// The farthest goal that is believed, metres.
const MAX_PLACE_M: f64 = 1000.0;

/// What does not depend on the joints: the box, and the shell that the wrist centre can be in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounded<T> {
    pub(super) min: Vector3<T>,
    pub(super) max: Vector3<T>,
    wrist_in_tool: Pose<T>,
    shoulder_height: T,
    /// Radius of the cylinder about the first axis that the wrist centre cannot enter.
    offset: T,
    reach: T,
    inner_reach: T,
}

impl<T: Real> Bounded<T> {
    pub(super) fn new(arm: &Puma560<T>, workspace: &Workspace) -> Self {
        let config = arm.config();
        let tool = Pose {
            rotation: config.tool.rotation.map(T::of),
            translation: config.tool.translation.map(T::of),
        };
        Self {
            min: Vector3::from(workspace.min_m.map(T::of)),
            max: Vector3::from(workspace.max_m.map(T::of)),
            wrist_in_tool: tool.inverse(),
            shoulder_height: T::of(config.lengths.base_m),
            offset: T::of(config.lengths.offset_m),
            reach: arm.reach(),
            inner_reach: arm.inner_reach(),
        }
    }

    /// How far inside the box a place is, metres; below 0 where it is out.
    pub(super) fn depth(&self, place: &Vector3<T>) -> T {
        let depths = (place - self.min).zip_map(&(self.max - place), |a, b| a.min(b));
        depths.x.min(depths.y).min(depths.z)
    }

    /// The goal in the box and within reach, its orientation kept.
    ///
    /// # Errors
    /// What is wrong with a goal that cannot be used at all.
    pub(super) fn admit(&self, goal: &Pose<T>, limits: &mut Limits) -> Result<Pose<T>, Limit> {
        check(goal)?;
        let place = goal.translation.zip_zip_map(&self.min, &self.max, |x, min, max| x.max(min).min(max));
        if place != goal.translation {
            limits.add(Limit::WorkspaceEdge);
        }
        let inside = Pose { rotation: goal.rotation, translation: place };
        let wrist = inside.compose(&self.wrist_in_tool).translation;
        Ok(match self.reachable(&wrist) {
            None => inside,
            Some((nearest, limit)) => {
                limits.add(limit);
                Pose { translation: place + (nearest - wrist), ..inside }
            }
        })
    }

    /// The place nearest to this one that the wrist centre can be at, and why it is another; `None`
    /// where it is not.
    fn reachable(&self, wrist: &Vector3<T>) -> Option<(Vector3<T>, Limit)> {
        let from_axis = (wrist.x * wrist.x + wrist.y * wrist.y).sqrt();
        let up = wrist.z - self.shoulder_height;
        let mut limit = None;
        // in the plane of the arm: out from the cylinder, up from the shoulder
        let free = from_axis - self.offset;
        let mut out = if free < -T::SLACK {
            limit = Some(Limit::TooNear);
            T::zero()
        } else {
            (free.max(T::zero()) * (from_axis + self.offset)).sqrt()
        };
        let mut height = up;
        let distance = (out * out + up * up).sqrt();
        let nearest = if distance > self.reach + T::SLACK {
            limit = Some(Limit::TooFar);
            self.reach
        } else if distance < self.inner_reach - T::SLACK {
            limit = Some(Limit::TooNear);
            self.inner_reach
        } else {
            distance
        };
        if distance > T::zero() {
            out *= nearest / distance;
            height *= nearest / distance;
        } else {
            out = nearest;
        }
        let limit = limit?;
        let radius = (out * out + self.offset * self.offset).sqrt();
        let (x, y) = if from_axis > T::zero() {
            (wrist.x * (radius / from_axis), wrist.y * (radius / from_axis))
        } else {
            (radius, T::zero())
        };
        Some((Vector3::new(x, y, self.shoulder_height + height), limit))
    }
}

fn check<T: Real>(goal: &Pose<T>) -> Result<(), Limit> {
    let most = T::of(MAX_PLACE_M);
    // comparisons written so that NaN fails them
    if !goal.translation.iter().all(|x| x.abs() <= most) || !goal.rotation.iter().all(|x| x.abs() <= most) {
        return Err(Limit::GoalNotFinite);
    }
    let skew = goal.rotation.tr_mul(&goal.rotation) - Matrix3::identity();
    let is_rotation =
        skew.iter().all(|x| x.abs() <= T::of(MAX_SKEW)) && goal.rotation.determinant() > T::zero();
    if is_rotation { Ok(()) } else { Err(Limit::GoalNotARotation) }
}

/// What is left from one pose to another: metres and radians, both in the base's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Left<T> {
    pub(super) place: Vector3<T>,
    pub(super) turn: Vector3<T>,
}

impl<T: Real> Left<T> {
    pub(super) fn between(from: &Pose<T>, to: &Pose<T>) -> Self {
        Self {
            place: to.translation - from.translation,
            turn: so3::log(&(to.rotation * from.rotation.transpose())),
        }
    }

    /// The pose after this share of the straight way.
    pub(super) fn along(&self, from: &Pose<T>, share: T) -> Pose<T> {
        Pose {
            rotation: so3::exp(&(self.turn * share)) * from.rotation,
            translation: from.translation + self.place * share,
        }
    }
}
