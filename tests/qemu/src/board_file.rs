//! A real board, named by a file.

use crate::clip::{Sequence, others, sequences};
use crate::recorded;
use crate::tape::Tape;
use serde::Deserialize;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// What a line may be asked for, bits a second.
const BAUDS: std::ops::RangeInclusive<u32> = 9_600..=12_000_000;

/// The frames that the repository keeps.
const RECORDED: &str = "recorded";

/// Where a board is, how its program gets onto it, and what it is shown.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoardFile {
    /// The serial port.
    pub port: PathBuf,
    /// Of the serial line, bits a second.
    #[serde(default = "default_baud")]
    pub baud: u32,
    /// What loads the program and starts it; without it the board runs it already.
    pub probe: Option<Probe>,
    /// What is shown, by name; without it, the recorded frames and the nine sequences.
    #[serde(default = "default_sequences")]
    pub sequences: Vec<String>,
    /// Of each sequence no more pictures than these.
    pub pictures: Option<NonZeroUsize>,
}

/// How a board is told what to run.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// A command and its arguments, which ends when the board runs. It is started in the file's folder.
    pub run: Vec<String>,
}

fn default_baud() -> u32 {
    921_600
}

fn default_sequences() -> Vec<String> {
    let scenes = sequences().map(|sequence| sequence.scene.to_owned());
    std::iter::once(RECORDED.to_owned()).chain(scenes).collect()
}

impl BoardFile {
    /// Reads the file.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn read(path: &Path) -> Result<Self, String> {
        let wrong = |what: String| format!("{}: {what}", path.display());
        let text = fs::read_to_string(path).map_err(|error| {
            wrong(format!(
                "{error}; it names the board: port = \"/dev/ttyACM0\", and what firmware/README.md has"
            ))
        })?;
        let file: Self = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        file.check().map_err(wrong)?;
        Ok(file)
    }

    fn check(&self) -> Result<(), String> {
        if !BAUDS.contains(&self.baud) {
            let (least, most) = BAUDS.into_inner();
            return Err(format!("baud = {}: from {least} to {most}", self.baud));
        }
        if self.probe.as_ref().is_some_and(|probe| probe.run.is_empty()) {
            return Err(
                "probe.run is empty: name the command that loads the program, or leave probe out".into()
            );
        }
        if self.sequences.is_empty() {
            return Err("sequences is empty: name one, or leave it out for all".into());
        }
        self.sequences.iter().try_for_each(|name| named(name).map(drop))
    }

    /// What is shown under a name.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn tape(&self, name: &str) -> Result<Tape, String> {
        let most = self.pictures.map_or(usize::MAX, NonZeroUsize::get);
        let mut tape = match named(name)? {
            None => recorded::tape(),
            Some(mut sequence) => {
                // (the first is that in which the balls are taught)
                sequence.frames.truncate(most - 1);
                Tape::of(&sequence)
            }
        };
        tape.end_behind(most);
        Ok(tape)
    }
}

/// The sequence of that name; `None` for the recorded frames.
fn named(name: &str) -> Result<Option<Sequence>, String> {
    if name == RECORDED {
        return Ok(None);
    }
    let mut all = sequences().into_iter().chain(others());
    all.find(|sequence| sequence.scene == name).map(Some).ok_or_else(|| {
        let names: Vec<&str> = sequences().iter().chain(&others()).map(|sequence| sequence.scene).collect();
        format!("sequences: there is no {name:?}; there are {RECORDED}, {}", names.join(", "))
    })
}
