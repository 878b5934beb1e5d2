//! Figure 4: one camera's frame in, four observations out.
//!
//! ```text
//! predict -> window (3 d) -> larger window -> global search -> hidden balls (eq. 3)
//!         -> shape and geometry (3.5) -> reference colours -> observations
//! ```
//! A ball that is found skips the searches after its own. Every path ends in an observation whose
//! state says how the place is known; a place that was not measured is never called visible.

mod judge;
mod refine;
mod report;

use super::appearance::{LearntBall, LearntBallError, background_around};
use super::centre::Clean;
use super::detect::Scratch;
use super::frame::FrameView;
use super::locate::{Finds, Locator};
use super::reacquire::Places;
use super::search::Region;
pub use super::track::Mode;
use super::track::{BallTrack, Tracks};
use crate::config::{ConfigError, TrackerConfig};
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, Ball, Observations};
use core::fmt;

/// Where each ball is expected, if anybody knows better than the linear prediction.
pub type Prediction = [Option<ImagePoint>; BALLS];

/// Why a tracker cannot be made or a ball not be taught.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TrackerError {
    /// A setting cannot be worked with.
    Config(ConfigError),
    /// A ball cannot be tracked as it was taught.
    Ball(Ball, LearntBallError),
}

impl fmt::Display for TrackerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(e) => e.fmt(f),
            Self::Ball(ball, e) => write!(f, "{}: {e}", ball.name()),
        }
    }
}

impl core::error::Error for TrackerError {}

/// What one step saw and what it took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// The balls, ordered as [`Ball::ALL`]; one that is not tracked is `Lost`.
    pub observations: Observations,
    /// Which search found each.
    pub modes: [Mode; BALLS],
    /// How much each find looks like its ball, 0 to 1.
    pub scores: [f32; BALLS],
    /// Pixels looked at, all balls together.
    pub tested: u32,
    /// d(measured, predicted) of section 3.5; `None` where fewer than two balls could be compared.
    pub mismatch: Option<f32>,
    /// Whether every rule held, so that the reference colours may follow.
    pub validated: bool,
    /// Where each ball was looked for first.
    pub windows: [Option<Region>; BALLS],
}

/// Tracks up to four balls in one camera's frames. No heap; well under 4 KiB.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraTracker {
    config: TrackerConfig,
    tracks: Tracks,
}

impl CameraTracker {
    /// A tracker of the balls given; the others stay in [`Mode::Learning`].
    ///
    /// # Errors
    /// [`TrackerError`] names the setting or the ball that cannot be worked with.
    pub fn new(config: TrackerConfig, balls: [Option<LearntBall>; BALLS]) -> Result<Self, TrackerError> {
        config.check().map_err(TrackerError::Config)?;
        let mut tracker = Self { config, tracks: [None; BALLS] };
        for (ball, learnt) in Ball::ALL.into_iter().zip(balls) {
            if let Some(learnt) = learnt {
                tracker.teach(ball, learnt)?;
            }
        }
        Ok(tracker)
    }

    /// Teaches one ball, or teaches it anew. It is searched for everywhere in the next frame, unless
    /// [`CameraTracker::place`] says where it is.
    ///
    /// # Errors
    /// [`TrackerError::Ball`] when it cannot be tracked so; a former teaching stays.
    pub fn teach(&mut self, ball: Ball, learnt: LearntBall) -> Result<(), TrackerError> {
        let track = BallTrack::new(learnt).map_err(|e| TrackerError::Ball(ball, e))?;
        if let Some(slot) = self.tracks.get_mut(ball.index()) {
            *slot = Some(track);
        }
        Ok(())
    }

