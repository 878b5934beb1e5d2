//! Simulated pinhole cameras with known truth and noisy centres.

use super::*;
use crate::observation::ObservationState;
use nalgebra::{Matrix3, Rotation3};
use std::vec::Vec;
use std::{eprintln, vec};

/// A pinhole camera in double precision.
#[derive(Clone, Debug)]
pub(crate) struct Eye {
    rotation: Matrix3<f64>,
    position: Vector3<f64>,
    focal: f64,
    nominal: f32,
}

impl Eye {
    pub(crate) fn looking(azimuth_deg: f64, elevation_deg: f64, distance: f64) -> Self {
        let (a, e) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        let position = Vector3::new(e.cos() * a.cos(), e.cos() * a.sin(), e.sin()) * distance;
        let forward = -position.normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        let rotation = Matrix3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
        Self { rotation, position, focal: 800.0, nominal: 800.0 }
    }

    fn sees(&self, x: &Vector3<f64>) -> (f64, f64, f64) {
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
pub(crate) struct Hand {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

/// Seeded noise.
pub(crate) struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    fn gauss(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (core::f64::consts::TAU * self.uniform()).cos()
    }
}

fn about(axis: Vector3<f64>, degrees: f64) -> Matrix3<f64> {
    *Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), degrees.to_radians()).matrix()
}

fn rest() -> Hand {
    let rotation = about(Vector3::z(), 95.0) * about(Vector3::x(), -59.0);
    Hand { rotation, translation: -(rotation * Vector3::repeat(0.02)) }
}

fn moved(shift: Vector3<f64>, turn: Matrix3<f64>) -> Hand {
    let rest = rest();
    Hand { rotation: turn * rest.rotation, translation: rest.translation + shift }
}

fn pair(half_deg: f64) -> Vec<Eye> {
    vec![Eye::looking(-half_deg, 12.0, 1.0), Eye::looking(half_deg, 12.0, 1.0)]
}

