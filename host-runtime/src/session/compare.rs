//! Whether what is computed anew is what was recorded: hash by hash, and the first place where it is not.

use super::schema::tetrad as msg;
use prost::Message as _;
use std::collections::VecDeque;
use tetrad_core::observation::Ball;
use tetrad_fixtures::golden::Fnv1a;

/// Results that wait for those they are compared with; more are not kept.
const MOST_WAITING: usize = 10_000;

/// What can be compared.
pub(super) trait Judged: Clone {
    /// What it is numbered by.
    fn number(&self) -> u64;

    /// What must be the same, bit by bit.
    fn bytes(&self) -> Vec<u8>;

    /// The first thing that is not, in words.
    fn difference(&self, replayed: &Self) -> String;
}

/// What came of comparing one kind of results.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Compared {
    /// What is compared, as `left observations`.
    pub what: String,
    /// How many were.
    pub count: u64,
    /// The hash of those that were recorded.
    pub recorded: u64,
    /// The hash of those that were computed anew.
    pub replayed: u64,
    /// The first difference.
    pub first: Option<String>,
    /// Recorded results that could not be computed anew: their pictures are not in the file.
    pub missing: u64,
}

impl Compared {
    /// Whether all that was recorded came out the same, to the bit.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        self.first.is_none() && self.missing == 0 && self.recorded == self.replayed
    }
}

/// Compares results of one kind as they come, in either order.
pub(super) struct Comparison<M> {
    what: String,
    recorded: VecDeque<M>,
    replayed: VecDeque<M>,
    hashes: [Fnv1a; 2],
    count: u64,
    first: Option<String>,
    missing: u64,
}

impl<M: Judged> Comparison<M> {
    pub(super) fn new(what: String) -> Self {
        Self {
            what,
            recorded: VecDeque::new(),
            replayed: VecDeque::new(),
            hashes: [Fnv1a::default(), Fnv1a::default()],
            count: 0,
            first: None,
            missing: 0,
        }
    }

    /// What was recorded; numbers go up.
    pub(super) fn recorded(&mut self, message: M) {
        self.recorded.push_back(message);
        self.compare();
    }

    /// What came out now; numbers go up.
    pub(super) fn replayed(&mut self, message: M) {
        self.replayed.push_back(message);
        self.compare();
        if self.replayed.len() > MOST_WAITING {
            self.replayed.pop_front();
        }
    }

    fn compare(&mut self) {
        while let (Some(recorded), Some(replayed)) = (self.recorded.front(), self.replayed.front()) {
            if replayed.number() < recorded.number() {
                // nobody waited for it then
                self.replayed.pop_front();
                continue;
            }
            if recorded.number() < replayed.number() {
                self.recorded.pop_front();
                self.missing += 1;
                continue;
            }
            let [was, is] = [recorded.bytes(), replayed.bytes()];
            if was != is && self.first.is_none() {
                self.first = Some(recorded.difference(replayed));
            }
            let [hash_was, hash_is] = &mut self.hashes;
            hash_was.write(&was);
            hash_is.write(&is);
            self.count += 1;
            self.recorded.pop_front();
            self.replayed.pop_front();
        }
    }

    /// The same where a session may end between a result and its picture: that one is not missed.
    pub(super) fn finish_open(mut self) -> Compared {
        if self.count > 0 && self.recorded.len() == 1 {
            self.recorded.clear();
        }
        self.finish()
    }

    pub(super) fn finish(self) -> Compared {
        let [recorded, replayed] = self.hashes;
        Compared {
            what: self.what,
            count: self.count,
            recorded: recorded.finish(),
            replayed: replayed.finish(),
            first: self.first,
            missing: self.missing + self.recorded.len() as u64,
        }
    }
}

