//! How closely an arm follows a hand whose true way is known.

use nalgebra::{Matrix3, Vector3};
use std::collections::VecDeque;

/// Delays that are tried, seconds: up to this one ...
const LONGEST_DELAY_S: f64 = 0.6;
/// ... in steps of so many.
const DELAY_STEP_S: f64 = 0.002;

/// A place and an orientation.
pub type Truth = (Matrix3<f64>, Vector3<f64>);

/// Where the tool was, and what it was told from.
#[derive(Clone, Copy, Debug)]
struct Sample {
    t_s: f64,
    tool: Truth,
    latch: Latch,
}

/// Where hand and tool were when the hand was latched.
#[derive(Clone, Copy, Debug)]
struct Latch {
    hand_t_s: f64,
    /// `None` where it is to be asked for by its time.
    hand: Option<Truth>,
    tool: Truth,
}

/// What the tool did while the hand was followed.
#[derive(Clone, Debug, Default)]
pub struct Following {
    latch: Option<Latch>,
    samples: VecDeque<Sample>,
    /// Samples that are kept; `None` for all.
    kept: Option<usize>,
}

/// How closely it was followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closeness {
    /// How long after the hand the arm is where the hand was, seconds: the delay for which the rest is
    /// least.
    pub delay_s: f64,
    /// What is left beside the delay, root mean square, metres.
    pub rms_m: f64,
    /// The most of it, metres.
    pub max_m: f64,
    /// The same of turns, root mean square, radians.
    pub turn_rms_rad: f64,
    /// From the arm to where the hand is at that moment, root mean square, metres.
    pub behind_rms_m: f64,
}

impl Following {
    /// One that keeps so many samples, the newest.
    #[must_use]
    pub const fn of_the_last(samples: usize) -> Self {
        Self { latch: None, samples: VecDeque::new(), kept: Some(samples) }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.latch = None;
        self.samples.clear();
    }

    /// Only what can be compared with a hand that is known from a time on.
    #[must_use]
    pub fn since(&self, known_s: f64) -> Self {
        let asked_s = |sample: &Sample| (sample.t_s - LONGEST_DELAY_S).max(sample.latch.hand_t_s);
        let samples = self.samples.iter().filter(|sample| asked_s(sample) >= known_s);
        Self { latch: self.latch, samples: samples.copied().collect(), kept: self.kept }
    }

    /// From here on the tool follows the hand as it was at `hand_t_s`.
    pub const fn latch(&mut self, hand_t_s: f64, tool: Truth) {
        self.latch = Some(Latch { hand_t_s, hand: None, tool });
    }

    /// The same where the hand's way is forgotten in time: then it was here.
    pub const fn latch_hand(&mut self, hand_t_s: f64, hand: Truth, tool: Truth) {
        self.latch = Some(Latch { hand_t_s, hand: Some(hand), tool });
    }

    /// The tool is engaged, and here.
    pub fn sample(&mut self, t_s: f64, tool: Truth) {
        let Some(latch) = self.latch else { return };
        if self.kept.is_some_and(|kept| self.samples.len() >= kept) {
            self.samples.pop_front();
        }
        self.samples.push_back(Sample { t_s, tool, latch });
    }

    /// How closely the hand was followed, one metre for one and turn for turn; `hand` is where it truly
    /// was at a time, in the axes it is told in. `None` where nothing was followed.
    pub fn closeness(
        &self,
        robot_from_hand: &Matrix3<f64>,
        hand: impl Fn(f64) -> Truth,
    ) -> Option<Closeness> {
        if self.samples.is_empty() {
            return None;
        }
        let off = |delay_s: f64| -> Vec<(f64, f64)> {
            self.samples.iter().map(|sample| sample.off(delay_s, robot_from_hand, &hand)).collect()
        };
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            let (mut sum, mut count) = (0.0, 0u32);
            for value in values {
                sum += value * value;
                count += 1;
            }
            (sum / f64::from(count.max(1))).sqrt()
        };
        let place = |off: &[(f64, f64)]| rms(&mut off.iter().map(|(place, _)| *place));
        let steps = (LONGEST_DELAY_S / DELAY_STEP_S) as u32;
        let delays = (0..=steps).map(|step| f64::from(step) * DELAY_STEP_S);
        let (delay_s, rms_m) =
            delays.map(|delay_s| (delay_s, place(&off(delay_s)))).min_by(|a, b| a.1.total_cmp(&b.1))?;
        let best = off(delay_s);
        Some(Closeness {
            delay_s,
            rms_m,
            max_m: best.iter().map(|(place, _)| *place).fold(0.0, f64::max),
            turn_rms_rad: rms(&mut best.iter().map(|(_, turn)| *turn)),
            behind_rms_m: place(&off(0.0)),
        })
    }
}

