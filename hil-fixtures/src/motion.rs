//! How the hand moves from its pose at rest.

use crate::noise::Seeded;
use core::f64::consts::{PI, TAU};
use nalgebra::{Matrix3, Vector3};

/// How long `Linear` and `Circular` stand still at an end, seconds: a tracker finds its feet.
const PAUSE_S: f64 = 0.5;

/// Acceleration of `Linear` and `Circular` along their path, m/s^2.
const ACCELERATION: f64 = 2.0;

/// A movement: what is added to the pose at rest.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// None.
    Still,
    /// A new place, drawn evenly from a cube around the place at rest, every `period_s`.
    Steps {
        /// How long one place is kept, seconds.
        period_s: f64,
        /// Half the side of the cube, metres.
        amplitude_m: f64,
    },
    /// To and fro on a straight path through the place at rest, with a pause at each end.
    Linear {
        /// From end to end; its length is the path's, metres.
        path_m: Vector3<f64>,
        /// Between acceleration and braking, m/s.
        speed: f64,
    },
    /// Round a circle about the place at rest.
    Circular {
        /// Metres.
        radius_m: f64,
        /// The normal of the circle's plane.
        normal: Vector3<f64>,
        /// After acceleration, m/s.
        speed: f64,
    },
    /// All six degrees of freedom in sines of unrelated periods, with a pause of two seconds in
    /// every twelve.
    Tour {
        /// Amplitudes along x, y, z, metres.
        reach_m: Vector3<f64>,
        /// Amplitudes about x, y, z, radians.
        turn_rad: Vector3<f64>,
        /// 1 is a calm operator.
        pace: f64,
    },
    /// A turn about an axis through the red ball at a steady rate.
    Turn {
        /// The axis in the world.
        axis: Vector3<f64>,
        /// First and last angle from the orientation at rest, radians.
        from_to_rad: (f64, f64),
        /// First and last time, seconds.
        from_to_s: (f64, f64),
    },
    /// Away by `to_m`, and back after a while, softly.
    Excursion {
        /// Metres.
        to_m: Vector3<f64>,
        /// When it starts, arrives, starts back and has returned, seconds.
        times_s: [f64; 4],
    },
}

impl Motion {
    /// Rotation (about the hand's origin, in world axes) and translation at `time_s`.
    pub(crate) fn at(&self, time_s: f64, seed: u64) -> (Matrix3<f64>, Vector3<f64>) {
        let straight = |x: Vector3<f64>| (Matrix3::identity(), x);
        match self {
            Self::Still => straight(Vector3::zeros()),
            Self::Steps { period_s, amplitude_m } => {
                let step = libm::round(time_s / period_s) as i64 as u64;
                let mut random = Seeded::new("steps", seed, &[step]);
                let mut next = || amplitude_m * (2.0 * random.unit() - 1.0);
                straight(Vector3::new(next(), next(), next()))
            }
            Self::Linear { path_m, speed } => {
                let length = path_m.norm();
                let pass = pass_time(length, *speed);
                let leg = libm::floor(time_s / (pass + PAUSE_S));
                let in_leg = time_s - leg * (pass + PAUSE_S) - PAUSE_S;
                let travelled = along_pass(in_leg, length, *speed) / length;
                let share = if leg as i64 % 2 == 0 { travelled } else { 1.0 - travelled };
                straight(path_m * (share - 0.5))
            }
            Self::Circular { radius_m, normal, speed } => {
                let ramp = speed / ACCELERATION;
                let t = (time_s - PAUSE_S).max(0.0);
                let travelled = if t < ramp {
                    0.5 * ACCELERATION * t * t
                } else {
                    0.5 * ACCELERATION * ramp * ramp + speed * (t - ramp)
                };
                let angle = travelled / radius_m;
                let normal = normal.normalize();
                let first = normal.cross(&Vector3::z()).normalize();
                let second = normal.cross(&first);
                straight((first * libm::cos(angle) + second * libm::sin(angle)) * *radius_m)
            }
            Self::Tour { reach_m, turn_rad, pace } => {
                let p = TAU * pace * tour_phase(time_s);
                let wave = |frequency: f64| libm::sin(p * frequency);
                let x = Vector3::new(reach_m.x * wave(0.11), reach_m.y * wave(0.13), reach_m.z * wave(0.19));
                let turn = about(&Vector3::z(), turn_rad.z * wave(0.14))
                    * about(&Vector3::y(), turn_rad.y * wave(0.23))
                    * about(&Vector3::x(), turn_rad.x * wave(0.17));
                (turn, x)
            }
            Self::Turn { axis, from_to_rad, from_to_s } => {
                let share = ((time_s - from_to_s.0) / (from_to_s.1 - from_to_s.0)).clamp(0.0, 1.0);
                let angle = from_to_rad.0 + (from_to_rad.1 - from_to_rad.0) * share;
                (about(axis, angle), Vector3::zeros())
            }
            Self::Excursion { to_m, times_s } => {
                let [start, arrive, leave, end] = *times_s;
                let share = soft_step((time_s - start) / (arrive - start))
                    - soft_step((time_s - leave) / (end - leave));
                straight(to_m * share)
            }
        }
    }
}

