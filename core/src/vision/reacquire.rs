//! Lost balls found again: where one may come back, and which of several finds belong together.
//!
//! The four balls are one rigid frame, so a ball that was lost comes back where the others have
//! carried it, and a thing of its colour elsewhere in the picture is not it (section 3.5's
//! geometric matching, used before a find is believed).

use super::detect::{Candidate, Shortlist};
use super::search::Region;
use super::track::{BallTrack, Tracks};
use crate::config::ValidationConfig;
use crate::geometry::ImagePoint;
use crate::observation::BALLS;

/// Other balls that must be seen before their motion confines where a lost one may be.
const GATE_BALLS: usize = 2;

/// Diameters that the gate is wider than what the spread gives: the window of section 3.2 around its
/// edge.
const GATE_DIAMETERS: f32 = 1.5;

/// What a ball that is left unfound costs, in scores.
const COST_OF_NONE: f32 = 1.0;

/// The most that one pair's distance may cost, in scores.
const COST_OF_A_PAIR: f32 = 0.4;

/// Distance between two balls, in diameters, that is unlikely for any frame of four balls.
const FAR_DIAMETERS: f32 = 25.0;

/// How many times the largest distance among the other balls one of a rigid frame may stand away ...
const STRAY_SPREADS: f32 = 2.5;

/// ... and how many of its own diameters more: the others may happen to stand behind each other.
const STRAY_DIAMETERS: f32 = 3.0;

/// What is found of each ball in the present frame: `None` while it is not.
pub(super) type Places = [Option<ImagePoint>; BALLS];

/// Where the others have carried a ball since it was last measured, and how many of them say so.
pub(super) fn suggested(ball: &BallTrack, now: &Places) -> Option<(ImagePoint, usize)> {
    let last = ball.last_centre()?;
    let (mut shift, mut voices) = (ImagePoint::default(), 0usize);
    for (now, then) in now.iter().zip(&ball.companions) {
        if let (Some(now), Some(then)) = (now, then) {
            shift = shift + (*now - *then);
            voices += 1;
        }
    }
    (voices > 0).then(|| (last + shift * (1.0 / voices as f32), voices))
}

/// The largest distance between two balls when this one was last measured, pixels.
fn spread(ball: &BallTrack) -> f32 {
    let mut largest = 0.0f32;
    let places = || ball.companions.iter().copied().chain([ball.last_centre()]).flatten();
    for a in places() {
        for b in places() {
            largest = largest.max(a.distance(b));
        }
    }
    largest
}

/// The part of the picture in which a lost ball may come back: around where the others have carried
/// it, the wider the longer it has been away. `None`: anywhere.
pub(super) fn gate(
    ball: &BallTrack,
    now: &Places,
    absent_us: u64,
    width: u16,
    height: u16,
    config: &ValidationConfig,
) -> Option<Region> {
    let (centre, voices) = suggested(ball, now)?;
    if voices < GATE_BALLS {
        return None;
    }
    let seconds = absent_us as f32 * 1e-6;
    let radius = spread(ball) * (config.gate_spread + config.gate_growth * seconds * seconds)
        + GATE_DIAMETERS * ball.clean.diameter;
    Region::square(centre.u, centre.v, 2.0 * radius, width, height)
}

/// Which find stands so far from all others that it cannot be a ball of the same rigid frame: further
/// from the nearest of them than [`STRAY_SPREADS`] times the largest distance among them. `None` when
/// there is none, or fewer than three balls to judge by.
pub(super) fn stray(places: &Places, diameters: &[f32; BALLS]) -> Option<usize> {
    let mut farthest: Option<(usize, f32)> = None;
    for (k, (place, diameter)) in places.iter().zip(diameters).enumerate() {
        let Some(place) = place else { continue };
        let others = || places.iter().enumerate().filter(move |(l, _)| *l != k).filter_map(|(_, p)| *p);
        if others().count() < GATE_BALLS {
            return None;
        }
        let nearest = others().map(|other| place.distance(other)).fold(f32::INFINITY, f32::min);
        let among = others().flat_map(|a| others().map(move |b| a.distance(b))).fold(0.0, f32::max);
        let excess = nearest - STRAY_SPREADS * among - STRAY_DIAMETERS * diameter;
        if excess > 0.0 && farthest.is_none_or(|(_, most)| excess > most) {
            farthest = Some((k, excess));
        }
    }
    farthest.map(|(k, _)| k)
}

/// One of a ball's candidates, and its threshold; 0 is none of them.
pub(super) fn picked(list: &Shortlist, pick: usize) -> Option<&(Candidate, u8)> {
    pick.checked_sub(1).and_then(|i| list.get(i))
}

/// Picks at most one candidate of each ball so that together they score best: each by its own score,
/// each pair by how well its distance agrees with the last known one (or, where none is known, by
/// not being far apart). 5^4 combinations at the most. [`picked`] says which are meant.
pub(super) fn choose(
    tracks: &Tracks,
    candidates: &[Shortlist; BALLS],
    found: &Places,
    rigid: bool,
) -> [usize; BALLS] {
    let mut best = [0usize; BALLS];
    let mut least = f32::INFINITY;
    let mut picks = [0usize; BALLS];
    loop {
        let mut places = *found;
        let mut cost = 0.0f32;
        for ((place, list), pick) in places.iter_mut().zip(candidates).zip(picks) {
            match picked(list, pick) {
                Some((c, _)) => {
                    cost += 1.0 - c.score;
                    *place = Some(c.blob.centre);
                }
                None if !list.is_empty() => cost += COST_OF_NONE,
                None => {}
            }
        }
        if rigid {
            cost += cost_of_pairs(tracks, &places);
        }
        if cost < least {
            least = cost;
            best = picks;
        }
        // the next combination, as an odometer counts
        let mut carried = true;
        for (pick, list) in picks.iter_mut().zip(candidates) {
            if carried {
                *pick += 1;
                carried = *pick > list.len();
                if carried {
                    *pick = 0;
                }
            }
        }
        if carried {
            return best;
        }
    }
}

fn cost_of_pairs(tracks: &Tracks, places: &Places) -> f32 {
    let mut cost = 0.0;
    for (k, (a, ball)) in places.iter().zip(tracks).enumerate() {
        for (l, b) in places.iter().enumerate().skip(k + 1) {
            let (Some(a), Some(b), Some(ball)) = (a, b, ball) else { continue };
            let is = a.distance(*b);
            let was = ball.last_centre().zip(ball.companions.get(l).copied().flatten());
            let relative = match was {
                Some((x, y)) => {
                    let should = x.distance(y).max(1.0);
                    libm::fabsf(is - should) / should
                }
                None => is / (FAR_DIAMETERS * ball.clean.diameter.max(1.0)),
            };
            cost += COST_OF_A_PAIR * relative.min(2.0) * 0.5;
        }
    }
    cost
}
