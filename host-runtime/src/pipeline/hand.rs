//! The second half of the chain: what all cameras saw at one instant in, where the hand is out.

use std::time::{Duration, Instant};
use tetrad_core::config::HandConfig;
use tetrad_core::geometry::{ImagePoint, Pose};
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::{HandMode, HandReport, HandTracker};
use tetrad_core::hand::view::HandView;
use tetrad_core::observation::BALLS;

/// What is known of the hand after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandStep {
    /// Motion, pose and how well it is known.
    pub report: HandReport,
    /// The pose smoothed and carried on by the filter's lead; `None` while the hand is lost.
    pub filtered: Option<Pose>,
    /// How many times the hand was latched, counting and wrapping.
    pub engagements: u32,
    /// How long the solver took.
    pub solving: Duration,
}

/// The hand that all cameras see, and its filter.
#[derive(Clone, Debug)]
pub struct HandStage {
    mode: HandMode,
    config: HandConfig,
    tracker: HandTracker,
    /// Latches of the hands before this one.
    latched_before: u32,
    filter: PoseFilter,
}

impl HandStage {
    /// A hand with these arms that has not been seen yet.
    #[must_use]
    pub fn new(mode: HandMode, arms: Arms, config: HandConfig, filter: PoseFilter) -> Self {
        Self { mode, config, tracker: HandTracker::new(mode, arms, config), latched_before: 0, filter }
    }

    /// The same with another filter.
    #[must_use]
    pub fn with_filter(self, filter: PoseFilter) -> Self {
        Self { filter, ..self }
    }

    /// Latches the hand: from the next step on the pose is told from where the hand is now.
    pub fn engage(&mut self) {
        let engagements = self.tracker.engagements();
        self.tracker.engage();
        if self.tracker.engagements() != engagements {
            // the pose is told in other axes from here on
            self.filter.reset();
        }
    }

    /// Another hand: nothing is known of it but its arms, nor of the cameras, and its pose is told in the axes
    /// of its own first complete instant. It counts as latched, so that nobody takes it for the old one.
    pub fn set_up(&mut self, arms: Arms) {
        self.latched_before = self.engagements().wrapping_add(1);
        self.tracker = HandTracker::new(self.mode, arms, self.config);
        self.filter.reset();
    }

    /// Where the camera `view` is expected to see the four balls at `t_us`, px.
    #[must_use]
    pub fn predict(&self, view: usize, t_us: u64) -> [Option<ImagePoint>; BALLS] {
        self.tracker.predict(view, t_us)
    }

    /// Takes each camera's part of what was seen at `t_us`, microseconds of any clock that goes forward,
    /// in the same order of cameras every time.
    pub fn step(&mut self, views: &[HandView], t_us: u64) -> HandStep {
        let engagements = self.tracker.engagements();
        let started = Instant::now();
        let report = self.tracker.update(views, t_us);
        let solving = started.elapsed();
        if self.tracker.engagements() != engagements {
            // an engage that had waited for the hand
            self.filter.reset();
        }
        let filtered = filtered(&mut self.filter, &report, t_us);
        HandStep { report, filtered, engagements: self.engagements(), solving }
    }

    const fn engagements(&self) -> u32 {
        self.latched_before.wrapping_add(self.tracker.engagements())
    }
}

/// A measured pose filtered; one that is not is the filter's own to carry on.
fn filtered(filter: &mut PoseFilter, report: &HandReport, t_us: u64) -> Option<Pose> {
    if report.state == PoseState::Lost {
        filter.reset();
        return None;
    }
    let measured = report.pose.filter(|_| report.state.is_measured());
    measured.and_then(|pose| filter.measure(t_us, &pose).ok()).or_else(|| filter.coast(t_us))
}
