//! Which commands count: those of one sender, each newer than the last. Nothing is queued.

use super::command::CommandRefusal;

/// Sessions that have ended and are remembered, so that what is left of them in the network is not
/// taken for a new sender.
const RETIRED: usize = 8;

/// How many commands came, and what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Taken.
    pub taken: u32,
    /// Never seen before a newer one was taken: lost, or late (then they are in `old` as well).
    pub missed: u32,
    /// Dropped: no newer than one taken before.
    pub old: u32,
    /// Dropped: of a session that has ended.
    pub old_session: u32,
    /// Dropped: of a second sender.
    pub another_sender: u32,
    /// Dropped: numbers that cannot be used.
    pub bad: u32,
}

/// The sender that is listened to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sender {
    session: u32,
    sequence: u32,
    received_us: u64,
}

/// Drops what is old or of somebody else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Inbox {
    sender: Option<Sender>,
    /// A ring: `next` is written next.
    retired: [Option<u32>; RETIRED],
    next: usize,
    pub(super) counts: Counts,
}

/// What a command that counts is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admitted {
    /// The next of the sender that is listened to.
    Next,
    /// The first of a sender.
    NewSender,
}

impl Inbox {
    pub(super) const fn new() -> Self {
        Self {
            sender: None,
            retired: [None; RETIRED],
            next: 0,
            counts: Counts { taken: 0, missed: 0, old: 0, old_session: 0, another_sender: 0, bad: 0 },
        }
    }

    /// Whether a command counts. A sender that has been silent for over `silence_us` may be followed
    /// by another one.
    pub(super) fn admit(
        &mut self,
        session: u32,
        sequence: u32,
        received_us: u64,
        silence_us: u32,
    ) -> Result<Admitted, CommandRefusal> {
        let admitted = match self.sender {
            Some(sender) if sender.session == session => {
                // half the numbers are newer, half are older: the count may wrap
                let ahead = sequence.wrapping_sub(sender.sequence);
                if ahead == 0 || ahead > u32::MAX / 2 {
                    self.counts.old = self.counts.old.saturating_add(1);
                    return Err(CommandRefusal::Old);
                }
                self.counts.missed = self.counts.missed.saturating_add(ahead - 1);
                Admitted::Next
            }
            _ if self.retired.contains(&Some(session)) => {
                self.counts.old_session = self.counts.old_session.saturating_add(1);
                return Err(CommandRefusal::OldSession);
            }
            Some(sender) if received_us.saturating_sub(sender.received_us) <= u64::from(silence_us) => {
                self.counts.another_sender = self.counts.another_sender.saturating_add(1);
                return Err(CommandRefusal::AnotherSender);
            }
            Some(sender) => {
                self.retire(sender.session);
                Admitted::NewSender
            }
            None => Admitted::NewSender,
        };
        self.sender = Some(Sender { session, sequence, received_us });
        self.counts.taken = self.counts.taken.saturating_add(1);
        Ok(admitted)
    }

    /// The sender that is listened to has ended: the next command is of whoever comes.
    pub(super) fn end_sender(&mut self) {
        if let Some(sender) = self.sender.take() {
            self.retire(sender.session);
        }
    }

    /// The clock was set to `now_us`: nothing came later than that.
    pub(super) fn rewind(&mut self, now_us: u64) {
        if let Some(sender) = &mut self.sender {
            sender.received_us = sender.received_us.min(now_us);
        }
    }

    fn retire(&mut self, session: u32) {
        if let Some(slot) = self.retired.get_mut(self.next) {
            *slot = Some(session);
        }
        self.next = (self.next + 1) % RETIRED;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILENCE_US: u32 = 500_000;

    fn admit(inbox: &mut Inbox, session: u32, sequence: u32, at_us: u64) -> Result<Admitted, CommandRefusal> {
        inbox.admit(session, sequence, at_us, SILENCE_US)
    }

    #[test]
    fn only_what_is_newer_counts_also_across_the_wrap() {
        let mut inbox = Inbox::new();
        let start = u32::MAX - 2;
        assert_eq!(admit(&mut inbox, 7, start, 0), Ok(Admitted::NewSender));
        for (sequence, expected) in [
            (start, Err(CommandRefusal::Old)),
            (start.wrapping_add(1), Ok(Admitted::Next)),
            (start.wrapping_add(4), Ok(Admitted::Next)),
            (start.wrapping_add(2), Err(CommandRefusal::Old)),
            (start.wrapping_add(4), Err(CommandRefusal::Old)),
            (start, Err(CommandRefusal::Old)),
            (start.wrapping_add(5), Ok(Admitted::Next)),
        ] {
            assert_eq!(admit(&mut inbox, 7, sequence, 1), expected, "{sequence}");
        }
        let counts = inbox.counts;
        assert_eq!((counts.taken, counts.missed, counts.old), (4, 2, 4));
    }

    #[test]
    fn a_second_sender_is_refused_until_the_first_is_silent_and_the_first_never_comes_back() {
        let mut inbox = Inbox::new();
        assert_eq!(admit(&mut inbox, 1, 10, 0), Ok(Admitted::NewSender));
        assert_eq!(admit(&mut inbox, 2, 0, 500_000), Err(CommandRefusal::AnotherSender));
        assert_eq!(admit(&mut inbox, 2, 1, 500_001), Ok(Admitted::NewSender));
        assert_eq!(admit(&mut inbox, 1, 11, 2_000_000), Err(CommandRefusal::OldSession));
        assert_eq!(admit(&mut inbox, 2, 2, 2_000_000), Ok(Admitted::Next));
        assert_eq!((inbox.counts.another_sender, inbox.counts.old_session), (1, 1));
    }
}
