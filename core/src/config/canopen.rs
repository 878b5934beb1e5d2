//! What can be set about a CANopen robot, with the keys of `tetrad.toml` (docs/canopen.md).

use super::arm::JOINTS;
use super::drives::{DriveConfig, DrivesConfig, DrivesConfigError};
use core::fmt;
use serde::Deserialize;

/// How it is known where the joints are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Homing {
    /// The encoders are absolute, or the drives were homed and keep it: positions are always right.
    #[default]
    Absolute,
    /// Each drive sets this bit of its statusword once it is homed: one of the maker's own, 8, 14 or 15.
    StatusBit(u8),
    /// Somebody says so, each time that a drive was switched on.
    Confirm,
}

/// The bus and its six drives.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CanopenConfig {
    /// Node numbers of the drives of joints 1 to 6; each 1 to 127.
    pub nodes: [u8; JOINTS],
    /// The master's own node number, for its heartbeat.
    pub master: u8,
    /// The vendor that every drive must name in 0x1018:1; any where it is not set.
    pub vendor: Option<u32>,
    /// From one SYNC to the next, microseconds: 10 ms is 14 % of 1 Mbit/s.
    pub period_us: u32,
    /// How it is known where the joints are.
    pub homing: Homing,
    /// Counts a radian of each drive, negative for the other sense.
    pub counts_per_rad: [f64; JOINTS],
    /// What each drive shows when every joint is at zero.
    pub zero_counts: [i32; JOINTS],
    /// How the motors turn later joints (see [`DrivesConfig`]).
    pub coupling: [[f64; JOINTS]; JOINTS],
    /// How often master and drives send their heartbeat, milliseconds.
    pub heartbeat_ms: u16,
    /// After how long without the other's heartbeat it counts as gone, milliseconds.
    pub heartbeat_timeout_ms: u16,
    /// After how many cycles without an answer to SYNC a drive counts as gone.
    pub missing_cycles: u32,
    /// After how many cycles without a new set-point the arm stops.
    pub watchdog_cycles: u32,
    /// By how much a set-point may exceed what a joint can go in a cycle at its largest speed: above 1,
    /// since whoever writes set-points has a clock of its own.
    pub step_margin: f64,
    /// How long the bus is listened to for another master before anything is sent, milliseconds.
    pub listen_ms: u32,
    /// How long a drive has to answer an SDO request, milliseconds; it is asked three times.
    pub sdo_timeout_ms: u32,
    /// How long the drives have to be switched on, milliseconds.
    pub enable_timeout_ms: u32,
}

/// The longest until a loss is noticed that a station's file may ask for, milliseconds: about the time in
/// which somebody at the emergency stop would notice.
const MAX_WATCH_MS: u64 = 1_000;

impl Default for CanopenConfig {
    fn default() -> Self {
        let drives = DrivesConfig::default();
        Self {
            nodes: [1, 2, 3, 4, 5, 6],
            master: 127,
            vendor: None,
            period_us: 10_000,
            homing: Homing::Absolute,
            counts_per_rad: drives.drives.map(|drive| drive.counts_per_rad),
            zero_counts: drives.drives.map(|drive| drive.zero_counts),
            coupling: drives.coupling,
            heartbeat_ms: 50,
            heartbeat_timeout_ms: 200,
            missing_cycles: 5,
            watchdog_cycles: 10,
            step_margin: 2.0,
            listen_ms: 300,
            sdo_timeout_ms: 300,
            enable_timeout_ms: 5_000,
        }
    }
}

/// Which setting cannot be worked with. The message names its key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanopenConfigError {
    /// Node numbers.
    Nodes,
    /// The period.
    Period,
    /// The bit of the statusword.
    HomingBit,
    /// Heartbeats.
    Heartbeat,
    /// Cycles.
    Cycles,
    /// The margin.
    Margin,
    /// Times.
    Times,
    /// Watches that take too long.
    Slow {
        /// Its key.
        key: &'static str,
        /// How long it takes, milliseconds.
        ms: u64,
    },
    /// Counts or coupling.
    Drives(DrivesConfigError),
}

impl fmt::Display for CanopenConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nodes => "nodes and master: give seven different node numbers from 1 to 127",
            Self::Period => "period_us: give 1000 to 100000 in whole milliseconds; 10000 is 100 Hz",
            Self::HomingBit => "homing: the status bit must be one that is left to the maker: 8, 14 or 15",
            Self::Heartbeat => {
                "heartbeat_timeout_ms must be at least twice heartbeat_ms, and that at least 10"
            }
            Self::Cycles => "missing_cycles and watchdog_cycles must be between 1 and 1000",
            Self::Margin => "step_margin must be between 1 and 10",
            Self::Times => {
                "listen_ms, sdo_timeout_ms and enable_timeout_ms must be between 10 and 60000"
            }
            Self::Slow { key, ms } => {
                return write!(
                    f,
                    "{key}: that is {ms} ms until a loss is noticed, in which nobody holds the arm: give so much \
                     that it is at most 1000 ms"
                );
            }
            Self::Drives(error) => return write!(f, "counts_per_rad and coupling: {error}"),
        })
    }
}

impl core::error::Error for CanopenConfigError {}

impl From<DrivesConfigError> for CanopenConfigError {
    fn from(error: DrivesConfigError) -> Self {
        Self::Drives(error)
    }
}

