//! A station with an arm that goes where it is sent, driven by hand.

mod clutch;

mod home;

pub(in crate::arm) mod network;

mod paper;

mod refusals;

mod same_bits;

mod scale;

mod states;

mod zero_jump;

use super::*;
use crate::hand::state::PoseCovariance;
use nalgebra::{Matrix3, Vector3};

/// Between two frames of the sender.
pub(in crate::arm) const FRAME_US: u64 = 33_333;

/// How many random sequences a test runs: all of them with `TETRAD_FULL=1` or in a release build (as
/// `cargo verify` does), a twentieth otherwise.
pub(in crate::arm) fn sequences(full: u64) -> u64 {
    let all = !cfg!(debug_assertions) || std::env::var_os("TETRAD_FULL").is_some_and(|value| value == "1");
    if all { full } else { full / 20 }
}

/// A small random generator (splitmix64): the same seed, the same sequence.
pub(in crate::arm) struct Random(u64);

impl Random {
    pub(in crate::arm) fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5851_F42D_4C95_7F2D)
    }

    pub(in crate::arm) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// From `min` to `max`.
    pub(in crate::arm) fn within(&mut self, min: f64, max: f64) -> f64 {
        min + (max - min) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(in crate::arm) fn chance(&mut self, p: f64) -> bool {
        self.within(0.0, 1.0) < p
    }

    /// In the box of this half side.
    pub(in crate::arm) fn vector(&mut self, most: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.within(-most, most))
    }

    pub(in crate::arm) fn rotation(&mut self, most: f64) -> Matrix3<f64> {
        so3::exp(&self.vector(most))
    }
}

pub(in crate::arm) use crate::hand::so3;

pub(in crate::arm) fn single(pose: &Pose<f64>) -> Pose {
    Pose { rotation: pose.rotation.map(|x| x as f32), translation: pose.translation.map(|x| x as f32) }
}

pub(in crate::arm) fn of<T: Real>(pose: &Pose<f64>) -> Pose<T> {
    Pose { rotation: pose.rotation.map(T::of), translation: pose.translation.map(T::of) }
}

pub(in crate::arm) fn double<T: Real>(pose: &Pose<T>) -> Pose<f64> {
    Pose { rotation: pose.rotation.map(T::to_f64), translation: pose.translation.map(T::to_f64) }
}

/// Metres and radians between two poses.
pub(in crate::arm) fn apart(a: &Pose<f64>, b: &Pose<f64>) -> (f64, f64) {
    ((a.translation - b.translation).norm(), law::angle(&a.rotation, &b.rotation))
}

pub(in crate::arm) fn at(x: f64, y: f64, z: f64) -> Pose<f64> {
    Pose { rotation: Matrix3::identity(), translation: Vector3::new(x, y, z) }
}

/// The operator station: where the hand is and was latched, and the commands that tell of it.
#[derive(Clone, Copy)]
pub(in crate::arm) struct Sender {
    /// world_from_hand, now and in the command before.
    pub(in crate::arm) hand: Pose<f64>,
    before: Pose<f64>,
    pub(in crate::arm) latch: Pose<f64>,
    pub(in crate::arm) engaged: bool,
    pub(in crate::arm) engagements: u32,
    pub(in crate::arm) session: u32,
    pub(in crate::arm) sequence: u32,
    pub(in crate::arm) state: PoseState,
}

impl Sender {
    pub(in crate::arm) fn new(hand: Pose<f64>) -> Self {
        Self {
            hand,
            before: hand,
            latch: hand,
            engaged: false,
            engagements: 0,
            session: 7,
            sequence: 0,
            state: PoseState::Both,
        }
    }

    pub(in crate::arm) fn engage(&mut self) {
        self.latch = self.hand;
        self.engagements = self.engagements.wrapping_add(1);
        self.engaged = true;
    }

    /// The command of a frame; when it comes is still open.
    pub(in crate::arm) fn command(&mut self, capture_us: u64) -> Command {
        self.sequence = self.sequence.wrapping_add(1);
        // a still hand does not move by a rounding
        let between = |a: &Pose<f64>, b: &Pose<f64>| {
            if a == b { Pose::identity() } else { a.inverse().compose(b) }
        };
        let increment = between(&self.before, &self.hand);
        self.before = self.hand;
        Command {
            session: self.session,
            sequence: self.sequence,
            capture_us,
            received_us: 0,
            engaged: self.engaged,
            engagements: self.engagements,
            state: self.state,
            increment: single(&increment),
            since_engage: single(&between(&self.latch, &self.hand)),
            covariance: None,
        }
    }
}

/// A slave station without a network: what is sent comes at once.
pub(in crate::arm) struct Rig<T> {
    pub(in crate::arm) teleop: Teleop<T>,
    pub(in crate::arm) arm: ArmView<T>,
    pub(in crate::arm) sender: Sender,
    pub(in crate::arm) now_us: u64,
}

impl<T: Real> Rig<T> {
    pub(in crate::arm) fn new(config: &TeleopConfig) -> Self {
        let place = of(&at(0.4, 0.1, 0.8));
        Self {
            teleop: Teleop::new(config).unwrap(),
            arm: ArmView { measured: place, set_point: place, condition: ArmCondition::Ready },
            sender: Sender::new(at(0.0, 0.0, 1.0)),
            now_us: 1_000_000,
        }
    }

    /// Reset, armed, with a sender that is heard.
    pub(in crate::arm) fn armed(config: &TeleopConfig) -> Self {
        let mut rig = Self::new(config);
        rig.button(false);
        rig.teleop.reset(rig.now_us, &rig.arm).unwrap();
        rig.frame();
        assert_eq!(rig.step().status, Status::Armed(ArmedReason::Press));
        rig
    }

    pub(in crate::arm) fn engaged(config: &TeleopConfig) -> Self {
        let mut rig = Self::armed(config);
        rig.press();
        assert_eq!(rig.step().status, Status::Engaged);
        rig
    }

    pub(in crate::arm) fn wait(&mut self, us: u64) {
        self.now_us += us;
    }

    /// What the button is, told now.
    pub(in crate::arm) fn button(&mut self, pressed: bool) {
        self.teleop.hold_to_run(pressed, self.now_us);
    }

    /// One command, a frame later.
    pub(in crate::arm) fn frame(&mut self) {
        self.send(|_| ()).unwrap();
    }

    pub(in crate::arm) fn send(&mut self, change: impl FnOnce(&mut Command)) -> Result<(), CommandRefusal> {
        self.wait(FRAME_US);
        let mut command = self.sender.command(self.now_us);
        command.received_us = self.now_us;
        change(&mut command);
        self.teleop.take(&command)
    }

    /// Button and commands say engaged.
    pub(in crate::arm) fn press(&mut self) {
        self.sender.engage();
        self.button(true);
        self.frame();
    }

    pub(in crate::arm) fn release(&mut self) {
        self.sender.engaged = false;
        self.frame();
        self.button(false);
    }

    /// The hand goes on by this much in the axes of the hand at engage; a command tells of it.
    pub(in crate::arm) fn move_hand(&mut self, by: Vector3<f64>) {
        self.sender.hand.translation += self.sender.latch.rotation * by;
        self.frame();
        let pressed = self.teleop.button.is_pressed();
        self.button(pressed);
    }

    /// One step; the arm goes where it is sent.
    pub(in crate::arm) fn step(&mut self) -> Decision<T> {
        let decision = self.teleop.step(self.now_us, &self.arm);
        if let Some(goal) = decision.order.goal() {
            self.arm.set_point = *goal;
            self.arm.measured = *goal;
        }
        decision
    }
}
