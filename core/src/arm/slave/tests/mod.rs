//! The whole slave with an arm that goes where it is sent.

mod bounds;

mod home;

mod report;

mod states;

mod ways;

use super::*;
use crate::arm::governor::Limits;
use crate::arm::teleop::tests::{FRAME_US, Sender, at, double};
use crate::config::JOINTS;
use crate::geometry::Pose;
use std::vec::Vec;

/// In front of the arm, far from every singularity.
const START_DEG: [f64; JOINTS] = [10.0, 45.0, -170.0, 5.0, 50.0, 0.0];

/// A slave, an arm without mass, an operator.
pub(super) struct Rig<T> {
    pub(super) slave: Slave<T>,
    pub(super) joints: Joints<T>,
    pub(super) status: PortStatus,
    pub(super) readable: bool,
    pub(super) sender: Sender,
    pub(super) now_us: u64,
    pub(super) pressed: bool,
    cycle_us: u64,
    frame_us: u64,
}

impl<T: Real> Rig<T> {
    pub(super) fn new(config: &SlaveConfig) -> Self {
        Self {
            slave: Slave::new(config).unwrap(),
            joints: START_DEG.map(|deg| T::of(deg.to_radians())),
            status: PortStatus::Ready,
            readable: true,
            sender: Sender::new(at(0.0, 0.0, 1.0)),
            now_us: 1_000_000,
            pressed: false,
            cycle_us: u64::from(config.governor.cycle_us),
            frame_us: 0,
        }
    }

    /// Reset, and the button heard to be released.
    pub(super) fn armed(config: &SlaveConfig) -> Self {
        let mut rig = Self::new(config);
        rig.run(100_000);
        rig.reset().unwrap();
        rig.run(100_000);
        rig
    }

    /// Armed, then pressed.
    pub(super) fn engaged(config: &SlaveConfig) -> Self {
        let mut rig = Self::armed(config);
        rig.press();
        rig.run(200_000);
        rig
    }

    pub(super) fn press(&mut self) {
        self.sender.engage();
        self.pressed = true;
    }

    pub(super) fn release(&mut self) {
        self.sender.engaged = false;
        self.pressed = false;
    }

    pub(super) fn reading(&self) -> ArmReading<T> {
        let joints = self.readable.then_some(JointReading { joints: self.joints, age_us: 0 });
        ArmReading { joints, status: self.status }
    }

    pub(super) fn reset(&mut self) -> Result<(), ResetRefusal> {
        self.slave.reset(self.now_us, &self.reading())
    }

    /// The next command of the sender, if a frame is due.
    pub(super) fn due(&mut self) -> Option<Command> {
        if self.now_us < self.frame_us {
            return None;
        }
        self.frame_us = self.frame_us.max(self.now_us - FRAME_US / 2) + FRAME_US;
        Some(self.sender.command(self.now_us))
    }

    /// One cycle; what is due of the sender has come, and the arm goes where it is sent.
    pub(super) fn cycle(&mut self) -> SlaveStep<T> {
        self.now_us += self.cycle_us;
        if let Some(mut command) = self.due() {
            command.received_us = self.now_us;
            self.slave.take(&command).unwrap();
        }
        self.step()
    }

    /// One cycle without a command.
    pub(super) fn step(&mut self) -> SlaveStep<T> {
        self.slave.hold_to_run(self.pressed, self.now_us);
        let step = self.slave.step(self.now_us, &self.reading());
        if let PortOrder::Write(joints) = step.order {
            self.joints = joints;
        }
        step
    }

    /// Cycles for so long; the last one.
    pub(super) fn run(&mut self, us: u64) -> SlaveStep<T> {
        let until = self.now_us + us;
        loop {
            let step = self.cycle();
            if self.now_us >= until {
                return step;
            }
        }
    }

    /// Where the tool is.
    pub(super) fn tool(&self) -> Pose<f64> {
        double(&self.slave.arm().forward(&self.joints))
    }
}

/// Joint by joint: speed, acceleration and jerk of a way by differences, each as a share of what the
/// limits allow; the largest met.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shares {
    pub(super) speed: f64,
    pub(super) acceleration: f64,
    pub(super) jerk: f64,
}

pub(super) fn shares<T: Real>(config: &SlaveConfig, way: &[Joints<T>]) -> Shares {
    let dt = f64::from(config.governor.cycle_us) * 1e-6;
    let mut worst = Shares::default();
    for joint in 0..JOINTS {
        let places: Vec<f64> = way.iter().map(|joints| joints[joint].to_f64()).collect();
        let rate = |of: &[f64]| -> Vec<f64> { of.windows(2).map(|pair| (pair[1] - pair[0]) / dt).collect() };
        let most = |of: &[f64]| of.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        let speeds = rate(&places);
        let accelerations = rate(&speeds);
        let jerks = rate(&accelerations);
        worst.speed = worst.speed.max(most(&speeds) / config.puma.joints[joint].max_speed_rad_s);
        let acceleration = most(&accelerations) / config.governor.max_acceleration_rad_s2[joint];
        worst.acceleration = worst.acceleration.max(acceleration);
        worst.jerk = worst.jerk.max(most(&jerks) / config.governor.max_jerk_rad_s3[joint]);
    }
    worst
}
