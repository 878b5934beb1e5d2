//! Which stations have announced themselves on the local network, and which address to try next.
//!
//! Whoever is on the network may announce anything under any name: what is kept is bounded, and an address
//! is no more than a place to dial. Who answers there is decided by the certificates.

use super::name::StationName;
use std::net::{IpAddr, SocketAddr};

/// Announcements that are kept for a name: the station's own and those of whoever uses its name. The oldest
/// goes first.
const ANNOUNCEMENTS: usize = 4;

/// Addresses that are kept of an announcement: a computer has few.
const ADDRESSES: usize = 8;

/// See the [module's text](self).
#[derive(Debug)]
pub(super) struct Announced {
    peers: Vec<(StationName, Vec<Announcement>)>,
    /// Loopback addresses count: only where nothing else is listened to.
    loopback: bool,
}

#[derive(Debug)]
struct Announcement {
    /// What the network calls it.
    instance: String,
    addresses: Vec<SocketAddr>,
}

impl Announced {
    /// Nothing was heard yet; only these names count.
    pub(super) fn of(peers: impl IntoIterator<Item = StationName>, loopback: bool) -> Self {
        Self { peers: peers.into_iter().map(|name| (name, Vec::new())).collect(), loopback }
    }

    /// Somebody announces a station of that name.
    pub(super) fn hear(&mut self, instance: &str, name: &str, addresses: &[IpAddr], port: u16) {
        let usable = |address: &&IpAddr| self.loopback || !address.is_loopback();
        let mut usable: Vec<_> = addresses.iter().filter(usable).copied().filter(can_be_dialled).collect();
        usable.sort_by_key(|address| (rank(address), *address));
        usable.truncate(ADDRESSES);
        let addresses: Vec<_> = usable.into_iter().map(|address| SocketAddr::new(address, port)).collect();
        self.forget(instance);
        let Some((_, heard)) = self.peers.iter_mut().find(|(peer, _)| peer.as_str() == name) else { return };
        if port == 0 || addresses.is_empty() {
            return;
        }
        if heard.len() >= ANNOUNCEMENTS {
            heard.remove(0);
        }
        heard.push(Announcement { instance: instance.to_owned(), addresses });
    }

    /// An announcement is taken back.
    pub(super) fn forget(&mut self, instance: &str) {
        for (_, heard) in &mut self.peers {
            heard.retain(|known| known.instance != instance);
        }
    }

    /// The address to dial in that attempt, counted from 0, of those of this family: the newest announcement's
    /// best one first, then all others in turn.
    pub(super) fn address(&self, name: &StationName, attempt: usize, ipv4: bool) -> Option<SocketAddr> {
        let (_, heard) = self.peers.iter().find(|(peer, _)| peer == name)?;
        let all = heard.iter().rev().flat_map(|known| &known.addresses);
        let all: Vec<_> = all.filter(|address| address.is_ipv4() == ipv4).collect();
        all.get(attempt.checked_rem(all.len())?).map(|address| **address)
    }
}

/// Whether a datagram can be sent there without knowing through which interface.
const fn can_be_dialled(address: &IpAddr) -> bool {
    let scoped = match address {
        IpAddr::V4(_) => false,
        IpAddr::V6(address) => address.is_unicast_link_local(),
    };
    !(scoped || address.is_unspecified() || address.is_multicast())
}

/// Addresses that somebody gave out come before those a computer gave itself for want of one.
const fn rank(address: &IpAddr) -> u8 {
    match address {
        IpAddr::V4(address) if address.is_link_local() => 1,
        IpAddr::V4(_) | IpAddr::V6(_) => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slave() -> StationName {
        "slave".parse().unwrap()
    }

    fn ips(all: &[&str]) -> Vec<IpAddr> {
        all.iter().map(|ip| ip.parse().unwrap()).collect()
    }

    fn first(announced: &Announced, attempt: usize) -> Option<String> {
        announced.address(&slave(), attempt, true).map(|address| address.to_string())
    }

    #[test]
    fn the_best_address_comes_first_and_the_others_in_turn() {
        let mut announced = Announced::of([slave()], false);
        assert_eq!(first(&announced, 0), None);
        let all = ["127.0.0.1", "169.254.3.4", "fe80::1", "10.0.0.3", "0.0.0.0", "2001:db8::3", "224.0.0.1"];
        announced.hear("slave.x", "slave", &ips(&all), 7420);
        let tried: Vec<_> = (0..3).filter_map(|attempt| first(&announced, attempt)).collect();
        assert_eq!(tried, ["10.0.0.3:7420", "169.254.3.4:7420", "10.0.0.3:7420"]);
        let v6 = announced.address(&slave(), 5, false).map(|address| address.to_string());
        assert_eq!(v6.as_deref(), Some("[2001:db8::3]:7420"));
        // it has moved
        announced.hear("slave.x", "slave", &ips(&["10.0.0.9"]), 7421);
        assert_eq!(first(&announced, 1).as_deref(), Some("10.0.0.9:7421"));
        announced.forget("slave.x");
        assert_eq!(first(&announced, 0), None);
    }

    #[test]
    fn what_is_not_asked_for_or_cannot_be_dialled_is_not_kept() {
        let mut announced = Announced::of([slave()], false);
        announced.hear("left.x", "left", &ips(&["10.0.0.1"]), 7420);
        announced.hear("slave.x", "slave", &ips(&["127.0.0.1", "fe80::1"]), 7420);
        announced.hear("slave.y", "slave", &ips(&["10.0.0.3"]), 0);
        announced.hear("slave.z", "Slave", &ips(&["10.0.0.3"]), 7420);
        announced.hear("slave.w", "", &ips(&["10.0.0.3"]), 7420);
        assert_eq!((first(&announced, 0), announced.peers.len()), (None, 1));
        let mut local = Announced::of([slave()], true);
        local.hear("slave.x", "slave", &ips(&["127.0.0.1"]), 7420);
        assert_eq!(first(&local, 0).as_deref(), Some("127.0.0.1:7420"));
    }

    #[test]
    fn a_flood_of_announcements_is_bounded_and_the_true_one_has_its_turn() {
        let mut announced = Announced::of([slave()], false);
        let many: Vec<IpAddr> = (0..200).map(|last| IpAddr::from([10, 9, 9, last])).collect();
        for number in 0..1_000 {
            announced.hear(&format!("slave-{number}"), "slave", &many, 7420);
        }
        announced.hear("slave", "slave", &ips(&["10.0.0.3"]), 7420);
        announced.hear("late", "slave", &many, 7420);
        let kept: usize = announced.peers[0].1.iter().map(|known| known.addresses.len()).sum();
        assert!(kept <= ANNOUNCEMENTS * ADDRESSES, "{kept}");
        assert!((0..kept).any(|attempt| first(&announced, attempt).as_deref() == Some("10.0.0.3:7420")));
    }
}
