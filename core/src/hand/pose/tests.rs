//! Simulated pinhole cameras with known truth and noisy centres.

use super::*;
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

/// A tracker that has seen `frames` of a movement, and the noise it goes on with.
fn after(eyes: &[Eye], path: fn(f64) -> Hand, frames: usize) -> (PoseTracker, Noise) {
    let mut noise = Noise(5);
    let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    for frame in 0..frames {
        see(&mut tracker, eyes, &path(frame as f64 / 30.0), frame, &mut noise);
    }
    (tracker, noise)
}

fn see(tracker: &mut PoseTracker, eyes: &[Eye], hand: &Hand, frame: usize, noise: &mut Noise) -> HandReport {
    let views: Vec<HandView> = eyes.iter().map(|eye| view(eye, hand, 0.03, noise)).collect();
    tracker.update(&views, frame as u64 * 33_333)
}

fn error_mm(first: &Hand, now: &Hand, report: &HandReport) -> f64 {
    let pose = report.pose.expect("a pose");
    errors(first, now, &pose).fixed_rows::<3>(0).norm() * 1e3
}

#[test]
fn a_hand_that_comes_back_after_ten_minutes_is_where_it_was() {
    for seed in 0..3 {
        let eyes = pair(30.0);
        let mut noise = Noise(seed);
        let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
        let mut worst = 0.0_f64;
        for frame in 0..18_000 {
            let hand = demo(frame as f64 / 30.0);
            let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
            worst = worst.max(error_mm(&demo(0.0), &hand, &report));
        }
        // and at rest for a second where it began
        for frame in 18_000..18_030 {
            let report = see(&mut tracker, &eyes, &demo(0.0), frame, &mut noise);
            let error = error_mm(&demo(0.0), &demo(0.0), &report);
            assert!(error < 0.3, "{error} mm");
        }
        assert!(worst < 0.6, "{worst} mm on the way");
    }
}

#[test]
fn cameras_thirty_to_a_hundred_and_twenty_degrees_apart() {
    for half_deg in [15.0, 30.0, 45.0, 60.0] {
        let tally = run("apart", &pair(half_deg), demo, 300, 0.03, 4, untouched);
        holds(&tally, 1.5, 0.6, 0.3);
        is_honest(&tally);
    }
}

#[test]
fn one_camera_alone_gives_the_whole_pose() {
    for path in [linear, circular] {
        for nominal in [800.0, 880.0, 720.0] {
            let mut eye = Eye::looking(-30.0, 12.0, 1.0);
            eye.nominal = nominal;
            let tally = run("one camera", &[eye], path, 300, 0.02, 6, untouched);
            holds(&tally, 6.0, 1.5, 1.0);
            is_honest(&tally);
        }
    }
}

#[test]
fn eight_cameras_are_better_than_two() {
    let ring = |count: usize| -> Vec<Eye> {
        (0..count).map(|i| Eye::looking(-60.0 + 17.0 * i as f64, 12.0 + 5.0 * (i % 3) as f64, 1.0)).collect()
    };
    let of = |count| {
        let tally = run("ring", &ring(count), demo, 200, 0.03, 1, untouched);
        is_honest(&tally);
        tally.sum / tally.n as f64
    };
    assert!(of(8) < 0.8 * of(2));
}

#[test]
fn a_wrong_ball_is_left_out() {
    let wrong = |frame: usize, views: &mut [HandView]| {
        if frame % 20 > 10 {
            views[1].balls[Ball::Green.index()].centre.u += 12.0;
        }
    };
    let tally = run("wrong ball", &pair(30.0), demo, 300, 0.03, 4, wrong);
    holds(&tally, 1.0, 0.3, 0.3);
    assert!(tally.states.contains_key(&PoseState::Three), "and the state says so");
    is_honest(&tally);
}

#[test]
fn a_camera_that_was_moved_is_left_out_and_latched_anew() {
    let mut eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 90);
    // knocked by two degrees
    eyes[1].rotation = about(Vector3::new(1.0, 2.0, 0.5), 2.0) * eyes[1].rotation;
    let mut states = vec![];
    for frame in 90..300 {
        let hand = demo(frame as f64 / 30.0);
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        states.push(report.state);
        let error = error_mm(&demo(0.0), &hand, &report);
        assert!(error < 3.0, "frame {frame}, {}: {error} mm", report.state.name());
    }
    let patience = HandConfig::default().pose.relatch_frames as usize;
    assert!(states[..patience].iter().all(|state| *state == PoseState::One));
    assert!(states[patience + 1..].iter().all(|state| *state == PoseState::Both));
}

#[test]
fn a_camera_that_joins_later_is_latched_from_the_pose_of_the_others() {
    let late = |frame: usize, views: &mut [HandView]| {
        if frame < 100 {
            hide(views, 1, &Ball::ALL);
        }
    };
    let tally = run("late", &pair(30.0), demo, 400, 0.03, 4, late);
    assert!(tally.states.contains_key(&PoseState::Both) && tally.states.contains_key(&PoseState::One));
    is_honest(&tally);
}

#[test]
fn engage_tells_the_pose_from_where_the_hand_is() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 100);
    let latched = demo(99.0 / 30.0);
    tracker.engage();
    assert_eq!(tracker.engagements(), 1);
    for frame in 100..300 {
        let hand = demo(frame as f64 / 30.0);
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        let error = error_mm(&latched, &hand, &report);
        assert!(error < 0.6, "frame {frame}: {error} mm");
        assert_eq!(report.motion.map(|motion| (motion.engagements, motion.spans)), Ok((1, 1)));
    }
}

