//! When something that went away is tried again: soon at first, then every two seconds.

use std::time::Duration;

const FIRST_US: u64 = 100_000;
const LAST_US: u64 = 2_000_000;

/// The longest that anybody sleeps at a time, so that it hears of the program's end.
const NAP_US: u64 = 50_000;

/// The pauses between attempts, by any clock in microseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BackOff {
    pause_us: u64,
    due_us: u64,
}

impl BackOff {
    /// An attempt has failed.
    pub(super) fn failed(&mut self, now_us: u64) {
        self.pause_us = (2 * self.pause_us).clamp(FIRST_US, LAST_US);
        self.due_us = now_us + self.pause_us;
    }

    /// How long to sleep, and then to ask again; `None` where the next attempt is due.
    pub(super) fn wait(&self, now_us: u64) -> Option<Duration> {
        let left_us = self.due_us.saturating_sub(now_us);
        (left_us > 0).then(|| Duration::from_micros(left_us.min(NAP_US)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_to_two_seconds_and_are_slept_in_naps() {
        let mut back_off = BackOff::default();
        assert_eq!(back_off.wait(0), None);
        let mut now_us = 1_000;
        let pauses = [(); 7].map(|()| {
            back_off.failed(now_us);
            assert_eq!(back_off.wait(now_us), Some(Duration::from_micros(NAP_US)));
            let pause_us = back_off.due_us - now_us;
            now_us = back_off.due_us - 7;
            assert_eq!(back_off.wait(now_us), Some(Duration::from_micros(7)));
            now_us += 7;
            assert_eq!(back_off.wait(now_us), None);
            pause_us / 1_000
        });
        assert_eq!(pauses, [100, 200, 400, 800, 1_600, 2_000, 2_000]);
    }
}
