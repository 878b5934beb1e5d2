//! Promise: the refined pose of rendered scenes, two cameras 1 m away, in even light and lit from one
//! side (45 % in the shadow): along 0.3 m and round a circle of 0.1 m radius at 0.5 m/s the error stays
//! in a box of 1.5 mm, its mean under 0.6 mm and the rotation's under 0.3 degrees; with both focal
//! lengths 10 % wrong in a box of 2.5 mm; with one camera in one of 6 mm. (Where nothing is promised of
//! means and rotations their bounds are about three times what is measured.) And errors are what the
//! covariance says they are, in every state that a pose may have.

mod common;

use nalgebra::{Matrix6, Vector3, Vector6};
use std::collections::BTreeMap;
use tetrad::pipeline::PipelineConfig;
use tetrad_core::config::HandConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::{HandMode, HandReport, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Observation};
use tetrad_fixtures::{Light, Scene};

/// What the cameras saw of a scene.
struct Seen {
    scene: Scene,
    frames: Vec<Vec<HandView>>,
}

impl Seen {
    /// Tracks a scene with the refined centre; `frames` of it.
    fn new(mut scene: Scene, frames: usize, light: Light) -> Self {
        scene.light = light;
        scene.frames = frames;
        let mut seen: Vec<Vec<HandView>> = vec![Vec::new(); frames];
        common::track_hand_with(&scene, PipelineConfig::refined(), |_, tracked| {
            let camera = CameraModel { width: scene.width, height: scene.height, focal_px: 800.0 };
            seen[tracked.frame].push(HandView { balls: tracked.report.observations, camera });
        });
        Self { scene, frames: seen }
    }

    /// Solves all frames after `change` was done to what was seen, and tells of those with a pose.
    fn solve(&self, change: impl Fn(usize, &mut Vec<HandView>)) -> Errors {
        let arms = Arms::equal(self.scene.arm_m as f32).expect("the arms of a scene");
        let mut tracker = HandTracker::new(HandMode::Refined, arms, HandConfig::default());
        let (mut errors, mut first) = (Errors::default(), None);
        for (frame, views) in self.frames.iter().enumerate() {
            let mut views = views.clone();
            change(frame, &mut views);
            let report = tracker.update(&views, common::time_us(&self.scene, frame));
            let first = *first.get_or_insert(frame);
            errors.add(&report, &self.error(first, frame, &report));
        }
        errors
    }

    /// Measured less true, metres and radians, in the axes of the feature frame of `first`.
    fn error(&self, first: usize, frame: usize, report: &HandReport) -> Option<Vector6<f64>> {
        let pose = report.pose?;
        let (then, now) = (self.scene.hand(first), self.scene.hand(frame));
        let back = then.rotation.transpose();
        let t = pose.translation.cast::<f64>() - back * (now.translation - then.translation);
        let r = pose.rotation.cast::<f64>() * (back * now.rotation).transpose();
        // twice the sine times the axis: the errors are small
        let w = Vector3::new(r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12) / 2.0;
        Some(Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z))
    }
}

/// The errors of a run.
#[derive(Default)]
struct Errors {
    low_m: Vector3<f64>,
    high_m: Vector3<f64>,
    sum_m: f64,
    worst_turn_rad: f64,
    poses: usize,
    /// Frames, and the sum of normalised squares per degree of freedom, by state.
    squares: BTreeMap<PoseState, (usize, f64)>,
}

impl Errors {
    fn add(&mut self, report: &HandReport, error: &Option<Vector6<f64>>) {
        let (Some(error), Some(covariance)) = (error, report.covariance) else { return };
        let [x, y, z, wx, wy, wz] = (*error).into();
        let (t, w) = (Vector3::new(x, y, z), Vector3::new(wx, wy, wz));
        self.low_m = self.low_m.inf(&t);
        self.high_m = self.high_m.sup(&t);
        self.sum_m += t.norm();
        self.worst_turn_rad = self.worst_turn_rad.max(w.norm());
        self.poses += 1;
        let covariance: Matrix6<f64> = covariance.cast();
        let information = covariance.try_inverse().expect("a covariance can be inverted");
        let of_state = self.squares.entry(report.state).or_default();
        of_state.0 += 1;
        of_state.1 += (error.transpose() * information * error)[0] / 6.0;
    }

    fn box_mm(&self) -> [f64; 3] {
        (1e3 * (self.high_m - self.low_m)).into()
    }

    fn mean_mm(&self) -> f64 {
        1e3 * self.sum_m / self.poses as f64
    }

    /// Holds the errors to bounds, all named where one is broken.
    fn check(&self, name: &str, box_mm: f64, mean_mm: f64, turn_deg: f64) {
        let (sides, mean, turn) = (self.box_mm(), self.mean_mm(), self.worst_turn_rad.to_degrees());
        let told = format!("{name}: box {sides:.2?} mm, mean {mean:.2} mm, turn {turn:.3} degrees");
        println!("{told}; {:?}", self.ratios());
        let holds = sides.iter().all(|side| *side <= box_mm) && mean <= mean_mm && turn <= turn_deg;
        assert!(holds && self.poses > 200, "{told} of {} poses", self.poses);
    }

