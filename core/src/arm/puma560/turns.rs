//! Angles that differ by whole turns mean the same posture, but not the same place in a joint's
//! range.

use super::joint_set::JointSet;
use super::model::{Joints, Puma560, Range};
use crate::real::Real;

/// 1 / (2 pi).
const TURNS_PER_RADIAN: f64 = 0.5 * core::f64::consts::FRAC_1_PI;

/// `angle` plus the whole turns that bring it nearest to `near`. Without a branch: which way angles
/// have to be turned cannot be foretold, and there are dozens in one inverse.
#[inline]
pub(super) fn nearest_turn<T: Real>(angle: T, near: T) -> T {
    angle + T::two_pi() * ((near - angle) * T::of(TURNS_PER_RADIAN)).nearest_whole()
}

/// The angle between -pi and pi that means the same as `angle`.
pub(super) fn wrapped<T: Real>(angle: T) -> T {
    nearest_turn(angle, T::zero())
}

#[inline]
fn larger<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

impl<T: Real> Range<T> {
    /// By how much `angle` is outside the range, radians; 0 inside.
    #[inline]
    pub(super) fn excess(self, angle: T) -> T {
        larger(larger(angle - self.max, self.min - angle), T::zero())
    }

    /// The angle inside the range that means the same as `angle` and is nearest to it, or one outside
    /// where there is none. An excess that may be rounding is cut off.
    #[inline]
    fn fit(self, angle: T) -> T {
        // turns needed to come down to `max` or up to `min`; without a branch, as above
        let half = T::of(0.5) - T::SLACK;
        let turns = |excess: T| larger((excess * T::of(TURNS_PER_RADIAN) + half).nearest_whole(), T::zero());
        let down = angle - T::two_pi() * turns(angle - self.max);
        let up = down + T::two_pi() * turns(self.min - angle);
        if self.excess(up) <= T::SLACK { self.cut(up) } else { up }
    }

    /// `angle`, or the end of the range that it is beyond.
    #[inline]
    fn cut(self, angle: T) -> T {
        -larger(-larger(angle, self.min), -self.max)
    }
}

impl<T: Real> Puma560<T> {
    /// The angles that mean the same as `joints` and are nearest to `near`; where some are in their
    /// joint's range, the nearest of those. And the joints for which none is.
    #[inline]
    pub(super) fn fit(&self, joints: &Joints<T>, near: &Joints<T>) -> (Joints<T>, JointSet) {
        let mut fitted = *joints;
        for ((angle, near), range) in fitted.iter_mut().zip(near).zip(&self.ranges) {
            let nearest = nearest_turn(*angle, *near);
            let inside = range.fit(nearest);
            *angle = if range.excess(inside) > T::zero() { nearest } else { inside };
        }
        (fitted, self.outside(&fitted))
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
        let places = (1..).zip(joints.iter().zip(&self.ranges));
        // written so that NaN is outside
        let outside = places.filter(|(_, (angle, range))| !(**angle >= range.min && **angle <= range.max));
        outside.fold(JointSet::EMPTY, |set, (number, _)| set.with(number))
    }
}
