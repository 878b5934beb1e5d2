//! Figure 4: one camera's frame in, four observations out.
//!
//! ```text
//! predict -> window (3 d) -> larger window -> global search -> hidden balls (eq. 3)
//!         -> shape and geometry (3.5) -> reference colours -> observations
//! ```
//! A ball that is found skips the searches after its own. Every path ends in an observation whose
//! state says how the place is known; a place that was not measured is never called visible.

use super::appearance::{LearntBall, LearntBallError, background_around};
use super::centre::{Blob, Clean};
use super::colour::Matcher;
use super::detect::{Candidate, Expectation, Scratch, Search};
use super::frame::FrameView;
use super::occlusion::{Seen, centre_behind, centre_beyond_the_edge, is_hidden_by, touch};
use super::reacquire::{Places, choose, gate, suggested};
use super::search::Region;
use super::track::BallTrack;
pub use super::track::Mode;
use super::validation::{geometric_mismatch, is_whole, shape_holds};
use crate::config::{ConfigError, TrackerConfig};
use crate::geometry::ImagePoint;
use crate::observation::{BALLS, Ball, Observation, ObservationState, Observations};
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

/// One ball found in the present frame.
#[derive(Clone, Copy, Debug)]
struct Find {
    blob: Blob,
    score: f32,
    mode: Mode,
    matcher: Matcher,
    whole: bool,
    /// Whether another ball hides a part of it.
    behind: bool,
    centre: ImagePoint,
}

/// The thresholds of eq. 1 that are tried in turn while a window gives no ball worth the name.
#[derive(Clone, Copy, Debug)]
enum Attempt {
    /// With the background of the previous frame.
    AsBefore,
    /// With the background around the place where the ball is expected now: it may have moved from
    /// in front of one thing to in front of another.
    BackgroundHere,
    /// Near the typical pixel, whatever the background, by the margin of that number: something
    /// like the ball touches it.
    Within(usize),
}

impl Attempt {
    const ALL: [Self; 6] = [
        Self::AsBefore,
        Self::BackgroundHere,
        Self::Within(0),
        Self::Within(1),
        Self::Within(2),
        Self::Within(3),
    ];
}

