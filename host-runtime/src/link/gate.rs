//! What passes of a numbered row of packets: each that is newer than all before. Nothing is put in order
//! again, for what is old is of no use.

/// How far back a packet that comes late is still told from one that was lost.
const WINDOW: u32 = u64::BITS;

/// What became of the packets of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Newer than all before.
    pub taken: u64,
    /// Never came, as far as is known: in the numbers' gaps.
    pub lost: u64,
    /// Dropped: a newer one had come.
    pub late: u64,
    /// Dropped: had come before, or is too old to know.
    pub repeated: u64,
    /// Taken, but a newer one came before the station looked.
    pub overtaken: u64,
}

impl Counts {
    /// Of the packets that were sent, as far as is known, how many never came: 0 to 1.
    #[must_use]
    pub fn loss(&self) -> f64 {
        let sent = self.taken + self.late + self.lost;
        if sent == 0 { 0.0 } else { self.lost as f64 / sent as f64 }
    }
}

/// Why a packet is dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stale {
    /// A newer one had come.
    Late,
    /// It had come before, or is too old to know.
    Repeated,
}

/// Lets through what is newer than all before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gate {
    /// The newest number that came.
    newest: Option<u32>,
    /// Bit i: whether the number i before the newest came.
    came: u64,
    pub(super) counts: Counts,
}

impl Gate {
    /// Forgets the numbers: another session begins. The counts go on.
    pub(super) fn restart(&mut self) {
        self.newest = None;
    }

    pub(super) fn admit(&mut self, sequence: u32) -> Result<(), Stale> {
        let ahead = match self.newest {
            // as if the one before had come
            None => 1,
            Some(newest) => sequence.wrapping_sub(newest),
        };
        // half the numbers are newer, half are older: the count may wrap
        if ahead != 0 && ahead <= u32::MAX / 2 {
            self.came = self.came.checked_shl(ahead).unwrap_or(0) | 1;
            self.counts.lost += u64::from(ahead - 1);
            self.counts.taken += 1;
            if self.newest.is_none() {
                // what was before the first was not missed
                self.came = u64::MAX;
            }
            self.newest = Some(sequence);
            return Ok(());
        }
        let behind = ahead.wrapping_neg();
        let bit = 1_u64.checked_shl(behind).unwrap_or(0);
        if behind < WINDOW && self.came & bit == 0 {
            self.came |= bit;
            self.counts.lost -= 1;
            self.counts.late += 1;
            return Err(Stale::Late);
        }
        self.counts.repeated += 1;
        Err(Stale::Repeated)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn newer_passes_and_the_rest_is_told_apart() {
        let mut gate = Gate::default();
        let start = u32::MAX - 1;
        for (ahead, expected) in [
            (0, Ok(())),
            (0, Err(Stale::Repeated)),
            (3, Ok(())),
            (1, Err(Stale::Late)),
            (1, Err(Stale::Repeated)),
            (200, Ok(())),
            (2, Err(Stale::Repeated)),
            (199, Err(Stale::Late)),
        ] {
            assert_eq!(gate.admit(start.wrapping_add(ahead)), expected, "{ahead}");
        }
        let counts = gate.counts;
        assert_eq!((counts.taken, counts.late, counts.repeated), (3, 2, 3));
        assert_eq!(counts.lost, 2 + 196 - 2, "gaps of 2 and 196, two of which came late");
        gate.restart();
        assert_eq!(gate.admit(7), Ok(()), "another session starts anywhere");
        assert_eq!(gate.counts.lost, 196);
    }

    proptest! {
        /// Whatever the network does, what passes only ever goes up, and nothing is counted twice.
        #[test]
        fn only_ever_newer(start in any::<u32>(), steps in prop::collection::vec(0_u32..100, 1..300)) {
            let mut gate = Gate::default();
            let mut newest = None;
            let mut came = std::collections::HashSet::new();
            for step in &steps {
                let passed = gate.admit(start.wrapping_add(*step)).is_ok();
                prop_assert_eq!(passed, newest.is_none_or(|newest| *step > newest));
                if passed {
                    newest = Some(*step);
                }
                came.insert(*step);
            }
            let counts = gate.counts;
            prop_assert_eq!(counts.taken + counts.late + counts.repeated, steps.len() as u64);
            prop_assert!(counts.taken + counts.late <= came.len() as u64);
            let first = steps[0];
            let span = u64::from(newest.unwrap() - first) + 1;
            // late ones from before the first were never missed
            prop_assert_eq!(counts.taken + counts.late + counts.lost, span);
        }
    }
}
