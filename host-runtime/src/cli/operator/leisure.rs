//! When the operator's loop does what can wait: right after a motion has gone, where the next picture is farthest.
//! Another camera's may come any moment else, and would wait.

/// No motion has gone for so long: none may come soon, and what was put off is not put off any more, microseconds.
/// Longer than from one picture to the next at twenty a second.
const PATIENCE_US: u64 = 60_000;

#[derive(Debug, Default)]
pub(super) struct Leisure {
    moved_us: Option<u64>,
}

impl Leisure {
    /// Whether this turn has the time; `moved`: a motion went in it.
    pub(super) fn is_now(&mut self, moved: bool, now_us: u64) -> bool {
        if moved {
            self.moved_us = Some(now_us);
        }
        moved || self.moved_us.is_none_or(|moved_us| now_us.saturating_sub(moved_us) >= PATIENCE_US)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_can_wait_follows_a_motion_or_a_silence() {
        let mut leisure = Leisure::default();
        assert!(leisure.is_now(false, 5_000), "nothing has gone yet");
        let turns = [
            (true, 10_000),
            (false, 12_000),
            (false, 43_000),
            (true, 43_400),
            (false, 103_300),
            (false, 103_400),
        ];
        let at_leisure = turns.map(|(moved, now_us)| leisure.is_now(moved, now_us));
        assert_eq!(at_leisure, [true, false, false, true, false, true]);
        assert!(leisure.is_now(false, 200_000), "and goes on where no motion does");
        assert!(!leisure.is_now(false, 43_000), "a clock that goes back is no silence");
    }
}
