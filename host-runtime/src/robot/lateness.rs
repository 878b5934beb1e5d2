//! How late cycles began: a histogram that costs the same whatever comes.

use std::fmt;

/// Width of a bin, microseconds.
const BIN_US: u64 = 10;
/// Bins: up to 20 ms, the rest in the last.
const BINS: usize = 2_000;

/// Lateness of cycles.
#[derive(Clone)]
pub struct Lateness {
    bins: Box<[u32; BINS]>,
    count: u64,
    least_us: u64,
    most_us: u64,
}

impl Default for Lateness {
    fn default() -> Self {
        Self { bins: Box::new([0; BINS]), count: 0, least_us: u64::MAX, most_us: 0 }
    }
}

impl Lateness {
    /// A cycle began so late.
    pub fn record(&mut self, us: u64) {
        let bin = usize::try_from(us / BIN_US).unwrap_or(usize::MAX).min(BINS - 1);
        self.bins[bin] = self.bins[bin].saturating_add(1);
        self.count += 1;
        self.least_us = self.least_us.min(us);
        self.most_us = self.most_us.max(us);
    }

    /// The lateness that `share` (0 to 1) of the cycles did not exceed, microseconds, to 10; `None`
    /// before the first cycle.
    #[must_use]
    pub fn quantile_us(&self, share: f64) -> Option<u64> {
        let rank = (share * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        for (bin, count) in (1u64..).zip(self.bins.iter()) {
            seen += u64::from(*count);
            if seen >= rank {
                return Some((bin * BIN_US).min(self.most_us));
            }
        }
        None
    }
}

impl fmt::Debug for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// `late by 12 us at least, 60 us (p50), 140 us (p99), 310 us at most`.
impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Some(p50), Some(p99)) = (self.quantile_us(0.5), self.quantile_us(0.99)) else {
            return f.write_str("no cycle yet");
        };
        write!(
            f,
            "late by {} us at least, {p50} us (p50), {p99} us (p99), {} us at most",
            self.least_us, self.most_us
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_cycles() {
        let mut lateness = Lateness::default();
        assert_eq!(lateness.to_string(), "no cycle yet");
        for us in 1..=100 {
            lateness.record(us * 10);
        }
        assert_eq!(lateness.quantile_us(0.5), Some(510));
        assert_eq!(lateness.quantile_us(0.99), Some(1000));
        lateness.record(1_000_000);
        let text = "late by 10 us at least, 520 us (p50), 1010 us (p99), 1000000 us at most";
        assert_eq!(lateness.to_string(), text);
    }
}
