//! The governor with any settings, starts, orders and hands, in both precisions, and its texts.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::hint::black_box;
use tetrad_core::arm::governor::Governor;
use tetrad_core::arm::puma560::{Joints, Puma560};
use tetrad_core::arm::teleop::{Order, Uncertainty};
use tetrad_core::config::{GovernorConfig, PumaConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::real::Real;
use tetrad_no_panic::Nowhere;

fn any<T: Real>() {
    let Ok(arm) = Puma560::<T>::new(&black_box(PumaConfig::default())) else { return };
    match Governor::<T>::new(&arm, &black_box(GovernorConfig::default())) {
        Err(error) => {
            let _ = write!(Nowhere, "{error}");
        }
        Ok(mut governor) => {
            let joints: Joints<T> = black_box([T::one(); 6]);
            if let Err(refusal) = governor.start(&joints) {
                let _ = write!(Nowhere, "{refusal}");
            }
            for _ in 0..black_box(9) {
                let goal = black_box(Pose::<T>::identity());
                let order = if black_box(true) { Order::Follow(goal) } else { Order::Stop };
                let known = black_box(Uncertainty { place_m: T::one(), turn_rad: T::one() });
                let known = if black_box(true) { Some(&known) } else { None };
                let governed = black_box(governor.step(&order, known));
                let _ = write!(Nowhere, "{}", governed.limits);
                for limit in governed.limits.iter() {
                    black_box((limit.name(), limit.joint()));
                }
                black_box((governor.set_point(), *governor.pose()));
            }
        }
    }
}

tetrad_no_panic::program!({
    any::<f32>();
    any::<f64>();
});