#[test]
fn engage_with_the_hand_unseen_waits_for_it() {
    let eyes = pair(30.0);
    let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    tracker.engage();
    assert_eq!(tracker.engagements(), 0);
    let mut noise = Noise(3);
    let report = see(&mut tracker, &eyes, &demo(3.0), 0, &mut noise);
    let motion = report.motion.unwrap();
    assert_eq!((motion.engagements, motion.spans, report.pose), (1, 0, Some(Pose::identity())));
    let mut hidden: Vec<HandView> = eyes.iter().map(|eye| view(eye, &demo(3.0), 0.03, &mut noise)).collect();
    hide(&mut hidden, 0, &Ball::ALL);
    hide(&mut hidden, 1, &Ball::ALL);
    let report = tracker.update(&hidden, 33_333);
    assert_eq!(report.motion, Err(MotionRefusal::BallMissing { view: 0, ball: Ball::Red }));
    tracker.engage();
    assert_eq!(tracker.engagements(), 1);
    let report = see(&mut tracker, &eyes, &demo(4.0), 2, &mut noise);
    let motion = report.motion.unwrap();
    assert_eq!((motion.engagements, motion.spans, motion.since_engage), (2, 2, Pose::identity()));
    assert!(motion.alpha.norm() > 0.005, "the increment still tells what was moved");
}

#[test]
fn increments_add_up_to_the_pose() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 60);
    let mut sum = see(&mut tracker, &eyes, &demo(2.0), 60, &mut noise).pose.unwrap();
    for frame in 61..120 {
        let report = see(&mut tracker, &eyes, &demo(frame as f64 / 30.0), frame, &mut noise);
        let motion = report.motion.unwrap();
        sum = sum.compose(&motion.increment());
        assert!((sum.translation - motion.since_engage.translation).norm() < 1e-5);
        assert_eq!(Some(motion.since_engage), report.pose);
    }
}

#[test]
fn balls_are_expected_where_they_will_be_also_in_a_blind_camera() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, slow, 120);
    for frame in 120..180 {
        let hand = slow(frame as f64 / 30.0);
        let truth: Vec<HandView> = eyes.iter().map(|eye| view(eye, &hand, 0.0, &mut noise)).collect();
        for (camera, truth) in truth.iter().enumerate() {
            let expected = tracker.predict(camera, frame as u64 * 33_333);
            for (expected, truth) in expected.iter().zip(&truth.balls) {
                let off = expected.expect("a place").distance(truth.centre);
                assert!(off < 2.0, "frame {frame}, camera {camera}: {off} px");
            }
        }
        let mut views: Vec<HandView> = eyes.iter().map(|eye| view(eye, &hand, 0.03, &mut noise)).collect();
        hide(&mut views, 0, &Ball::ALL);
        assert_eq!(tracker.update(&views, frame as u64 * 33_333).state, PoseState::One);
    }
    assert_eq!(tracker.predict(2, 180 * 33_333), [None; BALLS]);
    assert_eq!(tracker.predict(0, 1 << 40), [None; BALLS], "too long ago");
}

#[test]
fn a_hand_at_rest_does_not_creep() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 200);
    let hand = demo(200.0 / 30.0);
    let settled = see(&mut tracker, &eyes, &hand, 200, &mut noise);
    let focal = tracker.focal_px(0);
    for frame in 201..800 {
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        let off = (report.pose.unwrap().translation - settled.pose.unwrap().translation).norm();
        assert!(off < 0.3e-3, "{off} m");
    }
    // a frame or two may have been learnt from on the way to where it stopped, no more
    let change = (tracker.focal_px(0).unwrap() - focal.unwrap()).abs();
    assert!(change < 4.0, "{change} px");
}

#[test]
fn centres_that_are_worse_than_they_say_are_found_out() {
    let liar = |_: usize, views: &mut [HandView]| {
        for ball in views.iter_mut().flat_map(|view| &mut view.balls) {
            ball.covariance = ImageCovariance::isotropic(0.02);
        }
    };
    let tally = run("liar", &pair(30.0), demo, 600, 0.1, 3, liar);
    is_honest(&tally);
}

mod any_input {
    use super::*;
    use crate::hand::synthetic::number;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_taken_or_refused(
            values in prop::collection::vec(number(), 6 * 24),
            states in prop::collection::vec(0_u8..4, 24),
            focal_px in number(),
        ) {
            let eyes = pair(30.0);
            let (mut tracker, _) = after(&eyes, demo, 3);
            for (frame, (values, states)) in values.chunks(48).zip(states.chunks(8)).enumerate() {
                let views: Vec<HandView> = values
                    .chunks(24)
                    .zip(states.chunks(4))
                    .map(|(values, states)| HandView {
                        balls: core::array::from_fn(|i| {
                            let v = &values[6 * i..];
                            Observation {
                                state: [ObservationState::Visible, ObservationState::Occluded,
                                    ObservationState::Visible, ObservationState::Lost][usize::from(states[i])],
                                centre: ImagePoint::new(v[0], v[1]),
                                diameter: v[2],
                                covariance: ImageCovariance { uu: v[3], uv: v[4], vv: v[5] },
                                visible: 1.0,
                            }
                        }),
                        camera: CameraModel { width: 640, height: 480, focal_px },
                    })
                    .collect();
                let report = tracker.update(&views, (frame as u64 + 3) * 33_333);
                if let Some(pose) = report.pose {
                    prop_assert!(pose.translation.iter().chain(pose.rotation.iter()).all(|x| x.is_finite()));
                    prop_assert!(report.covariance.unwrap().iter().all(|x| x.is_finite()));
                }
                tracker.engage();
            }
        }
    }
}
