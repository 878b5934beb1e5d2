//! Which set-points a port takes: the part of the contract that is the same for every arm.

use super::port::PortError;
use super::puma560::Joints;
use crate::config::{JOINTS, JointConfig, PumaConfig};
use crate::real::Real;

/// By how much a set-point may exceed a bound that was kept by whoever computed it: rounding, radians.
/// Where set-points are computed in single precision, what is taken for rounding there.
const ROUNDING_RAD: f64 = 1e-9;

/// Ranges, and the farthest that each joint can go in a cycle.
#[derive(Clone, Debug)]
pub struct SetPointGate {
    joints: [JointConfig; JOINTS],
    cycle_s: f64,
}

impl SetPointGate {
    /// For an arm that gets a set-point every `cycle_s` seconds.
    #[must_use]
    pub fn new(puma: &PumaConfig, cycle_s: f64) -> Self {
        Self { joints: puma.joints, cycle_s }
    }

    /// Whether `next` may be gone to from `last`, the set-point before or, for the first one, where the
    /// arm stands. Radians.
    ///
    /// # Errors
    /// [`PortError::NotFinite`], [`PortError::OutOfRange`] or [`PortError::TooFar`] with the first joint
    /// that it is true of. A joint that is out of its range may come back towards it.
    pub fn check<T: Real>(&self, last: &Joints<T>, next: &Joints<T>) -> Result<(), PortError> {
        let rounding_rad = ROUNDING_RAD.max(T::SLACK.to_f64());
        let (last, next) = (last.map(T::to_f64), next.map(T::to_f64));
        let each = || (1..).zip(&self.joints).zip(last.iter().zip(&next));
        for ((number, _), (_, next)) in each() {
            if !next.is_finite() {
                return Err(PortError::NotFinite(number));
            }
        }
        for ((number, joint), (&last, &next)) in each() {
            let least = joint.min_rad.min(last) - rounding_rad;
            let most = joint.max_rad.max(last) + rounding_rad;
            if !(least..=most).contains(&next) {
                return Err(PortError::OutOfRange(number));
            }
        }
        for ((number, joint), (&last, &next)) in each() {
            if (next - last).abs() > joint.max_speed_rad_s * self.cycle_s + rounding_rad {
                return Err(PortError::TooFar(number));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOME: Joints<f64> = [0.0, 0.8, -3.1, 0.0, 0.8, 0.0];

    fn check(change: impl FnOnce(&mut Joints<f64>)) -> Result<(), PortError> {
        let mut next = HOME;
        change(&mut next);
        SetPointGate::new(&PumaConfig::default(), 0.01).check(&HOME, &next)
    }

    #[test]
    fn a_step_that_the_joints_can_do_is_taken() {
        assert_eq!(check(|_| ()), Ok(()));
        assert_eq!(check(|q| q[0] += 0.0192), Ok(()));
        assert_eq!(check(|q| q[5] -= 0.0574), Ok(()));
    }

    #[test]
    fn what_is_not_finite_out_of_range_or_too_far_is_refused_by_joint() {
        assert_eq!(check(|q| q[4] = f64::NAN), Err(PortError::NotFinite(5)));
        assert_eq!(check(|q| q[1] = f64::INFINITY), Err(PortError::NotFinite(2)));
        assert_eq!(check(|q| q[0] = 3.0), Err(PortError::OutOfRange(1)));
        assert_eq!(check(|q| q[0] = 0.0193), Err(PortError::TooFar(1)));
        // a worse joint comes before a nearer one
        let both = check(|q| {
            q[0] = 1.0;
            q[3] = f64::NAN;
        });
        assert_eq!(both, Err(PortError::NotFinite(4)));
    }

    #[test]
    fn a_joint_beyond_its_range_may_only_come_back() {
        let gate = SetPointGate::new(&PumaConfig::default(), 0.01);
        let most = PumaConfig::default().joints[0].max_rad;
        let at = |q1: f64| {
            let mut joints = HOME;
            joints[0] = q1;
            joints
        };
        assert_eq!(gate.check(&at(most + 0.1), &at(most + 0.09)), Ok(()));
        assert_eq!(gate.check(&at(most + 0.1), &at(most + 0.11)), Err(PortError::OutOfRange(1)));
    }
}
