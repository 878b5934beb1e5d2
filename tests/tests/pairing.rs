//! Promise: cameras that run free lose little against cameras on one trigger. A hand on a circle is
//! rendered for two cameras whose pictures are up to half a period apart, tracked and joined; where its
//! balls and the hand itself are told to be is compared with where they were at the instant.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test pairing` rewrites tests/snapshots/pairing.txt: read the
//! difference.

mod common;

use nalgebra::Vector3;
use std::fmt::Write as _;
use tetrad::station::pairing::{Joined, Pairing, Sighting, Source};
use tetrad_core::config::{HandConfig, TrackerConfig};
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Observations};
use tetrad_fixtures::{Scene, golden};

/// Offsets are whole parts of a period.
const PARTS: usize = 8;

/// Pictures of each camera.
const FRAMES: usize = 45;

/// The first instants, in which the hand is still at rest and the cameras get to know each other.
const SETTLE: usize = 16;

/// A row of the table: the scene, its pictures a second.
const SCENES: [(&str, f64); 3] =
    [("circular-0.5-30fps", 30.0), ("circular-0.25-60fps", 60.0), ("circular-0.7-30fps", 30.0)];

/// A root mean square and a largest value.
#[derive(Default)]
struct Errors {
    square: f64,
    max: f64,
    count: usize,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.square += error * error;
        self.max = self.max.max(error);
        self.count += 1;
    }

    fn rms(&self) -> f64 {
        (self.square / self.count.max(1) as f64).sqrt()
    }
}

/// What one camera saw, each picture at its time on the grid of parts.
fn sightings(scene: &Scene, camera: usize, part: usize) -> Vec<(usize, Observations)> {
    let (mut rgb, mut tracker) = (Vec::new(), None);
    (0..FRAMES)
        .map(|frame| {
            let at = frame * PARTS + part;
            scene.render_rgb(at, camera, &mut rgb);
            let view = common::view(scene, &rgb);
            let tracker = tracker.get_or_insert_with(|| {
                common::taught_with(&view, &scene.truth(at, camera), TrackerConfig::default())
            });
            (at, tracker.step(&view, common::time_us(scene, at), &[None; BALLS]).observations)
        })
        .collect()
}

/// Errors of the red ball's place in the hand's first axes, metres.
fn poses(scene: &Scene, instants: &[(usize, [Observations; 2])]) -> Errors {
    let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
    let mut hand = HandTracker::new(HandMode::Refined, arms, HandConfig::default());
    let camera = CameraModel::nominal(scene.width, scene.height);
    let mut errors = Errors::default();
    let mut first = None;
    for (number, (at, balls)) in instants.iter().enumerate() {
        let report = hand.update(&balls.map(|balls| HandView { balls, camera }), common::time_us(scene, *at));
        let Some(pose) = report.pose else { continue };
        let truth = scene.hand(*at);
        let first = first.get_or_insert(truth);
        let moved = first.rotation.transpose() * (truth.translation - first.translation);
        let told: Vector3<f64> = pose.translation.cast();
        if number >= SETTLE {
            errors.add((told - moved).norm());
        }
    }
    errors
}

/// Errors of the second camera's balls, px, and of the hand, when each of its pictures stands for the
/// first camera's time: what a station does that pairs by order.
fn side_by_side(
    scene: &Scene,
    left: &[(usize, Observations)],
    right: &[(usize, Observations)],
) -> (Errors, Errors) {
    let instants: Vec<_> =
        left.iter().zip(right).map(|((at, left), (_, right))| (*at, [*left, *right])).collect();
    (balls(scene, &instants), poses(scene, &instants))
}

fn balls(scene: &Scene, instants: &[(usize, [Observations; 2])]) -> Errors {
    let mut errors = Errors::default();
    for (at, views) in instants.iter().skip(SETTLE) {
        for (camera, view) in views.iter().enumerate() {
            for (seen, truth) in view.iter().zip(scene.truth(*at, camera)) {
                if seen.state.is_measured() {
                    let (u, v) = truth.outline_centre;
                    errors.add((f64::from(seen.centre.u) - u).hypot(f64::from(seen.centre.v) - v));
                }
            }
        }
    }
    errors
}