impl Sample {
    /// Metres and radians from here to where the hand was `delay_s` before.
    fn off(&self, delay_s: f64, robot_from_hand: &Matrix3<f64>, hand: &impl Fn(f64) -> Truth) -> (f64, f64) {
        let latch = &self.latch;
        let (turn_then, place_then) = latch.hand.unwrap_or_else(|| hand(latch.hand_t_s));
        // before the latch the hand moved nothing
        let (turn_now, place_now) = hand((self.t_s - delay_s).max(latch.hand_t_s));
        let place = latch.tool.1 + robot_from_hand * (place_now - place_then);
        let turn = robot_from_hand * turn_now * turn_then.transpose() * robot_from_hand.transpose();
        let rotation = turn * latch.tool.0;
        let apart = (rotation.transpose() * self.tool.0 - Matrix3::identity()).norm() / 8.0_f64.sqrt();
        ((place - self.tool.1).norm(), 2.0 * apart.min(1.0).asin())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    fn hand(t_s: f64) -> Truth {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.3 * (1.3 * t_s).sin());
        (turn.into_inner(), Vector3::new((2.0 * t_s).sin(), (3.0 * t_s).cos(), 0.5 * t_s.sin()) * 0.1)
    }

    /// An arm that does the same `delay_s` later, and `aside` beside it.
    fn followed(robot_from_hand: &Matrix3<f64>, delay_s: f64, aside: Vector3<f64>) -> Following {
        let mut following = Following::default();
        let start = (*robot_from_hand, Vector3::new(0.6, -0.1, 0.7));
        let (turn_0, place_0) = hand(1.0);
        following.latch(1.0, start);
        for step in 0..1000 {
            let t_s = 1.0 + f64::from(step) * 0.01;
            let (turn, place) = hand((t_s - delay_s).max(1.0));
            let turn = robot_from_hand * turn * turn_0.transpose() * robot_from_hand.transpose();
            following.sample(t_s, (turn * start.0, start.1 + robot_from_hand * (place - place_0) + aside));
        }
        following
    }

    #[test]
    fn delay_and_rest_are_told_apart() {
        let robot_from_hand = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let aside = Vector3::new(0.0, 0.002, 0.0);
        let closeness = followed(&robot_from_hand, 0.12, aside).closeness(&robot_from_hand, hand).unwrap();
        assert!((closeness.delay_s - 0.12).abs() < 0.003, "{closeness:?}");
        assert!((closeness.rms_m - 0.002).abs() < 2e-4, "{closeness:?}");
        assert!(closeness.turn_rms_rad < 1e-3, "{closeness:?}");
        assert!(closeness.behind_rms_m > 0.02, "{closeness:?}");
    }

    #[test]
    fn an_arm_that_goes_another_way_is_not_close() {
        let robot_from_hand = Matrix3::identity();
        let other = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let closeness = followed(&other, 0.0, Vector3::zeros()).closeness(&robot_from_hand, hand).unwrap();
        assert!(closeness.rms_m > 0.05, "{closeness:?}");
    }

    #[test]
    fn nothing_followed_is_nothing_known() {
        assert_eq!(Following::default().closeness(&Matrix3::identity(), hand), None);
    }
}
