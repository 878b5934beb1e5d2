//! No arm at all: every set-point goes to a CSV file, and the joints are at once where they are sent.
//!
//! The file has the columns `t,q1..q6` (seconds since the port was opened, radians) and can be given to
//! `tetrad arm fk`. A port that is stricter than some arms: it refuses what breaks the contract of
//! [`tetrad_core::arm::port`], so that a dry run tells whether a station keeps it.

use super::Robot;
use super::clock::Clock;
use super::set_point::SetPointGate;
use super::start::start_joints;
use crate::output::{CsvFile, OutputError};
use std::path::Path;
use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::PumaConfig;

/// How long it goes without a set-point before it says so, microseconds: 100 ms as for commands.
const WATCHDOG_US: u64 = 100_000;

/// The cycle that set-points are expected in, seconds: 100 Hz.
const CYCLE_S: f64 = 0.01;

/// The port.
#[derive(Debug)]
pub struct DryRun {
    file: CsvFile,
    clock: Clock,
    gate: SetPointGate,
    joints: Joints<f64>,
    status: PortStatus,
    last_us: u64,
    written: u64,
    reason: Option<String>,
}

impl DryRun {
    /// Makes (or empties) the file. The joints stand where the simulated arm's do.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn create(file: &Path, puma: &PumaConfig) -> Result<Self, OutputError> {
        Self::with_clock(file, puma, Clock::wall())
    }

    /// The same by another clock.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be written.
    pub fn with_clock(file: &Path, puma: &PumaConfig, clock: Clock) -> Result<Self, OutputError> {
        Ok(Self {
            file: CsvFile::create(Path::new(""), file, "t,q1,q2,q3,q4,q5,q6")?,
            clock,
            gate: SetPointGate::new(puma, CYCLE_S),
            joints: start_joints(puma),
            status: PortStatus::Disabled,
            last_us: 0,
            written: 0,
            reason: None,
        })
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
        let late = self.clock.now_us().saturating_sub(self.last_us) > WATCHDOG_US;
        if self.status == PortStatus::Ready && late { PortStatus::Stopped } else { self.status }
    }
}

impl Robot for DryRun {
    fn reason(&self) -> Option<String> {
        match (self.status, self.status()) {
            (PortStatus::Ready, PortStatus::Stopped) => {
                Some(format!("no set-point came for {} ms", WATCHDOG_US / 1000))
            }
            _ => self.reason.clone(),
        }
    }

    fn report(&self) -> Vec<String> {
        vec![format!("{} set-points recorded", self.written)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn port(clock: &Clock) -> (tempfile::TempDir, DryRun) {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("set-points.csv");
        let port = DryRun::with_clock(&file, &PumaConfig::default(), clock.clone()).unwrap();
        (dir, port)
    }

    #[test]
    fn set_points_are_recorded_with_their_times_and_followed() {
        let clock = Clock::given();
        let (dir, mut port) = port(&clock);
        let mut joints = port.read_joints().unwrap().joints;
        assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Disabled)));
        port.enable().unwrap();
        port.write_set_point(&joints).unwrap();
        clock.set(10_000);
        joints[0] = 0.0125;
        port.write_set_point(&joints).unwrap();
        assert_eq!(port.read_joints().unwrap(), JointReading { joints, age_us: 0 });
        assert_eq!(port.report(), ["2 set-points recorded"]);
        let text = std::fs::read_to_string(dir.path().join("set-points.csv")).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[0], "t,q1,q2,q3,q4,q5,q6");
        assert!(lines[2].starts_with("0.010000,0.0125,0.785"), "{}", lines[2]);
    }

    #[test]
    fn a_jump_is_refused_and_not_recorded() {
        let clock = Clock::given();
        let (_dir, mut port) = port(&clock);
        port.enable().unwrap();
        let stood = port.read_joints().unwrap().joints;
        let mut far = stood;
        far[2] += 1.0;
        assert_eq!(port.write_set_point(&far), Err(PortError::TooFar(3)));
        assert_eq!(port.read_joints().unwrap().joints, stood);
        assert_eq!(port.report(), ["0 set-points recorded"]);
    }

    #[test]
    fn without_set_points_it_stops_until_it_is_enabled_again() {
        let clock = Clock::given();
        let (_dir, mut port) = port(&clock);
        port.enable().unwrap();
        let joints = port.read_joints().unwrap().joints;
        clock.set(WATCHDOG_US);
        assert_eq!(port.status(), PortStatus::Ready);
        clock.set(WATCHDOG_US + 1);
        assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Stopped)));
        assert_eq!(port.reason().as_deref(), Some("no set-point came for 100 ms"));
        port.enable().unwrap();
        assert_eq!((port.status(), port.reason()), (PortStatus::Ready, None));
        port.write_set_point(&joints).unwrap();
        port.stop().unwrap();
        assert_eq!(port.write_set_point(&joints), Err(PortError::NotReady(PortStatus::Stopped)));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_file_that_goes_away_is_a_loss_with_a_reason() {
        use std::os::fd::AsRawFd as _;
        let (reader, writer) = std::io::pipe().unwrap();
        let file = format!("/dev/fd/{}", writer.as_raw_fd());
        let mut port = DryRun::with_clock(Path::new(&file), &PumaConfig::default(), Clock::given()).unwrap();
        let joints = port.read_joints().unwrap().joints;
        port.enable().unwrap();
        port.write_set_point(&joints).unwrap();
        drop(reader);
        assert_eq!(port.write_set_point(&joints), Err(PortError::Lost));
        assert_eq!(port.status(), PortStatus::Lost);
        let reason = port.reason().unwrap();
        assert!(reason.starts_with(&format!("cannot write {file}: Broken pipe")), "{reason}");
    }
}
