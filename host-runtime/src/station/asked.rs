//! Where the hand asks the tool to be, as far as an operator can know it: for the eyes alone.
//!
//! The goal is the slave's own affair (`tetrad_core::arm::teleop`), and no packet tells it. But the slave says
//! what it latched and when, which motion it has used, by which scale it follows and along which axes; with what was
//! sent, that is the same law here:
//!
//! ```text
//! goal place    = start + scale C (hand now - hand at latch)       scale: as the slave says it is now
//! goal rotation = C (R now  R at latch^T) C^T  start            C = robot_from_hand
//! ```
//!
//! Where the slave lets the hand slip (the workspace, its lead over the arm), the goal stays where it was. Nothing
//! is steered by this.

use super::SlaveAnnouncement;
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::collections::VecDeque;
use tetrad_core::arm::teleop::{Note, Notes};
use tetrad_core::geometry::Pose;
use tetrad_core::wire::{ArmState, ArmStatePacket, MotionPacket};

/// Motions that are remembered until the slave has told of them: a second at 120 a second.
const REMEMBERED: usize = 120;

/// By what the slave follows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Law {
    /// `None`: the tool keeps its orientation.
    turn_scale: Option<f64>,
    robot_from_hand: Matrix3<f64>,
}

/// Hand and tool where they belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Latch {
    hand: Pose<f64>,
    tool: Pose<f64>,
    /// What the slave was asked by the motion that it used last.
    last: Pose<f64>,
    /// Metres of the tool for one of the hand.
    scale: f64,
}

/// Where the hand asks the tool to be, worked out again from what the slave announces and says; for the eyes
/// alone.
#[derive(Clone, Debug, Default)]
pub struct Asked {
    law: Option<Law>,
    sent: VecDeque<(u32, Pose<f64>)>,
    latch: Option<Latch>,
}

impl Asked {
    /// What a slave says of itself; one that does not say how it follows has no goal here.
    pub fn announced(&mut self, slave: &SlaveAnnouncement) {
        let law = |rows: [f64; 9]| Law {
            turn_scale: slave.turn_scale,
            robot_from_hand: Matrix3::from_row_slice(&rows),
        };
        self.law = slave.robot_from_hand.map(law);
        self.latch = None;
    }

    /// What the slave was told.
    pub fn sent(&mut self, motion: &MotionPacket) {
        if self.sent.len() == REMEMBERED {
            self.sent.pop_front();
        }
        self.sent.push_back((motion.sequence, in_full(Pose::from(motion.since_engage))));
    }

    /// What the slave says of the arm.
    pub fn heard(&mut self, state: &ArmStatePacket) {
        let notes = Notes::from_bits(state.notes);
        // on its way home the arm is asked nothing by the hand
        let follows = state.state == ArmState::Engaged && !notes.contains(Note::GoesHome);
        let Some(law) = self.law.filter(|_| follows) else {
            self.latch = None;
            return;
        };
        let noted = |asked: &[Note]| notes.iter().any(|note| asked.contains(&note));
        let used = state.command.map(|command| command.sequence);
        let Some(hand) = used.and_then(|used| self.hand_of(used)) else { return };
        let kept = self.latch.filter(|_| !noted(&[Note::Latched, Note::HandJumped]));
        let mut latch = kept.unwrap_or_else(|| {
            let tool = in_full(Pose::from(state.tool));
            Latch { hand, tool, last: tool, scale: f64::from(state.scale) }
        });
        // what slipped does not count, and the rest goes on from there
        if noted(&[Note::WorkspaceEdge, Note::AheadOfArm]) {
            latch.hand.translation = hand.translation;
            latch.tool.translation = latch.last.translation;
        }
        if noted(&[Note::TurnedAheadOfArm]) {
            latch.hand.rotation = hand.rotation;
            latch.tool.rotation = latch.last.rotation;
        }
        latch.last = law.goal(&latch, &hand);
        self.latch = Some(latch);
    }

    /// Where the newest motion asks the tool to be; `None` while the arm does not follow.
    #[must_use]
    pub fn goal(&self) -> Option<Pose<f64>> {
        let (_, hand) = self.sent.back()?;
        Some(self.law?.goal(self.latch.as_ref()?, hand))
    }

    fn hand_of(&self, sequence: u32) -> Option<Pose<f64>> {
        self.sent.iter().rev().find(|(sent, _)| *sent == sequence).map(|(_, hand)| *hand)
    }
}

impl Law {
    fn goal(&self, latch: &Latch, hand: &Pose<f64>) -> Pose<f64> {
        let c = &self.robot_from_hand;
        let moved: Vector3<f64> = hand.translation - latch.hand.translation;
        let turn = Rotation3::from_matrix_unchecked(hand.rotation * latch.hand.rotation.transpose());
        let scale = self.turn_scale.unwrap_or(0.0);
        let turn = Rotation3::new(turn.scaled_axis() * scale);
        Pose {
            translation: latch.tool.translation + c * moved * latch.scale,
            rotation: c * turn.matrix() * c.transpose() * latch.tool.rotation,
        }
    }
}

