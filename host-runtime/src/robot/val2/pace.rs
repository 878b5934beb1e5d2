//! How far apart set-points may be, and how long a move may get.
//!
//! Set-points come a hundred times a second; a line of 9600 baud takes a few points a second, and the
//! arm makes a move of its own of each. Three bounds follow, each in the time a joint needs at its
//! top speed:
//!
//! - between two set-points, the time that has passed: more is a jump, and refused;
//! - between what is asked for and what was sent, [`LAG`]: an arm that has fallen further behind is
//!   being led faster than it follows, and refused;
//! - in one move, [`MOVE`] at the speed the controller was given: a stop has to wait for the move
//!   under way, so that moves are kept short. A point further away is gone to straight in joint
//!   space, move by move, and always towards the newest one.

use std::time::Duration;

use tetrad_core::arm::port::PortError;
use tetrad_core::arm::puma560::Joints;

/// The longest move, seconds at the speed the controller was given. About what a point takes on the
/// line: shorter moves would slow the arm, longer ones its stop.
pub(super) const MOVE: f64 = 0.25;

/// How far behind the set-points an arm may be, seconds at full speed.
const LAG: f64 = 1.0;

/// How far from the measured joints the first set-point may be, radians: two degrees, what a reading
/// rounded and read again is never off by.
const START: f64 = 0.035;

/// The shortest time that is believed between two set-points: two cycles at 100 Hz, as a caller's
/// thread may be late for one and not for the next.
const SHORTEST: Duration = Duration::from_millis(20);

/// What is allowed to a set-point beyond the joint's speed: rounding.
const SLACK: f64 = 1.0 + 1e-9;

/// The bounds of an arm.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    /// Of each joint, rad/s.
    top: Joints<f64>,
    /// The share of it that the controller goes at.
    share: f64,
    longest: Duration,
}

/// What bounds the next set-point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Last {
    /// The last point sent, or where the arm was found.
    pub(super) sent: Joints<f64>,
    /// The last set-point accepted, and how long ago.
    pub(super) accepted: Option<(Joints<f64>, Duration)>,
}

impl Pace {
    /// Bounds for joints of `top` rad/s, of which the controller takes `share`; set-points are at most
    /// `longest` apart.
    #[must_use]
    pub(super) fn new(top: Joints<f64>, share: f64, longest: Duration) -> Self {
        Self { top, share, longest }
    }

    /// Whether a set-point may follow.
    ///
    /// # Errors
    /// [`PortError::TooFar`] with the first joint it is too far for.
    pub(super) fn check(&self, last: &Last, next: &Joints<f64>) -> Result<(), PortError> {
        let Some((accepted, ago)) = last.accepted else {
            return beyond(&last.sent, next, &[START; 6])
                .map_or(Ok(()), |joint| Err(PortError::TooFar(joint)));
        };
        let passed = ago.clamp(SHORTEST, self.longest.max(SHORTEST)).as_secs_f64() * SLACK;
        let jump = beyond(&accepted, next, &self.top.map(|speed| speed * passed));
        let lag = || beyond(&last.sent, next, &self.top.map(|speed| speed * LAG));
        jump.or_else(lag).map_or(Ok(()), |joint| Err(PortError::TooFar(joint)))
    }

    /// The next point on the straight way from `sent` to `target`.
    #[must_use]
    pub(super) fn step(&self, sent: &Joints<f64>, target: &Joints<f64>) -> Joints<f64> {
        let moves = sent.iter().zip(target).zip(&self.top);
        let share = moves
            .map(|((from, to), speed)| speed * self.share * MOVE / (to - from).abs())
            .fold(1.0, f64::min);
        std::array::from_fn(|joint| sent[joint] + share * (target[joint] - sent[joint]))
    }

    /// The first joint, from 1, that is further from where it was sent than three of the longest moves:
    /// held by something, or misread.
    #[must_use]
    pub(super) fn misplaced(&self, sent: &Joints<f64>, measured: &Joints<f64>) -> Option<u8> {
        beyond(sent, measured, &self.top.map(|speed| 3.0 * speed * self.share * MOVE + START))
    }
}

/// Moves that were sent.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moves {
    count: u64,
    /// The mean time from one to the next is over those that followed within a second.
    followed: u32,
    time: Duration,
    last: Option<Duration>,
}

