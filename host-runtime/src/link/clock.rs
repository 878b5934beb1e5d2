//! How far another station's clock is ahead of this one, from the times of questions and answers.
//!
//! Four times make a sample, as in NTP ([RFC 5905, section 8]): asked and answered by this clock, heard
//! and sent by the other. What the two ways take together is known exactly; that they take equally long
//! is not, so a sample can be wrong by half of it. The sample that took least of the last ones is
//! believed (the minimum-delay filter of section 10), an old one less for what the clocks may have
//! drifted since, and the drift is the slope of the best samples of longer stretches.
//!
//! The times only tell when pictures were taken. No rule of safety looks at them: a slave counts the age
//! of a command from when it came, by its own clock.
//!
//! [RFC 5905, section 8]: https://www.rfc-editor.org/rfc/rfc5905#section-8

use std::collections::VecDeque;

/// Samples that are looked at: half a minute at two a second.
const SAMPLES: usize = 64;

/// How much two clocks may drift apart while it is not measured, microseconds a second: 100 ppm,
/// twice what a cheap quartz is sold with.
const DRIFT_BOUND_PPM: f64 = 100.0;

/// One best sample is kept of each stretch of this length, microseconds...
const STRETCH_US: u64 = 5_000_000;

/// ...and so many of them tell the drift...
const STRETCHES: usize = 24;

/// ...once there are this many.
const STRETCHES_FOR_DRIFT: usize = 4;

/// The least a measured drift is trusted to, parts in a million: clocks change theirs with the warmth.
const DRIFT_TRUST_PPM: f64 = 20.0;

/// Samples in a row that cannot be true together with what is believed: the other clock was set.
const DISAGREEING: u32 = 3;

/// The four times of a question and its answer, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// When it was asked, this clock.
    pub asked_us: u64,
    /// When that was heard, the other clock.
    pub heard_us: u64,
    /// When the answer was sent, the other clock.
    pub answered_us: u64,
    /// When the answer was here, this clock.
    pub back_us: u64,
}

/// What is known of the other clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClockEstimate {
    /// The other clock minus this one, now, microseconds.
    pub offset_us: i64,
    /// The offset is right within this, microseconds, if no clock drifts by more than 100 ppm.
    pub error_us: u64,
    /// How much faster the other clock goes, parts in a million; 0 until it is known.
    pub drift_ppm: f64,
    /// The shortest way there and back of late, microseconds.
    pub round_trip_us: u64,
}

#[derive(Clone, Copy, Debug)]
struct Sample {
    at_us: u64,
    offset_us: i64,
    delay_us: u64,
}

impl Sample {
    /// How wrong the sample may be at a time, microseconds.
    fn error_at(&self, now_us: u64, drift_bound_ppm: f64) -> f64 {
        let age_us = now_us.saturating_sub(self.at_us) as f64;
        self.delay_us as f64 / 2.0 + age_us * drift_bound_ppm / 1e6
    }
}

/// Believes the samples that took least.
#[derive(Clone, Debug, Default)]
pub struct OtherClock {
    samples: VecDeque<Sample>,
    /// The best of each stretch, the last still growing.
    stretches: VecDeque<Sample>,
    disagreeing: u32,
}

