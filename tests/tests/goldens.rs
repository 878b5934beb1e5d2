//! Promise: the same frames give the same bits, twice, in debug and in release builds and on every
//! target. `cargo verify` runs this file in both builds; both are compared with one file.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test goldens` rewrites hil-fixtures/data/tracker.txt.

mod common;

use tetrad::pipeline::PipelineConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::tracker::{HandReport, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
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

/// The hand's motion, as in `paper` mode.
fn write_motion(hash: &mut Fnv1a, report: &HandReport) {
    match &report.motion {
        Ok(motion) => {
            let pose = motion.since_engage;
            let increment = motion.alpha.iter().chain(motion.phi.iter());
            let since_engage = pose.translation.iter().chain(pose.rotation.iter());
            increment.chain(since_engage).for_each(|x| hash.write_f32(*x));
        }
        Err(refusal) => hash.write(refusal.to_string().as_bytes()),
    }
}

/// What `refined` mode says besides.
fn write_certainty(hash: &mut Fnv1a, seen: &[HandView], report: &HandReport) {
    for ball in seen.iter().flat_map(|view| &view.balls) {
        let known = ball.covariance;
        [known.uu, known.uv, known.vv, ball.visible].iter().for_each(|x| hash.write_f32(*x));
    }
    hash.write(&[report.state as u8]);
    if let Some(pose) = &report.pose {
        pose.translation.iter().chain(pose.rotation.iter()).for_each(|x| hash.write_f32(*x));
    }
    if let Some(covariance) = &report.covariance {
        covariance.iter().for_each(|x| hash.write_f32(*x));
    }
}

/// A mode whose results are hashed.
struct Mode {
    /// What is before the scene's name in the file of hashes.
    prefix: &'static str,
    config: fn() -> PipelineConfig,
    /// Whether covariances and states are hashed too.
    certainty: bool,
}

const MODES: [Mode; 2] = [
    Mode { prefix: "", config: PipelineConfig::paper, certainty: false },
    Mode { prefix: "refined-", config: PipelineConfig::refined, certainty: true },
];

/// Both cameras and the hand, and the hash of everything they have given so far.
struct Chain {
    trackers: Vec<CameraTracker>,
    hand: HandTracker,
    certainty: bool,
    hash: Fnv1a,
}

impl Chain {
    fn new(scene: &Scene, config: &PipelineConfig, certainty: bool) -> Self {
        let mut rgb = Vec::new();
        let mut taught = |camera| {
            scene.render_rgb(0, camera, &mut rgb);
            common::taught_with(&common::view(scene, &rgb), &scene.truth(0, camera), config.tracker)
        };
        let trackers = (0..scene.cameras()).map(&mut taught).collect();
        let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
        let hand = HandTracker::new(config.hand_mode, arms, config.hand);
        Self { trackers, hand, certainty, hash: Fnv1a::default() }
    }

    fn step(&mut self, frames: &[FrameView<'_>], t_us: u64) {
        let mut views = Vec::new();
        for (camera, (tracker, frame)) in self.trackers.iter_mut().zip(frames).enumerate() {
            let report = tracker.step(frame, t_us, &self.hand.predict(camera, t_us));
            write_report(&mut self.hash, &report);
            let camera = CameraModel::nominal(frame.width(), frame.height());
            views.push(HandView { balls: report.observations, camera });
        }
        let report = self.hand.update(&views, t_us);
        write_motion(&mut self.hash, &report);
        if self.certainty {
            write_certainty(&mut self.hash, &views, &report);
        }
    }
}

/// For each mode the hashes of two chains that are made and stepped apart, on the same frames of a
/// scene.
fn hashes(name: &str) -> [[u64; 2]; 2] {
    let scene = common::scene(name);
    let mut chains = MODES.map(|mode| [(); 2].map(|()| Chain::new(&scene, &(mode.config)(), mode.certainty)));
    let mut pictures = vec![Vec::new(); scene.cameras()];
    for frame in 0..FRAMES.min(scene.frames()) {
        for (camera, rgb) in pictures.iter_mut().enumerate() {
            scene.render_rgb(frame, camera, rgb);
        }
        let frames: Vec<_> = pictures.iter().map(|rgb| common::view(&scene, rgb)).collect();
        for chain in chains.as_flattened_mut() {
            chain.step(&frames, common::time_us(&scene, frame));
        }
    }
    chains.map(|twins| twins.map(|chain| chain.hash.finish()))
}

fn check(name: &str) -> Result<(), GoldenError> {
    for ([first, second], Mode { prefix: mode, .. }) in hashes(name).into_iter().zip(MODES) {
        assert_eq!(first, second, "{mode}{name}: the same frames gave other bits the second time");
        golden::check(&golden::data("tracker.txt"), &format!("{mode}{name}"), first)?;
    }
    Ok(())
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
    let (of_16, of_5) = (hashes("static-16px"), hashes("static-5px"));
    assert!(of_16.iter().zip(&of_5).all(|(a, b)| a != b), "{of_16:x?} {of_5:x?}");
    assert_ne!(of_16[0], of_16[1], "the modes differ");
}
