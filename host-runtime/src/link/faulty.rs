//! A link without a network, for tests: two ends in one process, and between them whatever can go wrong.
//!
//! Everything is drawn from a seed and told the time by hand, so a run is the same each time and an hour
//! takes a moment. What the stations see is what they see over QUIC: the same inbox decides what counts.
//! QUIC drops a packet that came before; here copies are handed on to the inbox instead, and damage that
//! [`unseen`](Faults::unseen) says nobody sees, so that what stands behind QUIC is tried as well.

use super::carrier::Carrier;
use super::inbox::{CAMERAS, Dropped, EndedSession, Inbox, Received};
use super::picture::Picture;
use crate::robot::clock::Clock;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use tetrad_core::wire::{EncodeError, MAX_BODY_LEN, Packet, encode_body};

/// What goes wrong on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// The share of packets that are lost: 0 to 1.
    pub loss: f64,
    /// How long each takes, microseconds.
    pub delay_us: u64,
    /// How much longer it takes at most, drawn evenly, microseconds. Where it is more than the time
    /// between packets, they overtake each other.
    pub jitter_us: u64,
    /// The share of packets that come twice, the copy drawn anew from delay and jitter.
    pub duplication: f64,
    /// The share of packets that are damaged: up to eight bits of each are changed. Found and dropped by
    /// a check, as QUIC does by its seal.
    pub corruption: f64,
    /// Damage is not found, and the inbox gets it as it is: what a peer that has gone mad would send.
    pub unseen: bool,
    /// The share of packets that are kept and come again one second later.
    pub replay: f64,
    /// From when until when the cable is cut, microseconds.
    pub cut: Option<(u64, u64)>,
}

/// Bits that damage changes at most.
const DAMAGED_BITS: u64 = 8;

/// How long a kept packet is kept, microseconds.
const REPLAYED_AFTER_US: u64 = 1_000_000;

/// What happened on the way to one end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Carried {
    /// Packets that were sent.
    pub sent: u64,
    /// Copies that came to the inbox.
    pub arrived: u64,
    /// Of those, what was seen to be damaged.
    pub damaged: u64,
    /// Of the others, what the inbox dropped.
    pub dropped: u64,
}

/// One end of the loopback. Clones are the same end.
#[derive(Clone, Debug)]
pub struct FaultyEnd {
    here: Rc<RefCell<Inbox>>,
    /// What is on its way to the other end.
    away: Rc<RefCell<Way>>,
    /// What is on its way to this one.
    back: Rc<RefCell<Way>>,
    clock: Clock,
}

#[derive(Debug)]
struct Way {
    faults: Faults,
    draws: Draws,
    /// By when they arrive, and then in the order they were sent.
    flying: BTreeMap<(u64, u64), Vec<u8>>,
    carried: Carried,
    pictures: [Option<Received<Picture>>; CAMERAS],
    configuration: Option<Vec<u8>>,
}

/// Two ends of a link with a clock that is [given](Clock::given): set it, then ask either end. Faults
/// may differ for the two ways: `[to the second end, to the first]`.
#[must_use]
pub fn pair(seed: u64, faults: [Faults; 2], clock: &Clock) -> [FaultyEnd; 2] {
    let way = |faults, seed| {
        let draws = Draws(seed);
        Rc::new(RefCell::new(Way {
            faults,
            draws,
            flying: BTreeMap::new(),
            carried: Carried::default(),
            pictures: Default::default(),
            configuration: None,
        }))
    };
    let [to_second, to_first] = faults;
    let (to_second, to_first) = (way(to_second, 2 * seed + 1), way(to_first, 2 * seed + 2));
    let end = |away: &Rc<RefCell<Way>>, back: &Rc<RefCell<Way>>| FaultyEnd {
        here: Rc::default(),
        away: Rc::clone(away),
        back: Rc::clone(back),
        clock: clock.clone(),
    };
    [end(&to_second, &to_first), end(&to_first, &to_second)]
}

impl FaultyEnd {
    /// The other end has said which session its packets are of.
    ///
    /// # Errors
    /// [`EndedSession`]
    pub fn begin(&self, session: u32) -> Result<(), EndedSession> {
        self.here.borrow_mut().begin(session)
    }

    /// The other end has this very clock.
    pub fn share_clock(&self) {
        self.here.borrow_mut().share_clock();
    }

