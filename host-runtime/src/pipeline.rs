//! One or more cameras' frames in, observations and the hand's motion out.
//!
//! ```text
//! frame ----> CameraTracker ----> observations --+  HandStage ------------------------------------------+
//! frame ----> CameraTracker ----> observations --+--> HandTracker ----> motion, pose ---> PoseFilter ---> pose
//!                   ^                                     |
//!                   +------ where each ball is next ------+
//! ```
//!
//! [`Pipeline`] is the whole of it; an operator station, whose cameras are elsewhere, has the
//! [`HandStage`] alone.
//!
//! No files and no clock of its own but the stopwatch around each tracker: `track`, `demo` and the
//! tests feed it frames.

mod hand;

pub use hand::{HandStage, HandStep};

use std::time::{Duration, Instant};
use tetrad_core::config::{HandConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::tracker::HandMode;
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::tracker::{CameraTracker, StepReport, TrackerError};

/// What one camera starts with, ordered as [`Ball::ALL`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraStart {
    /// The balls as they were taught; `None` for one that is not tracked.
    pub balls: [Option<LearntBall>; BALLS],
    /// Where they are in the first frame, pixels; `None` where that is to be searched for.
    pub places: [Option<ImagePoint>; BALLS],
    /// Its nominal focal length, px; `None` where nobody knows:
    /// [`CameraModel::NOMINAL_FOCAL_WIDTHS`] picture widths.
    pub focal_px: Option<f32>,
}

impl CameraStart {
    /// Balls that are to be searched for.
    #[must_use]
    pub const fn anywhere(balls: [Option<LearntBall>; BALLS]) -> Self {
        Self { balls, places: [None; BALLS], focal_px: None }
    }
}

/// The tracker of a camera that starts so, live and in a replay.
///
/// # Errors
/// The [`TrackerError`] that names the setting or the ball.
pub fn tracker_of(config: TrackerConfig, start: &CameraStart) -> Result<CameraTracker, TrackerError> {
    let mut tracker = CameraTracker::new(config, start.balls)?;
    for (ball, place) in Ball::ALL.into_iter().zip(start.places) {
        if let Some(place) = place {
            tracker.place(ball, place);
        }
    }
    Ok(tracker)
}

/// How everything is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PipelineConfig {
    /// One camera's stages.
    pub tracker: TrackerConfig,
    /// How the pose is computed.
    pub hand_mode: HandMode,
    /// The hand's stages.
    pub hand: HandConfig,
}

impl PipelineConfig {
    /// The paper's methods throughout.
    #[must_use]
    pub fn paper() -> Self {
        let (tracker, hand) = (TrackerConfig::paper(), HandConfig::default());
        Self { tracker, hand_mode: HandMode::Paper, hand }
    }

    /// The finer ones, which are the default.
    #[must_use]
    pub fn refined() -> Self {
        let (tracker, hand) = (TrackerConfig::default(), HandConfig::default());
        Self { tracker, hand_mode: HandMode::Refined, hand }
    }
}

impl Default for PipelineConfig {
    fn default() -> Self {
        Self::refined()
    }
}

/// What one camera saw in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraStep {
    /// Observations and what they took.
    pub report: StepReport,
    /// How long the tracker took; getting and decoding the frame is not in it.
    pub tracking: Duration,
}

/// What came of one frame of each camera.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// The cameras in the order they were given.
    pub cameras: Vec<CameraStep>,
    /// The hand; `None` when no hand is solved for.
    pub hand: Option<HandStep>,
}

/// Trackers of all cameras, and of the hand they see.
#[derive(Clone, Debug)]
pub struct Pipeline {
    cameras: Vec<Camera>,
    hand: Option<HandStage>,
}

#[derive(Clone, Debug)]
struct Camera {
    tracker: CameraTracker,
    focal_px: Option<f32>,
}

impl Pipeline {
    /// A pipeline of these cameras. With `arms` the hand is solved for; that
    /// takes two cameras or more and all four balls, and without them every frame is refused.
    ///
    /// # Errors
    /// The camera's place in the list and the [`TrackerError`] that names its setting or ball.
    pub fn new(
        starts: &[CameraStart],
        config: PipelineConfig,
        arms: Option<Arms>,
    ) -> Result<Self, (usize, TrackerError)> {
        let mut cameras = Vec::new();
        for (camera, start) in starts.iter().enumerate() {
            let tracker = tracker_of(config.tracker, start).map_err(|error| (camera, error))?;
            cameras.push(Camera { tracker, focal_px: start.focal_px });
        }
        let filter = PoseFilter::default();
        let hand = arms.map(|arms| HandStage::new(config.hand_mode, arms, config.hand, filter));
        Ok(Self { cameras, hand })
    }

    /// The same pipeline with a filter of other settings than the default ones.
    #[must_use]
    pub fn with_filter(self, filter: PoseFilter) -> Self {
        Self { hand: self.hand.map(|hand| hand.with_filter(filter)), ..self }
    }

    /// Latches the hand: from the next step on the pose is told from where the hand is now.
    pub fn engage(&mut self) {
        if let Some(hand) = &mut self.hand {
            hand.engage();
        }
    }

    /// Takes one frame of each camera in their order, each with its time in microseconds of any clock
    /// that goes forward. Cameras beyond the frames given are left out. The hand's time is the first
    /// camera's.
    pub fn step(&mut self, frames: &[(FrameView<'_>, u64)]) -> Step {
        let hand = &self.hand;
        let predictions = |view, t_us| hand.as_ref().map_or([None; BALLS], |hand| hand.predict(view, t_us));
        let cameras: Vec<CameraStep> = self
            .cameras
            .iter_mut()
            .zip(frames)
            .enumerate()
            .map(|(view, (camera, (frame, t_us)))| {
                let prediction = predictions(view, *t_us);
                let started = Instant::now();
                let report = camera.tracker.step(frame, *t_us, &prediction);
                CameraStep { report, tracking: started.elapsed() }
            })
            .collect();
        let views: Vec<HandView> = cameras
            .iter()
            .zip(&self.cameras)
            .zip(frames)
            .map(|((step, camera), (frame, _))| {
                let nominal = CameraModel::nominal(frame.width(), frame.height());
                let focal_px = camera.focal_px.unwrap_or(nominal.focal_px);
                HandView { balls: step.report.observations, camera: CameraModel { focal_px, ..nominal } }
            })
            .collect();
        let t_us = frames.first().map_or(0, |(_, t_us)| *t_us);
        let hand = self.hand.as_mut().map(|hand| hand.step(&views, t_us));
        Step { cameras, hand }
    }
}
