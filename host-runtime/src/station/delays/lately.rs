//! The same stages over the last seconds alone: two sets of histograms take turns, the younger is filled and the
//! older still counts, so that old delays are forgotten in memory that does not grow.

use super::{Spread, Stage, empty};
use hdrhistogram::Histogram;

/// A set is filled for so long, microseconds; so what counts is of the last 5 to 10 s.
const TURN_US: u64 = 5_000_000;

#[derive(Clone, Debug)]
pub(super) struct Lately {
    young: Vec<Histogram<u32>>,
    old: Vec<Histogram<u32>>,
    /// When the younger set was begun.
    began_us: Option<u64>,
}

impl Lately {
    pub(super) fn new() -> Self {
        Self { young: empty(), old: empty(), began_us: None }
    }

    pub(super) fn add(&mut self, stage: Stage, us: u64, now_us: u64) {
        let began_us = *self.began_us.get_or_insert(now_us);
        let turns = now_us.saturating_sub(began_us) / TURN_US;
        if turns > 0 {
            std::mem::swap(&mut self.young, &mut self.old);
            self.young.iter_mut().for_each(Histogram::reset);
            if turns > 1 {
                // nothing came for a whole turn
                self.old.iter_mut().for_each(Histogram::reset);
            }
            self.began_us = Some(now_us);
        }
        if let Some(histogram) = self.young.get_mut(stage as usize) {
            histogram.saturating_record(us);
        }
    }

    /// What is known of a stage at this time.
    pub(super) fn of(&self, stage: Stage, now_us: u64) -> Option<Spread> {
        let turns = now_us.saturating_sub(self.began_us?) / TURN_US;
        let young = self.young.get(stage as usize).filter(|_| turns < 2);
        let old = self.old.get(stage as usize).filter(|_| turns < 1);
        let mut both = young?.clone();
        if let Some(old) = old {
            // both have the same bounds
            let _ = both.add(old);
        }
        Spread::of(&both)
    }
}
