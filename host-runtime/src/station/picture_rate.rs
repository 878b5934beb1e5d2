//! How good the pictures of the scene may be: the best that the link carries without holding up motion.
//!
//! Pictures have a bounded rate and a connection of their own, so they cannot queue before motion at this
//! station. On the way they share the line with it. Three signs tell that they take too much of it:
//!
//! | sign | told by |
//! |---|---|
//! | pictures are overtaken before they are sent: the bounded rate, or a slow line | the outbox's counts |
//! | the way there and back grows: a queue somewhere on the way | QUIC's round trip of the connection of motion |
//! | motion's packets are lost on it | QUIC's losses of the same connection |
//!
//! With any of them the quality goes down by a quarter of itself, at the lowest the rate is halved instead.
//! After some time without, the rate comes back first, then the quality, step by step: down fast, up slowly,
//! so that it does not swing.

/// How often it is looked at, microseconds: some pictures, and some round trips.
pub(super) const LOOK_US: u64 = 500_000;

/// The lowest JPEG quality that can be steered by.
const LOWEST: u8 = 20;

/// What a bad sign leaves of the quality, in quarters.
const LEFT_QUARTERS: u16 = 3;

/// By how much the quality comes back at a time.
const RAISE: u8 = 5;

/// Looks without a bad sign before anything is raised: two seconds.
const GOOD_LOOKS: u32 = 4;

/// Of the pictures that are made, one in so many is sent at least: slower than 15 / 4 a second nobody
/// steers by them.
const MOST_LEFT_OUT: u32 = 4;

/// The share of pictures that may be overtaken, in percent: one in ten is nobody's fault.
const MAY_BE_OVERTAKEN: u64 = 10;

/// How much longer the way may be than the shortest that was seen, microseconds, and times: what a busy
/// computer does, a queue of one picture on a line of 20 Mbit/s does not.
const LONGER_US: u64 = 20_000;
const LONGER_TIMES: u64 = 2;

/// The share of QUIC's packets that may be lost, in percent: a radio loses some without any queue.
const MAY_BE_LOST: u64 = 5;

/// What the link says of itself, counted from its beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineState {
    /// Pictures that were handed to the network.
    pub pictures_sent: u64,
    /// Pictures that were overtaken before.
    pub pictures_overtaken: u64,
    /// The way there and back of motion's connection, microseconds; `None` where there is no way.
    pub round_trip_us: Option<u64>,
    /// QUIC packets of that connection that were sent, and of those lost.
    pub packets_sent: u64,
    /// See `packets_sent`.
    pub packets_lost: u64,
}

/// What quality the pictures to one peer have now.
#[derive(Clone, Copy, Debug)]
pub struct PictureRate {
    best: u8,
    quality: u8,
    /// One picture in so many is sent.
    every: u32,
    last: LineState,
    shortest_us: Option<u64>,
    good_looks: u32,
}

impl PictureRate {
    /// Begins with the best quality, 1 to 100.
    #[must_use]
    pub const fn new(best: u8) -> Self {
        Self {
            best,
            quality: best,
            every: 1,
            last: LineState {
                pictures_sent: 0,
                pictures_overtaken: 0,
                round_trip_us: None,
                packets_sent: 0,
                packets_lost: 0,
            },
            shortest_us: None,
            good_looks: 0,
        }
    }

    /// The JPEG quality of the next picture.
    #[must_use]
    pub const fn quality(&self) -> u8 {
        self.quality
    }

    /// One picture in so many is to be sent.
    #[must_use]
    pub const fn every(&self) -> u32 {
        self.every
    }

    /// Looks at the link; to be called twice a second.
    pub fn look(&mut self, line: LineState) {
        let before = std::mem::replace(&mut self.last, line);
        if line.packets_sent < before.packets_sent {
            // another connection, perhaps another way
            self.shortest_us = None;
        }
        if let Some(now_us) = line.round_trip_us {
            self.shortest_us = Some(self.shortest_us.map_or(now_us, |shortest| shortest.min(now_us)));
        }
        if self.is_crowded(&before, &line) {
            self.good_looks = 0;
            self.lower();
        } else {
            self.good_looks += 1;
            if self.good_looks >= GOOD_LOOKS {
                self.good_looks = 0;
                self.raise();
            }
        }
    }

