//! Joint angles as the motors' encoders count them, and back.

use super::model::Joints;
use crate::config::{DrivesConfig, DrivesConfigError, JOINTS};
use crate::real::Real;
use core::fmt;

/// What the six encoders show, from base to wrist.
pub type Counts = [i32; JOINTS];

/// Joints that no encoder can show: the number of the first (from 1) whose counts leave 32 bits or
/// whose angle is not finite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BeyondCounts(pub u8);

impl fmt::Display for BeyondCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "joint {}: no 32-bit count stands for this angle; check the counts a radian", self.0)
    }
}

impl core::error::Error for BeyondCounts {}

/// The six motors. Computed in double precision whatever the angles are in: counts may have more
/// digits than an f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drives {
    config: DrivesConfig,
}

impl Drives {
    /// Motors.
    ///
    /// # Errors
    /// [`DrivesConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &DrivesConfig) -> Result<Self, DrivesConfigError> {
        config.check()?;
        Ok(Self { config: *config })
    }

    /// The configuration they were made from.
    #[must_use]
    pub const fn config(&self) -> &DrivesConfig {
        &self.config
    }

    /// What the encoders show with the joints at `joints` radians, to the nearest count.
    ///
    /// # Errors
    /// [`BeyondCounts`].
    pub fn counts<T: Real>(&self, joints: &Joints<T>) -> Result<Counts, BeyondCounts> {
        let mut motors = [0.0f64; JOINTS];
        for (place, (row, joint)) in self.config.coupling.iter().zip(joints).enumerate() {
            // this motor and those after it are still 0 here: only what earlier ones carry is summed
            let carried = carried(row, &motors);
            if let Some(motor) = motors.get_mut(place) {
                *motor = joint.to_f64() - carried;
            }
        }
        let mut counts = [0; JOINTS];
        for (number, (count, (motor, drive))) in
            (1..).zip(counts.iter_mut().zip(motors.iter().zip(&self.config.drives)))
        {
            let turned = (motor * drive.counts_per_rad).nearest_whole() + f64::from(drive.zero_counts);
            if !(f64::from(i32::MIN)..=f64::from(i32::MAX)).contains(&turned) {
                return Err(BeyondCounts(number));
            }
            *count = turned as i32;
        }
        Ok(counts)
    }

    /// Where the joints are when the encoders show `counts`, radians.
    #[must_use]
    pub fn joints<T: Real>(&self, counts: &Counts) -> Joints<T> {
        let mut motors = [0.0f64; JOINTS];
        for (motor, (count, drive)) in motors.iter_mut().zip(counts.iter().zip(&self.config.drives)) {
            // counts_per_rad was checked not to be 0
            *motor = (f64::from(*count) - f64::from(drive.zero_counts)) / drive.counts_per_rad;
        }
        let mut joints = [T::zero(); JOINTS];
        for (joint, (motor, row)) in joints.iter_mut().zip(motors.iter().zip(&self.config.coupling)) {
            *joint = T::of(motor + carried(row, &motors));
        }
        joints
    }

    /// The angle of one count of each encoder, radians.
    #[must_use]
    pub fn resolution<T: Real>(&self) -> Joints<T> {
        self.config.drives.map(|drive| T::of(1.0 / drive.counts_per_rad.abs()))
    }
}

/// By how much the motors turn the joint of `row` on top of its own motor, radians.
fn carried(row: &[f64; JOINTS], motors: &[f64; JOINTS]) -> f64 {
    row.iter().zip(motors).fold(0.0, |sum, (share, motor)| sum + share * motor)
}
