//! Promise: the same frames give the same bits, twice, in debug and in release builds and on every
//! target. `cargo verify` runs this file in both builds; both are compared with one file.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test goldens` rewrites hil-fixtures/data/tracker.txt.

mod common;

use tetrad_core::config::HandConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::motion::MotionTracker;
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::vision::tracker::StepReport;
use tetrad_fixtures::golden::{self, Fnv1a, GoldenError};

/// Frames of each scene that are hashed: every search and state has its turn by then.
const FRAMES: usize = 150;

fn write_observation(hash: &mut Fnv1a, seen: &Observation) {
    hash.write(&[seen.state as u8]);
    hash.write_f32(seen.centre.u);
    hash.write_f32(seen.centre.v);
    hash.write_f32(seen.diameter);
}

fn write_report(hash: &mut Fnv1a, report: &StepReport) {
    report.observations.iter().for_each(|seen| write_observation(hash, seen));
    report.scores.iter().for_each(|score| hash.write_f32(*score));
    hash.write(&report.tested.to_le_bytes());
    hash.write_f32(report.mismatch.unwrap_or(-1.0));
    hash.write(&[u8::from(report.validated)]);
}

/// The whole chain of a scene, both cameras and the hand, as one number.
fn hash(name: &str) -> u64 {
    let scene = common::scene(name);
    let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
    let mut hand = MotionTracker::new(arms, HandConfig::default());
    let mut rgb = Vec::new();
    let mut trackers = [0, 1].map(|camera| {
        scene.render_rgb(0, camera, &mut rgb);
        common::taught(&common::view(&scene, &rgb), &scene.truth(0, camera))
    });
    let mut hash = Fnv1a::default();
    for frame in 0..FRAMES.min(scene.frames()) {
        let mut views = [[Observation::default(); BALLS]; 2];
        for (camera, (tracker, view)) in trackers.iter_mut().zip(&mut views).enumerate() {
            scene.render_rgb(frame, camera, &mut rgb);
            let t_us = common::time_us(&scene, frame);
            let report = tracker.step(&common::view(&scene, &rgb), t_us, &hand.predict(camera));
            write_report(&mut hash, &report);
            *view = report.observations;
        }
        match hand.update(&views) {
            Ok(motion) => {
                motion.alpha.iter().chain(motion.phi.iter()).for_each(|x| hash.write_f32(*x));
                let pose = motion.since_engage;
                pose.translation.iter().chain(pose.rotation.iter()).for_each(|x| hash.write_f32(*x));
            }
            Err(refusal) => hash.write(refusal.to_string().as_bytes()),
        }
    }
    hash.finish()
}

fn check(name: &str) -> Result<(), GoldenError> {
    let first = hash(name);
    assert_eq!(first, hash(name), "{name}: the same frames gave other bits the second time");
    golden::check(&golden::data("tracker.txt"), name, first)
}

macro_rules! scenes {
    ($($test:ident $scene:literal)*) => { $(
        #[test]
        fn $test() -> Result<(), GoldenError> {
            check($scene)
        }
    )* };
}

scenes! {
    demo "demo"
    resting_balls "static-16px"
    small_balls "static-5px"
    side_light "static-side-48px"
    fast_and_few_frames "linear-0.7-10fps"
    circle "circular-0.5-30fps"
    crossing "crossing"
    covered "cover-all"
    distractor "distractor"
    picture_edge "edge"
}

#[test]
fn another_scene_gives_another_hash() {
    assert_ne!(hash("static-16px"), hash("static-5px"));
}
