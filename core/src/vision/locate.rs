//! Where each ball is in one frame: figure 4's window, larger window and global search.
//!
//! Eq. 1 is tried first with the colours of the previous frame. Where that gives nothing that looks
//! like the ball, other thresholds are tried and the find that looks most like it is taken: the
//! background may have changed, or something of nearly its colour may touch it.

use super::appearance::{Appearance, background_around};
use super::centre::Blob;
use super::colour::Matcher;
use super::detect::{Candidate, Expectation, Scratch, Search, Shortlist};
use super::frame::{FrameView, Rgb};
use super::occlusion::touch;
use super::reacquire::{Places, choose, gate, picked, suggested};
use super::rim::Rim;
use super::search::Region;
use super::track::{Attempt, BallTrack, Mode, Tracks};
use crate::config::{ColourConfig, TrackerConfig};
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
    pub(super) fn new(candidate: &Candidate, matcher: Matcher, mode: Mode) -> Self {
        let Candidate { blob, score } = *candidate;
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

/// A find that looks little like its ball: others are sought, and count before it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    /// Whether it may be the rest of a ball that stands where it is expected: then it is kept where
    /// nothing better is found, and else dropped.
    pub(super) near: bool,
    /// Whether doubt has lasted.
    pub(super) lasting: bool,
}

/// What is doubted of each ball's find.
pub(super) type Doubts = [Option<Doubt>; BALLS];

/// The places of what is found.
pub(super) fn places(finds: &Finds) -> Places {
    let mut places = [None; BALLS];
    for (place, find) in places.iter_mut().zip(finds) {
        *place = find.as_ref().map(|f| f.centre);
    }
    places
}

const fn is_certain(find: &Option<Find>, doubt: &Option<Doubt>) -> bool {
    find.is_some() && doubt.is_none()
}