impl OtherClock {
    /// Takes a question and its answer. What cannot be (an answer before its question, an answer sent
    /// before the question was heard) is left out.
    pub fn take(&mut self, exchange: &Exchange) {
        let Exchange { asked_us, heard_us, answered_us, back_us } = *exchange;
        let (Some(away), Some(there)) = (back_us.checked_sub(asked_us), answered_us.checked_sub(heard_us))
        else {
            return;
        };
        let Some(delay_us) = away.checked_sub(there) else { return };
        // i128, for the other clock may show anything
        let sum = i128::from(heard_us) - i128::from(asked_us) + i128::from(answered_us) - i128::from(back_us);
        let Ok(offset_us) = i64::try_from(sum / 2) else { return };
        let sample = Sample { at_us: back_us, offset_us, delay_us };

        if let Some(estimate) = self.at(back_us) {
            let apart = offset_us.abs_diff(estimate.offset_us);
            if apart > estimate.error_us.saturating_add(delay_us.div_ceil(2)).saturating_add(1) {
                self.disagreeing += 1;
                if self.disagreeing < DISAGREEING {
                    return;
                }
                *self = Self::default();
            }
        }
        self.disagreeing = 0;
        self.samples.push_back(sample);
        if self.samples.len() > SAMPLES {
            self.samples.pop_front();
        }
        match self.stretches.back_mut() {
            Some(best) if best.at_us / STRETCH_US == back_us / STRETCH_US => {
                if delay_us <= best.delay_us {
                    *best = sample;
                }
            }
            _ => self.stretches.push_back(sample),
        }
        if self.stretches.len() > STRETCHES {
            self.stretches.pop_front();
        }
    }

    /// What is known at a time of this clock; `None` before the first sample.
    #[must_use]
    pub fn at(&self, now_us: u64) -> Option<ClockEstimate> {
        let (drift_ppm, bound) = self.drift().unwrap_or((0.0, DRIFT_BOUND_PPM));
        let error = |sample: &&Sample| sample.error_at(now_us, bound);
        let best = self.samples.iter().min_by(|a, b| error(a).total_cmp(&error(b)))?;
        let since_us = now_us.saturating_sub(best.at_us) as f64;
        Some(ClockEstimate {
            offset_us: best.offset_us.saturating_add((since_us * drift_ppm / 1e6).round() as i64),
            error_us: best.error_at(now_us, bound).ceil() as u64,
            drift_ppm,
            round_trip_us: self.samples.iter().map(|sample| sample.delay_us).min()?,
        })
    }

    /// A time of the other clock as this clock would have shown it; `None` where that is not known or
    /// before this clock's beginning.
    #[must_use]
    pub fn here_us(&self, there_us: u64, now_us: u64) -> Option<u64> {
        let offset = self.at(now_us)?.offset_us;
        u64::try_from(i128::from(there_us) - i128::from(offset)).ok()
    }

    /// The slope of the stretches' best samples by least squares, and how wrong it may be, both in parts
    /// in a million; `None` where that is more than is known without.
    fn drift(&self) -> Option<(f64, f64)> {
        if self.stretches.len() < STRETCHES_FOR_DRIFT {
            return None;
        }
        let first = self.stretches.front()?;
        let points = self.stretches.iter().map(|sample| {
            let t = sample.at_us.saturating_sub(first.at_us) as f64;
            let y = (i128::from(sample.offset_us) - i128::from(first.offset_us)) as f64;
            (t, y, sample.delay_us as f64 / 2.0)
        });
        let mean_t = points.clone().map(|(t, ..)| t).sum::<f64>() / self.stretches.len() as f64;
        let (mut spread, mut slope, mut wrong) = (0.0, 0.0, 0.0);
        for (t, y, error) in points {
            spread += (t - mean_t).powi(2);
            slope += (t - mean_t) * y;
            // each sample may be wrong by its own error, and all to the same side of the slope
            wrong += (t - mean_t).abs() * error;
        }
        let (slope, wrong) = (slope / spread * 1e6, wrong / spread * 1e6);
        let bound = wrong.max(DRIFT_TRUST_PPM);
        (slope.is_finite() && bound < DRIFT_BOUND_PPM).then_some((slope, bound))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Another clock, and ways of a length that is made up of a least one and what is drawn.
    struct World {
        ahead_us: i64,
        drift_ppm: f64,
    }

    impl World {
        fn there(&self, here_us: u64) -> u64 {
            let drifted = here_us as f64 * self.drift_ppm / 1e6;
            u64::try_from(here_us as i64 + self.ahead_us + drifted.round() as i64).unwrap()
        }

        fn exchange(&self, asked_us: u64, there_us: u64, back_us: u64) -> Exchange {
            let heard = asked_us + there_us;
            let answered = heard + 50;
            Exchange {
                asked_us,
                heard_us: self.there(heard),
                answered_us: self.there(answered),
                back_us: answered + back_us,
            }
        }
    }

    /// Draws that are the same in each run.
    fn draws() -> impl Iterator<Item = u64> {
        std::iter::successors(Some(12345_u64), |x| {
            Some(x.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407))
        })
        .map(|x| x >> 33)
    }

