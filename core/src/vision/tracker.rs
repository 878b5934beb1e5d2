//! Figure 4: one camera's frame in, four observations out.
//!
//! ```text
//! predict -> window (3 d) -> larger window -> global search -> hidden balls (eq. 3)
//!         -> shape and geometry (3.5) -> reference colours -> observations
//! ```
//! A ball that is found skips the searches after its own. Every path ends in an observation whose
//! state says how the place is known; a place that was not measured is never called visible.

use super::appearance::{LearntBall, LearntBallError, background_around};
use super::centre::Clean;
use super::detect::Scratch;
use super::frame::FrameView;
use super::locate::{Doubtful, Find, Finds, Locator, places};
use super::occlusion::{Seen, centre_behind, centre_beyond_the_edge, is_hidden_by, touch};
use super::reacquire::{Places, stray, suggested};
use super::rim::{RimMemory, Sought, aspect_of_pixels, find_rim};
use super::search::Region;
pub use super::track::Mode;
use super::track::{BallTrack, Tracks};
use super::validation::{geometric_mismatch, is_whole, shape_holds};
use crate::config::{CentreMode, ConfigError, TrackerConfig};
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, Ball, ImageCovariance, Observation, ObservationState, Observations};
use core::fmt;

/// The standard deviation of a row-edge centre along each axis, px: section 5 reports a mean error
/// of 0.1 px in even light. The measure itself says nothing about the light.
const PAPER_SIGMA_PX: f32 = 0.1;

/// That of a whole ball whose rim was refused, in diameters: the row edges of a ball lit from one side
/// are off by a tenth.
const UNREFINED_SIGMA: f32 = 0.1;

/// That of a ball seen in part whose rim was refused.
const UNREFINED_PART_SIGMA: f32 = 0.25;

