//! A governed arm, driven, and every set-point checked.

use super::*;
use crate::arm::teleop::tests::{Random, sequences};
use crate::config::PumaConfig;
use crate::hand::so3;
use nalgebra::Vector3;

mod back_out;

mod following;

mod home;

mod orders;

mod rest;

mod workspace;

/// The differences of the set-points so far, in double precision.
pub(super) struct Checked<T> {
    pub(super) governor: Governor<T>,
    pub(super) config: GovernorConfig,
    pub(super) arm: Puma560<T>,
    angles: Joints<f64>,
    speeds: Joints<f64>,
    accelerations: Joints<f64>,
    place: Vector3<f64>,
    /// Whether it was in the box at the start.
    is_held: bool,
    /// The farthest out of the box that the tool was, metres, and the fastest, m/s.
    pub(super) out_m: f64,
    pub(super) fastest_m_s: f64,
    pub(super) cycles: u64,
    pub(super) changes: u64,
}

pub(super) fn double<T: Real>(joints: &Joints<T>) -> Joints<f64> {
    joints.map(T::to_f64)
}

impl<T: Real> Checked<T> {
    pub(super) fn new(config: &GovernorConfig, joints: &Joints<f64>) -> Self {
        let arm = Puma560::new(&PumaConfig::default()).unwrap();
        let mut governor = Governor::new(&arm, config).unwrap();
        let joints = joints.map(T::of);
        governor.start(&joints).unwrap();
        Self {
            governor,
            config: *config,
            arm,
            angles: double(&joints),
            speeds: [0.0; JOINTS],
            accelerations: [0.0; JOINTS],
            place: governor.pose.translation.map(T::to_f64),
            is_held: true,
            out_m: 0.0,
            fastest_m_s: 0.0,
            cycles: 0,
            changes: 0,
        }
    }

    /// The same, outside of the box.
    pub(super) fn unheld(config: &GovernorConfig, joints: &Joints<f64>) -> Self {
        Self { is_held: false, ..Self::new(config, joints) }
    }

    pub(super) fn follow(&mut self, goal: &Pose<T>) -> Governed<T> {
        self.step(&Order::Follow(*goal))
    }

    pub(super) fn step(&mut self, order: &Order<T>) -> Governed<T> {
        self.step_knowing(order, None)
    }

    /// One cycle; what is sent keeps every bound.
    pub(super) fn step_knowing(
        &mut self,
        order: &Order<T>,
        uncertainty: Option<&Uncertainty<T>>,
    ) -> Governed<T> {
        let governed = self.governor.step(order, uncertainty);
        let cycle = f64::from(self.config.cycle_us) * 1e-6;
        let angles = double(&governed.set_point);
        let spans = self.governor.spans;
        // what the rounding of angles up to 4 rad makes of their differences, each twice as much
        let noise = 4.0 * T::EPSILON.to_f64();
        let exact = 1.0 + 1e-9;
        for i in 0..JOINTS {
            let speed = (angles[i] - self.angles[i]) / cycle;
            let acceleration = (speed - self.speeds[i]) / cycle;
            let jerk = (acceleration - self.accelerations[i]) / cycle;
            let most = self.arm.config().joints[i].max_speed_rad_s * self.config.speed_share;
            let told = || std::format!("joint {} in cycle {}: {governed:?}", i + 1, self.cycles);
            assert!(speed.abs() <= most * exact + noise / cycle, "speed {speed}, {}", told());
            let most = self.config.max_acceleration_rad_s2[i];
            let slack = 2.0 * noise / cycle.powi(2);
            assert!(acceleration.abs() <= most * exact + slack, "acceleration {acceleration}, {}", told());
            let most = self.config.max_jerk_rad_s3[i];
            let slack = 4.0 * noise / cycle.powi(3);
            assert!(jerk.abs() <= most * exact + slack, "jerk {jerk}, {}", told());
            let (min, max) = (spans[i].min.to_f64(), spans[i].max.to_f64());
            assert!(angles[i] >= min && angles[i] <= max, "angle {}, {}", angles[i], told());
            (self.speeds[i], self.accelerations[i]) = (speed, acceleration);
        }
        self.angles = angles;
        let place = governed.pose.translation.map(T::to_f64);
        assert_eq!(governed.pose, self.arm.forward(&governed.set_point));
        self.fastest_m_s = self.fastest_m_s.max((place - self.place).norm() / cycle);
        self.place = place;
        let w = &self.config.workspace;
        for i in 0..3 {
            self.out_m = self.out_m.max(w.min_m[i] - place[i]).max(place[i] - w.max_m[i]);
        }
        // a place is rounded
        let most = self.config.max_tool_speed_m_s + 16.0 * T::EPSILON.to_f64() / cycle;
        assert!(self.fastest_m_s <= most, "{} m/s: {governed:?}", self.fastest_m_s);
        // a place is rounded, too
        let over = fence::OVER_FACE_M + 16.0 * T::EPSILON.to_f64();
        assert!(!self.is_held || self.out_m <= over, "{} m out of the box: {governed:?}", self.out_m);
        self.cycles += 1;
        self.changes += u64::from(governed.change.is_some());
        governed
    }

    /// Follows one goal until the arm is at rest there; the cycles it took, or `None` after `most`.
    pub(super) fn settle(&mut self, goal: &Pose<T>, exact: f64, most: u32) -> Option<u32> {
        (0..most).find(|_| self.follow(goal).at_rest && self.off(goal).0.max(self.off(goal).1) < exact)
    }

    pub(super) fn off(&self, goal: &Pose<T>) -> (f64, f64) {
        let pose = &self.governor.pose;
        let turn = so3::log(&(goal.rotation * pose.rotation.transpose())).norm();
        ((goal.translation - pose.translation).norm().to_f64(), turn.to_f64())
    }
}

/// Joints in their ranges, the tool in the box, away from singularities by this share.
pub(super) fn anywhere(random: &mut Random, config: &GovernorConfig, away: f64) -> Joints<f64> {
    let arm = Puma560::<f64>::new(&PumaConfig::default()).unwrap();
    loop {
        let joints = core::array::from_fn(|i| {
            random.within(arm.config().joints[i].min_rad, arm.config().joints[i].max_rad)
        });
        let place = arm.forward(&joints).translation;
        let w = &config.workspace;
        let inside = (0..3).all(|i| place[i] > w.min_m[i] && place[i] < w.max_m[i]);
        let (_, nearness) = arm.nearest_singularity(&arm.singularities(&joints));
        if inside && nearness > away {
            return joints;
        }
    }
}
