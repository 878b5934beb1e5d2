//! Where each ball is in one frame: figure 4's window, larger window and global search.
//!
//! Eq. 1 is tried first with the colours of the previous frame. Where that gives nothing that looks
//! like the ball, other thresholds are tried and the find that looks most like it is taken: the
//! background may have changed, or something of nearly its colour may touch it.

use super::appearance::background_around;
use super::centre::Blob;
use super::colour::Matcher;
use super::detect::{Candidate, Expectation, Scratch, Search};
use super::frame::{FrameView, Rgb};
use super::occlusion::touch;
use super::reacquire::{Places, choose, gate, suggested};
use super::rim::Rim;
use super::search::Region;
use super::track::{Attempt, BallTrack, Mode, Tracks};
use crate::config::{MAX_CANDIDATES, TrackerConfig};
use crate::geometry::{ImagePoint, round_to_i32};
use crate::observation::BALLS;

/// One ball found in the present frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Find {
    pub(super) blob: Blob,
    pub(super) score: f32,
    pub(super) mode: Mode,
    pub(super) matcher: Matcher,
    /// Which threshold gave it, where a window did.
    pub(super) attempt: Attempt,
    /// Whether it is seen whole.
    pub(super) whole: bool,
    /// Whether another ball is so near that it may hide a part of it.
    pub(super) touching: bool,
    pub(super) centre: ImagePoint,
    /// Its rim, where the refined centre found one.
    pub(super) rim: Option<Rim>,
}

impl Find {
    pub(super) fn new(candidate: Candidate, mode: Mode) -> Self {
        let Candidate { blob, matcher, score } = candidate;
        Self {
            blob,
            score,
            mode,
            matcher,
            attempt: Attempt::AsBefore,
            whole: false,
            touching: false,
            centre: blob.centre,
            rim: None,
        }
    }
}

/// What is found of each ball.
pub(super) type Finds = [Option<Find>; BALLS];

/// Finds that look little like their balls, each with whether that has lasted.
pub(super) type Doubtful = [Option<(Find, bool)>; BALLS];

/// The places of what is found.
pub(super) fn places(finds: &Finds) -> Places {
    let mut places = [None; BALLS];
    for (place, find) in places.iter_mut().zip(finds) {
        *place = find.as_ref().map(|f| f.centre);
    }
    places
}

/// How far from a ball's centre its spiral and its ring read: so many radii ...
const FETCH_RADII: f32 = 1.3;

/// ... and so many pixels more.
const FETCH_PIXELS: f32 = 4.0;

/// So many frames in a row all thresholds are tried in the whole picture for a ball that is lost...
const WHOLE_FRAMES: u32 = 2;

/// ...and from then on a share of them each frame, in turn, beside eq. 1 as it was, which is tried in each:
/// four balls out of sight for long shall not hold up the pictures in which they come back. At 640x480 with
/// balls of 16 px all look at 5.1 million pixels a frame, in 20 ms, and a share at 1.1 million.
const SHARES: usize = 5;

/// Whether a ball that was missed for so many frames is searched in the whole picture with the threshold
/// of that number.
const fn is_due(threshold: usize, missed: u32) -> bool {
    missed < WHOLE_FRAMES || threshold == 0 || threshold % SHARES == missed as usize % SHARES
}

/// The searches of one frame.
pub(super) struct Locator<'a> {
    pub(super) frame: &'a FrameView<'a>,
    pub(super) t_us: u64,
    pub(super) config: &'a TrackerConfig,
    pub(super) tracks: &'a Tracks,
    pub(super) scratch: &'a mut Scratch,
    /// Pixels looked at.
    pub(super) tested: &'a mut u32,
}

impl<'a> Locator<'a> {
    /// The window around each prediction.
    pub(super) fn in_windows(&mut self, predicted: &Places, windows: &mut [Option<Region>; BALLS]) -> Finds {
        let mut finds = [None; BALLS];
        let tracks = self.tracks;
        for (track, at) in tracks.iter().zip(predicted) {
            if let (Some(track), Some(at)) = (track, at) {
                self.fetch(track, *at);
            }
        }
        let slots = finds.iter_mut().zip(windows).zip(tracks).zip(predicted).enumerate();
        for (k, (((find, window), track), predicted)) in slots {
            let (Some(track), Some(at)) = (track, predicted) else { continue };
            *window = self.window(track, *at, self.config.search.window_diameters);
            if let Some(region) = *window {
                *find = self.search_region(k, track, (*at, region), Mode::Tracking);
            }
        }
        finds
    }

