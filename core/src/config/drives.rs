//! The arm's motors: encoder counts a radian, where zero is, and how the wrist's motors turn each
//! other's joints.
//!
//! Defaults are those of a PUMA 560 with its own encoders: counts from the table of
//! `hil-fixtures/data/puma560`, coupling from a public driver that moves a real arm with them. A
//! retrofit with other encoders or gears sets its own.

use super::arm::JOINTS;
use core::fmt;

/// The most counts a radian that are believed: a 24-bit encoder behind a gear of 100, and some.
const MAX_COUNTS_PER_RAD: f64 = 1e9;

/// The strongest coupling that is believed: a motor that turns a later joint as fast as its own.
const MAX_COUPLING: f64 = 1.0;

/// One motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveConfig {
    /// Counts of the encoder while the joint turns by a radian and the other motors rest. Negative
    /// where the counts fall while the joint's angle grows.
    pub counts_per_rad: f64,
    /// What the encoder shows when every joint is at zero.
    pub zero_counts: i32,
}

/// The six motors.
///
/// With `m` the angles by which the motors alone would have turned their joints
/// (`(counts - zero_counts) / counts_per_rad`), the joints are at `m + coupling m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivesConfig {
    /// From base to wrist.
    pub drives: [DriveConfig; JOINTS],
    /// Row `i`, column `j`: radians that joint `i + 1` turns for one radian of motor `j + 1`. A motor
    /// turns only joints that come after its own: everything on and right of the diagonal is 0.
    pub coupling: [[f64; JOINTS]; JOINTS],
}

impl Default for DrivesConfig {
    fn default() -> Self {
        let drive = |counts_per_rad| DriveConfig { counts_per_rad, zero_counts: 0 };
        let mut coupling = [[0.0; JOINTS]; JOINTS];
        // the wrist's shafts run inside one another through the forearm
        coupling[4][3] = -0.013_903_7;
        coupling[5][3] = 0.013_040_1;
        coupling[5][4] = -13.0 / 72.0;
        Self { drives: [9_964.9, 13_727.4, 8_547.6, 12_101.6, 11_446.9, 12_205.0].map(drive), coupling }
    }
}

/// Which setting of the motors cannot be worked with. Joints count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DrivesConfigError {
    /// The counts a radian of this joint's motor must be between 1 and 1e9, or both negative.
    CountsPerRad(u8),
    /// The coupling into this joint must come from earlier motors alone, each within -1 to 1.
    Coupling(u8),
}

impl fmt::Display for DrivesConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CountsPerRad(joint) => write!(
                f,
                "joint {joint}: the counts a radian must be between 1 and 1e9 (negative for the other sense)"
            ),
            Self::Coupling(joint) => {
                write!(f, "joint {joint}: the coupling must name earlier motors alone, each between -1 and 1")
            }
        }
    }
}

impl core::error::Error for DrivesConfigError {}

impl DrivesConfig {
    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`DrivesConfigError`] met.
    pub fn check(&self) -> Result<(), DrivesConfigError> {
        for (number, drive) in (1..).zip(&self.drives) {
            if !(1.0..=MAX_COUNTS_PER_RAD).contains(&drive.counts_per_rad.abs()) {
                return Err(DrivesConfigError::CountsPerRad(number));
            }
        }
        for (number, row) in (1u8..).zip(&self.coupling) {
            let believed = (1u8..).zip(row).all(|(motor, share)| match motor < number {
                true => (-MAX_COUPLING..=MAX_COUPLING).contains(share),
                false => *share == 0.0,
            });
            if !believed {
                return Err(DrivesConfigError::Coupling(number));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut DrivesConfig)) -> Result<(), DrivesConfigError> {
        let mut config = DrivesConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_defaults_can_be_worked_with() {
        assert_eq!(DrivesConfig::default().check(), Ok(()));
        assert_eq!(with(|c| c.drives[2].counts_per_rad = -8_547.6), Ok(()));
    }

    #[test]
    fn what_cannot_be_worked_with_is_named() {
        use DrivesConfigError::{CountsPerRad, Coupling};
        assert_eq!(with(|c| c.drives[0].counts_per_rad = 0.0), Err(CountsPerRad(1)));
        assert_eq!(with(|c| c.drives[3].counts_per_rad = f64::NAN), Err(CountsPerRad(4)));
        assert_eq!(with(|c| c.drives[5].counts_per_rad = f64::INFINITY), Err(CountsPerRad(6)));
        assert_eq!(with(|c| c.coupling[4][4] = 0.1), Err(Coupling(5)));
        assert_eq!(with(|c| c.coupling[0][5] = 0.1), Err(Coupling(1)));
        assert_eq!(with(|c| c.coupling[5][4] = f64::NAN), Err(Coupling(6)));
        assert_eq!(with(|c| c.coupling[5][4] = -1.1), Err(Coupling(6)));
    }
}