    proptest! {
        /// Hours apart, drifting, jittery: the truth is within the error that is claimed.
        #[test]
        fn the_truth_is_within_the_claimed_error(hours in -20_i64..20, drift in -50.0_f64..50.0, jitter in 1_u64..20_000) {
            let world = World { ahead_us: hours * 3_600_000_000 + 123, drift_ppm: drift };
            let mut clock = OtherClock::default();
            let mut draws = draws();
            let mut draw = || draws.next().unwrap() % jitter;
            let start = 100_000_000_000;
            for second in 0..200 {
                let asked = start + second * 500_000;
                let exchange = world.exchange(asked, 200 + draw(), 200 + draw());
                clock.take(&exchange);
                let now = exchange.back_us + draw();
                let estimate = clock.at(now).unwrap();
                let truth = world.there(now) as i64 - now as i64;
                prop_assert!(estimate.offset_us.abs_diff(truth) <= estimate.error_us + 2, "{estimate:?}, truth {truth}");
                let here = clock.here_us(world.there(now), now).unwrap();
                prop_assert!(here.abs_diff(now) <= estimate.error_us + 2);
            }
        }
    }

    #[test]
    fn the_drift_is_found() {
        let world = World { ahead_us: -7_000_000, drift_ppm: 40.0 };
        let mut clock = OtherClock::default();
        let mut draws = draws();
        let mut draw = || draws.next().unwrap() % 500;
        for half_second in 0..240 {
            clock.take(&world.exchange(10_000_000_000 + half_second * 500_000, 100 + draw(), 100 + draw()));
        }
        let estimate = clock.at(10_120_000_000).unwrap();
        assert!((estimate.drift_ppm - 40.0).abs() < 5.0, "{estimate:?}");
        assert!(estimate.round_trip_us < 400, "{estimate:?}");
    }

    #[test]
    fn a_clock_that_is_set_is_found_out_and_a_liar_is_not_believed_once() {
        let before = World { ahead_us: 1_000, drift_ppm: 0.0 };
        let after = World { ahead_us: 3_600_000_000, drift_ppm: 0.0 };
        let mut clock = OtherClock::default();
        for i in 0..20 {
            clock.take(&before.exchange(10_000_000 + i * 500_000, 100, 100));
        }
        clock.take(&after.exchange(20_000_000, 100, 100));
        assert_eq!(clock.at(20_000_300).unwrap().offset_us, 1_000, "one that disagrees is left out");
        for i in 1..4 {
            clock.take(&after.exchange(20_000_000 + i * 500_000, 100, 100));
        }
        assert_eq!(clock.at(22_000_000).unwrap().offset_us, 3_600_000_000);
    }

    #[test]
    fn what_cannot_be_is_left_out() {
        let mut clock = OtherClock::default();
        let sound = Exchange { asked_us: 100, heard_us: 1_000, answered_us: 1_010, back_us: 200 };
        for bad in [
            Exchange { back_us: 99, ..sound },
            Exchange { answered_us: 999, ..sound },
            Exchange { answered_us: 1_101, ..sound },
            Exchange { heard_us: u64::MAX, answered_us: u64::MAX, ..sound },
        ] {
            clock.take(&bad);
            assert_eq!(clock.at(300), None, "{bad:?}");
        }
        clock.take(&sound);
        let estimate = clock.at(200).unwrap();
        assert_eq!((estimate.offset_us, estimate.error_us, estimate.round_trip_us), (855, 45, 90));
        assert_eq!(clock.here_us(10, 200), None, "before this clock began");
    }
}