/// Tracks up to four balls in one camera's frames. No heap; well under 4 KiB.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraTracker {
    config: TrackerConfig,
    tracks: [Option<BallTrack>; BALLS],
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
        let mut finds = self.search_windows(frame, &predicted, &mut scratch, &mut report);
        let doubtful = self.set_doubtful_aside(t_us, &mut finds);
        self.search_wider(frame, t_us, &mut finds, &doubtful, &mut scratch, &mut report);
        for (find, doubtful) in finds.iter_mut().zip(doubtful) {
            *find = find.or(doubtful.map(|(find, _)| find));
        }
        self.judge_whole(&mut finds);
        self.place_hidden(frame, &mut finds, &mut report.tested);
        self.validate(&finds, &predicted, &mut report);
        self.follow_colours(frame, &finds, &mut report);
        self.remember(t_us, &finds, &predicted, &mut report);
        report
    }

    fn predict(&self, t_us: u64, prediction: &Prediction) -> Places {
        let mut predicted = [None; BALLS];
        for ((slot, track), given) in predicted.iter_mut().zip(&self.tracks).zip(prediction) {
            *slot = track.as_ref().and_then(|t| given.filter(|p| p.is_finite()).or_else(|| t.predict(t_us)));
        }
        predicted
    }

    /// The window around the prediction; where its colour runs into something larger, once more with
    /// a stricter threshold.
    fn search_windows(
        &self,
        frame: &FrameView<'_>,
        predicted: &Places,
        scratch: &mut Scratch,
        report: &mut StepReport,
    ) -> [Option<Find>; BALLS] {
        let mut finds = [None; BALLS];
        let slots = finds.iter_mut().zip(&mut report.windows).zip(&self.tracks).zip(predicted);
        for (((find, window), track), predicted) in slots {
            let (Some(track), Some(at)) = (track, predicted) else { continue };
            *window = self.window(frame, track, *at, self.config.search.window_diameters);
            if let Some(region) = *window {
                *find = self.search_region(
                    frame,
                    track,
                    (*at, region),
                    Mode::Tracking,
                    scratch,
                    &mut report.tested,
                );
            }
        }
        finds
    }

    fn window(
        &self,
        frame: &FrameView<'_>,
        track: &BallTrack,
        at: ImagePoint,
        diameters: f32,
    ) -> Option<Region> {
        let side = track.clean.diameter.max(track.clean.height) * diameters;
        Region::square(at.u, at.v, side, frame.width(), frame.height())
    }

    fn search_region(
        &self,
        frame: &FrameView<'_>,
        track: &BallTrack,
        (at, region): (ImagePoint, Region),
        mode: Mode,
        scratch: &mut Scratch,
        tested: &mut u32,
    ) -> Option<Find> {
        let c = &self.config;
        let expected = Expectation::nearby(
            &track.clean,
            track.appearance.learnt().aspect,
            c.occlusion.hidden_share,
            &c.search,
            &c.shape,
        );
        let mut best: Option<Find> = None;
        for attempt in Attempt::ALL {
            let Some(matcher) = self.matcher_for(attempt, frame, track, at, tested) else { continue };
            let search = Search { frame, matcher: &matcher, expected, search: &c.search, shape: &c.shape };
            let (found, left) = search.in_window(region, scratch, tested);
            if let Some(Candidate { blob, score, .. }) = found
                && best.is_none_or(|b| score > b.score)
            {
                best = Some(Find {
                    blob,
                    score,
                    mode,
                    matcher,
                    whole: false,
                    behind: false,
                    centre: blob.centre,
                });
            }
            let good = best.is_some_and(|b| b.score >= c.shape.good_score);
            if good || !left {
                break;
            }
        }
        best
    }

    fn matcher_for(
        &self,
        attempt: Attempt,
        frame: &FrameView<'_>,
        track: &BallTrack,
        at: ImagePoint,
        tested: &mut u32,
    ) -> Option<Matcher> {
        let c = &self.config.colour;
        match attempt {
            Attempt::AsBefore => Some(track.appearance.matcher(c.alpha_256)),
            Attempt::BackgroundHere => {
                let matcher = track.appearance.matcher(c.alpha_256);
                let size = (track.clean.diameter, track.clean.height);
                let ceiling = track.appearance.ceiling();
                let background =
                    background_around(frame, at, size, &matcher, ceiling, c.background_rank, tested)?;
                track.appearance.matcher_against(background, c.alpha_256)
            }
            Attempt::Within(step) => c.strict_margins.get(step).map(|m| track.appearance.matcher_within(*m)),
        }
    }

    /// Finds that look little like their balls: the larger window is searched for better ones, and
    /// the whole picture too when that has lasted (the flag); where there is none they are kept.
    fn set_doubtful_aside(
        &mut self,
        t_us: u64,
        finds: &mut [Option<Find>; BALLS],
    ) -> [Option<(Find, bool)>; BALLS] {
        let shape = &self.config.shape;
        let mut aside = [None; BALLS];
        for ((find, aside), track) in finds.iter_mut().zip(&mut aside).zip(&mut self.tracks) {
            let (Some(found), Some(track)) = (&find, track) else { continue };
            let doubtful = found.score < shape.doubtful_score && !found.blob.cut;
            let lasting = track.doubted_us(doubtful, t_us) > shape.doubt_us;
            if doubtful {
                *aside = find.take().map(|find| (find, lasting));
            }
        }
        aside
    }

    /// The larger window, then the whole picture (or the part of it where the other balls say that a
    /// lost one must be), for every ball that its window did not hold.
    fn search_wider(
        &self,
        frame: &FrameView<'_>,
        t_us: u64,
        finds: &mut [Option<Find>; BALLS],
        doubtful: &[Option<(Find, bool)>; BALLS],
        scratch: &mut Scratch,
        report: &mut StepReport,
    ) {
        let c = &self.config;
        let mut candidates: [heapless::Vec<Candidate, { crate::config::MAX_CANDIDATES }>; BALLS] =
            Default::default();
        for k in 0..BALLS {
            let now = self.places(finds);
            let (Some(Some(track)), Some(slot @ None)) = (self.tracks.get(k), finds.get_mut(k)) else {
                continue;
            };
            let suggestion = if c.rigid { suggested(track, &now).map(|(p, _)| p) } else { None };
            let expected_at = suggestion.or_else(|| track.predict(t_us));
            if let Some(at) = expected_at {
                if self.is_behind_another(track, at, &now) {
                    continue;
                }
                if let Some(region) = self.window(frame, track, at, c.search.widened_diameters) {
                    let tested = &mut report.tested;
                    *slot = self
                        .search_region(frame, track, (at, region), Mode::Widened, scratch, tested)
                        .filter(|find| find.score >= c.shape.doubtful_score);
                }
            }
            let kept_for_now = doubtful.get(k).is_some_and(|d| matches!(d, Some((_, false))));
            if slot.is_some() || kept_for_now {
                continue;
            }
            let confined = if c.rigid {
                let absent = track.absent_us(t_us).unwrap_or(0);
                gate(track, &now, absent, frame.width(), frame.height(), &c.validation)
            } else {
                None
            };
            let region = confined.unwrap_or_else(|| Region::whole(frame.width(), frame.height()));
            let aspect = track.appearance.learnt().aspect;
            let expected = Expectation::anywhere(&track.clean, aspect, &c.search, &c.shape);
            let Some(list) = candidates.get_mut(k) else { continue };
            for matcher in self.global_matchers(track) {
                let search =
                    Search { frame, matcher: &matcher, expected, search: &c.search, shape: &c.shape };
                search.candidates(region, list, scratch, &mut report.tested);
            }
        }
        if candidates.iter().all(|list| list.is_empty()) {
            return;
        }
        let chosen = choose(&self.tracks, &candidates, &self.places(finds), c.rigid);
        for (find, chosen) in finds.iter_mut().zip(chosen) {
            if let (None, Some(Candidate { blob, matcher, score })) = (&find, chosen) {
                *find = Some(Find {
                    blob,
                    score,
                    mode: Mode::Global,
                    matcher,
                    whole: false,
                    behind: false,
                    centre: blob.centre,
                });
            }
        }
    }

    /// Eq. 1 as it is now, then nearer and nearer to the typical pixel; every other frame with the
    /// colours that were taught, since the light may have changed back.
    fn global_matchers(&self, track: &BallTrack) -> impl Iterator<Item = Matcher> {
        let c = self.config.colour;
        let appearance = track.appearance;
        let taught = track.missed() % 2 == 1;
        let first =
            if taught { appearance.learnt_matcher(c.alpha_256) } else { appearance.matcher(c.alpha_256) };
        core::iter::once(first).chain(c.strict_margins.into_iter().map(move |margin| {
            if taught { appearance.learnt_matcher_within(margin) } else { appearance.matcher_within(margin) }
        }))
    }

    fn places(&self, finds: &[Option<Find>; BALLS]) -> Places {
        let mut places = [None; BALLS];
        for (place, find) in places.iter_mut().zip(finds) {
            *place = find.as_ref().map(|f| f.centre);
        }
        places
    }

    /// Whether a ball expected `at` would stand behind another one that is seen: then its absence is
    /// explained and nothing else of its colour is mistaken for it.
    fn is_behind_another(&self, track: &BallTrack, at: ImagePoint, now: &Places) -> bool {
        if track.last_centre().is_none() {
            return false;
        }
        now.iter().zip(&self.tracks).any(|(place, other)| {
            place.zip(other.as_ref()).is_some_and(|(place, other)| {
                other != track && touch(at, &track.clean, place, &other.clean, &self.config.occlusion)
            })
        })
    }

    fn judge_whole(&mut self, finds: &mut [Option<Find>; BALLS]) {
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
    fn place_hidden(&self, frame: &FrameView<'_>, finds: &mut [Option<Find>; BALLS], tested: &mut u32) {
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
                if let Some(y) = seen(other, other_track)
                    && l != k
                    && is_hidden_by(&x, &y, c)
                    && front.is_none_or(|f| x.centre.distance(y.centre) < x.centre.distance(f.centre))
                {
                    front = Some(y);
                }
            }
            if let Some(y) = front {
                find.whole = false;
                find.behind = true;
                find.centre =
                    centre_behind(frame, &find.matcher, &find.blob, &x.clean, y.centre, &y.clean, tested);
            } else if find.blob.cut {
                find.centre = centre_beyond_the_edge(frame, &find.blob, &x.clean);
            }
        }
    }

    /// Section 3.5. Colours are confirmed only when all tracked balls are whole and, for a rigid
    /// frame, stand to each other as predicted.
    fn validate(&mut self, finds: &[Option<Find>; BALLS], predicted: &Places, report: &mut StepReport) {
        report.mismatch = geometric_mismatch(&self.places(finds), predicted);
        let all_whole = finds.iter().zip(&self.tracks).all(|(find, track)| {
            track.is_none() || find.as_ref().is_some_and(|f| f.whole && f.mode == Mode::Tracking)
        });
        let stand_right =
            !self.config.rigid || report.mismatch.is_none_or(|m| m <= self.config.validation.max_mismatch);
        report.validated = all_whole && stand_right && self.tracks.iter().any(Option::is_some);
    }

    fn follow_colours(
        &mut self,
        frame: &FrameView<'_>,
        finds: &[Option<Find>; BALLS],
        report: &mut StepReport,
    ) {
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
                track.appearance.follow(typical, background);
                if find.whole {
                    track.clean = Clean::of(&find.blob);
                } else if find.score >= c.shape.whole_score && !find.blob.cut && !find.behind {
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

    fn remember(
        &mut self,
        t_us: u64,
        finds: &[Option<Find>; BALLS],
        predicted: &Places,
        report: &mut StepReport,
    ) {
        let places = self.places(finds);
        let predict_us = self.config.occlusion.predict_us;
        let rigid = self.config.rigid;
        let outputs = report.observations.iter_mut().zip(&mut report.modes).zip(&mut report.scores);
        for (k, ((((observation, mode), score), track), find)) in
            outputs.zip(&mut self.tracks).zip(finds).enumerate()
        {
            let Some(track) = track else { continue };
            if let Some(find) = find {
                let moves = find.mode != Mode::Global && find.score >= self.config.shape.doubtful_score;
                track.measured(t_us, find.centre, moves);
                track.companions = places;
                if let Some(own) = track.companions.get_mut(k) {
                    *own = None;
                }
                *mode = find.mode;
                *score = find.score;
                *observation = Observation {
                    state: if find.whole { ObservationState::Visible } else { ObservationState::Occluded },
                    centre: find.centre,
                    diameter: track.clean.diameter,
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
                        diameter: track.clean.diameter,
                    };
                }
                (_, Some(_)) if !rigid => track.forget(),
                _ => {}
            }
        }
    }
}