/// The same of instants that are joined as they come.
fn joined(
    scene: &Scene,
    left: &[(usize, Observations)],
    right: &[(usize, Observations)],
) -> (Errors, Errors, f64) {
    let mut arrivals: Vec<_> = [left, right]
        .iter()
        .enumerate()
        .flat_map(|(camera, seen)| seen.iter().map(move |(at, balls)| (*at, camera, *balls)))
        .collect();
    arrivals.sort_by_key(|(at, camera, _)| (*at, *camera));
    let mut pairing = Pairing::new(2);
    let mut instants = Vec::new();
    let mut waited_us = Errors::default();
    for (at, camera, balls) in arrivals {
        let now_us = common::time_us(scene, at);
        let size = (scene.width, scene.height);
        pairing.take(
            camera,
            &Sighting { capture_us: now_us, ready_us: now_us, received_us: now_us, balls, size },
        );
        let Some(Joined { t_us, views, .. }) = pairing.next(now_us) else { continue };
        if views.iter().any(|view| view.source == Source::Missing) {
            continue;
        }
        let at = (t_us as f64 * 1e-6 * scene.fps).round() as usize;
        assert_eq!(common::time_us(scene, at), t_us, "an instant is the time of a picture");
        let views: Vec<Observations> = views.iter().map(|view| view.balls).collect();
        instants.push((at, [views[0], views[1]]));
        waited_us.add((now_us - t_us) as f64);
    }
    assert!(instants.len() + 2 >= FRAMES, "one a period: {}", instants.len());
    (balls(scene, &instants), poses(scene, &instants), waited_us.rms())
}

#[test]
fn the_error_against_the_offset() -> Result<(), Box<dyn std::error::Error>> {
    let mut table = String::from(
        "# A hand on a circle of 0.1 m, two cameras at 1 m, 640x480, sub-pixel centres and refined pose. The\n\
         # right camera's pictures are taken so much after the left one's. By order: the pictures stand for\n\
         # one time, as if they were taken together; far apart they contradict each other so much that one of\n\
         # both is left out. Joined: told at the instant, between two pictures. Errors\n\
         # against the truth at that time: centres of the balls in px, place of the hand in mm, root mean\n\
         # square and largest. Waited: from the instant until both had their pictures around it.\n\
         #                          by order           |           joined            |\n\
         # scene         offset  px        mm           |  px         mm              | waited\n",
    );
    for (name, fps) in SCENES {
        let mut scene = common::scene(name);
        scene.fps = fps * PARTS as f64;
        let left = sightings(&scene, 0, 0);
        for part in 0..=PARTS / 2 {
            let right = sightings(&scene, 1, part);
            let (by_order, by_order_hand) = side_by_side(&scene, &left, &right);
            let (centres, hand, waited_us) = joined(&scene, &left, &right);
            let offset_ms = part as f64 / scene.fps * 1e3;
            writeln!(
                table,
                "{name:<20} {offset_ms:4.1} | {:5.2} {:5.2} {:6.2} {:6.2} | {:5.2} {:5.2} {:6.2} {:6.2} | {:4.1} ms",
                by_order.rms(),
                by_order.max,
                by_order_hand.rms() * 1e3,
                by_order_hand.max * 1e3,
                centres.rms(),
                centres.max,
                hand.rms() * 1e3,
                hand.max * 1e3,
                waited_us / 1e3,
            )?;
            if part == 0 {
                assert_eq!(
                    centres.max.to_bits(),
                    by_order.max.to_bits(),
                    "{name}: taken together, nothing changes"
                );
            } else {
                assert!(centres.rms() < by_order.rms() / 3.0, "{name}, {offset_ms} ms");
                assert!(hand.rms() < by_order_hand.rms() / 2.0, "{name}, {offset_ms} ms");
            }
        }
    }
    golden::check_file(&tetrad_tests::repository().join("tests/snapshots/pairing.txt"), table.as_bytes())?;
    Ok(())
}
