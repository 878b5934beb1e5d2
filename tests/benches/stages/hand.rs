//! What comes after the cameras: the hand in both modes, and the pose filter.

use crate::clip::{CAMERAS, Clip, FRAME_US};
use divan::{Bencher, black_box};
use tetrad_core::config::{FilterConfig, HandConfig, Prediction, Smoothing, TrackerConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::vision::tracker::CameraTracker;

/// Steps that are tracked beforehand; the hand is benchmarked on them over and over.
const STEPS: usize = 38;

/// What both cameras see in each step.
fn views() -> (Arms, Vec<[HandView; CAMERAS]>) {
    let clip = Clip::new(PixelFormat::Rgb888);
    let mut trackers = [0, 1].map(|camera| {
        let mut tracker = CameraTracker::new(TrackerConfig::default(), clip.learnt(camera).map(Some))
            .expect("the balls of a scene can be tracked");
        for (ball, place) in Ball::ALL.into_iter().zip(clip.places(camera)) {
            tracker.place(ball, place);
        }
        tracker
    });
    let views = (0..STEPS).map(|step| {
        [0, 1].map(|camera| {
            let frame = clip.view(camera, step);
            let report = trackers[camera].step(&frame, step as u64 * FRAME_US, &[None; BALLS]);
            HandView {
                balls: report.observations,
                camera: CameraModel::nominal(frame.width(), frame.height()),
            }
        })
    });
    (Arms::equal(clip.scene.arm_m as f32).expect("the arms of a scene"), views.collect())
}

/// Solving for the pose from two cameras.
#[divan::bench(args = [HandMode::Paper, HandMode::Refined])]
fn pose(bencher: Bencher<'_, '_>, mode: HandMode) {
    let (arms, views) = views();
    let mut hand = HandTracker::new(mode, arms, HandConfig::default());
    let mut steps = (0..).zip(views.iter().cycle());
    bencher.bench_local(|| {
        let (step, views) = steps.next()?;
        let report = hand.update(black_box(views), step * FRAME_US);
        assert!(report.state.is_measured(), "step {step}");
        report.pose
    });
}

/// Where the balls of one camera are expected next.
#[divan::bench(args = [HandMode::Paper, HandMode::Refined])]
fn prediction(bencher: Bencher<'_, '_>, mode: HandMode) {
    let (arms, views) = views();
    let mut hand = HandTracker::new(mode, arms, HandConfig::default());
    for (step, views) in (0..).zip(&views) {
        hand.update(views, step * FRAME_US);
    }
    let t_us = STEPS as u64 * FRAME_US;
    bencher.bench_local(|| black_box(&hand).predict(0, t_us));
}

/// Smoothing and prediction of a moving pose, 50 ms ahead.
#[divan::bench(args = [Prediction::Velocity, Prediction::Acceleration])]
fn filter_one_euro(bencher: Bencher<'_, '_>, prediction: Prediction) {
    filter(bencher, FilterConfig { prediction, ..FilterConfig::default() });
}

/// Prediction alone.
#[divan::bench(args = [Prediction::Velocity, Prediction::Acceleration])]
fn filter_off(bencher: Bencher<'_, '_>, prediction: Prediction) {
    filter(bencher, FilterConfig { prediction, smoothing: Smoothing::Off, ..FilterConfig::default() });
}

fn filter(bencher: Bencher<'_, '_>, config: FilterConfig) {
    let (arms, views) = views();
    let mut hand = HandTracker::new(HandMode::Paper, arms, HandConfig::default());
    let poses: Vec<Pose> =
        (0..).zip(&views).filter_map(|(step, views)| hand.update(views, step * FRAME_US).pose).collect();
    assert_eq!(poses.len(), STEPS);
    let mut filter = PoseFilter::new(FilterConfig { lead_us: 50_000, ..config }).expect("good settings");
    let mut steps = (0..).zip(poses.iter().cycle());
    bencher.bench_local(|| {
        let (step, pose) = steps.next()?;
        filter.measure(step * FRAME_US, black_box(pose)).ok()
    });
}
