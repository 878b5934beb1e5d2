//! Joins what one to eight free-running cameras saw to one instant, by when their pictures were taken.
//!
//! ```text
//! camera A   ----o---------o---------o----      instants, where A's pictures wait less for B's than
//! camera B   -------x---------x---------x-      B's for A's: each time an x has come, the o before it,
//! instants       ^         ^         ^          B's balls being told between its two x around it
//! ```
//!
//! - The instant is always the capture time of some camera's picture, and never later than the newest
//!   picture of any camera that is there: balls are told between two sightings ([`between`]), not
//!   beyond them. Pictures [taken together](TOGETHER_US) are paired as they are, bit for bit.
//! - In one frame period each camera's pictures could be the instants. The reference is the camera
//!   whose pictures wait least for the others': phases and delays are measured all the time.
//! - A camera that is late is waited for [`LATE_PERIODS`] of its own periods after another's picture
//!   came, and for what it is usually later on its way. Then the instant goes without it, its balls
//!   lost, and so do all that follow until its pictures are in time again: nothing stalls.
//! - Instants strictly increase.
//!
//! Plain data: what came and when are arguments, microseconds of one clock.

mod between;
mod camera;

pub use between::between;

use camera::Camera;
use tetrad_core::config::MAX_VIEWS;
use tetrad_core::observation::Observations;

#[cfg(test)]
mod tests;

/// Pictures taken within so many microseconds are taken together. A hand at 1 m/s, seen by 800 px from
/// 1 m away, moves 0.08 px in it, which is what a centre is good for; and no better are clocks compared
/// over a local network, or cameras triggered by one wire.
pub const TOGETHER_US: u64 = 100;

/// A camera is waited for so many of its frame periods after another camera's picture came: one, by
/// which its next picture is due wherever the two stand to each other, and a half for jitter. A lost packet
/// of a camera that follows closely behind the reference is bridged within.
pub const LATE_PERIODS: f64 = 1.5;

/// A camera whose way is longer than another's is waited for so much longer at most, microseconds: a
/// pose without it is better than one that is older.
pub const MAX_LATER_US: u64 = 100_000;

/// Balls are told between two sightings at most so many periods apart: two pictures lost in a row.
const MAX_SPAN_PERIODS: f64 = 3.5;

/// Another camera becomes the reference when its pictures wait less by this share of a period: near
/// equality jitter decides, and each change makes an uneven step.
const CHANGE_SHARE: f64 = 0.125;

/// Instants are at least this share of a period apart, so that none is made of two pictures that were
/// taken together.
const LEAST_STEP_SHARE: f64 = 1.0 / 3.0;

/// What a camera saw in one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// When the picture was taken, on the clock that all cameras' times are told on.
    pub capture_us: u64,
    /// When the whole picture was in its camera's memory.
    pub ready_us: u64,
    /// When it came here.
    pub received_us: u64,
    /// The four balls.
    pub balls: Observations,
    /// Pixels: width, height.
    pub size: (u16, u16),
}

/// How a camera's balls at an instant are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// As they were seen, in a picture taken at the instant.
    Seen,
    /// Between two pictures so many microseconds apart.
    Between(u64),
    /// Not at all: the camera is late, gone or has just come.
    Missing,
}

/// One camera's part of an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairedView {
    /// The balls; all lost where the camera's part is missing.
    pub balls: Observations,
    /// The size of its pictures, px; `None` before the first.
    pub size: Option<(u16, u16)>,
    /// How they are known.
    pub source: Source,
}

/// What all cameras saw at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Joined {
    /// When.
    pub t_us: u64,
    /// The cameras in their order.
    pub views: Vec<PairedView>,
    /// The camera whose picture was taken then, or together with the one that was.
    pub reference: usize,
    /// When the last of the pictures that were used was whole in its camera's memory.
    pub ready_us: u64,
    /// When the reference's picture came here.
    pub first_us: u64,
    /// When the last of those that were used came.
    pub last_us: u64,
}

/// What became of the sightings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairingCounts {
    /// Instants that all cameras are part of.
    pub complete: u64,
    /// Instants without one camera or more.
    pub partial: u64,
    /// How often another camera became the reference.
    pub changes: u64,
    /// Sightings that were no newer than the one before.
    pub old: u64,
}

/// Joins the cameras.
#[derive(Clone, Debug)]
pub struct Pairing {
    cameras: Vec<Camera>,
    last_us: Option<u64>,
    reference: Option<usize>,
    counts: PairingCounts,
}

impl Pairing {
    /// So many cameras, at most [`MAX_VIEWS`], that have not been heard of.
    #[must_use]
    pub fn new(cameras: usize) -> Self {
        let cameras = vec![Camera::default(); cameras.min(MAX_VIEWS)];
        Self { cameras, last_us: None, reference: None, counts: PairingCounts::default() }
    }

    /// Takes what a camera saw; ask for the [next](Self::next) instant then. One that is no newer than
    /// the camera's last, and one of a camera there is not, is left out.
    pub fn take(&mut self, camera: usize, sighting: &Sighting) {
        // no picture comes before it was taken, whatever the clocks say
        let capture_us = sighting.capture_us.min(sighting.received_us);
        let taken = self
            .cameras
            .get_mut(camera)
            .is_some_and(|camera| camera.take(&Sighting { capture_us, ..*sighting }));
        self.counts.old += u64::from(!taken);
    }

