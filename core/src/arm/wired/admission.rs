//! Which packets of a serial line count: those of the newest session, each newer than all of its kind before.

/// Sessions that have ended and are remembered: what is left of them in some buffer is not taken for new.
const RETIRED: usize = 8;

/// The kinds of packets that an operator sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Motion,
    Buttons,
}

/// What has come so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Admission {
    session: Option<u32>,
    /// A ring: `next` is written next.
    retired: [Option<u32>; RETIRED],
    next: usize,
    /// The newest number of each kind.
    motion: Option<u32>,
    buttons: Option<u32>,
}

/// What a packet that counts is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admitted {
    /// Newer than those before.
    Next,
    /// The first of a session.
    NewSession,
}

impl Admission {
    /// Whether a packet counts; `None` where it does not.
    pub(super) fn admit(&mut self, kind: Kind, session: u32, sequence: u32) -> Option<Admitted> {
        let mut admitted = Admitted::Next;
        if self.session != Some(session) {
            if self.retired.contains(&Some(session)) {
                return None;
            }
            if let Some(ended) = self.session.replace(session) {
                self.retire(ended);
            }
            (self.motion, self.buttons) = (None, None);
            admitted = Admitted::NewSession;
        }
        let newest = match kind {
            Kind::Motion => &mut self.motion,
            Kind::Buttons => &mut self.buttons,
        };
        // half the numbers are newer, half are older: the count may wrap
        let ahead = newest.map_or(1, |newest| sequence.wrapping_sub(newest));
        if ahead == 0 || ahead > u32::MAX / 2 {
            return None;
        }
        *newest = Some(sequence);
        Some(admitted)
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

    #[test]
    fn each_kind_goes_up_on_its_own_also_across_the_wrap() {
        let mut admission = Admission::default();
        assert_eq!(admission.admit(Kind::Motion, 7, u32::MAX), Some(Admitted::NewSession));
        assert_eq!(admission.admit(Kind::Buttons, 7, 3), Some(Admitted::Next));
        for (kind, sequence, expected) in [
            (Kind::Motion, u32::MAX, None),
            (Kind::Motion, 1, Some(Admitted::Next)),
            (Kind::Motion, 0, None),
            (Kind::Buttons, 2, None),
            (Kind::Buttons, 4, Some(Admitted::Next)),
        ] {
            assert_eq!(admission.admit(kind, 7, sequence), expected, "{kind:?} {sequence}");
        }
    }

    #[test]
    fn a_session_that_was_followed_by_another_never_comes_back() {
        let mut admission = Admission::default();
        admission.admit(Kind::Motion, 1, 5);
        assert_eq!(admission.admit(Kind::Buttons, 2, 0), Some(Admitted::NewSession));
        assert_eq!(admission.admit(Kind::Motion, 1, 6), None);
        assert_eq!(admission.admit(Kind::Motion, 2, 0), Some(Admitted::Next));
    }
}
