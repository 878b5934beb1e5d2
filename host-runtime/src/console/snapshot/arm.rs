//! What the pages are told of the arm.

use crate::station::{SlaveAnnouncement, arm_words};
use serde::Serialize;
use tetrad_core::arm::teleop::{Note, Notes};
use tetrad_core::geometry::Pose;
use tetrad_core::wire::{ArmState, ArmStatePacket};

/// An arm that was not heard for longer may do anything meanwhile, microseconds: as old as a picture may be that
/// somebody steers by. What a hand does, and what a camera sees, is as little known then.
pub const SILENT_US: u64 = 500_000;

/// The arm, as the slave tells it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ArmView {
    /// The law's state in one word; while it is silent, what it was last.
    pub state: &'static str,
    /// Nothing was heard of it for [`SILENT_US`], or nobody is there: it may stand, or move, as nobody knows.
    pub silent: bool,
    /// State, reason and what would mend it; that nobody knows, while it is silent.
    pub standing: String,
    /// How its controller stands, in words.
    pub controller: String,
    /// What keeps it from following as it was asked; nothing while it is silent.
    pub limits: Vec<String>,
    /// Microseconds since its last state came.
    pub age_us: u64,
    /// The slave's clock then, microseconds.
    pub slave_time_us: u64,
    /// Measured joints, degrees; `None` before the first reading.
    pub joints_deg: Option<[f32; 6]>,
    /// What the joints were told, degrees.
    pub set_point_deg: [f32; 6],
    /// Where the tool is by that, millimetres in the robot's base.
    pub tool_mm: [f32; 3],
    /// And how it is turned, row by row.
    pub tool_rotation: [f32; 9],
    /// Metres of the tool for one of the hand: of the press that is on, or of the next.
    pub scale: f32,
    /// Whether it goes home, or is there, and the button is still held for that.
    pub goes_home: bool,
    /// How fast the tool is asked to be, of what its speed limit allows, 0 to 1.
    pub speed_share: f32,
    /// How old the newest motion was by the slave's clock, microseconds.
    pub command_age_us: Option<u64>,
    /// How long ago the slave had heard of the button, microseconds.
    pub button_age_us: Option<u32>,
}

/// How the slave follows: its own settings, which no page changes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlaveView {
    /// What drives the arm: `sim`, `dry-run`, `val2`, `canopen`.
    pub port: String,
    /// Whether somebody could be hurt by it.
    pub moves_an_arm: bool,
    /// Metres of the tool for one of the hand, at the most.
    pub scale: f64,
    /// Radians of the tool for one of the hand; `None`: it keeps its orientation.
    pub turn_scale: Option<f64>,
    /// The robot's base axes from those of the hand, row by row.
    pub robot_from_hand: Option<[f64; 9]>,
    /// The least corner of where the tool may be, millimetres in the robot's base.
    pub workspace_min_mm: [f64; 3],
    /// The largest corner.
    pub workspace_max_mm: [f64; 3],
    /// How many cameras show its scene: the first is the left eye.
    pub cameras: u8,
}

/// A pose of the tool, in the robot's base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GoalView {
    /// Millimetres.
    pub place_mm: [f64; 3],
    /// Row by row.
    pub rotation: [f64; 9],
}

impl ArmView {
    /// The arm by a state that came at `received_us`; `connected`: whether its slave is there now.
    #[must_use]
    pub fn of(packet: &ArmStatePacket, received_us: u64, connected: bool, now_us: u64) -> Self {
        let age_us = now_us.saturating_sub(received_us);
        let silent = !connected || age_us > SILENT_US;
        let degrees = |joints: [f32; 6]| joints.map(f32::to_degrees);
        Self {
            state: arm_words::state_name(packet.state),
            silent,
            standing: if silent { silence(age_us) } else { arm_words::standing(packet) },
            controller: arm_words::controller(packet.controller),
            limits: if silent { Vec::new() } else { arm_words::limits(packet) },
            age_us,
            slave_time_us: packet.time_us,
            joints_deg: packet.measured.map(|measured| degrees(measured.joints)),
            set_point_deg: degrees(packet.set_point),
            tool_mm: packet.tool.translation.map(|m| m * 1e3),
            tool_rotation: packet.tool.rotation,
            scale: packet.scale,
            goes_home: Notes::from_bits(packet.notes).contains(Note::GoesHome),
            speed_share: packet.speed_share,
            command_age_us: packet.command_age_us(),
            button_age_us: packet.buttons_age_us,
        }
    }

    /// Whether it is known to follow the hand, or to go home, now.
    #[must_use]
    pub fn is_engaged(&self) -> bool {
        !self.silent && self.state == arm_words::state_name(ArmState::Engaged)
    }
}

/// What is said of an arm that has said nothing for so long.
pub(crate) fn silence(age_us: u64) -> String {
    format!("silent for {:.1} s: nobody knows what the arm does", age_us as f64 / 1e6)
}

impl SlaveView {
    /// What a slave says of itself.
    #[must_use]
    pub fn of(slave: &SlaveAnnouncement) -> Self {
        Self {
            port: slave.port.clone(),
            moves_an_arm: slave.moves_an_arm,
            scale: slave.scale,
            turn_scale: slave.turn_scale,
            robot_from_hand: slave.robot_from_hand,
            workspace_min_mm: slave.workspace_min_mm,
            workspace_max_mm: slave.workspace_max_mm,
            cameras: slave.cameras,
        }
    }
}

impl GoalView {
    /// A goal in metres.
    #[must_use]
    pub fn of(goal: &Pose<f64>) -> Self {
        let mut rotation = [0.0; 9];
        rotation.iter_mut().zip(goal.rotation.transpose().iter()).for_each(|(to, from)| *to = *from);
        Self { place_mm: (goal.translation * 1e3).into(), rotation }
    }
}

/// Whether the arm follows the hand.
#[must_use]
pub const fn is_engaged(packet: &ArmStatePacket) -> bool {
    matches!(packet.state, ArmState::Engaged) && !Notes::from_bits(packet.notes).contains(Note::GoesHome)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::wire::ArmReason;
    use tetrad_fixtures::packets;

    /// An engaged arm that something limits, heard so long ago.
    fn heard(age_us: u64, connected: bool) -> ArmView {
        let packet =
            ArmStatePacket { limits: 1 << 5, ..packets::arm_state(ArmState::Engaged, ArmReason::None) };
        ArmView::of(&packet, 1_000_000, connected, 1_000_000 + age_us)
    }

    #[test]
    fn an_arm_that_is_not_heard_any_more_is_not_said_to_follow() {
        let fresh = heard(SILENT_US, true);
        assert!(!fresh.silent && fresh.is_engaged());
        assert_eq!((fresh.standing.as_str(), fresh.limits.len()), ("engaged", 1));
        let silent = heard(3_200_000, true);
        assert!(silent.silent && !silent.is_engaged());
        assert_eq!(silent.standing, "silent for 3.2 s: nobody knows what the arm does");
        assert_eq!((silent.state, silent.limits.len()), ("engaged", 0));
    }

    #[test]
    fn a_slave_that_has_gone_is_silent_at_once() {
        let gone = heard(20_000, false);
        assert!(gone.silent && !gone.is_engaged());
        assert!(gone.standing.starts_with("silent for 0.0 s: nobody knows"), "{}", gone.standing);
    }
}