    /// The next instant, if its time has come.
    pub fn next(&mut self, now_us: u64) -> Option<Joined> {
        let live: Vec<usize> = (0..self.cameras.len()).filter(|&at| self.is_live(at, now_us)).collect();
        let (t_us, earliest) =
            live.iter().filter_map(|&at| Some((self.cameras.get(at)?.newest_us()?, at))).min()?;
        let period_us = live.iter().map(|&at| self.period_us(at)).fold(0.0, f64::max);
        let best = self.best(&live)?;
        // of pictures that were taken together either's time will do
        let newest_us = self.cameras.get(best)?.newest_us()?;
        let reference = if newest_us.abs_diff(t_us) <= TOGETHER_US { best } else { earliest };
        if let Some(last_us) = self.last_us {
            let step_us = t_us.checked_sub(last_us).filter(|&us| us > 0)? as f64;
            if live.len() > 1 && step_us < LEAST_STEP_SHARE * period_us {
                return None;
            }
            // where the reference's picture is missing, the next best goes
            if best != reference && step_us < period_us {
                return None;
            }
        }
        if self.reference.replace(reference).is_some_and(|before| before != reference) {
            self.counts.changes += 1;
        }
        self.last_us = Some(t_us);
        let views: Vec<PairedView> =
            (0..self.cameras.len()).map(|at| self.view(at, t_us, live.contains(&at))).collect();
        if views.iter().any(|view| view.source == Source::Missing) {
            self.counts.partial += 1;
        } else {
            self.counts.complete += 1;
        }
        let first_us = self.cameras.get(reference)?.newest()?.received_us;
        let used = live.iter().filter_map(|&at| self.cameras.get(at)?.used_at(t_us));
        let [mut ready_us, mut last_us] = [0; 2];
        for sighting in used {
            ready_us = ready_us.max(sighting.ready_us);
            last_us = last_us.max(sighting.received_us);
        }
        Some(Joined { t_us, views, reference, ready_us, first_us, last_us })
    }

    /// When to ask for the next instant though nothing came: a camera is late by then.
    #[must_use]
    pub fn due_us(&self, now_us: u64) -> Option<u64> {
        (0..self.cameras.len()).filter_map(|at| self.late_us(at)).filter(|&late_us| late_us > now_us).min()
    }

    /// What became of the sightings.
    #[must_use]
    pub const fn counts(&self) -> PairingCounts {
        self.counts
    }

    /// A camera's frame period as its pictures come, microseconds; `None` before it is known.
    #[must_use]
    pub fn measured_period_us(&self, camera: usize) -> Option<f64> {
        self.cameras.get(camera)?.period_us()
    }

    /// Whether a camera is part of the instants now.
    #[must_use]
    pub fn is_live(&self, camera: usize, now_us: u64) -> bool {
        self.cameras.get(camera).is_some_and(|camera| camera.newest_us().is_some())
            && self.late_us(camera).is_none_or(|late_us| now_us < late_us)
    }

    /// From when on a camera is late; `None` while no other is ahead of it.
    fn late_us(&self, camera: usize) -> Option<u64> {
        let it = self.cameras.get(camera)?;
        let newest_us = it.newest_us()?;
        let others = self.cameras.iter().enumerate().filter(|(at, _)| *at != camera);
        others
            .filter_map(|(_, other)| {
                let ahead = other.first_after(newest_us + TOGETHER_US)?;
                let later_us = it.delay_us().saturating_sub(other.delay_us()).min(MAX_LATER_US);
                Some(ahead.received_us + (LATE_PERIODS * it.period_or_default_us()) as u64 + later_us)
            })
            .min()
    }

    fn period_us(&self, camera: usize) -> f64 {
        self.cameras.get(camera).map_or(0.0, Camera::period_or_default_us)
    }

    /// Whose pictures are the least old when all others have theirs around them.
    fn best(&self, live: &[usize]) -> Option<usize> {
        let age = |at: usize| {
            let age_us = self.age_us(at, live);
            let stays = self.reference == Some(at);
            age_us - if stays { CHANGE_SHARE * self.period_us(at) } else { 0.0 }
        };
        live.iter().copied().min_by(|&a, &b| age(a).total_cmp(&age(b)))
    }

    /// How old a camera's picture is when all others have theirs around it, microseconds.
    fn age_us(&self, reference: usize, live: &[usize]) -> f64 {
        let Some(its) = self.cameras.get(reference) else { return f64::INFINITY };
        let others = live.iter().filter(|&&at| at != reference).filter_map(|&at| self.cameras.get(at));
        let ages = others.filter_map(|other| {
            let period_us = other.period_or_default_us().min(its.period_or_default_us());
            let apart_us = other.newest_us()? as f64 - its.newest_us()? as f64;
            let phase_us = apart_us.rem_euclid(period_us);
            let together = phase_us > period_us - TOGETHER_US as f64;
            Some(if together { 0.0 } else { phase_us } + other.delay_us() as f64)
        });
        ages.fold(its.delay_us() as f64, f64::max)
    }

    fn view(&self, camera: usize, t_us: u64, live: bool) -> PairedView {
        let it = self.cameras.get(camera);
        let size = it.and_then(Camera::size);
        let at = it.filter(|_| live).and_then(|camera| camera.at(t_us));
        let (balls, source) = at.unwrap_or((Observations::default(), Source::Missing));
        PairedView { balls, size, source }
    }
}
