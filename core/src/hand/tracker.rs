//! The hand in either mode: views of a frame in, pose with covariance and state out.

use crate::config::{HandConfig, MAX_VIEWS};
use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::Arms;
use crate::hand::motion::{Motion, MotionRefusal, MotionTracker};
use crate::hand::state::{PoseCovariance, PoseState};
use crate::hand::view::HandView;
use crate::observation::{BALLS, Observations};

/// How the pose is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HandMode {
    /// The paper's: every complete frame against the last one under weak perspective (section 4).
    Paper,
    /// Latched, with perspective terms.
    #[default]
    Refined,
}

/// What is known of the hand after a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandReport {
    /// The motion since the last measured frame, or why there is none.
    pub motion: Result<Motion, MotionRefusal>,
    /// engage_from_now (before the first engage: in the feature frame of the first complete frame);
    /// `None` before it, and when the hand has been away for too long.
    pub pose: Option<Pose>,
    /// How well the pose is known; `None` without a pose, and in `paper` mode, whose method says
    /// nothing about it.
    pub covariance: Option<PoseCovariance>,
    /// How the pose is known.
    pub state: PoseState,
}

/// The hand as all cameras together see it.
#[derive(Clone, Debug)]
pub struct HandTracker {
    paper: MotionTracker,
    /// Frames without a motion for which the last pose still stands for the hand.
    hold_frames: u32,
    /// Frames without a motion since the last; `None` before the first motion.
    missed: Option<u32>,
}

impl HandTracker {
    /// A tracker of a feature frame with these arms, which has seen nothing yet.
    #[must_use]
    pub fn new(_mode: HandMode, arms: Arms, config: HandConfig) -> Self {
        let hold_frames = config.max_predicted_frames;
        Self { paper: MotionTracker::new(arms, config), hold_frames, missed: None }
    }

    /// Latches the hand: from here on the pose is told from where the hand is now. Where it is not
    /// seen now, the latch waits for the next measured frame.
    pub fn engage(&mut self) {
        self.paper.engage();
    }

    /// Forgets the hand and the cameras, as after the cameras were moved.
    pub fn restart(&mut self) {
        self.paper.restart();
        self.missed = None;
    }

    /// How many times the hand was latched.
    #[must_use]
    pub const fn engagements(&self) -> u32 {
        self.paper.engagements()
    }

    /// Takes one frame: each camera's part, in the same order of cameras every time, taken at
    /// `t_us` microseconds of any clock that goes forward.
    pub fn update(&mut self, views: &[HandView], _t_us: u64) -> HandReport {
        let mut seen = heapless::Vec::<Observations, MAX_VIEWS>::new();
        for view in views {
            // views beyond the most there may be are left out
            let _ = seen.push(view.balls);
        }
        let motion = self.paper.update(&seen);
        self.missed = match &motion {
            Ok(_) => Some(0),
            Err(_) => self.missed.map(|n| n.saturating_add(1)),
        };
        let state = match (&motion, self.missed) {
            (Ok(_), _) => PoseState::Both,
            (Err(_), Some(missed)) if missed <= self.hold_frames => PoseState::Held,
            (Err(_), _) => PoseState::Lost,
        };
        let pose = (state != PoseState::Lost).then(|| *self.paper.since_engage());
        HandReport { motion, pose, covariance: None, state }
    }

    /// Where the camera `view` is expected to see the four balls at `t_us`, px; `None` where nothing
    /// is expected (section 3.5).
    #[must_use]
    pub fn predict(&self, view: usize, _t_us: u64) -> [Option<ImagePoint>; BALLS] {
        self.paper.predict(view)
    }
}
