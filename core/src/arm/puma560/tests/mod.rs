//! What holds of any arm and pose; numbers of others are compared in the workspace's tests.

mod choosing;
mod counting;
mod kinematics;
mod solving;

use super::{Joints, Puma560};
use crate::config::PumaConfig;
use crate::geometry::Pose;
use crate::real::Real;
use proptest::prelude::*;

/// The arm with its flange.
fn arm<T: Real>() -> Puma560<T> {
    Puma560::new(&PumaConfig::default()).expect("the default")
}

/// Joints somewhere in their ranges.
fn joints() -> impl Strategy<Value = Joints<f64>> {
    let range = |i: usize| {
        let joint = PumaConfig::default().joints[i];
        joint.min_rad..joint.max_rad
    };
    [range(0), range(1), range(2), range(3), range(4), range(5)]
}

/// The largest difference of two poses, metres and entries of the rotation.
fn apart<T: Real>(a: &Pose<T>, b: &Pose<T>) -> f64 {
    let rotation = (a.rotation - b.rotation).iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
    (a.translation - b.translation).iter().fold(rotation, |most, x| most.max(x.to_f64().abs()))
}

/// The largest difference of two joint vectors, whole turns aside, radians.
fn turned(a: &Joints<f64>, b: &Joints<f64>) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).sin().atan2((a - b).cos()).abs()))
}
