//! What a slave tells its operator before anything moves: the link's configuration message, as JSON.
//!
//! It is for the operator's eyes and for what the operator's program may do by itself; what the arm does
//! is decided by the slave's own settings, whoever has read this.

use crate::robot::{RobotAddress, RobotKind};
use serde::{Deserialize, Serialize};
use tetrad_core::config::{SlaveConfig, Turning};
use tetrad_core::wire::VERSION;

/// The message. Fields that are not known are passed over, so that a slave may say more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SlaveAnnouncement {
    /// What kind of station this is: always `slave`.
    pub station: String,
    /// The version of the packets.
    pub wire: u8,
    /// What drives the arm, without where: `sim`, `dry-run`, `val2`, `canopen`.
    pub port: String,
    /// Whether somebody could be hurt by it.
    pub moves_an_arm: bool,
    /// Metres of the tool for one of the hand.
    pub scale: f64,
    /// Radians of the tool for one of the hand; `None`: the tool keeps its orientation, or nobody says.
    #[serde(default)]
    pub turn_scale: Option<f64>,
    /// The robot's base axes from those of the hand, row by row; `None` where nobody says.
    #[serde(default)]
    pub robot_from_hand: Option<[f64; 9]>,
    /// The least corner of where the tool may be, in the robot's base, millimetres.
    pub workspace_min_mm: [f64; 3],
    /// The largest corner.
    pub workspace_max_mm: [f64; 3],
    /// From one set-point to the next, microseconds.
    pub cycle_us: u32,
    /// How many cameras show the scene: pictures come from camera 0 up.
    pub cameras: u8,
}

/// A configuration message that is no slave's.
#[derive(Debug, thiserror::Error)]
pub enum UnreadableAnnouncement {
    /// It is not what a slave sends.
    #[error("what the slave says of itself cannot be read: run the same version of tetrad at both ends")]
    NoJson(#[from] serde_json::Error),
    /// It is another station's.
    #[error("`slave` is to be a slave, but it says it is a {0}: name another peer in [operator]")]
    NoSlave(String),
}

impl SlaveAnnouncement {
    /// What a slave with these settings says.
    #[must_use]
    pub fn new(address: &RobotAddress, config: &SlaveConfig, cameras: u8) -> Self {
        let port = match address.kind() {
            RobotKind::Simulated(_) => "sim",
            RobotKind::DryRun(_) => "dry-run",
            RobotKind::Val2(_) => "val2",
            RobotKind::Canopen(_) => "canopen",
        };
        let workspace = &config.teleop.workspace;
        let mm = |m: f64| m * 1000.0;
        let mut rows = [0.0; 9];
        let by_rows = config.teleop.robot_from_hand.transpose();
        rows.iter_mut().zip(by_rows.iter()).for_each(|(to, from)| *to = *from);
        Self {
            station: "slave".to_owned(),
            wire: VERSION,
            port: port.to_owned(),
            moves_an_arm: address.moves_an_arm(),
            scale: config.teleop.scale,
            turn_scale: match config.teleop.turning {
                Turning::Scaled(scale) => Some(scale),
                Turning::Locked => None,
            },
            robot_from_hand: Some(rows),
            workspace_min_mm: workspace.min_m.map(mm),
            workspace_max_mm: workspace.max_m.map(mm),
            cycle_us: config.governor.cycle_us,
            cameras,
        }
    }

    /// The bytes of the message.
    ///
    /// # Errors
    /// [`serde_json::Error`] for settings with a number that is not finite.
    pub fn encode(&self) -> Result<Vec<u8>, serde_json::Error> {
        serde_json::to_vec(self)
    }

    /// Reads a message.
    ///
    /// # Errors
    /// [`UnreadableAnnouncement`]
    pub fn decode(message: &[u8]) -> Result<Self, UnreadableAnnouncement> {
        let announcement: Self = serde_json::from_slice(message)?;
        if announcement.station == "slave" {
            Ok(announcement)
        } else {
            Err(UnreadableAnnouncement::NoSlave(announcement.station))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of docs/link.md.
    fn documented() -> &'static str {
        let document = include_str!("../../../docs/link.md");
        let (_, block) = document.split_once("```json slave\n").expect("the block");
        block.split_once("```").expect("it ends").0
    }

    #[test]
    fn what_is_said_is_what_the_document_shows() {
        let address: RobotAddress = "sim:?seed=3".parse().unwrap();
        let announcement = SlaveAnnouncement::new(&address, &SlaveConfig::default(), 2);
        assert_eq!(SlaveAnnouncement::decode(documented().as_bytes()).unwrap(), announcement);
        assert_eq!(SlaveAnnouncement::decode(&announcement.encode().unwrap()).unwrap(), announcement);
    }

    #[test]
    fn an_arm_of_iron_is_told_apart() {
        for (address, port, moves) in
            [("sim:", "sim", false), ("dry-run:x.csv", "dry-run", false), ("canopen:can0", "canopen", true)]
        {
            let told = SlaveAnnouncement::new(&address.parse().unwrap(), &SlaveConfig::default(), 0);
            assert_eq!((told.port.as_str(), told.moves_an_arm), (port, moves));
        }
    }

    #[test]
    fn what_is_no_slaves_word_is_refused() {
        let said = |text: &str| SlaveAnnouncement::decode(text.as_bytes()).map_err(|error| error.to_string());
        assert!(said("{}").unwrap_err().contains("the same version"));
        let camera = documented().replace("\"slave\"", "\"camera\"");
        assert!(said(&camera).unwrap_err().contains("it says it is a camera"));
        let older =
            documented().lines().filter(|line| !line.contains("turn_scale") && !line.contains("_hand"));
        let older = SlaveAnnouncement::decode(older.collect::<String>().as_bytes()).unwrap();
        assert_eq!((older.turn_scale, older.robot_from_hand), (None, None));
        let more = documented().replacen('{', "{\"mood\": \"good\",", 1);
        assert!(said(&more).is_ok());
    }
}