fn view(eye: &Eye, hand: &Hand, sigma: f64, noise: &mut Noise) -> HandView {
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

/// Position and rotation error (m, rad; engage axes) of a reported pose.
fn errors(first: &Hand, now: &Hand, pose: &Pose) -> nalgebra::Vector6<f64> {
    let truth_r = first.rotation.transpose() * now.rotation;
    let truth_t = first.rotation.transpose() * (now.translation - first.translation);
    let t = pose.translation.cast::<f64>() - truth_t;
    let dr = pose.rotation.cast::<f64>() * truth_r.transpose();
    let w = Vector3::new(dr.m32 - dr.m23, dr.m13 - dr.m31, dr.m21 - dr.m12) / 2.0;
    nalgebra::Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

#[derive(Default, Debug)]
struct Tally {
    states: std::collections::BTreeMap<PoseState, (usize, f64, f64, f64, f64)>,
    low: [f64; 3],
    high: [f64; 3],
    sum: f64,
    worst_turn: f64,
    worst_jump: f64,
    n: usize,
    last: Option<nalgebra::Vector6<f64>>,
}

impl Tally {
    fn add(&mut self, report: &HandReport, e: &nalgebra::Vector6<f64>) {
        let covariance = report.covariance.unwrap().cast::<f64>();
        let nees = covariance.try_inverse().map_or(f64::NAN, |i| (e.transpose() * i * e)[0]) / 6.0;
        let t: nalgebra::Vector3<f64> = e.fixed_rows::<3>(0).into();
        let w: nalgebra::Vector3<f64> = e.fixed_rows::<3>(3).into();
        let st = t.norm_squared() / (covariance.m11 + covariance.m22 + covariance.m33);
        let sw = w.norm_squared() / (covariance.m44 + covariance.m55 + covariance.m66);
        let s = self.states.entry(report.state).or_default();
        s.0 += 1;
        s.1 += nees;
        s.2 += st;
        s.3 += sw;
        s.4 = s.4.max(t.norm());
        for (k, x) in t.iter().enumerate() {
            self.low[k] = self.low[k].min(*x);
            self.high[k] = self.high[k].max(*x);
        }
        self.sum += t.norm();
        self.worst_turn = self.worst_turn.max(w.norm().to_degrees());
        if let Some(last) = self.last {
            let d: nalgebra::Vector3<f64> = (e - last).fixed_rows::<3>(0).into();
            self.worst_jump = self.worst_jump.max(d.norm());
        }
        self.last = Some(*e);
        self.n += 1;
    }
    fn show(&self, name: &str) {
        let b: Vec<f64> = (0..3).map(|k| (self.high[k] - self.low[k]) * 1e3).collect();
        eprintln!(
            "{name}: box {:.2} {:.2} {:.2} mm, mean {:.2} mm, turn {:.3} deg, jump {:.2} mm",
            b[0],
            b[1],
            b[2],
            self.sum / self.n as f64 * 1e3,
            self.worst_turn,
            self.worst_jump * 1e3
        );
        for (s, (n, a, t, w, m)) in &self.states {
            let n_ = *n as f64;
            eprintln!(
                "    {:9} {n:5}: nees {:.2} t {:.2} w {:.2} worst {:.2} mm",
                s.name(),
                (a / n_).sqrt(),
                (t / n_).sqrt(),
                (w / n_).sqrt(),
                m * 1e3
            );
        }
    }
}

fn linear(t: f64) -> Hand {
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

fn circular(t: f64) -> Hand {
    let t = (t - 0.5).max(0.0);
    let s = if t < 0.25 { t * t } else { 0.0625 + 0.5 * (t - 0.25) };
    let a = s / 0.1;
    let n = Vector3::new(1.0, 0.3, 0.4).normalize();
    let first = n.cross(&Vector3::z()).normalize();
    let second = n.cross(&first);
    moved((first * a.cos() + second * a.sin()) * 0.1, Matrix3::identity())
}

fn tour(reach: Vector3<f64>, turn: Vector3<f64>, t: f64) -> Hand {
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

fn demo(t: f64) -> Hand {
    tour(Vector3::new(0.05, 0.11, 0.07), Vector3::new(0.22, 0.20, 0.26), t)
}

fn slow(t: f64) -> Hand {
    tour(Vector3::new(0.02, 0.04, 0.025), Vector3::repeat(0.06), t)
}

fn run(
    name: &str,
    eyes: &[Eye],
    path: fn(f64) -> Hand,
    frames: usize,
    sigma: f64,
    seeds: u64,
    change: impl Fn(usize, &mut [HandView]),
) -> Tally {
    let mut tally = Tally::default();
    for seed in 0..seeds {
        let mut noise = Noise(seed * 7919 + 17);
        let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
        let mut first = None;
        tally.last = None;
        for frame in 0..frames {
            let hand = path(frame as f64 / 30.0);
            let mut views: Vec<HandView> =
                eyes.iter().map(|eye| view(eye, &hand, sigma, &mut noise)).collect();
            change(frame, &mut views);
            let report = tracker.update(&views, frame as u64 * 33_333);
            let Some(pose) = report.pose else { continue };
            let first = *first.get_or_insert(hand);
            tally.add(&report, &errors(&first, &hand, &pose));
        }
    }
    tally.show(name);
    tally
}

/// Nothing done to what the cameras saw.
fn untouched(_: usize, _: &mut [HandView]) {}

/// The promise for two cameras 1 m away, movements of 0.3 m, centres good to a fiftieth to a
/// twenty-fifth of a pixel.
fn holds(tally: &Tally, box_mm: f64, mean_mm: f64, turn_deg: f64) {
    for (low, high) in tally.low.iter().zip(tally.high) {
        assert!(high - low < box_mm * 1e-3, "{} mm", (high - low) * 1e3);
    }
    let mean = tally.sum / tally.n as f64;
    assert!(mean < mean_mm * 1e-3, "{} mm", mean * 1e3);
    assert!(tally.worst_turn < turn_deg, "{} degrees", tally.worst_turn);
}

/// Errors are what the covariance says, in every state that occurred.
fn is_honest(tally: &Tally) {
    for (state, (n, squares, ..)) in &tally.states {
        let ratio = (squares / *n as f64).sqrt();
        assert!((0.7..1.4).contains(&ratio), "{}: {ratio}", state.name());
    }
}

#[test]
fn movements_are_followed_within_a_millimetre() {
    for sigma in [0.02, 0.04] {
        for path in [linear, circular, demo] {
            let tally = run("two cameras", &pair(30.0), path, 300, sigma, 6, untouched);
            holds(&tally, 1.0, 0.3, 0.3);
            is_honest(&tally);
        }
    }
}

#[test]
fn focal_lengths_ten_percent_off_are_mended_by_the_motion() {
    for (first, second) in [(1.1, 1.1), (0.9, 0.9), (1.1, 0.9), (0.9, 1.1)] {
        let mut eyes = pair(30.0);
        eyes[0].nominal *= first;
        eyes[1].nominal *= second;
        for path in [linear, circular] {
            let tally = run("focal lengths off", &eyes, path, 300, 0.03, 4, untouched);
            holds(&tally, 1.5, 0.5, 0.3);
            is_honest(&tally);
        }
    }
}

/// Balls of some views are not seen in some frames.
fn hide(views: &mut [HandView], view: usize, balls: &[Ball]) {
    for ball in balls {
        views[view].balls[ball.index()] = Observation::default();
    }
}

#[test]
fn degraded_states_are_named_and_honest() {
    // five seconds whole, then half a second each of a missing ball, a missing camera, and nothing
    let cover = |frame: usize, views: &mut [HandView]| match frame % 90 {
        0..15 => {}
        15..30 => hide(views, 1, &[Ball::Blue]),
        30..40 => hide(views, 0, &Ball::ALL),
        40..50 => hide(views, 1, &Ball::ALL),
        50..56 => {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &[Ball::Red]);
        }
        70..85 => {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &Ball::ALL);
        }
        _ => {}
    };
    for (name, path) in
        [("slow", slow as fn(f64) -> Hand), ("demo", demo), ("linear", linear), ("circular", circular)]
    {
        let tally = run(name, &pair(30.0), path, 720, 0.03, 8, cover);
        for (state, (n, ..)) in &tally.states {
            assert!(*n > 100, "{}: {n}", state.name());
        }
        assert_eq!(tally.states.len(), 5);
        is_honest(&tally);
    }
}
