//! How closely the arm has followed its hand lately, as the slave sees both: the hand by the motions that
//! came, each at its capture time by this station's clock, the arm by its measured joints.
//!
//! What it holds is bounded: the last minute, at fifty samples a second.

use super::following::{Closeness, Following, Truth};
use super::slave::Cycle;
use std::collections::VecDeque;
use tetrad_core::arm::teleop::{Note, Order};
use tetrad_core::config::{TeleopConfig, Turning};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::state::PoseState;
use tetrad_core::wire::MotionPacket;

/// From one sample of the arm to the next, microseconds.
const SAMPLE_US: u64 = 20_000;

/// Samples of the arm that are kept: a minute.
const SAMPLES: usize = 3_000;

/// Places of the hand that are kept: a minute of a camera with 120 frames a second.
const PLACES: usize = 7_200;

/// What the hand and the arm did.
#[derive(Clone, Debug)]
pub struct Trail {
    law: TeleopConfig,
    hand: VecDeque<(f64, Truth)>,
    /// What the places of the hand are told from.
    told_from: Option<(u32, u32)>,
    following: Following,
    sampled_us: Option<u64>,
}

impl Trail {
    /// Of an arm that goes by this law.
    #[must_use]
    pub fn new(law: &TeleopConfig) -> Self {
        Self {
            law: *law,
            hand: VecDeque::new(),
            told_from: None,
            following: Following::of_the_last(SAMPLES),
            sampled_us: None,
        }
    }

    /// A motion was taken. `captured_us` is when its pictures were taken, by this station's clock; where
    /// that is not known, nothing can be compared.
    pub fn motion(&mut self, motion: &MotionPacket, captured_us: Option<u64>) {
        let told_from = (motion.session, motion.engagements);
        if self.told_from.replace(told_from).is_some_and(|before| before != told_from) {
            // from here on the hand is told in other axes
            self.hand.clear();
            self.following.clear();
        }
        let Some(captured_us) = captured_us else { return };
        if motion.state == PoseState::Lost {
            return;
        }
        let pose: Pose = motion.since_engage.into();
        let place = pose.translation.map(f64::from) * self.law.scale;
        if self.hand.len() >= PLACES {
            self.hand.pop_front();
        }
        self.hand.push_back((seconds(captured_us), (pose.rotation.map(f64::from), place)));
    }

    /// A cycle was done at `now_us`. It counts where the arm follows the hand as far as its own scale has it: neither
    /// on the way home, nor by a share of the scale, in whose lengths the hand's places are not kept.
    pub fn cycle(&mut self, cycle: &Cycle, now_us: u64) {
        let decision = &cycle.step.decision;
        let follows = matches!(decision.order, Order::Follow(_)) && decision.scale == self.law.scale;
        let Some(measured) = cycle.step.measured.filter(|_| follows) else { return };
        let tool = (measured.rotation, measured.translation);
        let latched = decision.notes.contains(Note::Latched) || decision.notes.contains(Note::HandJumped);
        if let Some((newest_s, hand)) = self.hand.back().filter(|_| latched) {
            self.following.latch_hand(*newest_s, *hand, tool);
        }
        if self.sampled_us.is_none_or(|before| now_us.saturating_sub(before) >= SAMPLE_US) {
            self.sampled_us = Some(now_us);
            self.following.sample(seconds(now_us), tool);
        }
    }

    /// How closely the arm followed; `None` where it did not, or nobody knows when the hand was where.
    #[must_use]
    pub fn closeness(&self) -> Option<Closeness> {
        let begins_s = self.hand.front()?.0;
        self.following.since(begins_s).closeness(&self.law.robot_from_hand, |t_s| self.hand_at(t_s))
    }

    /// The same in words.
    #[must_use]
    pub fn line(&self) -> Option<String> {
        let close = self.closeness()?;
        let turns = match self.law.turning {
            Turning::Scaled(1.0) => format!(", {:.2} deg rms", close.turn_rms_rad.to_degrees()),
            // other turns than the hand's are what was asked for
            Turning::Scaled(_) | Turning::Locked => String::new(),
        };
        Some(format!(
            "{:.0} ms behind the hand ({:.1} mm rms on the way); beside that {:.2} mm rms, max {:.2} mm{turns}",
            close.delay_s * 1e3,
            close.behind_rms_m * 1e3,
            close.rms_m * 1e3,
            close.max_m * 1e3
        ))
    }

    /// Where the hand was: between the two places around it, turned as in the nearer one.
    fn hand_at(&self, t_s: f64) -> Truth {
        let after = self.hand.partition_point(|(at_s, _)| *at_s <= t_s);
        let (before, next) = (after.checked_sub(1).and_then(|at| self.hand.get(at)), self.hand.get(after));
        match (before, next) {
            (Some((a_s, a)), Some((b_s, b))) => {
                let share = (t_s - a_s) / (b_s - a_s);
                let turn = if share < 0.5 { a.0 } else { b.0 };
                (turn, a.1 + (b.1 - a.1) * share)
            }
            (Some((_, only)), None) | (None, Some((_, only))) => *only,
            (None, None) => (nalgebra::Matrix3::identity(), nalgebra::Vector3::zeros()),
        }
    }
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

#[cfg(test)]
mod tests;
