//! Angles that differ by whole turns mean the same posture, but not the same place in a joint's
//! range.

use super::joint_set::JointSet;
use super::model::{Joints, Puma560, Range};
use crate::config::JOINTS;
use crate::real::Real;

/// `angle` plus the whole turns that bring it nearest to `near`.
#[inline]
pub(super) fn nearest_turn<T: Real>(angle: T, near: T) -> T {
    let off = near - angle;
    // the usual case needs no division
    if off.abs() <= T::pi() { angle } else { angle + T::two_pi() * (off / T::two_pi() + T::of(0.5)).floor() }
}

/// The angle between -pi and pi that means the same as `angle`.
pub(super) fn wrapped<T: Real>(angle: T) -> T {
    nearest_turn(angle, T::zero())
}

impl<T: Real> Range<T> {
    /// By how much `angle` is outside the range, radians; 0 inside.
    #[inline]
    pub(super) fn excess(self, angle: T) -> T {
        if angle > self.max {
            angle - self.max
        } else if angle < self.min {
            self.min - angle
        } else {
            T::zero()
        }
    }

    /// The angle inside the range that means the same as `angle` and is nearest to it. An excess
    /// that may be rounding is cut off.
    #[inline]
    fn fit(self, angle: T) -> Option<T> {
        let inside = if angle > self.max + T::SLACK {
            angle - T::two_pi() * ((angle - self.max - T::SLACK) / T::two_pi()).ceil()
        } else if angle < self.min - T::SLACK {
            angle + T::two_pi() * ((self.min - T::SLACK - angle) / T::two_pi()).ceil()
        } else {
            angle
        };
        (self.excess(inside) <= T::SLACK).then(|| self.cut(inside))
    }

    /// `angle`, or the end of the range that it is beyond.
    #[inline]
    fn cut(self, angle: T) -> T {
        if angle > self.max {
            self.max
        } else if angle < self.min {
            self.min
        } else {
            angle
        }
    }
}

impl<T: Real> Puma560<T> {
    /// The angles that mean the same as `joints` and are nearest to `near`; where some are in their
    /// joint's range, the nearest of those. And the joints for which none is.
    #[inline]
    pub(super) fn fit(&self, joints: &Joints<T>, near: &Joints<T>) -> (Joints<T>, JointSet) {
        let mut fitted = *joints;
        let mut outside = [false; JOINTS];
        let places = fitted.iter_mut().zip(&mut outside).zip(near).zip(&self.ranges);
        for (((angle, outside), near), range) in places {
            *angle = nearest_turn(*angle, *near);
            match range.fit(*angle) {
                Some(inside) => *angle = inside,
                None => *outside = true,
            }
        }
        (fitted, JointSet::from_flags(outside))
    }

    /// The angles that mean the same as `joints` and are nearest to `near`, ranges or not. An excess
    /// that may be rounding is cut off.
    pub(super) fn carried(&self, joints: &Joints<T>, near: &Joints<T>) -> Joints<T> {
        let mut carried = *joints;
        for ((angle, near), range) in carried.iter_mut().zip(near).zip(&self.ranges) {
            *angle = nearest_turn(*angle, *near);
            if range.excess(*angle) <= T::SLACK {
                *angle = range.cut(*angle);
            }
        }
        carried
    }

    /// The joints that are outside their range.
    #[must_use]
    pub fn outside(&self, joints: &Joints<T>) -> JointSet {
        let mut outside = [true; JOINTS];
        for ((outside, angle), range) in outside.iter_mut().zip(joints).zip(&self.ranges) {
            // written so that NaN is outside
            *outside = !(*angle >= range.min && *angle <= range.max);
        }
        JointSet::from_flags(outside)
    }
}