/// A rotation about `axis` (of any length but zero), right-handed.
pub(crate) fn about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (s, c) = (libm::sin(angle), libm::cos(angle));
    let a = axis.normalize();
    // Rodrigues
    Matrix3::identity() * c + a.cross_matrix() * s + a * a.transpose() * (1.0 - c)
}

/// Degrees to radians.
pub(crate) fn degrees(value: f64) -> f64 {
    value * PI / 180.0
}

/// From 0 to 1 with no speed at either end.
fn soft_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

/// The time of the tour's sines: stands still for the first and last second of every twelve.
fn tour_phase(time_s: f64) -> f64 {
    let cycle = libm::floor(time_s / 12.0);
    10.0 * (cycle + soft_step((time_s - 12.0 * cycle - 1.0) / 10.0))
}

/// How long a pass of `length` takes: full acceleration, `speed`, full braking.
fn pass_time(length: f64, speed: f64) -> f64 {
    let peak = speed.min(libm::sqrt(length * ACCELERATION));
    length / peak + peak / ACCELERATION
}

/// How far along a pass one is, `t` after its start.
fn along_pass(t: f64, length: f64, speed: f64) -> f64 {
    let peak = speed.min(libm::sqrt(length * ACCELERATION));
    let (ramp, total) = (peak / ACCELERATION, pass_time(length, speed));
    let t = t.clamp(0.0, total);
    if t < ramp {
        0.5 * ACCELERATION * t * t
    } else if t > total - ramp {
        length - 0.5 * ACCELERATION * (total - t) * (total - t)
    } else {
        0.5 * ACCELERATION * ramp * ramp + peak * (t - ramp)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest speed between samples 1 ms apart.
    fn peak_speed(motion: &Motion, seconds: f64) -> f64 {
        let mut peak = 0.0f64;
        let mut last = motion.at(0.0, 1).1;
        for ms in 1..(seconds * 1000.0) as usize {
            let now = motion.at(ms as f64 / 1000.0, 1).1;
            peak = peak.max((now - last).norm() * 1000.0);
            last = now;
        }
        peak
    }

    #[test]
    fn line_and_circle_reach_their_speed_and_no_more() {
        for speed in [0.25, 0.5, 0.7] {
            let line = Motion::Linear { path_m: Vector3::new(0.0, 0.3, 0.0), speed };
            let circle = Motion::Circular { radius_m: 0.1, normal: Vector3::x(), speed };
            for motion in [line, circle] {
                let peak = peak_speed(&motion, 8.0);
                assert!((peak - speed).abs() < 1e-3, "{motion:?}: {peak}");
            }
        }
    }

    #[test]
    fn line_runs_from_end_to_end_and_circle_keeps_its_radius() {
        let line = Motion::Linear { path_m: Vector3::new(0.0, 0.3, 0.0), speed: 0.5 };
        let places: Vec<f64> = (0..9000).map(|ms| line.at(ms as f64 / 1000.0, 1).1.y).collect();
        let least = places.iter().copied().fold(f64::INFINITY, f64::min);
        let most = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((least + 0.15).abs() < 1e-12 && (most - 0.15).abs() < 1e-12, "{least} {most}");
        let circle = Motion::Circular { radius_m: 0.1, normal: Vector3::new(1.0, 0.2, 0.3), speed: 0.7 };
        for ms in 0..4000 {
            assert!((circle.at(ms as f64 / 1000.0, 1).1.norm() - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn no_motion_jumps_at_thirty_frames_a_second_but_steps() {
        let tour = Motion::Tour {
            reach_m: Vector3::new(0.05, 0.11, 0.07),
            turn_rad: Vector3::new(0.2, 0.2, 0.3),
            pace: 1.0,
        };
        let away = Motion::Excursion { to_m: Vector3::new(0.0, 0.0, 0.3), times_s: [1.0, 2.5, 3.0, 4.5] };
        for motion in [tour, away] {
            assert!(peak_speed(&motion, 40.0) < 0.5, "{motion:?}");
        }
        let steps = Motion::Steps { period_s: 1.0 / 30.0, amplitude_m: 0.001 };
        let (a, b) = (steps.at(0.0, 1).1, steps.at(1.0 / 30.0, 1).1);
        assert_ne!(a, b);
        assert!(a.amax() <= 0.001 && b.amax() <= 0.001);
        // the same place during the whole of one exposure
        assert_eq!(steps.at(1.0 / 30.0 - 0.004, 1).1, steps.at(1.0 / 30.0 + 0.004, 1).1);
    }

    #[test]
    fn every_rotation_is_proper() {
        let turn = about(&Vector3::new(1.0, -2.0, 0.5), 0.8);
        assert!((turn.transpose() * turn - Matrix3::identity()).amax() < 1e-15);
        assert!((turn.determinant() - 1.0).abs() < 1e-15);
        let quarter = about(&Vector3::z(), PI / 2.0) * Vector3::x();
        assert!((quarter - Vector3::y()).amax() < 1e-15);
    }
}
