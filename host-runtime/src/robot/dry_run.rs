//! No arm at all: every set-point goes to a CSV file, and the joints are at once where they are sent.
//!
//! The file has the columns `t,q1..q6` (seconds since the port was opened, radians) and can be given to
//! `tetrad arm fk`. Only what an earlier dry run recorded is written over. A port that is stricter than some arms: it refuses what breaks the contract of
//! [`tetrad_core::arm::port`], so that a dry run tells whether a station keeps it.

use super::Robot;
use super::clock::Clock;
use super::start::start_joints;
use crate::output::{CsvFile, OutputError};
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::arm::set_point::SetPointGate;
use tetrad_core::config::PumaConfig;

/// How long it goes without a set-point before it says so, microseconds: 100 ms as for commands, or two
/// cycles where those are longer.
const WATCHDOG_US: u64 = 100_000;

/// The first line of the file.
const HEADER: &str = "t,q1,q2,q3,q4,q5,q6";

/// Why a dry run cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum DryRunError {
    /// There is a file of something else.
    #[error(
        "{} is there and no dry run's record (its first line would be {HEADER}): it is left as it is; name \
         another file, or take it away first",
        file.display()
    )]
    NotOurs {
        /// The file.
        file: PathBuf,
    },
    /// The folder is missing.
    #[error("there is no folder {}: make it first, or name a file elsewhere", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// It cannot be looked into.
    #[error("cannot read {}, to see whether it may be written over; name another file", file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system said.
        #[source]
        cause: io::Error,
    },
    /// It cannot be written.
    #[error(transparent)]
    Unwritten(#[from] OutputError),
}

/// The port.
#[derive(Debug)]
pub struct DryRun {
    file: CsvFile,
    clock: Clock,
    gate: SetPointGate,
    joints: Joints<f64>,
    status: PortStatus,
    last_us: u64,
    watchdog_us: u64,
    written: u64,
    reason: Option<String>,
}

impl DryRun {
    /// Makes the file, or writes over an earlier record, for a set-point every `cycle_us` microseconds.
    /// The joints stand where the simulated arm's do.
    ///
    /// # Errors
    /// [`DryRunError`] when the file is of something else or cannot be written.
    pub fn create(file: &Path, puma: &PumaConfig, cycle_us: u32) -> Result<Self, DryRunError> {
        Self::with_clock(file, puma, cycle_us, Clock::wall())
    }

    /// The same by another clock.
    ///
    /// # Errors
    /// [`DryRunError`] when the file is of something else or cannot be written.
    pub fn with_clock(
        file: &Path,
        puma: &PumaConfig,
        cycle_us: u32,
        clock: Clock,
    ) -> Result<Self, DryRunError> {
        look_before(file)?;
        Ok(Self {
            file: CsvFile::create(Path::new(""), file, HEADER)?,
            watchdog_us: WATCHDOG_US.max(2 * u64::from(cycle_us)),
            gate: SetPointGate::new(puma, f64::from(cycle_us) / 1e6),
            clock,
            joints: start_joints(puma),
            status: PortStatus::Disabled,
            last_us: 0,
            written: 0,
            reason: None,
        })
    }
}

/// Whether the file may be made, or written over: by its first line, and an empty one always. What is no
/// file but a device or a pipe has nothing to lose.
fn look_before(file: &Path) -> Result<(), DryRunError> {
    let unreadable = |cause| DryRunError::Unreadable { file: file.to_owned(), cause };
    match std::fs::metadata(file) {
        Ok(found) if !found.is_file() || found.len() == 0 => return Ok(()),
        Ok(_) => {}
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let folder = file.parent().unwrap_or(file);
            return match folder.as_os_str().is_empty() || folder.is_dir() {
                true => Ok(()),
                false => Err(DryRunError::NoFolder { folder: folder.to_owned() }),
            };
        }
        Err(cause) => return Err(unreadable(cause)),
    }
    let mut first = Vec::new();
    let read = File::open(file).and_then(|found| found.take(HEADER.len() as u64 + 1).read_to_end(&mut first));
    read.map_err(unreadable)?;
    match first.strip_prefix(HEADER.as_bytes()) {
        Some(b"" | b"\n" | b"\r") => Ok(()),
        _ => Err(DryRunError::NotOurs { file: file.to_owned() }),
    }
}

impl RobotPort<f64> for DryRun {
    fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
        Ok(JointReading { joints: self.joints, age_us: 0 })
    }

    fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        let now_us = self.clock.now_us();
        if self.status() != PortStatus::Ready {
            return Err(PortError::NotReady(self.status()));
        }
        self.gate.check(&self.joints, joints)?;
        let written = self.file.row(|row| {
            row.time(now_us as f64 / 1e6);
            for angle in joints {
                row.field(angle);
            }
        });
        if let Err(error) = written {
            self.reason = Some(format!("{error}: {}", error.cause));
            self.status = PortStatus::Lost;
            return Err(PortError::Lost);
        }
        self.joints = *joints;
        self.last_us = now_us;
        self.written += 1;
        Ok(())
    }

    fn enable(&mut self) -> Result<(), PortError> {
        self.last_us = self.clock.now_us();
        self.status = PortStatus::Ready;
        self.reason = None;
        Ok(())
    }

    fn stop(&mut self) -> Result<(), PortError> {
        if self.status == PortStatus::Ready {
            self.status = PortStatus::Stopped;
        }
        Ok(())
    }

    fn status(&self) -> PortStatus {
        let late = self.clock.now_us().saturating_sub(self.last_us) > self.watchdog_us;
        if self.status == PortStatus::Ready && late { PortStatus::Stopped } else { self.status }
    }
}

impl Robot for DryRun {
    fn reason(&self) -> Option<String> {
        match (self.status, self.status()) {
            (PortStatus::Ready, PortStatus::Stopped) => {
                Some(format!("no set-point came for {} ms", self.watchdog_us / 1000))
            }
            _ => self.reason.clone(),
        }
    }

    fn report(&self) -> Vec<String> {
        vec![format!("{} set-points recorded", self.written)]
    }
}

#[cfg(test)]
mod tests;
