//! One cycle of the slave with any settings, joints and port, in both precisions.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::hint::black_box;
use tetrad_core::arm::port::{JointReading, PortStatus};
use tetrad_core::arm::slave::{ArmReading, PortOrder, Slave};
use tetrad_core::config::SlaveConfig;
use tetrad_core::real::Real;
use tetrad_no_panic::Nowhere;

fn any<T: Real>() {
    match Slave::<T>::new(&black_box(SlaveConfig::default())) {
        Ok(mut slave) => {
            for _ in 0..black_box(9) {
                let joints = Some(JointReading { joints: [T::of(0.1); 6], age_us: 7 });
                let reading = black_box(ArmReading { joints, status: PortStatus::Ready });
                let _ = black_box(slave.reset(black_box(11), &reading));
                slave.hold_to_run(black_box(true), black_box(12));
                let step = black_box(slave.step(black_box(13), &reading));
                if let PortOrder::Write(joints) = step.order {
                    black_box(joints);
                }
                for limit in step.governed.iter().flat_map(|governed| governed.limits.iter()) {
                    let _ = write!(Nowhere, "{limit}");
                }
                if let Some(refusal) = step.refusal {
                    let _ = write!(Nowhere, "{refusal}");
                }
                if black_box(true) {
                    slave.stop();
                }
            }
        }
        Err(error) => {
            let _ = write!(Nowhere, "{error}");
        }
    }
}

tetrad_no_panic::program!({
    any::<f32>();
    any::<f64>();
});
