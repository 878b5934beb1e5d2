//! One whole cycle of the slave: command, law, limits, kinematics, set-point.

use divan::{Bencher, black_box};
use nalgebra::{Rotation3, Vector3};
use tetrad_core::arm::port::{JointReading, PortStatus};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::arm::slave::{ArmReading, PortOrder, Slave};
use tetrad_core::arm::teleop::{Command, State};
use tetrad_core::config::SlaveConfig;
use tetrad_core::geometry::Pose;
use tetrad_core::hand::state::{PoseCovariance, PoseState};
use tetrad_core::real::Real;

/// Cycles of the arm for one command of the hand.
const CYCLES: u64 = 3;

/// A slave that follows a hand round and round.
struct Moving<T> {
    slave: Slave<T>,
    joints: Joints<T>,
    cycle: u64,
}

impl<T: Real> Moving<T> {
    fn new() -> Self {
        let slave = Slave::new(&SlaveConfig::default()).expect("the default");
        let joints = [0.0_f64, 45.0, -170.0, 5.0, 50.0, 0.0].map(|deg| T::of(deg.to_radians()));
        let mut moving = Self { slave, joints, cycle: 100 };
        moving.slave.hold_to_run(false, moving.now_us());
        let reading = moving.reading();
        moving.slave.reset(moving.now_us(), &reading).expect("it is armed");
        for _ in 0..100 {
            moving.step();
        }
        assert_eq!(moving.step().state(), State::Engaged);
        moving
    }

    fn now_us(&self) -> u64 {
        self.cycle * 10_000
    }

    fn reading(&self) -> ArmReading<T> {
        let joints = Some(JointReading { joints: self.joints, age_us: 0 });
        ArmReading { joints, status: PortStatus::Ready }
    }

    fn command(&self) -> Command {
        let t_s = self.now_us() as f32 * 1e-6;
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), 0.3 * (1.1 * t_s).sin());
        let place = Vector3::new((2.0 * t_s).sin(), (2.0 * t_s).cos() - 1.0, (3.1 * t_s).sin()) * 0.08;
        Command {
            session: 1,
            sequence: self.cycle as u32,
            capture_us: self.now_us(),
            received_us: self.now_us(),
            engaged: true,
            engagements: 1,
            state: PoseState::Both,
            increment: Pose::identity(),
            since_engage: Pose { rotation: turn.into_inner(), translation: place },
            covariance: Some(PoseCovariance::identity() * 1e-8),
        }
    }

    fn step(&mut self) -> tetrad_core::arm::teleop::Status {
        self.cycle += 1;
        let now_us = self.now_us();
        if self.cycle.is_multiple_of(CYCLES) {
            self.slave.take(black_box(&self.command())).expect("it is newer");
        }
        self.slave.hold_to_run(true, now_us);
        let step = self.slave.step(now_us, &self.reading());
        if let PortOrder::Write(joints) = black_box(&step).order {
            self.joints = joints;
        }
        step.decision.status
    }
}

/// While it follows a hand.
#[divan::bench(types = [f32, f64], sample_size = 1000)]
fn step<T: Real>(bencher: Bencher<'_, '_>) {
    let mut moving = Moving::<T>::new();
    bencher.bench_local(|| moving.step());
}