    /// The larger window, then the whole picture (or the part of it where the other balls say that a
    /// lost one must be), for every ball that is not found yet.
    pub(super) fn wider(&mut self, finds: &mut Finds, doubtful: &Doubtful) {
        let (c, tracks) = (self.config, self.tracks);
        let mut candidates: [heapless::Vec<Candidate, MAX_CANDIDATES>; BALLS] = Default::default();
        for (k, (track, list)) in tracks.iter().zip(&mut candidates).enumerate() {
            let now = places(finds);
            let (Some(track), Some(slot @ None)) = (track, finds.get_mut(k)) else { continue };
            let suggestion = if c.rigid { suggested(track, &now).map(|(p, _)| p) } else { None };
            if let Some(at) = suggestion.or_else(|| track.predict(self.t_us)) {
                if self.is_behind_another(k, track, at, &now) {
                    continue;
                }
                if let Some(region) = self.window(track, at, c.search.widened_diameters) {
                    *slot = self
                        .search_region(k, track, (at, region), Mode::Widened)
                        .filter(|find| find.score >= c.shape.doubtful_score);
                }
            }
            let kept_for_now = doubtful.get(k).is_some_and(|d| matches!(d, Some((_, false))));
            if slot.is_none() && !kept_for_now {
                self.search_globally(k, track, &now, list);
            }
        }
        if candidates.iter().all(|list| list.is_empty()) {
            return;
        }
        let chosen = choose(tracks, &candidates, &places(finds), c.rigid);
        for (find, chosen) in finds.iter_mut().zip(chosen) {
            *find = find.or(chosen.map(|candidate| Find::new(candidate, Mode::Global)));
        }
    }

    /// Asks for the memory under a ball before the search needs it.
    fn fetch(&self, track: &BallTrack, at: ImagePoint) {
        let reach = |extent: f32| extent * 0.5 * FETCH_RADII + FETCH_PIXELS;
        let (a, b) = (reach(track.clean.diameter), reach(track.clean.height));
        let span = |centre: f32, reach: f32| (round_to_i32(centre - reach), round_to_i32(centre + reach));
        self.frame.fetch(span(at.u, a), span(at.v, b));
    }

    fn window(&self, track: &BallTrack, at: ImagePoint, diameters: f32) -> Option<Region> {
        let side = track.clean.diameter.max(track.clean.height) * diameters;
        Region::square(at.u, at.v, side, self.frame.width(), self.frame.height())
    }

    fn search_region(
        &mut self,
        k: usize,
        track: &BallTrack,
        (at, region): (ImagePoint, Region),
        mode: Mode,
    ) -> Option<Find> {
        let c = self.config;
        let aspect = track.appearance.learnt().aspect;
        let expected =
            Expectation::nearby(&track.clean, aspect, c.occlusion.hidden_share, &c.search, &c.shape);
        let mut best: Option<Find> = None;
        for attempt in self.attempts(track) {
            let Some(matcher) = self.matcher_for(attempt, track, at) else { continue };
            let search = self.search(k, track, &matcher, expected);
            let (found, left) = search.in_window(region, self.scratch, self.tested);
            if let Some(candidate) = found
                && best.is_none_or(|b| candidate.score > b.score)
            {
                best = Some(Find { attempt, ..Find::new(candidate, mode) });
            }
            let good =
                best.is_some_and(|b| b.score >= c.shape.good_score || track.is_as_good(b.attempt, b.score));
            if good || !left {
                break;
            }
        }
        best
    }

    /// Eq. 1 as it was, then what gave the best find in the previous frame, then all the others.
    fn attempts(&self, track: &BallTrack) -> impl Iterator<Item = Attempt> + use<> {
        let usual = track.usual_attempt();
        let retries = self.config.colour.retries.map(Attempt::Near);
        let others = core::iter::once(Attempt::BackgroundHere).chain(retries);
        let second = (usual != Attempt::AsBefore).then_some(usual);
        core::iter::once(Attempt::AsBefore).chain(second).chain(others.filter(move |other| *other != usual))
    }

