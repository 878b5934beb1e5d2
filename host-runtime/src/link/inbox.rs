//! What came from one peer: of each kind the newest, and what became of the rest. No queue.

use super::clock::{Exchange, OtherClock};
use super::gate::{Counts, Gate, Stale};
use std::collections::VecDeque;
use tetrad_core::wire::{
    ArmStatePacket, ButtonsPacket, DecodeError, MotionPacket, ObservationPacket, Packet, decode_body,
};

/// Cameras whose observations a peer may send: as many as there are views.
pub const CAMERAS: usize = 8;

/// Sessions of a peer that have ended and are remembered.
const RETIRED: usize = 8;

/// Something that came, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Received<P> {
    /// What came.
    pub what: P,
    /// When, on this station's clock, microseconds. What is safe to do is told by this time alone.
    pub received_us: u64,
    /// When it was captured, as this station's clock would have shown it; `None` while the other
    /// station's clock is not known.
    pub captured_us: Option<u64>,
}

impl<P> Received<P> {
    /// Microseconds since it came.
    #[must_use]
    pub const fn age_us(&self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.received_us)
    }
}

/// Why a datagram was dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Dropped {
    /// It came before the peer had said which session is its.
    #[error("the peer has not said which session is its")]
    NoSession,
    /// It is of another session.
    #[error("it is of another session")]
    OtherSession,
    /// A newer one had come.
    #[error("a newer one had come")]
    Late,
    /// It had come before.
    #[error("it had come before")]
    Repeated,
    /// A camera that there cannot be.
    #[error("camera {0}: there are at most {CAMERAS}")]
    NoSuchCamera(u8),
    /// It is no packet.
    #[error("it is no packet: {0}")]
    NoPacket(DecodeError),
}

/// A session that may not begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it says it is of session {0:08x}, which has ended: two stations run with the same name and key")]
pub struct EndedSession(pub u32);

#[derive(Clone, Copy, Debug)]
struct Newest<P> {
    gate: Gate,
    newest: Option<(P, u64)>,
}

impl<P> Default for Newest<P> {
    fn default() -> Self {
        Self { gate: Gate::default(), newest: None }
    }
}

impl<P: Copy> Newest<P> {
    fn put(&mut self, sequence: u32, packet: P, now_us: u64) -> Result<(), Dropped> {
        self.gate.admit(sequence).map_err(|stale| match stale {
            Stale::Late => Dropped::Late,
            Stale::Repeated => Dropped::Repeated,
        })?;
        if self.newest.replace((packet, now_us)).is_some() {
            self.gate.counts.overtaken += 1;
        }
        Ok(())
    }

    fn restart(&mut self) {
        self.gate.restart();
        self.newest = None;
    }
}

/// What became of the datagrams of a peer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InboxCounts {
    /// Of motion.
    pub motion: Counts,
    /// Of the operator's buttons.
    pub buttons: Counts,
    /// Of the arm's state.
    pub arm_state: Counts,
    /// Of each camera's observations.
    pub observations: [Counts; CAMERAS],
    /// Of no session, or of another than the peer's.
    pub other_session: u64,
    /// Those that are no packets.
    pub no_packet: u64,
}

/// The newest of each kind from one peer. Plain data: it knows no sockets and reads no clock.
#[derive(Clone, Debug, Default)]
pub struct Inbox {
    session: Option<u32>,
    retired: VecDeque<u32>,
    motion: Newest<MotionPacket>,
    buttons: Newest<ButtonsPacket>,
    arm_state: Newest<ArmStatePacket>,
    observations: [Newest<ObservationPacket>; CAMERAS],
    other_session: u64,
    no_packet: u64,
    heard_us: Option<u64>,
    pub(super) clock: OtherClock,
}