/// That of a predicted place, in diameters.
const PREDICTED_SIGMA: f32 = 0.5;

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
        let mut scratch = Scratch::new();
        let predicted = self.predict(t_us, prediction);
        let mut finds = self
            .locator(frame, t_us, &mut scratch, &mut report.tested)
            .in_windows(&predicted, &mut report.windows);
        let doubtful = self.set_doubtful_aside(t_us, &predicted, &mut finds);
        self.locator(frame, t_us, &mut scratch, &mut report.tested).wider(&mut finds, &doubtful);
        for (find, doubtful) in finds.iter_mut().zip(doubtful) {
            *find = find.or(doubtful.map(|(find, _)| find));
        }
        self.drop_stray(&mut finds);
        self.judge_whole(&mut finds);
        self.drop_lone_part(&mut finds);
        self.place_hidden(frame, &mut finds, &mut report.tested);
        self.refine(frame, t_us, &mut finds, &mut report.tested);
        self.validate(&finds, &predicted, &mut report);
        self.follow_colours(frame, &finds, &mut report);
        self.remember(t_us, &finds, &predicted, &mut report);
        report
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

    /// Finds that look little like their balls: the larger window is searched for better ones, and
    /// the whole picture too when that has lasted (the flag); where there is none they are kept if
    /// they may be the rest of a ball that stands where it is expected, and else dropped.
    fn set_doubtful_aside(&mut self, t_us: u64, predicted: &Places, finds: &mut Finds) -> Doubtful {
        let shape = &self.config.shape;
        let mut aside = [None; BALLS];
        let slots = finds.iter_mut().zip(&mut aside).zip(&mut self.tracks).zip(predicted);
        for (((find, aside), track), expected) in slots {
            let (Some(found), Some(track)) = (&find, track) else { continue };
            let doubtful = found.score < shape.doubtful_score && !found.blob.cut;
            let lasting = track.doubt(doubtful, t_us, shape.doubt_us);
            if doubtful {
                let reach = shape.doubtful_reach * track.clean.diameter.max(track.clean.height);
                let near = expected.is_some_and(|expected| found.centre.distance(expected) <= reach);
                *aside = find.take().filter(|_| near).map(|find| (find, lasting));
            }
        }
        aside
    }

    /// While nothing else of a rigid frame is seen, a thing that is not a whole ball is no ball.
    fn drop_lone_part(&self, finds: &mut Finds) {
        let taught = self.tracks.iter().flatten().count();
        let mut found = finds.iter_mut().filter(|find| find.is_some());
        if let (Some(lone), None) = (found.next(), found.next())
            && self.config.rigid
            && taught > 1
            && lone.as_ref().is_some_and(|find| !find.whole)
        {
            *lone = None;
        }
    }

    /// A thing of a ball's colour far from the hand: neither found nor remembered.
    fn drop_stray(&mut self, finds: &mut Finds) {
        if !self.config.rigid {
            return;
        }
        let mut diameters = [0.0; BALLS];
        for (diameter, track) in diameters.iter_mut().zip(&self.tracks) {
            *diameter = track.as_ref().map_or(0.0, |t| t.clean.diameter);
        }
        if let Some(k) = stray(&places(finds), &diameters)
            && let (Some(find), Some(Some(track))) = (finds.get_mut(k), self.tracks.get_mut(k))
        {
            *find = None;
            track.forget();
        }
    }

    fn judge_whole(&mut self, finds: &mut Finds) {
        let c = self.config;
        for (find, track) in finds.iter_mut().zip(&mut self.tracks) {
            if let (Some(find), Some(track)) = (find, track) {
                let aspect = track.appearance.learnt().aspect;
                find.whole = is_whole(&find.blob, &track.clean, aspect, &c.shape, &c.occlusion);
                let round = !find.blob.cut && shape_holds(&find.blob, aspect, &c.shape);
                // A ball that stays round has come nearer or gone away; it is not hidden.
                find.whole |= track.looks_round(round);
                find.whole &= find.score >= c.shape.whole_score;
            }
        }
    }

    /// Section 3.4: of two balls that touch, the one that lost more of its area is behind the other.
    fn place_hidden(&self, frame: &FrameView<'_>, finds: &mut Finds, tested: &mut u32) {
        let c = &self.config.occlusion;
        let before = *finds;
        let seen = |find: &Option<Find>, track: &Option<BallTrack>| {
            find.as_ref().zip(track.as_ref()).map(|(f, t)| Seen {
                centre: f.blob.centre,
                area_share: f.blob.area / t.clean.area.max(1.0),
                clean: t.clean,
            })
        };
        for (k, (find, track)) in finds.iter_mut().zip(&self.tracks).enumerate() {
            let Some(x) = seen(find, track) else { continue };
            let Some(find) = find else { continue };
            let mut front: Option<Seen> = None;
            for (l, (other, other_track)) in before.iter().zip(&self.tracks).enumerate() {
                let Some(y) = seen(other, other_track) else { continue };
                if l == k || !touch(x.centre, &x.clean, y.centre, &y.clean, c) {
                    continue;
                }
                find.touching = true;
                if is_hidden_by(&x, &y, c)
                    && front.is_none_or(|f| x.centre.distance(y.centre) < x.centre.distance(f.centre))
                {
                    front = Some(y);
                }
            }
            if let Some(y) = front {
                find.whole = false;
                find.centre =
                    centre_behind(frame, &find.matcher, &find.blob, &x.clean, y.centre, &y.clean, tested);
            } else if find.blob.cut {
                find.centre = centre_beyond_the_edge(frame, &find.blob, &x.clean);
            }
        }
    }

    /// Where a ball's rim is found, its centre takes the place of the row edges' (and of eq. 3).
    fn refine(&mut self, frame: &FrameView<'_>, t_us: u64, finds: &mut Finds, tested: &mut u32) {
        let c = &self.config.centre;
        if c.mode == CentreMode::RowEdge {
            return;
        }
        for (find, track) in finds.iter_mut().zip(&mut self.tracks) {
            let (Some(find), Some(track)) = (find, track) else { continue };
            let learnt = track.appearance.learnt();
            let memory = track.rim.zip(track.absent_us(t_us)).map(|(rim, elapsed)| rim.later(elapsed));
            let sought = Sought {
                blob: &find.blob,
                matcher: &find.matcher,
                memory: memory.as_ref(),
                diameter: track.clean.diameter,
                aspect: aspect_of_pixels(learnt.aspect, learnt.diameter),
                speed: track.moved(t_us, find.blob.centre),
            };
            if let Ok(rim) = find_rim(frame, &sought, c, tested) {
                find.centre = rim.centre;
                find.rim = Some(rim);
                track.rim = Some(RimMemory::after(memory.as_ref(), &rim, &find.blob, c));
            }
        }
    }

    /// Section 3.5. Colours are confirmed only when all tracked balls are whole and, for a rigid
    /// frame, stand to each other as predicted.
    fn validate(&mut self, finds: &Finds, predicted: &Places, report: &mut StepReport) {
        report.mismatch = geometric_mismatch(&places(finds), predicted);
        let all_whole = finds.iter().zip(&self.tracks).all(|(find, track)| {
            track.is_none() || find.as_ref().is_some_and(|f| f.whole && f.mode == Mode::Tracking)
        });
        let stand_right =
            !self.config.rigid || report.mismatch.is_none_or(|m| m <= self.config.validation.max_mismatch);
        report.validated = all_whole && stand_right && self.tracks.iter().any(Option::is_some);
    }

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

    fn remember(&mut self, t_us: u64, finds: &Finds, predicted: &Places, report: &mut StepReport) {
        let places = places(finds);
        let predict_us = self.config.occlusion.predict_us;
        let rigid = self.config.rigid;
        let refined = self.config.centre.mode == CentreMode::Refined;
        let outputs = report.observations.iter_mut().zip(&mut report.modes).zip(&mut report.scores);
        for (k, ((((observation, mode), score), track), find)) in
            outputs.zip(&mut self.tracks).zip(finds).enumerate()
        {
            let Some(track) = track else { continue };
            if let Some(find) = find {
                let moves = find.mode != Mode::Global && find.score >= self.config.shape.doubtful_score;
                if let (Some(rim), true) = (&find.rim, moves) {
                    let variance = (rim.covariance.uu + rim.covariance.vv) * 0.5;
                    let expected = predicted.get(k).copied().flatten();
                    let carried = suggested(track, &places).map(|(place, _)| place);
                    track.judge_prediction(t_us, find.centre, variance, (expected, carried));
                }
                track.measured(t_us, find.centre, moves);
                track.settle(find.attempt, find.score);
                track.companions = places;
                if let Some(own) = track.companions.get_mut(k) {
                    *own = None;
                }
                *mode = find.mode;
                *score = find.score;
                let seen = (find.blob.area / track.clean.area.max(1.0)).min(1.0);
                let (covariance, visible) = match (find.rim, refined) {
                    (Some(rim), _) => (rim.covariance, rim.visible),
                    (None, true) => (unrefined(find, track.diameter()), seen),
                    (None, false) => (ImageCovariance::isotropic(PAPER_SIGMA_PX), seen),
                };
                *observation = Observation {
                    state: if find.whole { ObservationState::Visible } else { ObservationState::Occluded },
                    centre: find.centre,
                    diameter: track.diameter(),
                    covariance,
                    visible,
                };
                continue;
            }
            track.missing();
            *mode = Mode::Lost;
            let carried = if rigid { suggested(track, &places).map(|(p, _)| p) } else { None };
            let place = carried.or_else(|| predicted.get(k).copied().flatten());
            match (place, track.absent_us(t_us)) {
                (Some(centre), Some(absent)) if absent <= predict_us => {
                    *observation = Observation {
                        state: ObservationState::Predicted,
                        centre,
                        diameter: track.diameter(),
                        covariance: ImageCovariance::isotropic(match (refined, carried) {
                            (true, Some(_)) => track.forecast.carried_sigma(track.diameter(), absent),
                            (true, None) => track.forecast.sigma(track.diameter(), absent),
                            (false, _) => PREDICTED_SIGMA * track.clean.diameter,
                        }),
                        visible: 0.0,
                    };
                }
                (_, Some(_)) if !rigid => track.forget(),
                _ => {}
            }
        }
    }
}

/// How well a row-edge centre is known where the rim was refused.
fn unrefined(find: &Find, diameter: f32) -> ImageCovariance {
    let share = if find.whole { UNREFINED_SIGMA } else { UNREFINED_PART_SIGMA };
    ImageCovariance::isotropic(PAPER_SIGMA_PX + share * diameter)
}

#[cfg(test)]
mod tests;
