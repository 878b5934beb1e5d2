//! The arm with any lengths, joints and poses, in both precisions, and in single precision out of poses
//! in double.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::arm::puma560::{Configuration, Drives, Fixed, Joints, Passages, Policy, Puma560, Recent};
use tetrad_core::config::{DrivesConfig, PumaConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;

fn any<T: Real, P: Real>(zero: &Joints<T>) {
    if let Ok(arm) = Puma560::<T>::new(black_box(&PumaConfig::default())) {
        let joints: &Joints<T> = black_box(zero);
        black_box(arm.links());
        black_box(arm.forward(joints));
        black_box(arm.jacobian(joints));
        let at = arm.singularities(joints);
        black_box(arm.determinant(&at));
        black_box(arm.nearest_singularity(&at));
        black_box(arm.outside(joints).numbers().count());

        let pose = black_box(Pose::<P>::identity());
        if let Ok(solutions) = arm.inverse(&pose, joints) {
            black_box(solutions.get(black_box(Configuration::ALL[0])));
            black_box(solutions.within_ranges().count());
        }
        let mut recent = Recent::at_rest(&arm, joints);
        recent.push(&arm, black_box(joints));
        let fixed = Fixed::all(black_box(Configuration::ALL[0]));
        let policy = Policy { fixed, passages: Passages::ALL, jump: black_box(true) };
        let _ = black_box(arm.choose(&pose, &recent, &policy));
    }
    if let Ok(drives) = Drives::new(black_box(&DrivesConfig::default())) {
        let _ = black_box(drives.counts::<T>(black_box(zero)));
        black_box(drives.joints::<T>(black_box(&[0; 6])));
        black_box(drives.resolution::<T>());
    }
}

tetrad_no_panic::program!({
    any::<f32, f32>(&[0.0; 6]);
    any::<f32, f64>(&[0.0; 6]);
    any::<f64, f64>(&[0.0; 6]);
});