impl Moves {
    /// One more, sent at `now`.
    pub(super) fn add(&mut self, now: Duration) {
        self.count += 1;
        let passed = self.last.replace(now).map(|last| now.saturating_sub(last));
        if let Some(passed) = passed.filter(|passed| *passed < Duration::from_secs(1)) {
            self.followed += 1;
            self.time += passed;
        }
    }

    /// How many there were.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// From one to the next, where the arm was kept moving.
    #[must_use]
    pub fn mean_period(&self) -> Option<Duration> {
        self.time.checked_div(self.followed)
    }
}

/// The first joint, from 1, that is further from `a` to `b` than it may be.
fn beyond(a: &Joints<f64>, b: &Joints<f64>, most: &Joints<f64>) -> Option<u8> {
    // written so that NaN is beyond
    let within = |a: f64, b: f64, most: f64| (b - a).abs() <= most;
    let mut joints = (1..).zip(a.iter().zip(b).zip(most));
    joints.find(|(_, ((a, b), most))| !within(**a, **b, **most)).map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace() -> Pace {
        Pace::new([2.0; 6], 0.5, Duration::from_millis(500))
    }

    fn at(angle: f64) -> Joints<f64> {
        [0.0, 0.0, angle, 0.0, 0.0, 0.0]
    }

    #[test]
    fn the_first_set_point_is_where_the_arm_is() {
        let last = Last { sent: at(1.0), accepted: None };
        assert_eq!(pace().check(&last, &at(1.03)), Ok(()));
        assert_eq!(pace().check(&last, &at(1.04)), Err(PortError::TooFar(3)));
        assert_eq!(pace().check(&last, &at(f64::NAN)), Err(PortError::TooFar(3)));
    }

    #[test]
    fn a_set_point_follows_as_fast_as_the_joint_and_no_faster() {
        let after = |ms| Last { sent: at(0.0), accepted: Some((at(0.0), Duration::from_millis(ms))) };
        assert_eq!(pace().check(&after(100), &at(0.2)), Ok(()));
        assert_eq!(pace().check(&after(100), &at(0.21)), Err(PortError::TooFar(3)));
        assert_eq!(pace().check(&after(0), &at(0.04)), Ok(()), "a late thread");
        assert_eq!(pace().check(&after(9000), &at(1.01)), Err(PortError::TooFar(3)), "no credit for silence");
    }

    #[test]
    fn an_arm_that_falls_behind_is_not_led_further() {
        let last = Last { sent: at(0.0), accepted: Some((at(1.9), Duration::from_millis(100))) };
        assert_eq!(pace().check(&last, &at(2.0)), Ok(()));
        assert_eq!(pace().check(&last, &at(2.01)), Err(PortError::TooFar(3)));
        assert_eq!(pace().check(&last, &at(1.8)), Ok(()), "back is always allowed");
    }

    #[test]
    fn moves_are_short_and_end_at_the_target() {
        let (mut sent, target) = ([0.0; 6], [0.5, 0.0, -1.0, 0.1, 0.0, 0.0]);
        for _ in 0..4 {
            let next = pace().step(&sent, &target);
            assert!(next.iter().zip(&sent).all(|(a, b)| (a - b).abs() <= 0.25 + 1e-12));
            // on the straight way
            assert!((next[0] * -2.0 - next[2]).abs() < 1e-12 && (next[0] - 5.0 * next[3]).abs() < 1e-12);
            sent = next;
        }
        assert!(sent.iter().zip(&target).all(|(a, b)| (a - b).abs() < 1e-12), "{sent:?}");
        assert_eq!(pace().step(&target, &target), target);
    }

    #[test]
    fn the_mean_period_leaves_out_rests() {
        let mut moves = Moves::default();
        assert_eq!(moves.mean_period(), None);
        for ms in [0, 200, 500, 9000, 9100] {
            moves.add(Duration::from_millis(ms));
        }
        assert_eq!((moves.count(), moves.mean_period()), (5, Some(Duration::from_millis(200))));
    }

    #[test]
    fn an_arm_that_is_not_where_it_was_sent_is_seen() {
        assert_eq!(pace().misplaced(&at(0.0), &at(0.7)), None);
        assert_eq!(pace().misplaced(&at(0.0), &at(-0.9)), Some(3));
    }
}