impl Inbox {
    /// The peer has said which session its packets are of. Where it is the one before, its numbers go
    /// on; where it is another, what came of the one before is dropped.
    ///
    /// # Errors
    /// [`EndedSession`]: a session that was followed by another never comes back.
    pub fn begin(&mut self, session: u32) -> Result<(), EndedSession> {
        if self.session == Some(session) {
            return Ok(());
        }
        if self.retired.contains(&session) {
            return Err(EndedSession(session));
        }
        if let Some(ended) = self.session.replace(session) {
            self.retired.push_back(ended);
            if self.retired.len() > RETIRED {
                self.retired.pop_front();
            }
        }
        self.motion.restart();
        self.buttons.restart();
        self.arm_state.restart();
        self.observations.iter_mut().for_each(Newest::restart);
        // another session may be another computer
        self.clock = OtherClock::default();
        Ok(())
    }

    /// The other station has this very clock, as within one process: nothing has to be measured.
    pub fn share_clock(&mut self) {
        self.clock = OtherClock::default();
        self.clock.take(&Exchange { asked_us: 0, heard_us: 0, answered_us: 0, back_us: 0 });
    }

    /// The peer's session, once it has said it.
    #[must_use]
    pub const fn session(&self) -> Option<u32> {
        self.session
    }

    /// Takes a datagram that came at a time of this station's clock, microseconds.
    ///
    /// # Errors
    /// Why it was [`Dropped`]; it is counted.
    pub fn take(&mut self, body: &[u8], now_us: u64) -> Result<(), Dropped> {
        let packet = decode_body(body).map_err(|reason| {
            self.no_packet += 1;
            Dropped::NoPacket(reason)
        })?;
        let expected = self.session.ok_or(Dropped::NoSession);
        if expected != Ok(packet.session()) {
            self.other_session += 1;
            return Err(expected.err().unwrap_or(Dropped::OtherSession));
        }
        let sequence = packet.sequence();
        match packet {
            Packet::Motion(packet) => self.motion.put(sequence, packet, now_us),
            Packet::Buttons(packet) => self.buttons.put(sequence, packet, now_us),
            Packet::ArmState(packet) => self.arm_state.put(sequence, packet, now_us),
            Packet::Command(_) | Packet::Notice(_) | Packet::Preview(_) | Packet::Shown(_) => {
                self.no_packet += 1;
                Err(Dropped::NoPacket(DecodeError::UnknownKind(body.get(1).copied().unwrap_or_default())))
            }
            Packet::Observation(packet) => match self.observations.get_mut(usize::from(packet.camera)) {
                Some(newest) => newest.put(sequence, packet, now_us),
                None => {
                    self.no_packet += 1;
                    Err(Dropped::NoSuchCamera(packet.camera))
                }
            },
        }?;
        self.heard_us = Some(now_us);
        Ok(())
    }

    /// The newest motion, if it was not taken yet.
    pub fn motion(&mut self) -> Option<Received<MotionPacket>> {
        let (packet, at_us) = self.motion.newest.take()?;
        Some(self.received(packet, packet.capture_us, at_us))
    }

    /// The newest state of the operator's buttons, if it was not taken yet.
    pub fn buttons(&mut self) -> Option<Received<ButtonsPacket>> {
        let (packet, at_us) = self.buttons.newest.take()?;
        Some(self.received(packet, packet.time_us, at_us))
    }

    /// The newest state of the arm, if it was not taken yet.
    pub fn arm_state(&mut self) -> Option<Received<ArmStatePacket>> {
        let (packet, at_us) = self.arm_state.newest.take()?;
        Some(self.received(packet, packet.time_us, at_us))
    }

    /// The newest observations of a camera, if they were not taken yet.
    pub fn observation(&mut self, camera: u8) -> Option<Received<ObservationPacket>> {
        let (packet, at_us) = self.observations.get_mut(usize::from(camera))?.newest.take()?;
        Some(self.received(packet, packet.capture_us, at_us))
    }

