//! `tetrad.toml`: the arm, the slave's law, its limits and the port.
//!
//! | table | what |
//! |---|---|
//! | `[slave]` | the port: where the arm is |
//! | `[arm]` | lengths, ranges, speeds, the tool |
//! | `[teleop]` | the slave's law |
//! | `[workspace]` | where the tool may be, for the law and the governor |
//! | `[governor]` | what bounds the motion |
//! | `[canopen]` | drives on a CAN bus ([`CanopenConfig`]) |
//!
//! docs/arm.md lists every key with its default. Units stand in the names of the keys.
//!
//! Parsing is strict: an unknown key, a value of another kind or out of range is an error that names
//! the file and the key.

mod governor;
mod puma;
mod teleop;

pub(super) use governor::GovernorToml;
pub(super) use puma::ArmToml;
pub(super) use teleop::TeleopToml;

use super::file::{self, FileToml, Problem, SettingsError};
use super::station::SceneCameraToml;
use crate::robot::{AddressError, RobotAddress};
use nalgebra::{Matrix3, Rotation3};
use serde::Deserialize;
use std::fmt;
use std::path::Path;
use tetrad_core::config::{CanopenConfig, SlaveConfig, SlaveConfigError};

/// What a slave station and the commands about the arm are set to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArmSettings {
    /// The arm, the slave's law, its limits.
    pub slave: SlaveConfig,
    /// What drives the arm, where the file says so.
    pub port: Option<RobotAddress>,
    /// The drives of `canopen:` ports.
    pub canopen: CanopenConfig,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SlaveToml {
    port: Option<String>,
    lead_ms: Option<f64>,
    max_following_deg: Option<f64>,
    blind_timeout_ms: Option<f64>,
    /// Whose motion counts: of a station's file.
    pub(super) operator: Option<String>,
    /// The cameras of its scene: of a station's file.
    #[serde(default)]
    pub(super) camera: Vec<SceneCameraToml>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WorkspaceToml {
    min_mm: Option<[f64; 3]>,
    max_mm: Option<[f64; 3]>,
}

impl ArmSettings {
    /// Reads a file.
    ///
    /// # Errors
    /// [`SettingsError`] that names the file and the key.
    pub fn load(file: &Path) -> Result<Self, SettingsError> {
        Self::parse(&file::read(file)?, &file.display().to_string())
    }

    /// Reads the text of a file; `file` is only for messages. The tables of stations are read too, and
    /// left alone.
    ///
    /// # Errors
    /// [`SettingsError`] that names the key.
    pub fn parse(text: &str, file: &str) -> Result<Self, SettingsError> {
        Self::checked(&FileToml::parse(text, file)?).map_err(|problem| SettingsError::value(file, problem))
    }

    /// What a file's tables say of the arm.
    ///
    /// # Errors
    /// The key, and what would be right.
    pub(super) fn checked(file: &FileToml) -> Result<Self, Problem> {
        let mut settings = Self::default();
        if let Some(arm) = &file.arm {
            settings.slave.puma = arm.config()?;
        }
        let mut workspace = settings.slave.teleop.workspace;
        if let Some(corners) = &file.workspace {
            for axis in 0..3 {
                set(&mut workspace.min_m[axis], corners.min_mm.map(|all| all[axis]), mm);
                set(&mut workspace.max_m[axis], corners.max_mm.map(|all| all[axis]), mm);
            }
        }
        // also without these tables: a workspace or an arm alone may not go with their defaults
        settings.slave.teleop = file.teleop.as_ref().unwrap_or(&TeleopToml::default()).config(&workspace)?;
        let puma = settings.slave.puma;
        settings.slave.governor =
            file.governor.as_ref().unwrap_or(&GovernorToml::default()).config(&workspace, &puma)?;
        let canopen = file.canopen.check().and_then(|()| file.canopen.check_watches());
        canopen.map_err(|error| ("[canopen]".to_owned(), error.to_string()))?;
        settings.canopen = file.canopen;
        if let Some(slave) = &file.slave {
            slave.set(&mut settings)?;
        }
        Ok(settings)
    }
}

impl SlaveToml {
    fn set(&self, settings: &mut ArmSettings) -> Result<(), Problem> {
        let wrong = |key: &str, error: String| (format!("[slave] {key}"), error);
        if let Some(port) = &self.port {
            let address: Result<_, AddressError> = port.parse();
            settings.port = Some(address.map_err(|error| wrong("port", error.to_string()))?);
        }
        let slave = &mut settings.slave;
        set(&mut slave.max_following_rad, self.max_following_deg, f64::to_radians);
        for (value, place) in
            [(self.lead_ms, &mut slave.lead_us), (self.blind_timeout_ms, &mut slave.blind_timeout_us)]
        {
            if let Some(ms) = value {
                // what is negative or none becomes 0, what is too long the longest; the check says which
                *place = (ms * 1000.0).round() as u32;
            }
        }
        let nothing = |value: Option<f64>| value.is_some_and(|value| value.is_nan() || value < 0.0);
        match slave.check() {
            Err(error @ SlaveConfigError::Following) => Err(wrong("max_following_deg", error.to_string())),
            Err(error @ SlaveConfigError::Blind) => Err(wrong("blind_timeout_ms", error.to_string())),
            Err(error @ SlaveConfigError::Lead) => Err(wrong("lead_ms", error.to_string())),
            Ok(()) if nothing(self.lead_ms) => Err(wrong("lead_ms", SlaveConfigError::Lead.to_string())),
            // the other tables have been checked by themselves
            Ok(()) | Err(_) => Ok(()),
        }
    }
}

fn set(place: &mut f64, value: Option<f64>, unit: fn(f64) -> f64) {
    if let Some(value) = value {
        *place = unit(value);
    }
}

/// Millimetres to metres. Divided: 950 mm are then exactly the 0.95 of a default.
fn mm(value: f64) -> f64 {
    value / 1000.0
}

/// What both the law and the governor say of a workspace.
fn workspace_problem() -> Problem {
    ("[workspace] min_mm, max_mm".to_owned(), "each least must be below its largest, within 100 m".to_owned())
}

fn problem(table: &str, keys: &str, error: &dyn fmt::Display) -> Problem {
    (format!("[{table}] {keys}"), error.to_string())
}

/// Roll, pitch and yaw in degrees, about fixed axes in this order, as a rotation.
///
/// # Errors
/// The key, for angles beyond a whole turn: they lose digits, and nobody means them.
fn turned(degrees: [f64; 3], table: &str, key: &str) -> Result<Matrix3<f64>, Problem> {
    if !degrees.iter().all(|angle| (-360.0..=360.0).contains(angle)) {
        return Err(problem(table, key, &"angles from -360 to 360 degrees are needed"));
    }
    let [roll, pitch, yaw] = degrees.map(f64::to_radians);
    Ok(*Rotation3::from_euler_angles(roll, pitch, yaw).matrix())
}

#[cfg(test)]
mod tests;
