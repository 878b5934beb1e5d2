use super::*;
use crate::link::Doorbell;
use crate::robot::clock::Clock;
use std::time::Duration;
use tokio::time::timeout;

/// A room, and what leaves it when it is told to, as a connection does.
struct Door(Room);

impl Door {
    fn new(size: usize) -> Self {
        Self(Room::new(Desk::new(true, Vec::new(), Clock::given(), Doorbell::default()), size))
    }

    async fn admit(&self, from: &str) -> Option<Ticket> {
        let place = timeout(Duration::from_secs(60), self.0.admit(from.parse().unwrap()));
        let place = place.await.expect("nobody waits for room")?;
        let (ticket, leave) = (place.ticket(), place.leave());
        tokio::spawn(async move {
            leave.notified().await;
            drop(place);
        });
        Some(ticket)
    }

    fn has(&self, ticket: &Ticket) -> bool {
        lock(&self.0.crowd).members.iter().any(|member| member.number == ticket.number)
    }

    fn counted(&self) -> (usize, u64) {
        let counts = self.0.desk.counts();
        (counts.sockets.load(Ordering::Relaxed), counts.crowded_out.load(Ordering::Relaxed))
    }
}

#[tokio::test]
async fn the_stranger_that_was_here_longest_gives_way() {
    let door = Door::new(3);
    let known = door.admit("10.0.0.1").await.unwrap();
    known.is_known();
    let (first, second) = (door.admit("10.0.0.1").await.unwrap(), door.admit("10.0.0.1").await.unwrap());
    assert_eq!(door.counted(), (3, 0));
    let third = door.admit("10.0.0.1").await.unwrap();
    let here = [&known, &first, &second, &third].map(|ticket| door.has(ticket));
    assert_eq!(here, [true, false, true, true]);
    assert_eq!(door.counted(), (3, 1));
}

#[tokio::test]
async fn a_crowd_holds_out_nobody_of_another_network() {
    let door = Door::new(8);
    let waiting = door.admit("2001:db8:1::1").await.unwrap();
    for host in 1..200 {
        // a computer that has a whole network of addresses is no crowd of its own
        door.admit(&format!("2001:db8:2::{host:x}")).await.unwrap();
    }
    assert!(door.has(&waiting));
    // nor is one that speaks IPv4 through a socket of IPv6
    assert_eq!(network("::ffff:10.0.0.1".parse().unwrap()), "10.0.0.1".parse::<IpAddr>().unwrap());
}

#[tokio::test]
async fn who_asks_stays_and_without_strangers_the_one_that_is_silent_for_longest_goes() {
    let door = Door::new(3);
    let mut tickets = Vec::new();
    for _ in 0..3 {
        let ticket = door.admit("127.0.0.1").await.unwrap();
        ticket.is_known();
        tickets.push(ticket);
    }
    tickets[0].is_known();
    door.admit("127.0.0.1").await.unwrap().stays();
    let here: Vec<bool> = tickets.iter().map(|ticket| door.has(ticket)).collect();
    assert_eq!(here, [true, false, true]);
    // where all stay nobody else comes in, and who has gone is not asked for
    tickets[0].stays();
    tickets[1].stays();
    tickets[2].stays();
    assert!(door.admit("127.0.0.1").await.is_none());
    assert_eq!(door.counted(), (3, 2));
}
