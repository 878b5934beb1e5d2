//! Promise: the same frames give the same bits, twice, in debug and in release builds and on every
//! target. `cargo verify` runs this file in both builds; both are compared with one file.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test goldens` rewrites hil-fixtures/data/tracker.txt.

mod common;

use tetrad_core::config::HandConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::motion::MotionTracker;
use tetrad_core::observation::Observation;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::tracker::{CameraTracker, StepReport};
use tetrad_fixtures::Scene;
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

/// Both cameras and the hand, and the hash of everything they have given so far.
struct Chain {
    trackers: Vec<CameraTracker>,
    hand: MotionTracker,
    hash: Fnv1a,
}

impl Chain {
    fn new(scene: &Scene) -> Self {
        let mut rgb = Vec::new();
        let mut taught = |camera| {
            scene.render_rgb(0, camera, &mut rgb);
            common::taught(&common::view(scene, &rgb), &scene.truth(0, camera))
        };
        let trackers = (0..scene.cameras()).map(&mut taught).collect();
        let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
        Self { trackers, hand: MotionTracker::new(arms, HandConfig::default()), hash: Fnv1a::default() }
    }

    fn step(&mut self, frames: &[FrameView<'_>], t_us: u64) {
        let mut views = Vec::new();
        for (camera, (tracker, frame)) in self.trackers.iter_mut().zip(frames).enumerate() {
            let report = tracker.step(frame, t_us, &self.hand.predict(camera));
            write_report(&mut self.hash, &report);
            views.push(report.observations);
        }
        match self.hand.update(&views) {
            Ok(motion) => {
                let pose = motion.since_engage;
                let increment = motion.alpha.iter().chain(motion.phi.iter());
                let since_engage = pose.translation.iter().chain(pose.rotation.iter());
                increment.chain(since_engage).for_each(|x| self.hash.write_f32(*x));
            }
            Err(refusal) => self.hash.write(refusal.to_string().as_bytes()),
        }
    }
}

/// The hashes of two chains that are made and stepped apart, on the same frames of a scene.
fn hashes(name: &str) -> [u64; 2] {
    let scene = common::scene(name);
    let mut chains = [Chain::new(&scene), Chain::new(&scene)];
    let mut pictures = vec![Vec::new(); scene.cameras()];
    for frame in 0..FRAMES.min(scene.frames()) {
        for (camera, rgb) in pictures.iter_mut().enumerate() {
            scene.render_rgb(frame, camera, rgb);
        }
        let frames: Vec<_> = pictures.iter().map(|rgb| common::view(&scene, rgb)).collect();
        for chain in &mut chains {
            chain.step(&frames, common::time_us(&scene, frame));
        }
    }
    chains.map(|chain| chain.hash.finish())
}

fn check(name: &str) -> Result<(), GoldenError> {
    let [first, second] = hashes(name);
    assert_eq!(first, second, "{name}: the same frames gave other bits the second time");
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
    assert_ne!(hashes("static-16px"), hashes("static-5px"));
}