    /// Says where a ball is in the next frame. Without effect on a ball that was not taught, or when
    /// the place is not a number.
    pub fn place(&mut self, ball: Ball, centre: ImagePoint) {
        if let Some(Some(track)) = self.tracks.get_mut(ball.index())
            && centre.is_finite()
        {
            track.place(centre);
        }
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &TrackerConfig {
        &self.config
    }

    /// Today's colours of a ball; `None` if it was not taught.
    #[must_use]
    pub fn reference(&self, ball: Ball) -> Option<super::colour::Reference> {
        self.tracks.get(ball.index())?.as_ref().map(|t| *t.appearance.current())
    }

    /// One frame, captured at `t_us` microseconds of any clock that goes forward.
    pub fn step(&mut self, frame: &FrameView<'_>, t_us: u64, prediction: &Prediction) -> StepReport {
        let mut report = StepReport::default();
        let predicted = self.predict(t_us, prediction);
        let mut finds = [None; BALLS];
        self.find(frame, t_us, &predicted, &mut finds, &mut report);
        self.drop_stray(&mut finds);
        self.judge_whole(&mut finds);
        self.drop_lone_part(&mut finds);
        self.place_hidden(frame, &mut finds, &mut report.tested);
        self.refine(frame, t_us, &mut finds, &mut report.tested);
        self.drop_unproven(&mut finds);
        self.validate(&finds, &predicted, &mut report);
        self.follow_colours(frame, &finds, &mut report);
        self.remember(t_us, &finds, &predicted, &mut report);
        report
    }

    /// The searches. Never a part of its caller: what they work in is given back before rims are sought,
    /// which take as much stack.
    #[inline(never)]
    fn find(
        &mut self,
        frame: &FrameView<'_>,
        t_us: u64,
        predicted: &Places,
        finds: &mut Finds,
        report: &mut StepReport,
    ) {
        let mut scratch = Scratch::ZERO;
        scratch.clear();
        self.locator(frame, t_us, &mut scratch, &mut report.tested).in_windows(
            predicted,
            finds,
            &mut report.windows,
        );
        let mut doubts = self.doubts(t_us, predicted, finds);
        self.locator(frame, t_us, &mut scratch, &mut report.tested).wider(finds, &mut doubts);
        for (find, doubt) in finds.iter_mut().zip(doubts) {
            if doubt.is_some_and(|doubt| !doubt.near) {
                *find = None;
            }
        }
    }

    fn locator<'a>(
        &'a self,
        frame: &'a FrameView<'a>,
        t_us: u64,
        scratch: &'a mut Scratch,
        tested: &'a mut u32,
    ) -> Locator<'a> {
        Locator { frame, t_us, config: &self.config, tracks: &self.tracks, scratch, tested }
    }

    fn predict(&self, t_us: u64, prediction: &Prediction) -> Places {
        let mut predicted = [None; BALLS];
        for ((slot, track), given) in predicted.iter_mut().zip(&self.tracks).zip(prediction) {
            *slot = track.as_ref().and_then(|t| given.filter(|p| p.is_finite()).or_else(|| t.predict(t_us)));
        }
        predicted
    }

    #[inline(never)]
    fn follow_colours(&mut self, frame: &FrameView<'_>, finds: &Finds, report: &mut StepReport) {
        let c = &self.config;
        for (find, track) in finds.iter().zip(&mut self.tracks) {
            let Some(track) = track else { continue };
            if let Some(find) = find
                && find.score >= c.shape.doubtful_score
            {
                let size = (track.clean.diameter, track.clean.height);
                let ceiling = track.appearance.ceiling();
                let rank = c.colour.background_rank;
                let tested = &mut report.tested;
                let background =
                    background_around(frame, find.centre, size, &find.matcher, ceiling, rank, tested);
                let typical = (find.score >= c.shape.whole_score).then_some(find.blob.colour);
                track.appearance.follow(typical, background, c.validation.max_drift);
                // Beside another ball the size stays that of the last pass without occlusion (3.4).
                if find.whole && !find.touching {
                    track.clean = Clean::of(&find.blob);
                } else if find.score >= c.shape.whole_score && !find.blob.cut && !find.touching {
                    track.clean = track.clean.towards(&Clean::of(&find.blob), c.shape.size_follow);
                }
            }
            if report.validated {
                track.appearance.confirm(&c.validation);
            } else {
                track.appearance.doubt();
            }
        }
    }
}

#[cfg(test)]
mod tests;
