//! What was lost on the way to each station lately: the link counts since a connection began.

use crate::console::snapshot::LinkView;
use std::collections::{BTreeMap, VecDeque};

/// How far back, microseconds.
const LATELY_US: u64 = 10_000_000;

/// Counts of one connection at one time.
#[derive(Clone, Copy)]
struct Count {
    at_us: u64,
    sent: u64,
    lost: u64,
}

/// The counts of the last seconds, by the station's name: as many as the links are looked at in that time.
#[derive(Default)]
pub(super) struct Losses(BTreeMap<String, VecDeque<Count>>);

impl Losses {
    /// Remembers the counts of each link, and tells it what share was lost since the oldest that it remembers.
    pub(super) fn look(&mut self, links: &mut [LinkView], now_us: u64) {
        for link in links {
            let (Some(sent), Some(lost)) = (link.sent_packets, link.lost_packets) else { continue };
            let counts = self.0.entry(link.name.clone()).or_default();
            if counts.back().is_some_and(|last| sent < last.sent || lost < last.lost) {
                // another connection, which counts anew
                counts.clear();
            }
            while counts.front().is_some_and(|first| now_us.saturating_sub(first.at_us) > LATELY_US) {
                counts.pop_front();
            }
            counts.push_back(Count { at_us: now_us, sent, lost });
            let Some(first) = counts.front() else { continue };
            let (sent, lost) = (sent - first.sent, lost - first.lost);
            // a packet may be known to be lost a little after others were sent
            link.loss_lately = (sent > 0).then(|| (lost as f64 / sent as f64).min(1.0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: u64 = 1_000_000;

    fn look(losses: &mut Losses, at_s: u64, sent: u64, lost: u64) -> Option<f64> {
        let mut links = [LinkView {
            name: "slave".to_owned(),
            sent_packets: Some(sent),
            lost_packets: Some(lost),
            ..LinkView::default()
        }];
        losses.look(&mut links, at_s * S);
        links[0].loss_lately
    }

    #[test]
    fn a_loss_is_seen_while_it_is_there() {
        let mut losses = Losses::default();
        assert_eq!(look(&mut losses, 0, 1_000_000, 0), None);
        for at_s in 1..=20 {
            assert_eq!(look(&mut losses, at_s, 1_000_000 + at_s * 100, 0), Some(0.0));
        }
        assert_eq!(look(&mut losses, 21, 1_002_100, 50), Some(0.05), "50 of the last 1,000");
        for at_s in 22..=31 {
            look(&mut losses, at_s, 1_000_000 + at_s * 100, 50);
        }
        assert_eq!(look(&mut losses, 32, 1_003_200, 50), Some(0.0), "it is over");
        assert!(losses.0["slave"].len() <= 11);
        assert_eq!(look(&mut losses, 33, 10, 0), None, "another connection");
        assert_eq!(look(&mut losses, 34, 20, 5), Some(0.5));
    }

    #[test]
    fn within_one_process_nothing_is_lost_on_the_way() {
        let mut links = [LinkView::default()];
        Losses::default().look(&mut links, S);
        assert_eq!(links[0].loss_lately, None);
    }
}