impl CanopenConfig {
    /// The motors, as core counts with them.
    #[must_use]
    pub fn drives(&self) -> DrivesConfig {
        let mut drives = DrivesConfig { coupling: self.coupling, ..DrivesConfig::default() };
        let pairs = self.counts_per_rad.iter().zip(&self.zero_counts);
        for (drive, (&counts_per_rad, &zero_counts)) in drives.drives.iter_mut().zip(pairs) {
            *drive = DriveConfig { counts_per_rad, zero_counts };
        }
        drives
    }

    /// From one SYNC to the next, seconds.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        f64::from(self.period_us) / 1e6
    }

    /// Whether every loss is noticed within a second: no one, then, is at the arm's controls for longer.
    /// What a station's file has to keep; drives that a program simulates may be given more time.
    ///
    /// # Errors
    /// [`CanopenConfigError::Slow`]
    pub fn check_watches(&self) -> Result<(), CanopenConfigError> {
        let of = |cycles: u32| u64::from(cycles) * u64::from(self.period_us) / 1_000;
        let watches = [
            ("missing_cycles (times period_us)", of(self.missing_cycles)),
            ("watchdog_cycles (times period_us)", of(self.watchdog_cycles)),
            ("heartbeat_timeout_ms", u64::from(self.heartbeat_timeout_ms)),
        ];
        match watches.into_iter().find(|(_, ms)| *ms > MAX_WATCH_MS) {
            Some((key, ms)) => Err(CanopenConfigError::Slow { key, ms }),
            None => Ok(()),
        }
    }

    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`CanopenConfigError`] met.
    pub fn check(&self) -> Result<(), CanopenConfigError> {
        let numbers = || self.nodes.iter().chain([&self.master]);
        let is_taken_twice = |node: &u8| numbers().filter(|other| *other == node).count() > 1;
        if numbers().any(|node| !(1..=127).contains(node) || is_taken_twice(node)) {
            return Err(CanopenConfigError::Nodes);
        }
        if !(1_000..=100_000).contains(&self.period_us) || !self.period_us.is_multiple_of(1_000) {
            return Err(CanopenConfigError::Period);
        }
        if let Homing::StatusBit(bit) = self.homing
            && ![8, 14, 15].contains(&bit)
        {
            return Err(CanopenConfigError::HomingBit);
        }
        if self.heartbeat_ms < 10 || u32::from(self.heartbeat_timeout_ms) < 2 * u32::from(self.heartbeat_ms) {
            return Err(CanopenConfigError::Heartbeat);
        }
        if ![self.missing_cycles, self.watchdog_cycles].iter().all(|cycles| (1..=1_000).contains(cycles)) {
            return Err(CanopenConfigError::Cycles);
        }
        if !(1.0..=10.0).contains(&self.step_margin) {
            return Err(CanopenConfigError::Margin);
        }
        let times = [self.listen_ms, self.sdo_timeout_ms, self.enable_timeout_ms];
        if !times.iter().all(|ms| (10..=60_000).contains(ms)) {
            return Err(CanopenConfigError::Times);
        }
        Ok(self.drives().check()?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString as _;

    #[test]
    fn the_defaults_can_be_worked_with() {
        assert_eq!(CanopenConfig::default().check(), Ok(()));
        assert_eq!(CanopenConfig::default().drives(), DrivesConfig::default());
    }

    #[test]
    fn watches_of_more_than_a_second_are_named_with_the_time_they_take() {
        let slow = |change: &dyn Fn(&mut CanopenConfig)| {
            let mut config = CanopenConfig { period_us: 100_000, ..CanopenConfig::default() };
            assert_eq!(config.check_watches(), Ok(()), "the defaults, at any period");
            change(&mut config);
            assert_eq!(config.check(), Ok(()));
            config.check_watches().unwrap_err().to_string()
        };
        let problem = slow(&|c| c.watchdog_cycles = 1_000);
        assert!(problem.starts_with("watchdog_cycles (times period_us): that is 100000 ms"), "{problem}");
        assert!(
            slow(&|c| c.missing_cycles = 11).starts_with("missing_cycles (times period_us): that is 1100 ms")
        );
        assert!(
            slow(&|c| c.heartbeat_timeout_ms = 1_001).starts_with("heartbeat_timeout_ms: that is 1001 ms")
        );
    }

    #[test]
    fn what_cannot_be_worked_with_is_named_by_its_key() {
        let with = |change: &dyn Fn(&mut CanopenConfig)| {
            let mut config = CanopenConfig::default();
            change(&mut config);
            config.check().unwrap_err().to_string()
        };
        assert!(with(&|c| c.nodes[3] = 1).starts_with("nodes"));
        assert!(with(&|c| c.nodes[3] = 128).starts_with("nodes"));
        assert!(with(&|c| c.master = 6).starts_with("nodes"));
        assert!(with(&|c| c.period_us = 10_050).starts_with("period_us"));
        assert!(with(&|c| c.homing = Homing::StatusBit(3)).starts_with("homing"));
        assert!(with(&|c| c.heartbeat_timeout_ms = 60).starts_with("heartbeat_timeout_ms"));
        let saturated = |c: &mut CanopenConfig| (c.heartbeat_ms, c.heartbeat_timeout_ms) = (40_000, u16::MAX);
        assert!(with(&saturated).starts_with("heartbeat_timeout_ms"));
        assert!(with(&|c| c.watchdog_cycles = 0).contains("watchdog_cycles"));
        assert!(with(&|c| c.step_margin = f64::NAN).starts_with("step_margin"));
        assert!(with(&|c| c.listen_ms = 0).starts_with("listen_ms"));
        assert!(with(&|c| c.counts_per_rad[1] = 0.0).contains("joint 2"));
    }
}