    /// What became of the datagrams.
    #[must_use]
    pub fn counts(&self) -> InboxCounts {
        InboxCounts {
            motion: self.motion.gate.counts,
            buttons: self.buttons.gate.counts,
            arm_state: self.arm_state.gate.counts,
            observations: self.observations.map(|newest| newest.gate.counts),
            other_session: self.other_session,
            no_packet: self.no_packet,
        }
    }

    /// When the last packet that counts came.
    #[must_use]
    pub const fn heard_us(&self) -> Option<u64> {
        self.heard_us
    }

    fn received<P>(&self, what: P, capture_us: u64, received_us: u64) -> Received<P> {
        Received { what, received_us, captured_us: self.clock.here_us(capture_us, received_us) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_packets::{body, buttons, motion, observation};
    use super::*;

    #[test]
    fn the_newest_of_each_kind_once() {
        let mut inbox = Inbox::default();
        inbox.begin(7).unwrap();
        for sequence in [1, 2, 3] {
            inbox.take(&body(&motion(7, sequence)), 100 + u64::from(sequence)).unwrap();
        }
        inbox.take(&body(&buttons(7, 9, true)), 200).unwrap();
        inbox.take(&body(&observation(7, 4, 1)), 300).unwrap();
        let newest = inbox.motion().unwrap();
        assert_eq!((newest.what.sequence, newest.received_us, newest.age_us(150)), (3, 103, 47));
        assert_eq!(newest.captured_us, None, "the other clock is not known");
        assert_eq!(inbox.motion(), None, "once");
        assert!(inbox.buttons().unwrap().what.pressed);
        assert_eq!(inbox.observation(0), None);
        assert_eq!(inbox.observation(1).unwrap().what.sequence, 4);
        assert_eq!(inbox.observation(200), None);
        assert_eq!((inbox.counts().motion.taken, inbox.counts().motion.overtaken), (3, 2));
        assert_eq!(inbox.heard_us(), Some(300));
    }

    #[test]
    fn old_and_foreign_packets_never_come_through() {
        let mut inbox = Inbox::default();
        let early = inbox.take(&body(&motion(7, 1)), 1);
        assert_eq!(early, Err(Dropped::NoSession));
        inbox.begin(7).unwrap();
        for (packet, expected) in [
            (motion(7, 5), Ok(())),
            (motion(7, 5), Err(Dropped::Repeated)),
            (motion(7, 7), Ok(())),
            (motion(7, 6), Err(Dropped::Late)),
            (motion(6, 8), Err(Dropped::OtherSession)),
            (observation(7, 1, 8), Err(Dropped::NoSuchCamera(8))),
        ] {
            assert_eq!(inbox.take(&body(&packet), 2), expected, "{packet:?}");
        }
        assert_eq!(inbox.take(&[1, 2, 3], 2), Err(Dropped::NoPacket(DecodeError::UnknownVersion(1))));
        assert_eq!((inbox.counts().other_session, inbox.counts().no_packet), (2, 2));
    }

    #[test]
    fn a_session_that_goes_on_keeps_its_numbers_and_one_that_has_ended_stays_so() {
        let mut inbox = Inbox::default();
        inbox.begin(7).unwrap();
        inbox.take(&body(&motion(7, 5)), 1).unwrap();
        inbox.begin(7).unwrap();
        let replayed = inbox.take(&body(&motion(7, 5)), 2);
        assert_eq!(replayed, Err(Dropped::Repeated), "after a reconnection as before it");
        assert!(inbox.motion().is_some());
        inbox.take(&body(&motion(7, 6)), 3).unwrap();
        inbox.begin(8).unwrap();
        assert_eq!(inbox.motion(), None, "what the last session left is dropped");
        assert_eq!(inbox.take(&body(&motion(7, 7)), 4), Err(Dropped::OtherSession));
        assert_eq!(inbox.take(&body(&motion(8, 0)), 4), Ok(()));
        assert_eq!(inbox.begin(7), Err(EndedSession(7)));
        assert_eq!(inbox.session(), Some(8));
    }
}
