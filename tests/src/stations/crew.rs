//! The four stations, started and ended together.

use super::cell::Cell;
use super::station::{Ended, Station};
use std::time::Duration;

/// The three that wait for the operator.
pub(super) struct Others {
    pub(super) left: Station,
    pub(super) right: Station,
    pub(super) slave: Station,
}

impl Others {
    pub(super) fn start(cell: &Cell) -> Result<Self, String> {
        let out = cell.out("slave").display().to_string();
        Ok(Self {
            left: cell.start("camera", "left", &[])?,
            right: cell.start("camera", "right", &[])?,
            slave: cell.start("slave", "slave", &["--out", &out])?,
        })
    }

    pub(super) const fn each(&self) -> [&Station; 3] {
        [&self.left, &self.right, &self.slave]
    }

    /// Ends all three; each has to end well.
    pub(super) fn end(self) -> Result<[Ended; 3], String> {
        let ended = [self.left.end()?, self.right.end()?, self.slave.end()?];
        ended.iter().try_for_each(well)?;
        Ok(ended)
    }
}

/// An operator that holds its button by itself, and ends by itself after so long.
pub(super) fn operator(cell: &Cell, length: Duration) -> Result<Station, String> {
    let out = cell.out("operator").display().to_string();
    let seconds = length.as_secs_f64().to_string();
    let always = ["--hold-to-run", "always", "--seconds", &seconds, "--out", &out];
    cell.start("operator", "operator", &always)
}

/// Whether a station ended well.
pub(super) fn well(ended: &Ended) -> Result<(), String> {
    if ended.status.success() {
        return Ok(());
    }
    Err(format!("{} ended with {}:\n{}", ended.name, ended.status, ended.said))
}
