//! One or more cameras' frames in, observations and the hand's motion out.
//!
//! ```text
//! frame ----> CameraTracker ----> observations --+
//! frame ----> CameraTracker ----> observations --+--> MotionTracker ----> motion, pose
//!                   ^                                      |
//!                   +------ where each ball is next -------+
//! ```
//!
//! No files and no clock of its own but the stopwatch around each tracker: `track`, `demo` and the
//! tests feed it frames.

use std::time::{Duration, Instant};
use tetrad_core::config::{HandConfig, TrackerConfig};
use tetrad_core::geometry::{ImagePoint, Pose};
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::motion::{Motion, MotionRefusal, MotionTracker, PoseState};
use tetrad_core::observation::{BALLS, Ball, Observations};
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
}

impl CameraStart {
    /// Balls that are to be searched for.
    #[must_use]
    pub const fn anywhere(balls: [Option<LearntBall>; BALLS]) -> Self {
        Self { balls, places: [None; BALLS] }
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

/// What is known of the hand after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandStep {
    /// The motion since the last complete frame, or why there is none.
    pub motion: Result<Motion, MotionRefusal>,
    /// Where the hand is, in the feature frame of the first complete frame (or of the last engage);
    /// `None` before it, and when the hand has been away for too long.
    pub pose: Option<Pose>,
    /// How the pose is known.
    pub state: PoseState,
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
    cameras: Vec<CameraTracker>,
    hand: Option<Hand>,
}

#[derive(Clone, Debug)]
struct Hand {
    tracker: MotionTracker,
    /// Frames without a motion for which the last pose still stands for the hand.
    hold_frames: u32,
    /// Frames without a motion since the last; `None` before the first motion.
    missed: Option<u32>,
}

impl Pipeline {
    /// A pipeline of these cameras. With `arms` the hand is solved for; that
    /// takes two cameras or more and all four balls, and without them every frame is refused.
    ///
    /// # Errors
    /// The camera's place in the list and the [`TrackerError`] that names its setting or ball.
    pub fn new(
        starts: &[CameraStart],
        tracker: TrackerConfig,
        arms: Option<Arms>,
        hand: HandConfig,
    ) -> Result<Self, (usize, TrackerError)> {
        let mut cameras = Vec::new();
        for (camera, CameraStart { balls, places }) in starts.iter().enumerate() {
            let mut started = CameraTracker::new(tracker, *balls).map_err(|error| (camera, error))?;
            for (ball, place) in Ball::ALL.into_iter().zip(places) {
                if let Some(place) = place {
                    started.place(ball, *place);
                }
            }
            cameras.push(started);
        }
        let hand = arms.map(|arms| Hand {
            tracker: MotionTracker::new(arms, hand),
            hold_frames: hand.max_predicted_frames,
            missed: None,
        });
        Ok(Self { cameras, hand })
    }

    /// Takes one frame of each camera in their order, each with its time in microseconds of any clock
    /// that goes forward. Cameras beyond the frames given are left out.
    pub fn step(&mut self, frames: &[(FrameView<'_>, u64)]) -> Step {
        let hand = &self.hand;
        let predictions = |view| hand.as_ref().map_or([None; BALLS], |hand| hand.tracker.predict(view));
        let cameras: Vec<CameraStep> = self
            .cameras
            .iter_mut()
            .zip(frames)
            .enumerate()
            .map(|(view, (tracker, (frame, t_us)))| {
                let prediction = predictions(view);
                let started = Instant::now();
                let report = tracker.step(frame, *t_us, &prediction);
                CameraStep { report, tracking: started.elapsed() }
            })
            .collect();
        let hand = self.hand.as_mut().map(|hand| {
            let views: Vec<Observations> = cameras.iter().map(|camera| camera.report.observations).collect();
            hand.step(&views)
        });
        Step { cameras, hand }
    }
}

impl Hand {
    fn step(&mut self, views: &[Observations]) -> HandStep {
        let motion = self.tracker.update(views);
        self.missed = match &motion {
            Ok(_) => Some(0),
            Err(_) => self.missed.map(|n| n.saturating_add(1)),
        };
        let state = match (&motion, self.missed) {
            (Ok(motion), _) => motion.state(),
            (Err(_), Some(missed)) if missed <= self.hold_frames => PoseState::Held,
            (Err(_), _) => PoseState::Lost,
        };
        let pose = (state != PoseState::Lost).then(|| *self.tracker.since_engage());
        HandStep { motion, pose, state }
    }
}