fn in_full(pose: Pose<f32>) -> Pose<f64> {
    Pose { rotation: pose.rotation.map(f64::from), translation: pose.translation.map(f64::from) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::RobotAddress;
    use tetrad_core::config::{SlaveConfig, Turning};
    use tetrad_core::wire::{ArmReason, CommandEcho, Transform};
    use tetrad_fixtures::packets;

    /// Twice as far, half as much turned, and the hand's x is the robot's y.
    fn asked() -> Asked {
        let mut config = SlaveConfig::default();
        config.teleop.turning = Turning::Scaled(0.5);
        config.teleop.robot_from_hand = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        let address: RobotAddress = "sim:".parse().unwrap();
        let mut asked = Asked::default();
        asked.announced(&SlaveAnnouncement::new(&address, &config, 0));
        asked
    }

    /// The hand that far along its x, turned that far about it.
    fn motion(sequence: u32, x: f32, turn: f32) -> MotionPacket {
        let rotation = Rotation3::new(Vector3::x() * turn).into_inner();
        let mut rows = [0.0; 9];
        rows.iter_mut().zip(rotation.transpose().iter()).for_each(|(to, from)| *to = *from);
        let since_engage = Transform { translation: [x, 0.0, 0.0], rotation: rows };
        MotionPacket { since_engage, ..packets::motion(1, sequence) }
    }

    fn state(state: ArmState, used: u32, notes: &[Note]) -> ArmStatePacket {
        let echo = CommandEcho {
            session: 1,
            sequence: used,
            received_us: 0,
            solved_after_us: 0,
            written_after_us: 0,
        };
        let notes = notes.iter().fold(0, |bits, note| bits | 1 << *note as u8);
        let tool = Transform { translation: [0.5, 0.0, 0.7], ..Transform::IDENTITY };
        let told = packets::arm_state(state, ArmReason::None);
        ArmStatePacket { command: Some(echo), notes, tool, scale: 2.0, ..told }
    }

    fn near(goal: Option<Pose<f64>>, place: [f64; 3], turned: f64) {
        let goal = goal.unwrap();
        assert!((goal.translation - Vector3::from(place)).amax() < 1e-6, "{goal:?}");
        let turn = Rotation3::from_matrix_unchecked(goal.rotation).scaled_axis();
        // about the robot's y, which is the hand's x
        assert!((turn - Vector3::y() * turned).amax() < 1e-6, "{turn:?}");
    }

    #[test]
    fn the_goal_is_that_of_the_slaves_law() {
        let mut asked = asked();
        asked.sent(&motion(7, 0.1, 0.2));
        assert_eq!(asked.goal(), None, "nothing is latched");
        asked.heard(&state(ArmState::Engaged, 7, &[Note::Latched]));
        near(asked.goal(), [0.5, 0.0, 0.7], 0.0);
        asked.sent(&motion(8, 0.13, 0.6));
        near(asked.goal(), [0.5, 0.06, 0.7], 0.2);
        asked.heard(&state(ArmState::Engaged, 8, &[]));
        near(asked.goal(), [0.5, 0.06, 0.7], 0.2);
        asked.heard(&state(ArmState::Hold, 8, &[]));
        assert_eq!(asked.goal(), None);
        asked.heard(&state(ArmState::Engaged, 8, &[Note::GoesHome]));
        assert_eq!(asked.goal(), None, "the hand does not lead it home");
    }

    #[test]
    fn what_slips_does_not_come_back() {
        let mut asked = asked();
        asked.sent(&motion(1, 0.0, 0.0));
        asked.heard(&state(ArmState::Engaged, 1, &[Note::Latched]));
        asked.sent(&motion(2, 0.1, 0.0));
        asked.heard(&state(ArmState::Engaged, 2, &[]));
        asked.sent(&motion(3, 0.2, 0.0));
        asked.heard(&state(ArmState::Engaged, 3, &[Note::WorkspaceEdge]));
        // the way back begins at once
        asked.sent(&motion(4, 0.19, 0.0));
        near(asked.goal(), [0.5, 0.18, 0.7], 0.0);
    }

    #[test]
    fn a_motion_that_is_not_known_any_more_latches_nothing() {
        let mut asked = asked();
        for sequence in 0..=REMEMBERED as u32 {
            asked.sent(&motion(sequence, 0.0, 0.0));
        }
        asked.heard(&state(ArmState::Engaged, 0, &[Note::Latched]));
        assert_eq!(asked.goal(), None);
        asked.heard(&state(ArmState::Engaged, 1, &[]));
        near(asked.goal(), [0.5, 0.0, 0.7], 0.0);
    }
}
