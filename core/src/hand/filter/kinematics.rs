//! How the hand moves: its velocity and acceleration, by a filter of fading memory.
//!
//! The polynomial filters of Morrison and Brookner ("Tracking and Kalman Filtering Made Easy", 1998,
//! tables 1.10-1 and 1.10-2): least squares on a line (velocity) or a parabola (acceleration) in
//! which a measurement weighs less the older it is. Until enough is remembered the gains are those
//! of least squares with all measurements alike, so a velocity is known from the second measurement
//! on. Steady motion of the assumed kind is followed without lag. The gains are found from the time
//! that has passed, so frames may come as they like.

use super::so3;
use crate::config::{FilterConfig, Prediction};
use crate::geometry::Pose;
use crate::hand::orientation::nearest_rotation_step;
use nalgebra::Vector3;

/// Rad/s^2 that are believed for each m/s^2 that is.
const TURN_PER_METRE: f32 = 10.0;

/// Measurements that are counted; by then the fading gains are the larger ones.
const MAX_COUNT: u8 = 64;

/// The first and second derivative of three coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Rates {
    velocity: Vector3<f32>,
    acceleration: Vector3<f32>,
}

impl Rates {
    /// How far this leads in `s` seconds.
    fn travel(&self, s: f32) -> Vector3<f32> {
        self.velocity * s + self.acceleration * (0.5 * s * s)
    }

    /// `dt` later, corrected by measured minus predicted.
    fn correct(&mut self, residual: &Vector3<f32>, dt: f32, gains: &Gains, bounds: (f32, f32)) {
        let velocity = self.velocity + self.acceleration * dt + residual * (gains.velocity / dt);
        self.velocity = limited(velocity, bounds.0);
        self.acceleration =
            limited(self.acceleration + residual * (2.0 * gains.acceleration / dt / dt), bounds.1);
    }
}

/// Shares of a residual that go into place, velocity and acceleration (g, h and k).
#[derive(Clone, Copy, Debug, PartialEq)]
struct Gains {
    place: f32,
    velocity: f32,
    acceleration: f32,
}

impl Gains {
    /// After `n` measurements before this one and `dt` seconds since the last.
    fn new(prediction: Prediction, n: u8, dt: f32, memory: f32) -> Self {
        // 1 - theta without cancellation, theta the weight of what was known
        let fresh = -libm::expm1f(-dt / memory);
        let theta = 1.0 - fresh;
        let k = f32::from(n);
        let (growing, fading) = match prediction {
            // one residual gives a velocity and no more
            Prediction::Acceleration if n >= 2 => {
                let all = (k + 3.0) * (k + 2.0) * (k + 1.0);
                let growing = Self {
                    place: 3.0 * (3.0 * k * k + 3.0 * k + 2.0) / all,
                    velocity: 18.0 * (2.0 * k + 1.0) / all,
                    acceleration: 30.0 / all,
                };
                let fading = Self {
                    place: 1.0 - theta * theta * theta,
                    velocity: 1.5 * fresh * fresh * (1.0 + theta),
                    acceleration: 0.5 * fresh * fresh * fresh,
                };
                (growing, fading)
            }
            _ => {
                let all = (k + 2.0) * (k + 1.0);
                let growing =
                    Self { place: 2.0 * (2.0 * k + 1.0) / all, velocity: 6.0 / all, acceleration: 0.0 };
                let fading = Self { place: 1.0 - theta * theta, velocity: fresh * fresh, acceleration: 0.0 };
                (growing, fading)
            }
        };
        // both at once: a gain of one kind with a gain of the other would not be stable
        if growing.place > fading.place && n < MAX_COUNT { growing } else { fading }
    }
}

/// What is believed of the hand's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kinematics {
    pose: Pose,
    linear: Rates,
    angular: Rates,
    /// Measurements so far.
    count: u8,
}

impl Kinematics {
    /// A hand at rest.
    pub(super) fn at(pose: &Pose) -> Self {
        Self { pose: *pose, linear: Rates::default(), angular: Rates::default(), count: 1 }
    }

    /// m/s.
    pub(super) fn speed(&self) -> f32 {
        norm(&self.linear.velocity)
    }

    /// rad/s.
    pub(super) fn turn_speed(&self) -> f32 {
        norm(&self.angular.velocity)
    }

    /// Takes a measurement, `dt` seconds (above 0) after the one before.
    pub(super) fn correct(&mut self, measured: &Pose, dt: f32, config: &FilterConfig) {
        let gains = Gains::new(config.prediction, self.count, dt, seconds(config.memory_us));
        let expected = self.carry(&self.pose, dt);
        let moved = measured.translation - expected.translation;
        let turned = so3::log(&(measured.rotation * expected.rotation.transpose()));
        let rotation = so3::exp(&(turned * gains.place)) * expected.rotation;
        self.pose = Pose {
            translation: expected.translation + moved * gains.place,
            rotation: nearest_rotation_step(&rotation),
        };
        let (most, bend) = (config.max_speed_m_s, config.max_acceleration_m_s2);
        self.linear.correct(&moved, dt, &gains, (most, bend));
        self.angular.correct(&turned, dt, &gains, (config.max_turn_rad_s, bend * TURN_PER_METRE));
        self.count = self.count.saturating_add(1).min(MAX_COUNT);
    }

    /// Where this motion carries `pose` in `s` seconds. The angular velocity is that in the axes
    /// the pose is told in, so the turn comes on the left.
    pub(super) fn carry(&self, pose: &Pose, s: f32) -> Pose {
        let rotation = so3::exp(&self.angular.travel(s)) * pose.rotation;
        Pose {
            translation: pose.translation + self.linear.travel(s),
            rotation: nearest_rotation_step(&rotation),
        }
    }
}

/// Microseconds in seconds.
pub(super) fn seconds(us: u32) -> f32 {
    us as f32 * 1e-6
}

fn norm(v: &Vector3<f32>) -> f32 {
    libm::sqrtf(v.dot(v))
}

/// `v`, no longer than `most`.
fn limited(v: Vector3<f32>, most: f32) -> Vector3<f32> {
    let length = norm(&v);
    if length > most { v * (most / length) } else { v }
}
