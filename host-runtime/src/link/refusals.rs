//! Which refusals are told: whoever knocks again and again shall not fill a log.

use std::collections::VecDeque;
use std::net::IpAddr;

/// The same refusal of the same address is told once in so many microseconds.
const AGAIN_US: u64 = 60_000_000;

/// Refusals that are told within that time at most, whoever is refused.
const TOLD: usize = 20;

/// Refusals as they come.
#[derive(Debug, Default)]
pub(super) struct Refusals {
    /// Those that were told within the last [`AGAIN_US`], the oldest first.
    told: VecDeque<(u64, IpAddr, String)>,
    untold: u64,
}

impl Refusals {
    /// Whether this one is to be told: then how many before it were not.
    pub(super) fn tell(&mut self, address: IpAddr, reason: &str, now_us: u64) -> Option<u64> {
        while self.told.front().is_some_and(|(at_us, ..)| now_us.saturating_sub(*at_us) >= AGAIN_US) {
            self.told.pop_front();
        }
        let known = self.told.iter().any(|(_, who, why)| *who == address && why == reason);
        if known || self.told.len() >= TOLD {
            self.untold += 1;
            return None;
        }
        self.told.push_back((now_us, address, reason.to_owned()));
        Some(std::mem::take(&mut self.untold))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(last: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, last])
    }

    #[test]
    fn one_that_knocks_on_is_told_once_a_minute() {
        let mut refusals = Refusals::default();
        assert_eq!(refusals.tell(address(1), "no certificate", 5), Some(0));
        for knock in 1..1_000 {
            assert_eq!(refusals.tell(address(1), "no certificate", 5 + knock * 50_000), None);
        }
        assert_eq!(refusals.tell(address(1), "another name", 55_000_000), Some(999), "another reason");
        assert_eq!(refusals.tell(address(1), "no certificate", 60_000_005), Some(0));
    }

    #[test]
    fn many_are_told_of_up_to_a_bound() {
        let mut refusals = Refusals::default();
        let told = (0..100).filter(|&last| refusals.tell(address(last), "", 0).is_some()).count();
        assert_eq!(told, TOLD);
        assert_eq!(refusals.tell(address(7), "", AGAIN_US), Some(80));
    }
}
