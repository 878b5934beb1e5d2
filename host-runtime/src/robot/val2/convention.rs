//! VAL's joint angles against the model's.
//!
//! The model is that of [`tetrad_core::arm::puma560`]. With VAL's angles t, degrees:
//!
//! ```text
//! q = [t1, t2 + 180, t3 - 180, t4, t5, t6 + 180]        up to whole turns
//! ```
//!
//! and VAL's WORLD axes are the model's turned by 180 degrees about z: its x and y point the other
//! way. Only joint points are ever sent, so that this matters to a person who compares the numbers of
//! WHERE with ours, and to nothing else. READY, straight up, is t = (0, -90, 90, 0, 0, 0).
//!
//! # The last joint
//!
//! Half a turn lies between both zeros of joint 6, and each side has a range of its own: +-266
//! degrees about VAL's zero and, by default, +-266 about the model's. No one number of turns fits
//! both. The turns are chosen once, at enabling, so that the joint has as much room to either side as
//! there is, and are kept until it is enabled again: the joint never goes round by itself. What is
//! left is the part of both ranges that is in common, 352 degrees; a set-point beyond it is refused
//! by name.

use std::f64::consts::{PI, TAU};

use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::{JointConfig, PumaConfig};

/// VAL's joint angles, degrees.
pub type ValDegrees = [f64; 6];

/// Model minus VAL, radians, up to whole turns.
const OFFSETS: [f64; 6] = [0.0, PI, -PI, 0.0, 0.0, PI];

/// What joint 6 can do about VAL's own zero, radians to either side.
const LAST_JOINT: f64 = 266.0 / 180.0 * PI;

/// By how much an end of a range may be exceeded, radians.
const ROUNDING: f64 = 1e-9;

/// What one joint may be sent to, radians in the model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Range {
    min: f64,
    max: f64,
}

impl Range {
    /// Up to `angle` where that is outside.
    fn with(self, angle: f64) -> Self {
        Self { min: self.min.min(angle), max: self.max.max(angle) }
    }

    /// Rounding apart: whoever keeps to a range computes its end.
    fn contains(self, angle: f64) -> bool {
        angle >= self.min - ROUNDING && angle <= self.max + ROUNDING
    }

    /// From `angle` to the nearer end, radians; below 0 outside.
    fn room(self, angle: f64) -> f64 {
        (self.max - angle).min(angle - self.min)
    }
}

/// How both count joints, in one session.
#[derive(Clone, Debug, PartialEq)]
pub struct Convention {
    /// Model minus VAL, radians.
    offsets: [f64; 6],
    ranges: [Range; 6],
}

impl Convention {
    /// The one that suits an arm at `joints`: each with the turns that leave it the most room.
    #[must_use]
    pub fn at(joints: &ValDegrees, arm: &PumaConfig) -> Self {
        let mut found =
            Self { offsets: OFFSETS, ranges: arm.joints.map(|j| Range { min: j.min_rad, max: j.max_rad }) };
        for (joint, (offset, range)) in found.offsets.iter_mut().zip(&mut found.ranges).enumerate() {
            let angle = joints[joint].to_radians();
            let candidates = [-1.0, 0.0, 1.0].map(|turns| {
                let offset = *offset + turns * TAU;
                (offset, common(joint, &arm.joints[joint], offset))
            });
            let room = |(offset, range): &(f64, Range)| range.room(angle + offset);
            if let Some(best) = candidates.into_iter().max_by(|a, b| room(a).total_cmp(&room(b))) {
                (*offset, *range) = best;
            }
        }
        found
    }

    /// Radians in the model.
    #[must_use]
    pub fn to_model(&self, joints: &ValDegrees) -> Joints<f64> {
        std::array::from_fn(|joint| joints[joint].to_radians() + self.offsets[joint])
    }

    /// Degrees at the controller.
    #[must_use]
    pub fn to_val(&self, joints: &Joints<f64>) -> ValDegrees {
        std::array::from_fn(|joint| (joints[joint] - self.offsets[joint]).to_degrees())
    }

    /// The first joint, from 1, that `next` would bring out of its range. One that is out of it at
    /// `last` may come back.
    #[must_use]
    pub fn outside(&self, last: &Joints<f64>, next: &Joints<f64>) -> Option<u8> {
        let mut places = (1..).zip(self.ranges.iter().zip(last.iter().zip(next)));
        places
            .find(|(_, (range, (last, next)))| !range.with(**last).contains(**next))
            .map(|(number, _)| number)
    }
}