    fn is_crowded(&self, before: &LineState, now: &LineState) -> bool {
        let gained = |now: u64, before: u64| now.saturating_sub(before);
        let overtaken = gained(now.pictures_overtaken, before.pictures_overtaken);
        let pictures = overtaken + gained(now.pictures_sent, before.pictures_sent);
        let lost = gained(now.packets_lost, before.packets_lost);
        let packets = gained(now.packets_sent, before.packets_sent);
        let longer = now.round_trip_us.zip(self.shortest_us).is_some_and(|(now_us, shortest_us)| {
            now_us > shortest_us + LONGER_US && now_us > LONGER_TIMES * shortest_us
        });
        overtaken * 100 > pictures * MAY_BE_OVERTAKEN || lost * 100 > packets * MAY_BE_LOST || longer
    }

    fn lower(&mut self) {
        let lowest = LOWEST.min(self.best);
        if self.quality > lowest {
            let left = u16::from(self.quality) * LEFT_QUARTERS / 4;
            self.quality = u8::try_from(left).unwrap_or(self.best).max(lowest);
        } else {
            self.every = (2 * self.every).min(MOST_LEFT_OUT);
        }
    }

    fn raise(&mut self) {
        if self.every > 1 {
            self.every /= 2;
        } else {
            self.quality = self.quality.saturating_add(RAISE).min(self.best);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A link that carries so many pictures a look, and what comes of it.
    struct Line {
        rate: PictureRate,
        state: LineState,
    }

    impl Line {
        fn new(best: u8) -> Self {
            let state = LineState { round_trip_us: Some(1_000), ..LineState::default() };
            Self { rate: PictureRate::new(best), state }
        }

        fn look(&mut self, sent: u64, overtaken: u64) {
            self.state.pictures_sent += sent;
            self.state.pictures_overtaken += overtaken;
            self.state.packets_sent += 100;
            self.rate.look(self.state);
        }
    }

    #[test]
    fn a_free_line_gets_the_best() {
        let mut line = Line::new(80);
        for _ in 0..100 {
            line.look(15, 1);
        }
        assert_eq!((line.rate.quality(), line.rate.every()), (80, 1));
    }

    #[test]
    fn a_crowded_line_gets_less_quality_then_fewer_pictures() {
        let mut line = Line::new(80);
        let mut seen = Vec::new();
        for _ in 0..9 {
            line.look(5, 10);
            seen.push((line.rate.quality(), line.rate.every()));
        }
        let expected = [(60, 1), (45, 1), (33, 1), (24, 1), (20, 1), (20, 2), (20, 4), (20, 4), (20, 4)];
        assert_eq!(seen, expected, "the fewest in {} s", 7.0 * LOOK_US as f64 / 1e6);
        for _ in 0..2 * GOOD_LOOKS {
            line.look(15, 0);
        }
        assert_eq!((line.rate.quality(), line.rate.every()), (20, 1), "the rate comes back first");
        for _ in 0..12 * GOOD_LOOKS {
            line.look(15, 0);
        }
        assert_eq!(line.rate.quality(), 80);
    }

    #[test]
    fn a_queue_on_the_way_is_seen_by_the_round_trip() {
        let mut line = Line::new(80);
        line.look(15, 0);
        line.state.round_trip_us = Some(20_900);
        line.look(15, 0);
        assert_eq!(line.rate.quality(), 80, "a busy computer");
        line.state.round_trip_us = Some(25_000);
        line.look(15, 0);
        assert_eq!(line.rate.quality(), 60);
        // a long way is no queue
        let mut far = Line::new(80);
        far.state.round_trip_us = Some(300_000);
        far.look(15, 0);
        far.state.round_trip_us = Some(340_000);
        far.look(15, 0);
        assert_eq!(far.rate.quality(), 80);
        // and another connection may have a longer way
        line.state = LineState { round_trip_us: Some(200_000), ..LineState::default() };
        line.rate.look(line.state);
        line.look(15, 0);
        assert_eq!(line.rate.quality(), 60, "no lower");
    }

    #[test]
    fn losses_lower_it_and_low_settings_stay() {
        let mut line = Line::new(30);
        line.state.packets_lost += 6;
        line.look(15, 0);
        assert_eq!(line.rate.quality(), 22);
        let mut line = Line::new(10);
        for _ in 0..20 {
            line.look(0, 10);
        }
        assert_eq!((line.rate.quality(), line.rate.every()), (10, 4), "never above what was set");
    }
}
