//! `tetrad.toml` of a station: who it is, whom it talks to, and what it does.
//!
//! | table | what | read by |
//! |---|---|---|
//! | `[station]` | name, keys, where it listens | every station |
//! | `[[peer]]` | the stations it talks to; nobody else gets in | every station |
//! | `[camera]` | one camera and its colours | `tetrad camera` |
//! | `[operator]`, `[[operator.camera]]` | the hand, its cameras, where the arm is | `tetrad operator` |
//! | `[console]` | where the operator's page is served, and to whom | `tetrad operator` |
//! | `[slave]`, `[[slave.camera]]` and the [arm's tables](super::arm) | the arm, the cameras of its scene | `tetrad slave` |
//!
//! docs/stations.md lists every key with its default. What a file names (keys, colours) lies beside it:
//! such a path is relative to the file.

mod camera;
mod console;
mod network;
mod operator;
mod slave;

pub use camera::{CameraSettings, CameraStart, LocalCamera};
pub use console::{ConsolePort, ConsoleSettings, ConsoleTls};
pub use network::NetworkSettings;
pub use operator::{HandCamera, HandCameraSettings, OperatorSettings, SlavePlace};
pub use slave::{SceneCamera, SceneCameraSettings, SlaveSettings};

pub(super) use camera::CameraToml;
pub(super) use console::ConsoleToml;
pub(super) use network::{PeerToml, StationToml};
pub(super) use operator::OperatorToml;
pub(super) use slave::SceneCameraToml;

use super::file::{self, FileToml, Problem, SettingsError};
use std::path::{Path, PathBuf};

/// A station's file, checked: what is not in doubt before anything is opened.
#[derive(Clone, Debug, PartialEq)]
pub struct StationSettings {
    /// The file, for messages.
    pub file: PathBuf,
    /// Who the station is and whom it talks to; `None` for one that is alone.
    pub network: Option<NetworkSettings>,
    /// What makes it a camera station.
    pub camera: Option<CameraSettings>,
    /// What makes it an operator's.
    pub operator: Option<OperatorSettings>,
    /// Where its console is served; `None` for one without.
    pub console: Option<ConsoleSettings>,
    /// The arm; the default one where the file says nothing of it.
    pub slave: SlaveSettings,
}

impl StationSettings {
    /// Reads a file, and the colours and scenes that it names.
    ///
    /// # Errors
    /// [`SettingsError`] that names the file, the key, and what would mend it.
    pub fn load(file: &Path) -> Result<Self, SettingsError> {
        let label = file.display().to_string();
        let parsed = FileToml::parse(&file::read(file)?, &label)?;
        Self::checked(&parsed, file).map_err(|problem| SettingsError::value(&label, problem))
    }

    fn checked(toml: &FileToml, file: &Path) -> Result<Self, Problem> {
        let dir = file.parent().unwrap_or(Path::new(""));
        let network = NetworkSettings::checked(toml.station.as_ref(), &toml.peer, file)?;
        let settings = Self {
            file: file.to_owned(),
            camera: toml.camera.as_ref().map(|camera| camera.checked("[camera]", dir)).transpose()?,
            operator: toml.operator.as_ref().map(|operator| operator.checked(dir)).transpose()?,
            console: toml.console.as_ref().map(|console| console.checked(dir)).transpose()?,
            slave: SlaveSettings::checked(toml, dir)?,
            network,
        };
        if settings.camera.is_some() && settings.network.is_none() {
            let mend = "there is no [station], and a camera station needs it: docs/stations.md has a whole \
                        file for each station";
            return Err(("[camera]".to_owned(), mend.to_owned()));
        }
        if settings.console.is_some() && settings.operator.is_none() {
            let mend = "it is the operator's, and there is no [operator]: leave it out".to_owned();
            return Err(("[console]".to_owned(), mend));
        }
        let here = settings.operator.as_ref().is_some_and(|operator| operator.slave == SlavePlace::Here);
        if let Some(name) = settings.slave.operator.as_ref().filter(|_| here) {
            let mend = format!(
                "the arm is moved from here ([operator] slave = \"here\"), not by {name} too: leave one of both out"
            );
            return Err(("[slave] operator".to_owned(), mend));
        }
        for (key, name) in settings.peers_meant() {
            let known = settings.network.as_ref().is_some_and(|network| network.has_peer(name));
            if !known {
                let mend = format!("no [[peer]] is called `{name}`: add one with name = \"{name}\"");
                return Err((key, mend));
            }
        }
        Ok(settings)
    }

    /// The peers that other tables name, each with its key.
    fn peers_meant(&self) -> Vec<(String, &crate::link::StationName)> {
        let mut meant = Vec::new();
        if let Some(operator) = &self.operator {
            for (index, camera) in operator.cameras.iter().enumerate() {
                if let HandCamera::Station(name) = &camera.place {
                    meant.push((format!("[[operator.camera]] {} source", index + 1), name));
                }
            }
            if let SlavePlace::Station(name) = &operator.slave {
                meant.push(("[operator] slave".to_owned(), name));
            }
        }
        if let Some(name) = &self.slave.operator {
            meant.push(("[slave] operator".to_owned(), name));
        }
        meant
    }
}

/// A number within bounds, or the sentence that asks for one.
fn within(
    key: &str,
    value: Option<f64>,
    range: std::ops::RangeInclusive<f64>,
    unit: &str,
) -> Result<Option<f64>, Problem> {
    match value {
        Some(x) if !range.contains(&x) => {
            let (least, most) = range.into_inner();
            Err((key.to_owned(), format!("a number from {least} to {most}{unit} is needed, not {x}")))
        }
        x => Ok(x),
    }
}

#[cfg(test)]
mod tests;
