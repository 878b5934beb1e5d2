//! The hand in either mode: views of a frame in, pose with covariance and state out.

use crate::config::{HandConfig, MAX_VIEWS};
use crate::geometry::ImagePoint;
use crate::hand::affine::Arms;
use crate::hand::motion::MotionTracker;
use crate::hand::pose::PoseTracker;
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use crate::observation::{BALLS, Observations};

pub use crate::hand::report::HandReport;

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

/// The hand as all cameras together see it.
#[derive(Clone, Debug)]
pub struct HandTracker {
    solver: Solver,
}

#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "one a program, made once; without a heap there is no box")]
enum Solver {
    Paper(PaperTracker),
    Refined(PoseTracker),
}

/// The paper's tracker, and for how long its last pose stands.
#[derive(Clone, Debug)]
struct PaperTracker {
    motion: MotionTracker,
    /// Frames without a motion for which the last pose still stands for the hand.
    hold_frames: u32,
    /// Frames without a motion since the last; `None` before the first motion.
    missed: Option<u32>,
}

impl HandTracker {
    /// A tracker of a feature frame with these arms, which has seen nothing yet.
    #[must_use]
    pub fn new(mode: HandMode, arms: Arms, config: HandConfig) -> Self {
        let solver = match mode {
            HandMode::Paper => Solver::Paper(PaperTracker {
                motion: MotionTracker::new(arms, config),
                hold_frames: config.max_predicted_frames,
                missed: None,
            }),
            HandMode::Refined => Solver::Refined(PoseTracker::new(arms, config)),
        };
        Self { solver }
    }

    /// Latches the hand: from here on the pose is told from where the hand is now. Where it is not
    /// seen now, the latch waits for the next measured frame.
    pub fn engage(&mut self) {
        match &mut self.solver {
            Solver::Paper(paper) => paper.motion.engage(),
            Solver::Refined(refined) => refined.engage(),
        }
    }

    /// Forgets the hand and the cameras, as after the cameras were moved.
    pub fn restart(&mut self) {
        match &mut self.solver {
            Solver::Paper(paper) => {
                paper.motion.restart();
                paper.missed = None;
            }
            Solver::Refined(refined) => refined.restart(),
        }
    }

    /// How many times the hand was latched.
    #[must_use]
    pub const fn engagements(&self) -> u32 {
        match &self.solver {
            Solver::Paper(paper) => paper.motion.engagements(),
            Solver::Refined(refined) => refined.engagements(),
        }
    }

    /// Takes one frame: each camera's part, in the same order of cameras every time, taken at
    /// `t_us` microseconds of any clock that goes forward.
    pub fn update(&mut self, views: &[HandView], t_us: u64) -> HandReport {
        match &mut self.solver {
            Solver::Paper(paper) => paper.update(views),
            Solver::Refined(refined) => refined.update(views, t_us),
        }
    }

    /// Where the camera `view` is expected to see the four balls at `t_us`, px; `None` where nothing
    /// is expected (section 3.5).
    #[must_use]
    pub fn predict(&self, view: usize, t_us: u64) -> [Option<ImagePoint>; BALLS] {
        match &self.solver {
            Solver::Paper(paper) => paper.motion.predict(view),
            Solver::Refined(refined) => refined.predict(view, t_us),
        }
    }
}

impl PaperTracker {
    fn update(&mut self, views: &[HandView]) -> HandReport {
        let mut seen = heapless::Vec::<Observations, MAX_VIEWS>::new();
        for view in views {
            // views beyond the most there may be are left out
            let _ = seen.push(view.balls);
        }
        let motion = self.motion.update(&seen);
        self.missed = match &motion {
            Ok(_) => Some(0),
            Err(_) => self.missed.map(|n| n.saturating_add(1)),
        };
        let state = match (&motion, self.missed) {
            (Ok(_), _) => PoseState::Both,
            (Err(_), Some(missed)) if missed <= self.hold_frames => PoseState::Held,
            (Err(_), _) => PoseState::Lost,
        };
        let pose = (state != PoseState::Lost).then(|| *self.motion.since_engage());
        HandReport { motion, pose, covariance: None, state }
    }
}