    /// From now on something else goes wrong on the way to the other end.
    pub fn set_faults(&self, faults: Faults) {
        self.away.borrow_mut().faults = faults;
    }

    /// What happened on the way to this end.
    #[must_use]
    pub fn carried(&self) -> Carried {
        self.back.borrow().carried
    }

    /// What has arrived by now goes to the inbox, in the order of its arrival.
    fn arrive(&self) {
        let now_us = self.clock.now_us();
        let mut way = self.back.borrow_mut();
        let mut here = self.here.borrow_mut();
        while let Some(entry) = way.flying.first_entry() {
            let (at_us, _) = *entry.key();
            if at_us > now_us {
                break;
            }
            let sealed = entry.remove();
            way.carried.arrived += 1;
            let Some((body, check)) = sealed.split_last_chunk() else { continue };
            if !way.faults.unseen && *check != check_of(body) {
                way.carried.damaged += 1;
                continue;
            }
            let taken: Result<(), Dropped> = here.take(body, at_us);
            way.carried.dropped += u64::from(taken.is_err());
        }
    }
}

impl Carrier for FaultyEnd {
    fn send(&self, packet: &Packet) -> Result<(), EncodeError> {
        let mut body = [0; MAX_BODY_LEN];
        let length = encode_body(packet, &mut body)?;
        self.away.borrow_mut().send(body.get(..length).unwrap_or_default(), self.clock.now_us());
        Ok(())
    }

    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R {
        self.arrive();
        look(&mut self.here.borrow_mut())
    }

    // packets alone go wrong here: pictures and configurations are on streams, which come whole or not

    fn send_picture(&self, picture: Picture) {
        let (camera, received_us) = (usize::from(picture.camera), self.clock.now_us());
        let captured_us = Some(picture.capture_us);
        if let Some(slot) = self.away.borrow_mut().pictures.get_mut(camera) {
            *slot = Some(Received { what: picture, received_us, captured_us });
        }
    }

    fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        self.back.borrow_mut().pictures.get_mut(usize::from(camera))?.take()
    }

    fn tell_configuration(&self, configuration: &[u8]) {
        self.away.borrow_mut().configuration = Some(configuration.to_vec());
    }

    fn configuration(&self) -> Option<Vec<u8>> {
        self.back.borrow_mut().configuration.take()
    }
}

impl Way {
    fn send(&mut self, body: &[u8], now_us: u64) {
        self.carried.sent += 1;
        let faults = self.faults;
        let cut = faults.cut.is_some_and(|(from_us, until_us)| (from_us..until_us).contains(&now_us));
        // drawn in every case, so that one fault does not change what becomes of the others
        let [lost, twice, damaged, kept] =
            [faults.loss, faults.duplication, faults.corruption, faults.replay]
                .map(|share| self.draws.share() < share);
        let mut sealed = [body, &check_of(body)].concat();
        let bits = 1 + self.draws.below(DAMAGED_BITS);
        for _ in 0..bits {
            let bit = self.draws.below(8 * sealed.len() as u64);
            if damaged && let Some(byte) = sealed.get_mut(usize::try_from(bit / 8).unwrap_or(0)) {
                *byte ^= 1 << (bit % 8);
            }
        }
        let takes = [(); 3].map(|()| faults.delay_us + self.draws.below(faults.jitter_us + 1));
        if cut {
            return;
        }
        let number = 3 * self.carried.sent;
        let copies = [!lost, twice, kept];
        for (place, (copied, takes_us)) in (0..).zip(copies.into_iter().zip(takes)) {
            let later_us = if place == 2 { REPLAYED_AFTER_US } else { 0 };
            if copied {
                self.flying.insert((now_us + takes_us + later_us, number + place), sealed.clone());
            }
        }
    }
}

/// What tells a packet from one that was damaged: FNV-1a, 64 bits, in place of QUIC's seal.
fn check_of(body: &[u8]) -> [u8; 8] {
    let hash = body.iter().fold(0xCBF2_9CE4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01B3)
    });
    hash.to_le_bytes()
}

/// SplitMix64 (Steele, Lea, Flood 2014): enough for a network, and the same everywhere.
#[derive(Debug)]
struct Draws(u64);

impl Draws {
    fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// 0 to 1, without 1.
    fn share(&mut self) -> f64 {
        (self.draw() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Less than `bound`; 0 where that is 0.
    fn below(&mut self, bound: u64) -> u64 {
        self.draw().checked_rem(bound).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;