/// The first of the pairs that differ by their bits.
fn first_of<'a>(pairs: impl IntoIterator<Item = (&'a str, f32, f32)>) -> Option<String> {
    pairs
        .into_iter()
        .find(|(_, was, is)| was.to_bits() != is.to_bits())
        .map(|(name, was, is)| format!("{name} {was} recorded, {is} replayed"))
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

impl Judged for msg::Observations {
    fn number(&self) -> u64 {
        self.frame
    }

    fn bytes(&self) -> Vec<u8> {
        // when it was found and heard of is no result
        let Self { frame, capture_us, pixels_tested, .. } = *self;
        let balls = self.balls.clone();
        Self { frame, capture_us, pixels_tested, balls, ..Self::default() }.encode_to_vec()
    }

    fn difference(&self, replayed: &Self) -> String {
        let at = format!("frame {} ({:.6} s)", self.frame, seconds(self.capture_us));
        for ((ball, was), is) in Ball::ALL.into_iter().zip(&self.balls).zip(&replayed.balls) {
            let name = ball.name();
            if was.state != is.state {
                let [was, is] = [was.state(), is.state()];
                return format!("{at}, {name}: {was:?} recorded, {is:?} replayed");
            }
            let numbers = first_of([
                ("u", was.u, is.u),
                ("v", was.v, is.v),
                ("diameter", was.diameter, is.diameter),
                ("variance of u", was.uu, is.uu),
                ("covariance", was.uv, is.uv),
                ("variance of v", was.vv, is.vv),
                ("visible share", was.visible, is.visible),
            ]);
            if let Some(numbers) = numbers {
                return format!("{at}, {name}: {numbers}");
            }
        }
        format!("{at}: {} pixels tested recorded, {} replayed", self.pixels_tested, replayed.pixels_tested)
    }
}

impl Judged for msg::Hand {
    fn number(&self) -> u64 {
        self.frame
    }

    fn bytes(&self) -> Vec<u8> {
        self.encode_to_vec()
    }

    fn difference(&self, replayed: &Self) -> String {
        let at = format!("frame {} ({:.6} s)", self.frame, seconds(self.capture_us));
        if self.state != replayed.state {
            return format!("{at}: {:?} recorded, {:?} replayed", self.state(), replayed.state());
        }
        let numbers = |transform: &Option<msg::Transform>| -> Vec<f32> {
            let both = transform.iter().flat_map(|t| t.translation.iter().chain(&t.rotation));
            both.copied().collect()
        };
        const PLACES: [&str; 12] =
            ["x", "y", "z", "r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];
        for (what, was, is) in [
            ("pose", numbers(&self.pose), numbers(&replayed.pose)),
            ("filtered pose", numbers(&self.filtered), numbers(&replayed.filtered)),
        ] {
            if was.len() != is.len() {
                let there = |numbers: &[f32]| if numbers.is_empty() { "none" } else { "one" };
                return format!("{at}, {what}: {} recorded, {} replayed", there(&was), there(&is));
            }
            let pairs = PLACES.into_iter().zip(was).zip(is).map(|((name, was), is)| (name, was, is));
            if let Some(numbers) = first_of(pairs) {
                return format!("{at}, {what}: {numbers}");
            }
        }
        format!("{at}: the poses agree, their covariance or the motion does not")
    }
}

impl Judged for msg::Instant {
    fn number(&self) -> u64 {
        self.asked_us
    }

    fn bytes(&self) -> Vec<u8> {
        self.encode_to_vec()
    }

    fn difference(&self, replayed: &Self) -> String {
        let [was, is] = [self, replayed].map(|instant| (instant.capture_us, instant.reference));
        if was == is {
            return format!("the instant at {:.6} s: what a camera saw then differs", seconds(was.0));
        }
        format!(
            "the instant asked for at {:.6} s: {:.6} s recorded (camera {}), {:.6} s replayed (camera {})",
            seconds(self.asked_us),
            seconds(was.0),
            was.1,
            seconds(is.0),
            is.1
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(frame: u64, u: f32) -> msg::Observations {
        let balls = vec![msg::Observation { u, ..msg::Observation::default() }];
        msg::Observations { frame, capture_us: frame * 100_000, balls, ..msg::Observations::default() }
    }

    #[test]
    fn the_same_is_the_same_whichever_comes_first_and_whenever_it_was_heard_of() {
        let mut comparison = Comparison::new("left observations".to_owned());
        comparison.recorded(msg::Observations { received_us: 7, ..seen(0, 1.5) });
        comparison.replayed(seen(0, 1.5));
        comparison.replayed(seen(1, 2.5));
        comparison.replayed(seen(2, 3.5));
        comparison.recorded(seen(2, 3.5));
        let compared = comparison.finish();
        assert!(compared.is_identical(), "{compared:?}");
        assert_eq!((compared.count, compared.missing), (2, 0), "frame 1 was nobody's");
        assert_ne!(compared.recorded, Fnv1a::default().finish());
    }

    #[test]
    fn the_first_difference_is_told_and_what_is_missing_counted() {
        let mut comparison = Comparison::new("left observations".to_owned());
        for frame in 0..4 {
            comparison.recorded(seen(frame, 1.5));
        }
        comparison.replayed(seen(0, 1.5));
        comparison.replayed(seen(2, f32::from_bits(1.5f32.to_bits() + 1)));
        let compared = comparison.finish();
        assert!(!compared.is_identical());
        assert_eq!((compared.count, compared.missing), (2, 2), "frames 1 and 3");
        let mut open = Comparison::new("left observations".to_owned());
        open.recorded(seen(0, 1.5));
        open.replayed(seen(0, 1.5));
        open.recorded(seen(1, 1.5));
        assert!(open.finish_open().is_identical(), "the last picture did not reach the file");
        let first = compared.first.unwrap();
        assert_eq!(first, "frame 2 (0.200000 s), red: u 1.5 recorded, 1.5000001 replayed");
        assert_ne!(compared.recorded, compared.replayed);
    }

    #[test]
    fn a_hand_that_differs_is_told_by_its_first_number() {
        let pose = msg::Transform { translation: vec![0.25, 0.5, 0.75], rotation: vec![1.0; 9] };
        let hand = msg::Hand { frame: 3, pose: Some(pose.clone()), ..msg::Hand::default() };
        let other = msg::Transform { translation: vec![0.25, 0.5, 0.125], ..pose };
        let moved = msg::Hand { pose: Some(other), ..hand.clone() };
        assert_eq!(hand.difference(&moved), "frame 3 (0.000000 s), pose: z 0.75 recorded, 0.125 replayed");
        let gone = msg::Hand { pose: None, ..hand.clone() };
        assert!(hand.difference(&gone).ends_with("pose: one recorded, none replayed"));
        let lost = msg::Hand { state: msg::HandState::Lost.into(), ..hand.clone() };
        assert!(hand.difference(&lost).ends_with("Both recorded, Lost replayed"));
    }
}
