//! `[teleop]`: the slave's law.

use super::super::file::Problem;
use super::{mm, problem, set, turned};
use nalgebra::Matrix3;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use tetrad_core::config::{TeleopConfig, TeleopConfigError, TeleopMode, Turning, Workspace};

enum ModeToml {
    SinceEngage,
    Paper,
}

fn mode<'de, D: Deserializer<'de>>(text: D) -> Result<Option<ModeToml>, D::Error> {
    match String::deserialize(text)?.as_str() {
        "since-engage" => Ok(Some(ModeToml::SinceEngage)),
        "paper" => Ok(Some(ModeToml::Paper)),
        other => Err(D::Error::custom(format!(
            "'{other}' is no mode: write mode = \"since-engage\" or \"paper\", in small letters"
        ))),
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::settings) struct TeleopToml {
    #[serde(default, deserialize_with = "mode")]
    mode: Option<ModeToml>,
    scale: Option<f64>,
    turn_scale: Option<f64>,
    lock_turns: Option<bool>,
    robot_from_hand: Option<[[f64; 3]; 3]>,
    robot_from_hand_rpy_deg: Option<[f64; 3]>,
    max_lead_mm: Option<f64>,
    max_lead_deg: Option<f64>,
    command_timeout_ms: Option<f64>,
    hold_to_run_timeout_ms: Option<f64>,
    predicted_ms: Option<f64>,
    resume_ms: Option<f64>,
}

impl TeleopToml {
    /// The law in this workspace.
    ///
    /// # Errors
    /// The keys of what cannot be worked with, and why.
    pub(super) fn config(&self, workspace: &Workspace) -> Result<TeleopConfig, Problem> {
        let mut law = TeleopConfig { workspace: *workspace, ..TeleopConfig::default() };
        match self.mode {
            Some(ModeToml::Paper) => law.mode = TeleopMode::Paper,
            Some(ModeToml::SinceEngage) => law.mode = TeleopMode::SinceEngage,
            None => {}
        }
        set(&mut law.scale, self.scale, f64::from);
        match (self.lock_turns, self.turn_scale) {
            (Some(true), Some(_)) => {
                let both = "locked turns have no scale: leave one of both out";
                return Err(("[teleop] lock_turns, turn_scale".to_owned(), both.to_owned()));
            }
            (Some(true), None) => law.turning = Turning::Locked,
            (_, Some(scale)) => law.turning = Turning::Scaled(scale),
            (_, None) => {}
        }
        match (self.robot_from_hand, self.robot_from_hand_rpy_deg) {
            (Some(_), Some(_)) => {
                let both = "the same said twice: leave one of both out";
                return Err((
                    "[teleop] robot_from_hand, robot_from_hand_rpy_deg".to_owned(),
                    both.to_owned(),
                ));
            }
            (Some(rows), None) => law.robot_from_hand = Matrix3::from_fn(|row, column| rows[row][column]),
            (None, Some(angles)) => {
                law.robot_from_hand = turned(angles, "teleop", "robot_from_hand_rpy_deg")?;
            }
            (None, None) => {}
        }
        set(&mut law.max_lead_m, self.max_lead_mm, mm);
        set(&mut law.max_lead_rad, self.max_lead_deg, f64::to_radians);
        for (us, ms) in [
            (&mut law.command_timeout_us, self.command_timeout_ms),
            (&mut law.hold_to_run_timeout_us, self.hold_to_run_timeout_ms),
            (&mut law.predicted_us, self.predicted_ms),
            (&mut law.resume_us, self.resume_ms),
        ] {
            if let Some(ms) = ms {
                // what does not fit ends as 0 or the largest, and is refused for that
                *us = (ms * 1000.0).round() as u32;
            }
        }
        law.check().map_err(|error| {
            let keys = match error {
                TeleopConfigError::Scale => "scale, turn_scale",
                TeleopConfigError::RobotFromHand => "robot_from_hand",
                TeleopConfigError::Workspace => return super::workspace_problem(),
                TeleopConfigError::Lead => "max_lead_mm, max_lead_deg",
                TeleopConfigError::CommandTimeout => "command_timeout_ms",
                TeleopConfigError::HoldToRunTimeout => "hold_to_run_timeout_ms",
                TeleopConfigError::Predicted => "predicted_ms",
                TeleopConfigError::Resume | TeleopConfigError::ResumeTooShort => "resume_ms",
                // no key sets it
                TeleopConfigError::Believed => "",
            };
            problem("teleop", keys, &error)
        })?;
        Ok(law)
    }
}