/// The places of what is found and not in doubt.
fn certain_places(finds: &Finds, doubts: &Doubts) -> Places {
    let mut certain = places(finds);
    for (place, doubt) in certain.iter_mut().zip(doubts) {
        *place = place.filter(|_| doubt.is_none());
    }
    certain
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
const SHARES: u32 = 5;

/// Whether a ball that was missed for so many frames is searched in the whole picture with the threshold
/// of that number.
const fn is_due(threshold: u8, missed: u32) -> bool {
    missed < WHOLE_FRAMES || threshold == 0 || threshold as u32 % SHARES == missed % SHARES
}

/// Where a lost ball is searched.
#[derive(Clone, Copy)]
struct Scope {
    region: Region,
    /// Whether that is where the others say that it must be: then every threshold is tried.
    confined: bool,
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
    #[inline(never)]
    pub(super) fn in_windows(
        &mut self,
        predicted: &Places,
        finds: &mut Finds,
        windows: &mut [Option<Region>; BALLS],
    ) {
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
    }

    /// The larger window, then the whole picture (or the part of it where the other balls say that a
    /// lost one must be), for every ball that is not found yet. What is found is no longer in doubt.
    pub(super) fn wider(&mut self, finds: &mut Finds, doubts: &mut Doubts) {
        let all = self.tracks.iter().zip(finds.iter().zip(doubts.iter()));
        if all.filter(|(track, _)| track.is_some()).any(|(_, (find, doubt))| !is_certain(find, doubt)) {
            let scopes = self.widen(finds, doubts);
            if scopes.iter().any(Option::is_some) {
                self.search_everywhere(&scopes, finds, doubts);
            }
        }
    }

    /// The larger window; then says which balls are sought beyond it. Apart from what comes before and after
    /// it: neither needs this one's stack, nor does a frame in which the windows held every ball.
    #[inline(never)]
    fn widen(&mut self, finds: &mut Finds, doubts: &mut Doubts) -> [Option<Scope>; BALLS] {
        let c = self.config;
        let mut scopes = [None; BALLS];
        for (k, (track, scope)) in self.tracks.iter().zip(&mut scopes).enumerate() {
            let now = certain_places(finds, doubts);
            let (Some(track), Some(slot), Some(doubt)) = (track, finds.get_mut(k), doubts.get_mut(k)) else {
                continue;
            };
            if is_certain(slot, doubt) {
                continue;
            }
            let suggestion = if c.rigid { suggested(track, &now).map(|(p, _)| p) } else { None };
            if let Some(at) = suggestion.or_else(|| track.predict(self.t_us)) {
                if self.is_behind_another(k, track, at, &now) {
                    continue;
                }
                if let Some(region) = self.window(track, at, c.search.widened_diameters) {
                    let found = self.search_region(k, track, (at, region), Mode::Widened);
                    if found.as_ref().is_some_and(|find| find.score >= c.shape.doubtful_score) {
                        (*slot, *doubt) = (found, None);
                        continue;
                    }
                }
            }
            let kept_for_now = doubt.is_some_and(|doubt| doubt.near && !doubt.lasting);
            *scope = (!kept_for_now).then(|| self.scope(track, &now));
        }
        scopes
    }

    /// The whole picture, or the part of it where the others say that a lost ball must be.
    fn scope(&self, track: &BallTrack, now: &Places) -> Scope {
        let (width, height) = (self.frame.width(), self.frame.height());
        let absent_us = track.absent_us(self.t_us).unwrap_or(0);
        let validation = &self.config.validation;
        let gate =
            if self.config.rigid { gate(track, now, absent_us, width, height, validation) } else { None };
        Scope { region: gate.unwrap_or_else(|| Region::whole(width, height)), confined: gate.is_some() }
    }

    #[inline(never)]
    fn search_everywhere(&mut self, scopes: &[Option<Scope>; BALLS], finds: &mut Finds, doubts: &mut Doubts) {
        let (c, tracks) = (self.config, self.tracks);
        let mut candidates: [Shortlist; BALLS] = Default::default();
        for (k, ((track, scope), list)) in tracks.iter().zip(scopes).zip(&mut candidates).enumerate() {
            if let (Some(track), Some(scope)) = (track, scope) {
                self.search_globally(k, track, scope, list);
            }
        }
        if candidates.iter().all(|list| list.is_empty()) {
            return;
        }
        let picks = choose(tracks, &candidates, &certain_places(finds, doubts), c.rigid);
        let slots = finds.iter_mut().zip(doubts).zip(tracks);
        for (((find, doubt), track), (list, pick)) in slots.zip(candidates.iter().zip(picks)) {
            let (Some(track), Some((chosen, threshold))) = (track, picked(list, pick)) else { continue };
            if let Some(matcher) = global_matchers(&c.colour, &track.appearance).nth((*threshold).into()) {
                (*find, *doubt) = (Some(Find::new(chosen, matcher, Mode::Global)), None);
            }
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
                best = Some(Find { attempt, ..Find::new(&candidate, matcher, mode) });
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

    /// Apart from its caller, whose candidates stay while this works: what it needs itself is given back.
    #[inline(never)]
    fn search_globally(&mut self, k: usize, track: &BallTrack, scope: &Scope, list: &mut Shortlist) {
        let c = self.config;
        let aspect = track.appearance.learnt().aspect;
        let expected = Expectation::anywhere(&track.clean, aspect, &c.search, &c.shape);
        let missed = track.missed();
        for (threshold, matcher) in (0..).zip(global_matchers(&c.colour, &track.appearance)) {
            if !scope.confined && !is_due(threshold, missed) {
                continue;
            }
            let search = self.search(k, track, &matcher, expected);
            search.candidates(scope.region, threshold, list, self.scratch, self.tested);
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

/// Eq. 1 as it is now, then nearer and nearer to the typical pixel; the same with the colours that were
/// taught, since the light may have changed back.
fn global_matchers<'a>(
    c: &'a ColourConfig,
    appearance: &'a Appearance,
) -> impl Iterator<Item = Matcher> + 'a {
    let retries = || c.retries.iter().chain(&c.global_retries);
    let now = core::iter::once_with(|| appearance.matcher(c.alpha_256))
        .chain(retries().map(|retry| appearance.matcher_near(*retry)));
    let taught = core::iter::once_with(|| appearance.learnt_matcher(c.alpha_256))
        .chain(retries().map(|retry| appearance.learnt_matcher_near(*retry)));
    now.chain(taught)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{GLOBAL_RETRIES, RETRIES};

    #[test]
    fn every_threshold_has_its_turn() {
        let thresholds = 2 * (1 + RETRIES + GLOBAL_RETRIES) as u8;
        assert!((0..WHOLE_FRAMES).all(|missed| (0..thresholds).all(|number| is_due(number, missed))));
        for began in WHOLE_FRAMES..40 {
            let turns = began..began + SHARES;
            assert!((0..thresholds).all(|number| turns.clone().any(|missed| is_due(number, missed))));
            let due = (0..thresholds).filter(|number| is_due(*number, began)).count();
            assert!(
                is_due(0, began) && due <= 1 + usize::from(thresholds).div_ceil(SHARES as usize),
                "{due}"
            );
        }
    }
}