    /// The root mean square of errors in their standard deviations, by state.
    fn ratios(&self) -> Vec<(PoseState, usize, f64)> {
        self.squares
            .iter()
            .map(|(state, (frames, squares))| (*state, *frames, (squares / *frames as f64).sqrt()))
            .collect()
    }
}

fn lights() -> [(&'static str, Light); 2] {
    [("even", Light::even()), ("side", Light::side(0.45))]
}

/// Every movement in either light, named.
fn movements() -> Vec<(String, Seen)> {
    let scenes = ["linear-0.5-30fps", "circular-0.5-30fps"];
    scenes
        .iter()
        .flat_map(|name| {
            lights().map(|(of, light)| (format!("{name} {of}"), Seen::new(common::scene(name), 300, light)))
        })
        .collect()
}

#[test]
fn movements_are_followed_within_the_box() {
    for (name, seen) in movements() {
        seen.solve(|_, _| {}).check(&name, 1.5, 0.6, 0.3);
        for (left, right) in [(1.1, 1.1), (0.9, 0.9), (1.1, 0.9), (0.9, 1.1)] {
            let errors = seen.solve(|_, views| {
                for (view, wrong) in views.iter_mut().zip([left, right]) {
                    view.camera.focal_px *= wrong;
                }
            });
            errors.check(&format!("{name}, focal lengths times {left} and {right}"), 2.5, 0.12, 0.2);
        }
        for camera in 0..2 {
            let errors = seen.solve(|_, views| *views = vec![views[camera]]);
            errors.check(&format!("{name}, camera {camera} alone"), 6.0, 0.9, 0.4);
        }
    }
}

/// A second whole, then parts of a second each with a ball missing, a camera blind, and nothing seen.
fn covered(frame: usize, views: &mut [HandView]) {
    let hide = |view: &mut HandView, ball: usize| view.balls[ball] = Observation::default();
    let hide_all = |view: &mut HandView| view.balls = [Observation::default(); BALLS];
    match (frame % 90, views) {
        (15..30, [left, _]) => hide(left, frame / 90 % BALLS),
        (30..40, [left, _]) => hide_all(left),
        (40..50, [_, right]) => hide_all(right),
        (70..85, [left, right]) => {
            hide_all(left);
            hide_all(right);
        }
        _ => {}
    }
}

/// A finger covers red for a second: three balls are left, and to one camera they look the same in another
/// pose, 10 degrees away, so it must not tell one. Each kind of scene for itself, since the mean of many hides one that is wrong.
#[test]
fn one_camera_is_as_good_as_it_says_while_a_ball_is_covered() {
    let mut cameras = [Errors::default(), Errors::default()];
    for seed in 1..=3 {
        let mut scene = common::scene("cover");
        scene.seed = seed;
        let frames = scene.frames;
        let seen = Seen::new(scene, frames, Light::even());
        for (camera, all) in cameras.iter_mut().enumerate() {
            let errors = seen.solve(|_, views| *views = vec![views[camera]]);
            println!("seed {seed}, camera {camera}: {:.2?}", errors.ratios());
            for (state, (frames, squares)) in errors.squares {
                let sum = all.squares.entry(state).or_default();
                *sum = (sum.0 + frames, sum.1 + squares);
            }
        }
    }
    for (camera, errors) in cameras.iter().enumerate() {
        let one = errors.ratios().into_iter().find(|(state, ..)| *state == PoseState::One);
        let (_, frames, ratio) = one.expect("one camera gives a pose");
        assert!(frames > 400 && (0.7..=1.4).contains(&ratio), "camera {camera}: {ratio:.2} of {frames}");
    }
}

#[test]
fn errors_are_what_the_covariance_says_in_every_state() {
    let mut all: BTreeMap<PoseState, (usize, f64)> = BTreeMap::new();
    let scenes = ["linear-0.5-30fps", "circular-0.25-30fps", "demo", "cover-all"];
    for (number, name) in scenes.iter().enumerate() {
        for (of, light) in lights() {
            let scene = common::scene(name);
            let frames = scene.frames.min(360 + 30 * number);
            let seen = Seen::new(scene, frames, light);
            let errors = seen.solve(|frame, views| covered(frame, views));
            println!("{name} {of}: {:.2?}", errors.ratios());
            for (state, (frames, squares)) in errors.squares {
                let sum = all.entry(state).or_default();
                *sum = (sum.0 + frames, sum.1 + squares);
            }
        }
    }
    for (state, (frames, squares)) in all {
        let ratio = (squares / frames as f64).sqrt();
        println!("{}: {ratio:.2} of {frames}", state.name());
        assert!(frames > 60, "{}: {frames} frames", state.name());
        assert!((0.7..=1.4).contains(&ratio), "{}: {ratio:.2} of {frames}", state.name());
    }
}
