//! Six motors, their gears and their servos, moved on by an explicit time.
//!
//! Each joint has the servo that such drives have: a position loop around a speed loop, critically
//! damped, with the speed and the torque that the motor can give. A set-point is gone to in a straight
//! line over one cycle, as cyclic drives interpolate. What the joints do is computed a millisecond at a
//! time, whatever the steps of whoever asks: the same set-points at the same times give the same
//! motion, bit for bit.

use super::options::{LAG_MS, NOISE_COUNTS, SimulatedOptions};
use crate::robot::start::start_joints;
use rand_pcg::{Pcg32, rand_core::Rng as _};
use tetrad_core::arm::puma560::{Drives, Joints};
use tetrad_core::config::{
    DRIVEN_RAD_S2, DrivesConfig, DrivesConfigError, JOINTS, PumaConfig, PumaConfigError,
};

/// The share of what the motors can do ([`DRIVEN_RAD_S2`]) that the arm is slowed down with when it is stopped: what limits take by default.
const STOP_SHARE: f64 = 0.3;

/// The servo's own cycle, microseconds.
const STEP_US: u64 = 1_000;

/// The same in seconds.
const STEP_S: f64 = 1e-3;

/// Share of the lag that the speed loop has; a quarter is critically damped.
const SPEED_LOOP_SHARE: f64 = 0.25;

/// What the plant does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drive {
    /// The brakes hold.
    Braked,
    /// The servos follow the reference.
    Following,
    /// Each joint is slowed down to rest; then the brakes hold.
    Stopping,
}

/// One joint.
#[derive(Clone, Copy, Debug)]
struct Joint {
    angle: f64,
    speed: f64,
    max_speed: f64,
    max_acceleration: f64,
    /// Standard deviation of what shakes it, rad/s^2.
    shake: f64,
}

