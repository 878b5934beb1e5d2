//! What a port tells the time by: the wall's clock, or one that is set by hand.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Microseconds since some beginning, never going back.
#[derive(Clone, Debug)]
pub enum Clock {
    /// The computer's own monotonic clock.
    Wall(Instant),
    /// A clock that is set by whoever simulates; clones share it.
    Given(Arc<AtomicU64>),
}

impl Clock {
    /// The computer's clock, from now on.
    #[must_use]
    pub fn wall() -> Self {
        Self::Wall(Instant::now())
    }

    /// A clock that stands at 0 until it is [set](Self::set).
    #[must_use]
    pub fn given() -> Self {
        Self::Given(Arc::new(AtomicU64::new(0)))
    }

    /// Microseconds.
    #[must_use]
    pub fn now_us(&self) -> u64 {
        match self {
            // 584,000 years fit
            Self::Wall(start) => u64::try_from(start.elapsed().as_micros()).unwrap_or(u64::MAX),
            Self::Given(now) => now.load(Ordering::Relaxed),
        }
    }

    /// Sets a given clock; it does not go back. The computer's clock cannot be set: nothing happens.
    pub fn set(&self, us: u64) {
        if let Self::Given(now) = self {
            now.fetch_max(us, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_given_clock_is_shared_and_never_goes_back() {
        let clock = Clock::given();
        let other = clock.clone();
        clock.set(30);
        clock.set(20);
        assert_eq!(other.now_us(), 30);
    }

    #[test]
    fn the_wall_clock_does_not_go_back_and_is_not_set() {
        let clock = Clock::wall();
        let before = clock.now_us();
        clock.set(u64::MAX);
        let after = clock.now_us();
        assert!(before <= after && after < u64::MAX);
    }
}
