//! `tetrad.toml` as it is written: its tables, and why a file is refused.
//!
//! One file a station; which tables it needs is the matter of whoever reads it. Parsing is strict: an
//! unknown key, a value of another kind or out of range is an error that names the file and the key.

use super::arm::{ArmToml, GovernorToml, SlaveToml, TeleopToml, WorkspaceToml};
use super::station::{CameraToml, ConsoleToml, OperatorToml, PeerToml, StationToml};
use crate::text_file;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use tetrad_core::config::CanopenConfig;

/// Why a file of settings is refused.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// It cannot be read.
    #[error("cannot read {}", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        #[source]
        cause: std::io::Error,
    },
    /// It is not TOML, or a key is unknown or of another kind; the message has the line.
    #[error("{file}: {problem}")]
    Syntax {
        /// The file as it was named.
        file: String,
        /// The line, the place in it, and what would be right.
        problem: String,
    },
    /// A value that cannot be worked with.
    #[error("{file}: {key}: {problem}")]
    Value {
        /// The file as it was named.
        file: String,
        /// The table and the key, as `[arm] min_deg`.
        key: String,
        /// What would be right.
        problem: String,
    },
}

/// A key and what is wrong with its value.
pub(super) type Problem = (String, String);

/// Every table there is.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileToml {
    pub(super) station: Option<StationToml>,
    #[serde(default)]
    pub(super) peer: Vec<PeerToml>,
    pub(super) camera: Option<CameraToml>,
    pub(super) operator: Option<OperatorToml>,
    pub(super) console: Option<ConsoleToml>,
    pub(super) slave: Option<SlaveToml>,
    pub(super) arm: Option<ArmToml>,
    pub(super) teleop: Option<TeleopToml>,
    pub(super) workspace: Option<WorkspaceToml>,
    pub(super) governor: Option<GovernorToml>,
    #[serde(default)]
    pub(super) canopen: CanopenConfig,
}

impl FileToml {
    /// Understands the text of a file; `file` is only for messages.
    ///
    /// # Errors
    /// [`SettingsError::Syntax`]
    pub(super) fn parse(text: &str, file: &str) -> Result<Self, SettingsError> {
        toml::from_str(text).map_err(|error| SettingsError::Syntax {
            file: file.to_owned(),
            problem: error.to_string().trim_end().to_owned(),
        })
    }
}

impl SettingsError {
    /// The error of a key in a file.
    pub(super) fn value(file: &str, (key, problem): Problem) -> Self {
        Self::Value { file: file.to_owned(), key, problem }
    }
}

/// The text of a file.
///
/// # Errors
/// [`SettingsError::Unreadable`]
pub(super) fn read(file: &Path) -> Result<String, SettingsError> {
    text_file::read(file).map_err(|cause| SettingsError::Unreadable { file: file.to_owned(), cause })
}