    fn matcher_for(&mut self, attempt: Attempt, track: &BallTrack, at: ImagePoint) -> Option<Matcher> {
        let c = &self.config.colour;
        match attempt {
            Attempt::AsBefore => Some(track.appearance.matcher(c.alpha_256)),
            Attempt::BackgroundHere => {
                let matcher = track.appearance.matcher(c.alpha_256);
                let size = (track.clean.diameter, track.clean.height);
                let ceiling = track.appearance.ceiling();
                let rank = c.background_rank;
                let background =
                    background_around(self.frame, at, size, &matcher, ceiling, rank, self.tested)?;
                track.appearance.matcher_against(background, c.alpha_256)
            }
            Attempt::Near(retry) => Some(track.appearance.matcher_near(retry)),
        }
    }

    fn search_globally(
        &mut self,
        k: usize,
        track: &BallTrack,
        now: &Places,
        list: &mut heapless::Vec<Candidate, MAX_CANDIDATES>,
    ) {
        let c = self.config;
        let (width, height) = (self.frame.width(), self.frame.height());
        let absent_us = track.absent_us(self.t_us).unwrap_or(0);
        let confined = if c.rigid { gate(track, now, absent_us, width, height, &c.validation) } else { None };
        let region = confined.unwrap_or_else(|| Region::whole(width, height));
        let aspect = track.appearance.learnt().aspect;
        let expected = Expectation::anywhere(&track.clean, aspect, &c.search, &c.shape);
        let missed = track.missed();
        for (threshold, matcher) in self.global_matchers(track).enumerate() {
            if confined.is_none() && !is_due(threshold, missed) {
                continue;
            }
            let search = self.search(k, track, &matcher, expected);
            search.candidates(region, list, self.scratch, self.tested);
        }
    }

    fn search<'b>(
        &self,
        k: usize,
        track: &BallTrack,
        matcher: &'b Matcher,
        expected: Expectation,
    ) -> Search<'b>
    where
        'a: 'b,
    {
        Search {
            frame: self.frame,
            matcher,
            expected,
            own: track.appearance.current().typical,
            rivals: self.rivals(k),
            search: &self.config.search,
            shape: &self.config.shape,
        }
    }

    /// The typical colours of the other balls: what looks more like one of them is not this one.
    fn rivals(&self, k: usize) -> heapless::Vec<Rgb, BALLS> {
        let mut rivals = heapless::Vec::new();
        let others = self.tracks.iter().enumerate().filter(|(l, _)| *l != k);
        for track in others.filter_map(|(_, track)| track.as_ref()) {
            // There are as many places as balls. (Collecting into a heapless vector has a panic path.)
            let _ = rivals.push(track.appearance.current().typical);
        }
        rivals
    }

    /// Eq. 1 as it is now, then nearer and nearer to the typical pixel; the same with the colours that
    /// were taught, since the light may have changed back.
    fn global_matchers(&self, track: &BallTrack) -> impl Iterator<Item = Matcher> + use<> {
        let c = self.config.colour;
        let appearance = track.appearance;
        let retries = c.retries.into_iter().chain(c.global_retries);
        let now = core::iter::once(appearance.matcher(c.alpha_256))
            .chain(retries.clone().map(move |retry| appearance.matcher_near(retry)));
        let taught = core::iter::once(appearance.learnt_matcher(c.alpha_256))
            .chain(retries.map(move |retry| appearance.learnt_matcher_near(retry)));
        now.chain(taught)
    }

    /// Whether a ball expected `at` would stand behind another one that is seen: then its absence is
    /// explained and nothing else of its colour is mistaken for it.
    fn is_behind_another(&self, k: usize, track: &BallTrack, at: ImagePoint, now: &Places) -> bool {
        let known = track.last_centre().is_some();
        known
            && now.iter().zip(self.tracks).enumerate().any(|(l, (place, other))| {
                l != k
                    && place.zip(other.as_ref()).is_some_and(|(place, other)| {
                        touch(at, &track.clean, place, &other.clean, &self.config.occlusion)
                    })
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{GLOBAL_RETRIES, RETRIES};

    #[test]
    fn every_threshold_has_its_turn() {
        let thresholds = 2 * (1 + RETRIES + GLOBAL_RETRIES);
        assert!((0..WHOLE_FRAMES).all(|missed| (0..thresholds).all(|number| is_due(number, missed))));
        for began in WHOLE_FRAMES..40 {
            let turns = began..began + SHARES as u32;
            assert!((0..thresholds).all(|number| turns.clone().any(|missed| is_due(number, missed))));
            let due = (0..thresholds).filter(|number| is_due(*number, began)).count();
            assert!(is_due(0, began) && due <= 1 + thresholds.div_ceil(SHARES), "{due}");
        }
    }
}
