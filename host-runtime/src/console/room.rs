//! Room for connections: a bounded number, and who gives way where there is none left.
//!
//! Whoever connects has shown nothing yet. Where all room is taken, one leaves for each that comes:
//!
//! 1. a stranger, whose connection has brought no request that this console trusts: of the network with most
//!    of them the one that has been here longest, so that a crowd at one address holds out nobody elsewhere;
//! 2. where there is none, of those who are known the one that has asked for nothing for longest.
//!
//! WebSockets stay: there is a lower bound for those (`app`), and who drives has one.

use super::desk::Desk;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

/// See the [module's text](self).
#[derive(Clone, Debug)]
pub(super) struct Room {
    desk: Desk,
    permits: Arc<Semaphore>,
    crowd: Arc<Mutex<Crowd>>,
}

/// What a connection holds while it is open.
#[derive(Debug)]
pub(super) struct Place {
    room: Room,
    number: u64,
    leave: Arc<Notify>,
    _permit: OwnedSemaphorePermit,
}

/// What a connection's requests bring along, to tell how far it is trusted.
#[derive(Clone, Debug)]
pub(super) struct Ticket {
    crowd: Arc<Mutex<Crowd>>,
    number: u64,
}

/// Those who are here and may be asked to leave.
#[derive(Debug, Default)]
struct Crowd {
    /// Counts arrivals and requests up: the order in which they came.
    order: u64,
    members: Vec<Member>,
}

#[derive(Debug)]
struct Member {
    number: u64,
    network: IpAddr,
    standing: Standing,
    leave: Arc<Notify>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    /// Nothing that is trusted has come.
    Stranger,
    /// Something has, the last of it then.
    Known { asked: u64 },
    /// It is a WebSocket.
    Stays,
}

impl Room {
    /// Room for so many.
    pub(super) fn new(desk: Desk, size: usize) -> Self {
        Self { desk, permits: Arc::new(Semaphore::new(size)), crowd: Arc::default() }
    }

    /// A place for a connection from there; `None` where everybody stays.
    pub(super) async fn admit(&self, from: IpAddr) -> Option<Place> {
        let permit = match Arc::clone(&self.permits).try_acquire_owned() {
            Ok(permit) => permit,
            Err(_) => {
                self.desk.counts().crowded_out.fetch_add(1, Ordering::Relaxed);
                if !lock(&self.crowd).make_way() {
                    return None;
                }
                // whoever is told to leave does so at its next turn
                Arc::clone(&self.permits).acquire_owned().await.ok()?
            }
        };
        let (number, leave) = lock(&self.crowd).join(from);
        self.desk.counts().sockets.fetch_add(1, Ordering::Relaxed);
        Some(Place { room: self.clone(), number, leave, _permit: permit })
    }
}

impl Place {
    pub(super) fn ticket(&self) -> Ticket {
        Ticket { crowd: Arc::clone(&self.room.crowd), number: self.number }
    }

    /// Tells when it has to go.
    pub(super) fn leave(&self) -> Arc<Notify> {
        Arc::clone(&self.leave)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        lock(&self.room.crowd).members.retain(|member| member.number != self.number);
        self.room.desk.counts().sockets.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Ticket {
    /// A request came that is trusted.
    pub(super) fn is_known(&self) {
        let mut crowd = lock(&self.crowd);
        crowd.order += 1;
        let asked = crowd.order;
        crowd.set(self.number, Standing::Known { asked });
    }

    /// It has become a WebSocket.
    pub(super) fn stays(&self) {
        lock(&self.crowd).set(self.number, Standing::Stays);
    }
}

impl Crowd {
    fn join(&mut self, from: IpAddr) -> (u64, Arc<Notify>) {
        self.order += 1;
        let leave = Arc::new(Notify::new());
        let (number, network) = (self.order, network(from));
        self.members.push(Member {
            number,
            network,
            standing: Standing::Stranger,
            leave: Arc::clone(&leave),
        });
        (number, leave)
    }

    fn set(&mut self, number: u64, standing: Standing) {
        if let Some(member) = self.members.iter_mut().find(|member| member.number == number) {
            member.standing = standing;
        }
    }

    /// Tells one to leave; false where all stay.
    fn make_way(&mut self) -> bool {
        let strangers = |network: IpAddr| {
            let of = |member: &&Member| member.standing == Standing::Stranger && member.network == network;
            self.members.iter().filter(of).count()
        };
        // the largest of these leaves: strangers before those who are known, the older before the newer
        let first = self.members.iter().enumerate().filter_map(|(at, member)| match member.standing {
            Standing::Stranger => Some((strangers(member.network), u64::MAX - member.number, at)),
            Standing::Known { asked } => Some((0, u64::MAX - asked, at)),
            Standing::Stays => None,
        });
        let Some((_, _, at)) = first.max() else { return false };
        self.members.swap_remove(at).leave.notify_one();
        true
    }
}

/// Those addresses of which one computer can take any: of IPv6 those with the same first 64 bits.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64)),
        address => address,
    }
}

fn lock(crowd: &Mutex<Crowd>) -> MutexGuard<'_, Crowd> {
    // what it guards is whole between any two statements
    crowd.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
