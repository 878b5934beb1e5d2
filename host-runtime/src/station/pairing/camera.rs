//! One camera's last sightings, and what they teach of it.

use super::{MAX_SPAN_PERIODS, Sighting, Source, TOGETHER_US, between};
use std::collections::VecDeque;
use tetrad_core::observation::Observations;

/// Sightings that are kept: more than a camera can be ahead of another that is waited for at 60
/// pictures a second.
const KEPT: usize = 12;

/// Differences of which the middle one is believed: up to four of nine may be pauses or crowding.
const BELIEVED: usize = 9;

/// The frame period before it is measured, microseconds.
const DEFAULT_PERIOD_US: f64 = 1e6 / 30.0;

/// See the [module's text](self).
#[derive(Clone, Debug, Default)]
pub(super) struct Camera {
    seen: VecDeque<Sighting>,
    steps_us: VecDeque<u64>,
    delays_us: VecDeque<u64>,
}

impl Camera {
    /// Whether it is newer than the last, and was taken.
    pub(super) fn take(&mut self, sighting: &Sighting) -> bool {
        if let Some(newest_us) = self.newest_us() {
            let Some(step_us) = sighting.capture_us.checked_sub(newest_us).filter(|&us| us > 0) else {
                return false;
            };
            push(&mut self.steps_us, step_us, BELIEVED);
        }
        push(&mut self.delays_us, sighting.received_us.saturating_sub(sighting.capture_us), BELIEVED);
        push(&mut self.seen, *sighting, KEPT);
        true
    }

    pub(super) fn newest(&self) -> Option<&Sighting> {
        self.seen.back()
    }

    pub(super) fn newest_us(&self) -> Option<u64> {
        self.newest().map(|sighting| sighting.capture_us)
    }

    /// The last sighting that is needed to tell the balls at a time.
    pub(super) fn used_at(&self, t_us: u64) -> Option<&Sighting> {
        let together = self.seen.iter().find(|sighting| sighting.capture_us.abs_diff(t_us) <= TOGETHER_US);
        together.or_else(|| self.first_after(t_us))
    }

    pub(super) fn size(&self) -> Option<(u16, u16)> {
        self.newest().map(|sighting| sighting.size)
    }

    /// The time from picture to picture, microseconds; `None` before the second.
    pub(super) fn period_us(&self) -> Option<f64> {
        middle(&self.steps_us).map(|us| us as f64)
    }

    pub(super) fn period_or_default_us(&self) -> f64 {
        self.period_us().unwrap_or(DEFAULT_PERIOD_US)
    }

    /// How long its pictures take to come here as sightings, microseconds.
    pub(super) fn delay_us(&self) -> u64 {
        middle(&self.delays_us).unwrap_or(0)
    }

    /// The first sighting after a time.
    pub(super) fn first_after(&self, t_us: u64) -> Option<&Sighting> {
        self.seen.iter().find(|sighting| sighting.capture_us > t_us)
    }

    /// The balls at a time, and how they are known; `None` where no two pictures are around it.
    pub(super) fn at(&self, t_us: u64) -> Option<(Observations, Source)> {
        let nearest = self.seen.iter().min_by_key(|sighting| sighting.capture_us.abs_diff(t_us))?;
        if nearest.capture_us.abs_diff(t_us) <= TOGETHER_US {
            return Some((nearest.balls, Source::Seen));
        }
        let after = self.seen.iter().position(|sighting| sighting.capture_us > t_us)?;
        let [first, last] = [after.checked_sub(1)?, after].map(|at| self.seen.get(at));
        let (first, last) = (first?, last?);
        let span_us = last.capture_us - first.capture_us;
        if span_us as f64 > MAX_SPAN_PERIODS * self.period_or_default_us() {
            return None;
        }
        let before = after.checked_sub(2).and_then(|at| self.seen.get(at));
        Some((between(before, first, last, t_us), Source::Between(span_us)))
    }
}

fn push<T>(row: &mut VecDeque<T>, newest: T, kept: usize) {
    row.push_back(newest);
    if row.len() > kept {
        row.pop_front();
    }
}

fn middle(values: &VecDeque<u64>) -> Option<u64> {
    let mut sorted: Vec<u64> = values.iter().copied().collect();
    sorted.sort_unstable();
    sorted.get(sorted.len() / 2).copied()
}
