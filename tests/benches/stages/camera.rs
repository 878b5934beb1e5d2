//! A whole step of one camera's tracker: four balls in the next frame, in both modes.

use crate::clip::{Clip, FRAME_US};
use divan::Bencher;
use tetrad_core::config::TrackerConfig;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::vision::tracker::CameraTracker;

/// Row-edge centres.
#[divan::bench(args = PixelFormat::ALL)]
fn step_paper(bencher: Bencher<'_, '_>, format: PixelFormat) {
    step(bencher, format, TrackerConfig::paper());
}

/// Refined centres.
#[divan::bench(args = PixelFormat::ALL)]
fn step_refined(bencher: Bencher<'_, '_>, format: PixelFormat) {
    step(bencher, format, TrackerConfig::default());
}

fn step(bencher: Bencher<'_, '_>, format: PixelFormat, config: TrackerConfig) {
    let clip = Clip::new(format);
    let mut tracker =
        CameraTracker::new(config, clip.learnt(0).map(Some)).expect("the balls of a scene can be tracked");
    for (ball, place) in Ball::ALL.into_iter().zip(clip.places(0)) {
        tracker.place(ball, place);
    }
    let mut frame = 0;
    bencher.bench_local(|| {
        let report = tracker.step(&clip.view(0, frame), frame as u64 * FRAME_US, &[None; BALLS]);
        assert!(report.observations.iter().all(|ball| ball.state.is_measured()), "frame {frame}");
        frame += 1;
        report
    });
}