/// Why there can be no such arm.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The arm's settings cannot be worked with.
    #[error(transparent)]
    Puma(#[from] PumaConfigError),
    /// The encoders' settings cannot be worked with.
    #[error(transparent)]
    Drives(#[from] DrivesConfigError),
    /// An option that no such arm has.
    #[error("the lag must be from 10 to 500 ms, the noise from 0 to 100 counts, the cycle above 0")]
    Options,
    /// It would start out of a joint's range.
    #[error("start_deg: joint {joint} can be from {least_deg:.1} to {most_deg:.1} degrees")]
    Start {
        /// From 1.
        joint: u8,
        /// The least angle, degrees.
        least_deg: f64,
        /// The largest angle, degrees.
        most_deg: f64,
    },
}

/// The arm.
#[derive(Clone, Debug)]
pub struct Plant {
    joints: [Joint; JOINTS],
    encoders: Drives,
    lag_s: f64,
    cycle_us: u64,
    random: Pcg32,
    now_us: u64,
    drive: Drive,
    /// The line that is gone along: from where, to where, since when.
    from: Joints<f64>,
    to: Joints<f64>,
    since_us: u64,
}

impl Plant {
    /// At rest with its brakes on at time 0.
    ///
    /// # Errors
    /// [`PlantError`] for an arm that cannot be, or that would start out of its ranges.
    pub fn new(puma: &PumaConfig, options: &SimulatedOptions) -> Result<Self, PlantError> {
        puma.check()?;
        if !(LAG_MS.contains(&(options.lag_s * 1000.0)) && NOISE_COUNTS.contains(&options.noise_counts))
            || options.cycle_us() == 0
        {
            return Err(PlantError::Options);
        }
        let encoders = Drives::new(&DrivesConfig::default())?;
        let start = options.start.unwrap_or_else(|| start_joints(puma));
        for (number, (joint, angle)) in (1..).zip(puma.joints.iter().zip(&start)) {
            if !(joint.min_rad..=joint.max_rad).contains(angle) {
                return Err(PlantError::Start {
                    joint: number,
                    least_deg: joint.min_rad.to_degrees(),
                    most_deg: joint.max_rad.to_degrees(),
                });
            }
        }
        let resolution: Joints<f64> = encoders.resolution();
        // a critically damped servo (two poles at 2 / lag) that is shaken by white noise of standard
        // deviation s in each step trembles by s sqrt(step lag^3 / 32)
        let tremble = (STEP_S * options.lag_s.powi(3) / 32.0).sqrt();
        let joint = |place: usize| Joint {
            angle: start[place],
            speed: 0.0,
            max_speed: puma.joints[place].max_speed_rad_s,
            max_acceleration: DRIVEN_RAD_S2[place],
            shake: options.noise_counts * resolution[place] / tremble,
        };
        Ok(Self {
            joints: std::array::from_fn(joint),
            encoders,
            lag_s: options.lag_s,
            cycle_us: options.cycle_us(),
            random: Pcg32::new(options.seed, 0x7e7a),
            now_us: 0,
            drive: Drive::Braked,
            from: start,
            to: start,
            since_us: 0,
        })
    }

    /// The time it has been moved on to, microseconds.
    #[must_use]
    pub const fn now_us(&self) -> u64 {
        self.now_us
    }

    /// Where the joints are, radians: the truth, which no encoder shows.
    #[must_use]
    pub fn joints(&self) -> Joints<f64> {
        self.joints.map(|joint| joint.angle)
    }

    /// How fast they move, rad/s.
    #[must_use]
    pub fn speeds(&self) -> Joints<f64> {
        self.joints.map(|joint| joint.speed)
    }

    /// What the encoders show, as angles, radians. `None` past what 32 bits count, thousands of turns.
    #[must_use]
    pub fn measured(&self) -> Option<Joints<f64>> {
        let counts = self.encoders.counts(&self.joints()).ok()?;
        Some(self.encoders.joints(&counts))
    }

    /// When the joints would be at rest if they were stopped now, microseconds.
    #[must_use]
    pub fn rest_us(&self) -> u64 {
        let slowest = self
            .joints
            .iter()
            .map(|joint| joint.speed.abs() / (joint.max_acceleration * STOP_SHARE))
            .fold(0.0, f64::max);
        // one step more: the last one is begun
        self.now_us + (slowest * 1e6).ceil() as u64 + STEP_US
    }

    /// The set-point that is gone to; where the arm stands when none is.
    #[must_use]
    pub const fn set_point(&self) -> &Joints<f64> {
        &self.to
    }

    /// Whether no joint moves and the brakes hold.
    #[must_use]
    pub fn is_braked(&self) -> bool {
        self.drive == Drive::Braked
    }

    /// Lets the servos hold the joints where they are.
    pub fn release(&mut self) {
        if self.drive == Drive::Braked {
            self.hold();
            self.drive = Drive::Following;
        }
    }

    /// Sends the joints to `joints` radians, to be there a cycle from now. Nothing happens while the
    /// brakes hold.
    pub fn go_to(&mut self, joints: &Joints<f64>) {
        if self.drive == Drive::Following {
            self.from = self.reference();
            self.to = *joints;
            self.since_us = self.now_us;
        }
    }

    /// Slows every joint down to rest; then the brakes hold.
    pub fn stop(&mut self) {
        if self.drive == Drive::Following {
            self.drive = Drive::Stopping;
        }
    }

    /// Moves the time on to `us`; it does not go back. The joints move by whole milliseconds.
    pub fn advance_to(&mut self, us: u64) {
        while let Some(next) = self.now_us.checked_add(STEP_US).filter(|&next| next <= us) {
            if self.drive == Drive::Braked {
                // nothing moves: the rest of the time passes at once
                self.now_us += (us - self.now_us) / STEP_US * STEP_US;
                return;
            }
            self.now_us = next;
            match self.drive {
                Drive::Following => self.follow(),
                _ => self.slow_down(),
            }
        }
    }

    /// Where the interpolated line is now.
    fn reference(&self) -> Joints<f64> {
        let share = ((self.now_us - self.since_us) as f64 / self.cycle_us as f64).min(1.0);
        let mut reference = self.from;
        for (at, to) in reference.iter_mut().zip(&self.to) {
            *at += (to - *at) * share;
        }
        reference
    }

    fn follow(&mut self) {
        let reference = self.reference();
        let (lag, loop_s) = (self.lag_s, self.lag_s * SPEED_LOOP_SHARE);
        for (joint, to) in self.joints.iter_mut().zip(&reference) {
            let wanted = ((to - joint.angle) / lag).max(-joint.max_speed).min(joint.max_speed);
            let shaken = joint.shake * normal(&mut self.random);
            let acceleration = (wanted - joint.speed) / loop_s + shaken;
            let most = joint.max_acceleration;
            joint.speed += acceleration.max(-most).min(most) * STEP_S;
            joint.speed = joint.speed.max(-joint.max_speed).min(joint.max_speed);
            joint.angle += joint.speed * STEP_S;
        }
    }

    fn slow_down(&mut self) {
        let mut moving = false;
        for joint in &mut self.joints {
            let step = joint.max_acceleration * STOP_SHARE * STEP_S;
            joint.speed -= joint.speed.max(-step).min(step);
            joint.angle += joint.speed * STEP_S;
            moving |= joint.speed != 0.0;
        }
        if !moving {
            self.hold();
            self.drive = Drive::Braked;
        }
    }

    /// Nothing is gone to but where the joints are.
    fn hold(&mut self) {
        self.from = self.joints();
        self.to = self.from;
        self.since_us = self.now_us;
    }
}

/// A normally distributed number: twelve evenly distributed ones have variance 1. The same bits
/// everywhere, as no transcendental function is in it.
fn normal(random: &mut Pcg32) -> f64 {
    (0..12).map(|_| f64::from(random.next_u32()) / 4_294_967_296.0).sum::<f64>() - 6.0
}
