//! What is to go to one peer: of each kind the newest that has not gone. No queue.

use super::inbox::CAMERAS;
use crate::locked::lock;
use bytes::Bytes;
use std::sync::{Mutex, MutexGuard};
use tetrad_core::wire::{EncodeError, MAX_BODY_LEN, Packet, encode_body};
use tokio::sync::Notify;

/// The slots of packets: motion, buttons, the arm's state, and one for each camera.
pub(super) const PACKETS: usize = 3 + CAMERAS;

/// N slots, and what wakes whoever sends from them.
#[derive(Debug)]
pub(super) struct Outbox<const N: usize> {
    slots: Mutex<Slots<N>>,
    filled: Notify,
}

#[derive(Debug)]
struct Slots<const N: usize> {
    bodies: [Option<Bytes>; N],
    /// The slot looked at first, so that no kind waits for another for ever.
    first: usize,
    counts: OutboxCounts,
}

/// What became of what was to be sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutboxCounts {
    /// Handed to the network.
    pub sent: u64,
    /// Never sent: a newer one of its kind took its place, or nobody was there to take it. Pictures that were
    /// given up on their way too.
    pub overtaken: u64,
}

impl<const N: usize> Default for Outbox<N> {
    fn default() -> Self {
        let slots = Slots { bodies: [const { None }; N], first: 0, counts: OutboxCounts::default() };
        Self { slots: Mutex::new(slots), filled: Notify::new() }
    }
}

impl Outbox<PACKETS> {
    pub(super) fn put_packet(&self, packet: &Packet) -> Result<(), EncodeError> {
        let mut body = [0; MAX_BODY_LEN];
        let length = encode_body(packet, &mut body)?;
        let slot = match packet {
            // a smart camera's, on its serial line: no peer of a link takes them
            Packet::Command(_) | Packet::Notice(_) | Packet::Preview(_) | Packet::Shown(_) => return Ok(()),
            Packet::Motion(_) => 0,
            Packet::Buttons(_) => 1,
            Packet::ArmState(_) => 2,
            Packet::Observation(packet) => 3 + usize::from(packet.camera) % CAMERAS,
        };
        self.put(slot, Bytes::copy_from_slice(body.get(..length).unwrap_or_default()));
        Ok(())
    }
}

impl<const N: usize> Outbox<N> {
    /// Slots are counted round: the one behind the last is the first.
    pub(super) fn put(&self, slot: usize, body: Bytes) {
        let mut slots = self.lock();
        if slots.bodies.get_mut(slot % N).and_then(|place| place.replace(body)).is_some() {
            slots.counts.overtaken += 1;
        }
        drop(slots);
        self.filled.notify_one();
    }

    /// Waits until there is something to send.
    pub(super) async fn ready(&self) {
        while self.lock().bodies.iter().all(Option::is_none) {
            self.filled.notified().await;
        }
    }

    /// What goes next; each slot has its turn.
    pub(super) fn take(&self) -> Option<Bytes> {
        let mut slots = self.lock();
        let first = slots.first;
        let (at, body) =
            (first..first + N).find_map(|at| Some((at, slots.bodies.get_mut(at % N)?.take()?)))?;
        slots.first = (at + 1) % N;
        Some(body)
    }

    /// Drops what has not gone: nobody was there to take it, and it is old now.
    pub(super) fn clear(&self) {
        let mut slots = self.lock();
        let dropped = slots.bodies.iter_mut().filter_map(Option::take).count();
        slots.counts.overtaken += dropped as u64;
    }

    pub(super) fn count_sent(&self) {
        self.lock().counts.sent += 1;
    }

    /// What was sent did not arrive in time, and is not sent any more.
    pub(super) fn count_given_up(&self) {
        self.lock().counts.overtaken += 1;
    }

    pub(super) fn counts(&self) -> OutboxCounts {
        self.lock().counts
    }

    fn lock(&self) -> MutexGuard<'_, Slots<N>> {
        lock(&self.slots)
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_packets::{body, buttons, motion, observation};
    use super::*;

    #[test]
    fn the_newest_of_each_kind_goes_and_none_starves() {
        let outbox = Outbox::default();
        outbox.put_packet(&motion(1, 1)).unwrap();
        outbox.put_packet(&observation(1, 1, 0)).unwrap();
        outbox.put_packet(&buttons(1, 1, true)).unwrap();
        outbox.put_packet(&motion(1, 2)).unwrap();
        assert_eq!(outbox.take().unwrap(), body(&motion(1, 2)));
        outbox.put_packet(&motion(1, 3)).unwrap();
        assert_eq!(outbox.take().unwrap(), body(&buttons(1, 1, true)));
        assert_eq!(outbox.take().unwrap(), body(&observation(1, 1, 0)));
        assert_eq!(outbox.take().unwrap(), body(&motion(1, 3)));
        assert_eq!(outbox.take(), None);
        assert_eq!(outbox.counts().overtaken, 1);
        outbox.put_packet(&motion(1, 4)).unwrap();
        outbox.clear();
        assert_eq!((outbox.take(), outbox.counts().overtaken), (None, 2));
    }
}
