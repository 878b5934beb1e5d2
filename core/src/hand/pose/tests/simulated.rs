//! Simulated pinhole cameras, hand movements with known truth, and noisy centres.

use crate::geometry::ImagePoint;
use crate::hand::view::{CameraModel, HandView};
use crate::observation::{Ball, ImageCovariance, Observation, ObservationState};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::vec;
use std::vec::Vec;

/// A pinhole camera in double precision.
#[derive(Clone, Debug)]
pub(super) struct Eye {
    pub(super) rotation: Matrix3<f64>,
    position: Vector3<f64>,
    focal: f64,
    pub(super) nominal: f32,
}

impl Eye {
    pub(super) fn looking(azimuth_deg: f64, elevation_deg: f64, distance: f64) -> Self {
        let (a, e) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        let position = Vector3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin()) * distance;
        let forward = -position.normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        let rotation = Matrix3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
        Self { rotation, position, focal: 800.0, nominal: 800.0 }
    }

    pub(super) fn sees(&self, x: &Vector3<f64>) -> (f64, f64, f64) {
        let p = self.rotation * (x - self.position);
        // the centre of a sphere's outline
        let tangent = (p.x * p.x + p.y * p.y) / (p.z * p.z);
        let sine = 0.01 / p.norm();
        let out = 1.0 / (1.0 - sine * sine * (1.0 + tangent));
        (319.5 + self.focal * p.x / p.z * out, 239.5 + self.focal * p.y / p.z * out, self.focal * 0.02 / p.z)
    }
}

/// world_from_hand in double precision.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hand {
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
}

/// Seeded noise.
pub(super) struct Noise(pub(super) u64);

impl Noise {
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub(super) fn gauss(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (core::f64::consts::TAU * self.uniform()).cos()
    }
}

pub(super) fn about(axis: Vector3<f64>, degrees: f64) -> Matrix3<f64> {
    *Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), degrees.to_radians()).matrix()
}

pub(super) fn rest() -> Hand {
    let rotation = about(Vector3::z(), 95.0) * about(Vector3::x(), -59.0);
    Hand { rotation, translation: -(rotation * Vector3::repeat(0.02)) }
}

pub(super) fn moved(shift: Vector3<f64>, turn: Matrix3<f64>) -> Hand {
    let rest = rest();
    Hand { rotation: turn * rest.rotation, translation: rest.translation + shift }
}

pub(super) fn pair(half_deg: f64) -> Vec<Eye> {
    vec![Eye::looking(-half_deg, 12.0, 1.0), Eye::looking(half_deg, 12.0, 1.0)]
}

pub(super) fn view(eye: &Eye, hand: &Hand, sigma: f64, noise: &mut Noise) -> HandView {
    let ends = [Vector3::zeros(), Vector3::x(), Vector3::y(), Vector3::z()];
    let balls = ends.map(|end| {
        let (u, v, d) = eye.sees(&(hand.rotation * (end * 0.08) + hand.translation));
        Observation {
            state: ObservationState::Visible,
            centre: ImagePoint::new((u + sigma * noise.gauss()) as f32, (v + sigma * noise.gauss()) as f32),
            diameter: d as f32,
            covariance: ImageCovariance::isotropic(sigma as f32),
            visible: 1.0,
        }
    });
    HandView { balls, camera: CameraModel { width: 640, height: 480, focal_px: eye.nominal } }
}

/// Balls of some views are not seen in some frames.
pub(super) fn hide(views: &mut [HandView], view: usize, balls: &[Ball]) {
    for ball in balls {
        views[view].balls[ball.index()] = Observation::default();
    }
}

pub(super) fn linear(t: f64) -> Hand {
    let path = Vector3::new(0.30, 0.80, 0.52).normalize() * 0.3;
    let (length, speed, acc) = (0.3, 0.5, 2.0);
    let ramp: f64 = speed / acc;
    let pass = length / speed + ramp;
    let leg = (t / (pass + 0.5)).floor();
    let s = (t - leg * (pass + 0.5) - 0.5).clamp(0.0, pass);
    let along = if s < ramp {
        0.5 * acc * s * s
    } else if s > pass - ramp {
        length - 0.5 * acc * (pass - s) * (pass - s)
    } else {
        0.5 * acc * ramp * ramp + speed * (s - ramp)
    };
    let share = if leg as i64 % 2 == 0 { along / length } else { 1.0 - along / length };
    moved(path * (share - 0.5), Matrix3::identity())
}

pub(super) fn circular(t: f64) -> Hand {
    let t = (t - 0.5).max(0.0);
    let s = if t < 0.25 { t * t } else { 0.0625 + 0.5 * (t - 0.25) };
    let a = s / 0.1;
    let n = Vector3::new(1.0, 0.3, 0.4).normalize();
    let first = n.cross(&Vector3::z()).normalize();
    let second = n.cross(&first);
    moved((first * a.cos() + second * a.sin()) * 0.1, Matrix3::identity())
}

pub(super) fn tour(reach: Vector3<f64>, turn: Vector3<f64>, t: f64) -> Hand {
    let soft = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * x * (10.0 + x * (6.0 * x - 15.0))
    };
    let cycle = (t / 12.0).floor();
    let p = core::f64::consts::TAU * 10.0 * (cycle + soft((t - 12.0 * cycle - 1.0) / 10.0));
    let w = |f: f64| (p * f).sin();
    let x = Vector3::new(reach.x * w(0.11), reach.y * w(0.13), reach.z * w(0.19));
    let r = about(Vector3::z(), (turn.z * w(0.14)).to_degrees())
        * about(Vector3::y(), (turn.y * w(0.23)).to_degrees())
        * about(Vector3::x(), (turn.x * w(0.17)).to_degrees());
    moved(x, r)
}

pub(super) fn demo(t: f64) -> Hand {
    tour(Vector3::new(0.05, 0.11, 0.07), Vector3::new(0.22, 0.20, 0.26), t)
}

pub(super) fn slow(t: f64) -> Hand {
    tour(Vector3::new(0.02, 0.04, 0.025), Vector3::repeat(0.06), t)
}
