//! What the tracker's promises share: a scene is rendered, its balls are taught from the first frame,
//! and every frame is tracked beside its truth.
#![allow(dead_code, reason = "each test file uses its part")]

use tetrad::learning::tracked_as;
use tetrad::pipeline::{CameraStart, Pipeline, PipelineConfig};
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::observation::{BALLS, Ball, Observation, ObservationState};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::learn;
use tetrad_core::vision::tracker::{CameraTracker, StepReport};
use tetrad_fixtures::{BallTruth, Scene, to_format};

/// A scene by name.
pub(crate) fn scene(name: &str) -> Scene {
    Scene::named(name).unwrap_or_else(|| panic!("there is no scene {name}"))
}

/// One frame of one camera as it was tracked, beside what is true.
pub(crate) struct Tracked {
    /// The number of the frame.
    pub(crate) frame: usize,
    /// Where the balls are.
    pub(crate) truth: [BallTruth; BALLS],
    /// What the tracker says.
    pub(crate) report: StepReport,
}

impl Tracked {
    /// What is true of a ball, and what was seen of it.
    pub(crate) fn ball(&self, ball: Ball) -> (&BallTruth, &Observation) {
        (&self.truth[ball.index()], &self.report.observations[ball.index()])
    }

    /// The distance of a ball's observation from the centre of its outline, pixels.
    pub(crate) fn error_px(&self, ball: Ball) -> f64 {
        self.distance_px(ball, ball)
    }

    /// The distance of a ball's observation from the outline of another, pixels.
    pub(crate) fn distance_px(&self, ball: Ball, other: Ball) -> f64 {
        let (u, v) = self.truth[other.index()].outline_centre;
        let seen = self.report.observations[ball.index()].centre;
        (f64::from(seen.u) - u).hypot(f64::from(seen.v) - v)
    }

    /// Whether a ball is measured, and measured where it is: within a quarter of its diameter, or
    /// 2 px where that is more; within half of it where a part of the ball is hidden.
    pub(crate) fn holds(&self, ball: Ball) -> bool {
        let (truth, seen) = self.ball(ball);
        let share = if seen.state == ObservationState::Visible { 4.0 } else { 2.0 };
        seen.state.is_measured() && self.error_px(ball) <= (truth.diameter / share).max(2.0)
    }
}

/// Tracks every frame of one camera, in order, in `paper` mode.
pub(crate) fn track(scene: &Scene, camera: usize, each: impl FnMut(&Tracked)) {
    track_as(scene, camera, TrackerConfig::paper(), PixelFormat::Rgb888, each);
}

/// The same in any mode and format.
pub(crate) fn track_as(
    scene: &Scene,
    camera: usize,
    config: TrackerConfig,
    format: PixelFormat,
    each: impl FnMut(&Tracked),
) {
    track_shown(scene, camera, config, format, |_, _| {}, each);
}

/// The same of pictures that are changed before they are shown.
pub(crate) fn track_shown(
    scene: &Scene,
    camera: usize,
    config: TrackerConfig,
    format: PixelFormat,
    change: impl Fn(usize, &mut [u8]),
    mut each: impl FnMut(&Tracked),
) {
    let (mut rgb, mut tracker) = (Vec::new(), None);
    for frame in 0..scene.frames() {
        scene.render_rgb(frame, camera, &mut rgb);
        change(frame, &mut rgb);
        let bytes = to_format(&rgb, scene.width, scene.height, format);
        let view = FrameView::packed(&bytes, scene.width, scene.height, format);
        let view = view.expect("a rendered frame is whole");
        let tracker = tracker.get_or_insert_with(|| taught_with(&view, &scene.truth(frame, camera), config));
        let report = tracker.step(&view, time_us(scene, frame), &[None; BALLS]);
        each(&Tracked { frame, truth: scene.truth(frame, camera), report });
    }
}

/// Tracks every frame of all cameras, in order, as the program does: the hand that they see says where
/// each ball is next; with methods of choice.
pub(crate) fn track_hand_with(scene: &Scene, config: PipelineConfig, mut each: impl FnMut(usize, &Tracked)) {
    let mut pictures = vec![Vec::new(); scene.cameras()];
    render(scene, 0, &mut pictures);
    let starts: Vec<CameraStart> = pictures
        .iter()
        .enumerate()
        .map(|(camera, rgb)| {
            let (view, first) = (view(scene, rgb), scene.truth(0, camera));
            CameraStart {
                balls: Ball::ALL.map(|ball| Some(learnt(&view, ball, &first[ball.index()]))),
                places: Ball::ALL.map(|ball| Some(centre(&first[ball.index()]))),
                focal_px: None,
            }
        })
        .collect();
    let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
    let pipeline = Pipeline::new(&starts, config, Some(arms));
    let mut pipeline = pipeline.expect("the balls of a scene can be tracked");
    for frame in 0..scene.frames() {
        render(scene, frame, &mut pictures);
        let t_us = time_us(scene, frame);
        let views: Vec<_> = pictures.iter().map(|rgb| (view(scene, rgb), t_us)).collect();
        for (camera, step) in pipeline.step(&views).cameras.into_iter().enumerate() {
            each(camera, &Tracked { frame, truth: scene.truth(frame, camera), report: step.report });
        }
    }
}

fn render(scene: &Scene, frame: usize, pictures: &mut [Vec<u8>]) {
    for (camera, rgb) in pictures.iter_mut().enumerate() {
        scene.render_rgb(frame, camera, rgb);
    }
}

/// A rendered picture as the tracker takes it.
pub(crate) fn view<'a>(scene: &Scene, rgb: &'a [u8]) -> FrameView<'a> {
    FrameView::packed(rgb, scene.width, scene.height, PixelFormat::Rgb888).expect("a rendered frame is whole")
}

/// The time of a frame, microseconds.
pub(crate) fn time_us(scene: &Scene, frame: usize) -> u64 {
    (scene.time_s(frame) * 1e6).round() as u64
}

/// A tracker that has been taught the four balls where they are in the first frame.
pub(crate) fn taught(view: &FrameView<'_>, first: &[BallTruth; BALLS]) -> CameraTracker {
    taught_with(view, first, TrackerConfig::paper())
}

/// The same with settings of one's own.
pub(crate) fn taught_with(
    view: &FrameView<'_>,
    first: &[BallTruth; BALLS],
    config: TrackerConfig,
) -> CameraTracker {
    let balls = Ball::ALL.map(|ball| Some(learnt(view, ball, &first[ball.index()])));
    let mut tracker = CameraTracker::new(config, balls).expect("the balls of a scene can be tracked");
    for (ball, truth) in Ball::ALL.into_iter().zip(first) {
        tracker.place(ball, centre(truth));
    }
    tracker
}

/// The centre of a ball's outline.
pub(crate) fn centre(truth: &BallTruth) -> ImagePoint {
    ImagePoint::new(truth.outline_centre.0 as f32, truth.outline_centre.1 as f32)
}

/// A ball as it is learnt from one point inside it.
fn learnt(view: &FrameView<'_>, ball: Ball, truth: &BallTruth) -> LearntBall {
    let learnt = learn(view, Primary::of(ball), centre(truth), &LearnConfig::default());
    let learnt = learnt.unwrap_or_else(|refused| panic!("{}: {refused}", ball.name()));
    tracked_as(&learnt)
}
