//! The slave's law with any settings, commands, buttons, times and arms, in both precisions; and what
//! a port says of itself.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::hint::black_box;
use tetrad_core::arm::port::{PortError, PortFault, PortStatus};
use tetrad_core::arm::teleop::{ArmCondition, ArmView, Command, Teleop};
use tetrad_core::config::{TeleopConfig, TeleopMode};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::state::{PoseCovariance, PoseState};
use tetrad_core::real::Real;
use tetrad_core::wire::{MotionPacket, Transform};
use tetrad_no_panic::Nowhere;

fn any<T: Real>() {
    let mode = black_box(TeleopMode::Paper);
    let config = black_box(TeleopConfig { mode, ..TeleopConfig::default() });
    if let Ok(mut teleop) = Teleop::<T>::new(&config) {
        let packet = black_box(MotionPacket {
            session: 1,
            sequence: 2,
            capture_us: 3,
            engaged: true,
            engagements: 4,
            state: PoseState::Both,
            spans: 5,
            views: 6,
            seen_in: [7; 4],
            residual_px: 8.0,
            increment: Transform::IDENTITY,
            since_engage: Transform::IDENTITY,
            covariance: None,
        });
        let arm = || {
            black_box(ArmView {
                measured: Pose::<T>::identity(),
                set_point: Pose::<T>::identity(),
                condition: ArmCondition::Ready,
            })
        };
        for _ in 0..black_box(9) {
            let mut command = Command::new(&packet, black_box(9));
            command.covariance = black_box(Some(PoseCovariance::identity()));
            if let Err(refusal) = teleop.take(&command) {
                let _ = write!(Nowhere, "{refusal}");
            }
            teleop.hold_to_run(black_box(false), black_box(10));
            if let Err(refusal) = teleop.reset(black_box(11), &arm()) {
                let _ = write!(Nowhere, "{refusal}");
            }
            teleop.hold_to_run(black_box(true), black_box(10));
            let decision = black_box(teleop.step(black_box(12), &arm()));
            let _ = write!(Nowhere, "{}", decision.status);
            for note in decision.notes.iter() {
                let _ = write!(Nowhere, "{note}");
            }
            if black_box(true) {
                teleop.stop();
            }
            black_box(teleop.counts());
        }
    }
}

tetrad_no_panic::program!({
    any::<f32>();
    any::<f64>();
    let fault = black_box(PortFault { joint: Some(1), code: 2 });
    let status = black_box(PortStatus::Fault(fault));
    let _ = write!(Nowhere, "{status} {}", black_box(PortError::NotReady(status)));
    black_box(status.condition());
});
