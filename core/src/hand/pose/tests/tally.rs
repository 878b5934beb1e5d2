//! Runs of a tracker over simulated movements, and what their errors come to.

use super::simulated::{Eye, Hand, Noise, view};
use crate::config::HandConfig;
use crate::geometry::Pose;
use crate::hand::pose::PoseTracker;
use crate::hand::report::HandReport;
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use nalgebra::Vector3;
use std::eprintln;
use std::vec::Vec;

/// Position and rotation error (m, rad; engage axes) of a reported pose.
pub(super) fn errors(first: &Hand, now: &Hand, pose: &Pose) -> nalgebra::Vector6<f64> {
    let truth_r = first.rotation.transpose() * now.rotation;
    let truth_t = first.rotation.transpose() * (now.translation - first.translation);
    let t = pose.translation.cast::<f64>() - truth_t;
    let dr = pose.rotation.cast::<f64>() * truth_r.transpose();
    let w = Vector3::new(dr.m32 - dr.m23, dr.m13 - dr.m31, dr.m21 - dr.m12) / 2.0;
    nalgebra::Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

pub(super) fn error_mm(first: &Hand, now: &Hand, report: &HandReport) -> f64 {
    let pose = report.pose.expect("a pose");
    errors(first, now, &pose).fixed_rows::<3>(0).norm() * 1e3
}

#[derive(Default, Debug)]
pub(super) struct Tally {
    pub(super) states: std::collections::BTreeMap<PoseState, (usize, f64, f64, f64, f64)>,
    pub(super) low: [f64; 3],
    pub(super) high: [f64; 3],
    pub(super) sum: f64,
    pub(super) worst_turn: f64,
    worst_jump: f64,
    pub(super) n: usize,
    last: Option<nalgebra::Vector6<f64>>,
}

impl Tally {
    pub(super) fn add(&mut self, report: &HandReport, e: &nalgebra::Vector6<f64>) {
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
    pub(super) fn show(&self, name: &str) {
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

pub(super) fn run(
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
pub(super) fn untouched(_: usize, _: &mut [HandView]) {}

/// The promise for two cameras 1 m away, movements of 0.3 m, centres good to a fiftieth to a
/// twenty-fifth of a pixel.
pub(super) fn holds(tally: &Tally, box_mm: f64, mean_mm: f64, turn_deg: f64) {
    for (low, high) in tally.low.iter().zip(tally.high) {
        assert!(high - low < box_mm * 1e-3, "{} mm", (high - low) * 1e3);
    }
    let mean = tally.sum / tally.n as f64;
    assert!(mean < mean_mm * 1e-3, "{} mm", mean * 1e3);
    assert!(tally.worst_turn < turn_deg, "{} degrees", tally.worst_turn);
}

/// Errors are what the covariance says, in every state that occurred.
pub(super) fn is_honest(tally: &Tally) {
    for (state, (n, squares, ..)) in &tally.states {
        let ratio = (squares / *n as f64).sqrt();
        assert!((0.7..1.4).contains(&ratio), "{}: {ratio}", state.name());
    }
}

/// A tracker that has seen `frames` of a movement, and the noise it goes on with.
pub(super) fn after(eyes: &[Eye], path: fn(f64) -> Hand, frames: usize) -> (PoseTracker, Noise) {
    let mut noise = Noise(5);
    let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    for frame in 0..frames {
        see(&mut tracker, eyes, &path(frame as f64 / 30.0), frame, &mut noise);
    }
    (tracker, noise)
}

pub(super) fn see(
    tracker: &mut PoseTracker,
    eyes: &[Eye],
    hand: &Hand,
    frame: usize,
    noise: &mut Noise,
) -> HandReport {
    let views: Vec<HandView> = eyes.iter().map(|eye| view(eye, hand, 0.03, noise)).collect();
    tracker.update(&views, frame as u64 * 33_333)
}
