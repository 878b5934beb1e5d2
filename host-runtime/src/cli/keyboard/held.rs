//! How long a key counts as held.
//!
//! A terminal tells that a key is down only by repeating it, and most tell nothing when it is let go. So
//! the bar counts as held from its first repeat on, and after each repeat for twice as long as the
//! repeats lately were apart, [`LONGEST_GAP`] at most: a mere tap moves nothing, and a release is known
//! soon. Terminals that do tell (kitty's protocol) are believed at once, both ways.

use std::time::{Duration, Instant};

/// Longer than the slowest usual delay before a key repeats (660 ms under X11).
const FIRST_REPEAT: Duration = Duration::from_millis(700);

/// Two repeats of the slowest usual rate (10.9 a second on a Linux console).
const LONGEST_GAP: Duration = Duration::from_millis(200);

/// Two repeats of the fastest usual rate (30 a second), and what a busy computer may hold one up.
const SHORTEST_GAP: Duration = Duration::from_millis(80);

/// So many gaps between repeats tell how far apart they are.
const GAPS: usize = 4;

/// How long the space bar counts as held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Held {
    /// The terminal tells when it is let go.
    tells_releases: bool,
    struck: Option<Instant>,
    /// The last gaps between its repeats, the newest first.
    gaps: [Option<Duration>; GAPS],
    until: Option<Instant>,
}

impl Held {
    /// Of a key that is not held, at a terminal that tells releases or does not.
    pub(super) fn new(tells_releases: bool) -> Self {
        Self { tells_releases, ..Self::default() }
    }

    pub(super) const fn tells_releases(&self) -> bool {
        self.tells_releases
    }

    pub(super) fn strike(&mut self, now: Instant) {
        if self.until.is_some_and(|until| now >= until) {
            // it was let go meanwhile
            self.let_go();
        }
        let gap = self.struck.replace(now).map(|before| now.saturating_duration_since(before));
        let repeated = self.is_held(now);
        self.until = match gap {
            Some(gap) if repeated => {
                self.gaps.rotate_right(1);
                self.gaps[0] = Some(gap);
                Some(now + self.next_repeat())
            }
            // the first repeat
            Some(gap) if gap < FIRST_REPEAT && !self.tells_releases => Some(now + LONGEST_GAP),
            // a first strike, which may be a mere tap where nobody tells of its end
            _ => self.tells_releases.then(|| now + FIRST_REPEAT),
        };
    }

    /// How long to wait for the next repeat.
    fn next_repeat(&self) -> Duration {
        let known = self.gaps.iter().flatten();
        // where a release is told, nothing has to be guessed from the gaps
        let guess = !self.tells_releases && !self.gaps.contains(&None);
        let largest = if guess { known.max() } else { None };
        largest.map_or(LONGEST_GAP, |gap| (*gap * 2).clamp(SHORTEST_GAP, LONGEST_GAP))
    }

    pub(super) const fn let_go(&mut self) {
        *self = Self { tells_releases: self.tells_releases, struck: None, gaps: [None; GAPS], until: None };
    }

    pub(super) fn is_held(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| now < until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    /// Strikes the bar so often, so far apart; when it was struck last.
    fn strikes(held: &mut Held, mut now: Instant, apart: Duration, count: u32) -> Instant {
        for _ in 0..count {
            now += apart;
            held.strike(now);
            assert!(held.is_held(now));
        }
        now
    }

    #[test]
    fn a_tap_is_no_hold_and_the_first_repeat_is() {
        let mut held = Held::default();
        let start = Instant::now();
        held.strike(start);
        assert!(!held.is_held(start), "it may be a mere tap");
        let repeated = start + 660 * MS;
        assert!(!held.is_held(repeated));
        held.strike(repeated);
        assert!(held.is_held(repeated) && held.is_held(repeated + 199 * MS));
        let mut taps = Held::default();
        for tap in 0..5 {
            let now = start + tap * FIRST_REPEAT;
            taps.strike(now);
            assert!(!taps.is_held(now), "two taps are no repeat");
        }
    }

    #[test]
    fn the_bar_is_held_until_its_repeats_stay_away() {
        let start = Instant::now();
        // (apart, let go after): keyboards of 30, 25 and 10.9 repeats a second
        for (apart, gone) in [(33, 80), (40, 80), (45, 90), (92, 184), (150, 200)] {
            let mut held = Held::default();
            held.strike(start);
            let repeated = start + 500 * MS;
            held.strike(repeated);
            let last = strikes(&mut held, repeated, apart * MS, 20);
            assert!(held.is_held(last + (gone - 1) * MS), "{apart} ms apart");
            assert!(!held.is_held(last + gone * MS), "{apart} ms apart");
        }
    }

    #[test]
    fn a_late_repeat_is_waited_for_and_the_next_hold_begins_anew() {
        let mut held = Held::default();
        let start = Instant::now();
        held.strike(start);
        held.strike(start + 300 * MS);
        let last = strikes(&mut held, start + 300 * MS, 33 * MS, 10);
        // one came late: so may the next
        let late = strikes(&mut held, last, 75 * MS, 1);
        assert!(held.is_held(late + 149 * MS) && !held.is_held(late + 150 * MS));
        let last = strikes(&mut held, late, 33 * MS, 4);
        assert!(!held.is_held(last + SHORTEST_GAP));
        held.strike(last + 300 * MS);
        assert!(!held.is_held(last + 300 * MS), "a tap again");
    }
}