/// What `joint` may be sent to when `offset` lies between both zeros.
fn common(joint: usize, own: &JointConfig, offset: f64) -> Range {
    if joint + 1 < OFFSETS.len() {
        return Range { min: own.min_rad, max: own.max_rad };
    }
    Range { min: own.min_rad.max(offset - LAST_JOINT), max: own.max_rad.min(offset + LAST_JOINT) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};
    use tetrad_core::arm::puma560::Puma560;

    const READY: ValDegrees = [0.0, -90.0, 90.0, 0.0, 0.0, 0.0];

    fn degrees(joints: &Joints<f64>) -> [f64; 6] {
        joints.map(|angle| (angle.to_degrees() * 1e6).round() / 1e6)
    }

    /// VAL's world, whose axes lie on the model's shoulder, seen from the model's.
    fn val_position(arm: &Puma560<f64>, joints: &ValDegrees) -> Vector3<f64> {
        let in_model = arm.forward(&Convention::at(joints, arm.config()).to_model(joints)).translation;
        let world_from_model = Matrix3::from_diagonal(&Vector3::new(-1.0, -1.0, 1.0));
        world_from_model * in_model - Vector3::new(0.0, 0.0, arm.config().lengths.base_m)
    }

    /// With the lengths that VAL's own table has (149.09, 431.8, 20.32, 433.07 and 56.25 mm) READY is
    /// at (-20.32, 149.09, 921.12) in WORLD: above the shoulder, to its left, a little behind.
    #[test]
    fn ready_is_straight_up_where_val_says() {
        let mut config = PumaConfig::default();
        (config.lengths.offset_m, config.lengths.elbow_m) = (0.149_09, 0.020_32);
        config.lengths.forearm_m = 0.433_07;
        let arm = Puma560::new(&config).unwrap();
        let ready = val_position(&arm, &READY);
        assert!((ready - Vector3::new(-0.020_32, 0.149_09, 0.921_12)).norm() < 1e-12, "{ready}");
        let q = Convention::at(&READY, &config).to_model(&READY);
        assert_eq!(degrees(&q)[..5], [0.0, 90.0, -90.0, 0.0, 0.0]);
        assert_eq!(degrees(&q)[5].abs(), 180.0);
        let up = arm.forward(&q).rotation.column(2).into_owned();
        assert!((up - Vector3::z()).norm() < 1e-12, "the tool points up: {up}");
    }

    /// The signs, by what a person sees: from READY, +joint 1 turns left seen from above, the arm
    /// laid down by joint 2 towards 0 reaches along WORLD's x, joint 5 tips the hand.
    #[test]
    fn each_joint_turns_the_way_val_counts() {
        let arm = Puma560::new(&PumaConfig::bare()).unwrap();
        // the arm stretched level: t2 = 0, t3 = 90
        let level = val_position(&arm, &[0.0, 0.0, 90.0, 0.0, 0.0, 0.0]);
        assert!(level.x > 0.85 && level.z.abs() < 0.03, "{level}");
        let left = val_position(&arm, &[90.0, 0.0, 90.0, 0.0, 0.0, 0.0]);
        assert!(left.y > 0.85, "{left}");
        // the forearm folded upwards
        let up = val_position(&arm, &[0.0, 0.0, 180.0, 0.0, 0.0, 0.0]);
        assert!(up.z > 0.4 || up.z < -0.4, "{up}");
    }

    #[test]
    fn there_and_back_is_the_same() {
        let config = PumaConfig::default();
        for t in
            [READY, [-100.0, -200.0, 30.0, -60.0, 20.0, 250.0], [159.0, 44.0, 224.0, 169.0, -99.0, -265.0]]
        {
            let convention = Convention::at(&t, &config);
            let q = convention.to_model(&t);
            assert_eq!(convention.outside(&q, &q), None, "{t:?} {q:?}");
            let back = convention.to_val(&q);
            assert!(back.iter().zip(&t).all(|(a, b)| (a - b).abs() < 1e-9), "{back:?} {t:?}");
        }
    }

    #[test]
    fn the_last_joint_keeps_its_turns_and_is_bounded_on_both_sides() {
        let config = PumaConfig::default();
        let with_last = |t6: f64| [0.0, -90.0, 90.0, 0.0, 0.0, t6];
        let far = Convention::at(&with_last(200.0), &config);
        assert_eq!(degrees(&far.to_model(&with_last(200.0)))[5], 20.0);
        let home = far.to_model(&with_last(200.0));
        let mut q = home;
        q[5] = 86.1_f64.to_radians(); // 266.1 at the controller
        assert_eq!(far.outside(&home, &q), Some(6));
        q[5] = 85.9_f64.to_radians();
        assert_eq!(far.outside(&home, &q), None);
        q[5] = (-266.1_f64).to_radians();
        assert_eq!(far.outside(&home, &q), Some(6));
    }

    #[test]
    fn out_of_range_and_not_a_number_are_outside() {
        let config = PumaConfig::default();
        let convention = Convention::at(&READY, &config);
        let home = convention.to_model(&READY);
        let mut q = home;
        q[3] = f64::NAN;
        assert_eq!(convention.outside(&home, &q), Some(4));
        q = home;
        q[1] = 226.0_f64.to_radians();
        assert_eq!(convention.outside(&home, &q), Some(2));
        // back from beyond is always allowed
        let beyond = q;
        q[1] = 225.5_f64.to_radians();
        assert_eq!(convention.outside(&beyond, &q), None);
    }
}
