//! The slave station's arm side: the arm, the law, the limits, and what is believed of a reading.

use super::{
    GovernorConfig, GovernorConfigError, PumaConfig, PumaConfigError, TeleopConfig, TeleopConfigError,
};
use core::fmt;

/// The farthest that an arm may be from its set-point, radians.
const MAX_FOLLOWING_RAD: f64 = 1.0;

/// The longest time that joints may stay unread, microseconds.
const MAX_BLIND_US: u32 = 1_000_000;

/// The farthest that a goal may be told ahead, microseconds.
const MAX_LEAD_US: u32 = 500_000;

/// Everything that [`crate::arm::slave`] is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveConfig {
    /// The arm and its tool.
    pub puma: PumaConfig,
    /// The law.
    pub teleop: TeleopConfig,
    /// The limits.
    pub governor: GovernorConfig,
    /// How far ahead a goal that moves on is told, microseconds. 0.1 s of the 1/8 s by which the default
    /// [`GovernorConfig::response_per_s`] is late. 0 tells none ahead.
    pub lead_us: u32,
    /// How far a joint may be measured from where it was last sent, radians, beyond what it can go at
    /// its largest speed in the age of the reading. 0.35 rad (20 degrees): the wrist at its largest
    /// speed behind a servo of 50 ms, and a third more. What is beyond is a joint that is held, slips
    /// or is read wrongly.
    pub max_following_rad: f64,
    /// For how long the joints of an arm that moves may stay unread, microseconds. 100 ms, as long as
    /// a command stands.
    pub blind_timeout_us: u32,
}

impl Default for SlaveConfig {
    fn default() -> Self {
        Self {
            puma: PumaConfig::default(),
            teleop: TeleopConfig::default(),
            governor: GovernorConfig::default(),
            lead_us: 100_000,
            max_following_rad: 0.35,
            blind_timeout_us: 100_000,
        }
    }
}

/// Which setting of the slave cannot be worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlaveConfigError {
    /// One of the arm's.
    Puma(PumaConfigError),
    /// One of the law's.
    Teleop(TeleopConfigError),
    /// One of the limits'.
    Governor(GovernorConfigError),
    /// How far the arm may be from its set-point must be above 0 and at most 1 rad.
    Following,
    /// The joints may stay unread for 1 us to 1 s.
    Blind,
    /// A goal may be told at most half a second ahead.
    Lead,
}

impl fmt::Display for SlaveConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Puma(error) => error.fmt(f),
            Self::Teleop(error) => error.fmt(f),
            Self::Governor(error) => error.fmt(f),
            Self::Following => {
                f.write_str("how far the arm may be from its set-point must be above 0 and at most 1 rad")
            }
            Self::Blind => f.write_str("the time for which joints may stay unread must be 1 us to 1 s"),
            Self::Lead => f.write_str("a goal can be told at most 0.5 s ahead"),
        }
    }
}

impl core::error::Error for SlaveConfigError {}

impl From<PumaConfigError> for SlaveConfigError {
    fn from(error: PumaConfigError) -> Self {
        Self::Puma(error)
    }
}

impl From<TeleopConfigError> for SlaveConfigError {
    fn from(error: TeleopConfigError) -> Self {
        Self::Teleop(error)
    }
}

impl From<GovernorConfigError> for SlaveConfigError {
    fn from(error: GovernorConfigError) -> Self {
        Self::Governor(error)
    }
}

impl SlaveConfig {
    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`SlaveConfigError`] met.
    pub fn check(&self) -> Result<(), SlaveConfigError> {
        self.puma.check()?;
        self.teleop.check()?;
        self.governor.check(&self.puma.joints.map(|joint| joint.max_speed_rad_s))?;
        // written so that NaN fails it
        if !(self.max_following_rad > 0.0 && self.max_following_rad <= MAX_FOLLOWING_RAD) {
            return Err(SlaveConfigError::Following);
        }
        if !(1..=MAX_BLIND_US).contains(&self.blind_timeout_us) {
            return Err(SlaveConfigError::Blind);
        }
        if self.lead_us > MAX_LEAD_US {
            return Err(SlaveConfigError::Lead);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut SlaveConfig)) -> Result<(), SlaveConfigError> {
        let mut config = SlaveConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn what_cannot_be_worked_with_is_named() {
        assert_eq!(SlaveConfig::default().check(), Ok(()));
        assert_eq!(with(|c| c.max_following_rad = f64::NAN), Err(SlaveConfigError::Following));
        assert_eq!(with(|c| c.max_following_rad = 0.0), Err(SlaveConfigError::Following));
        assert_eq!(with(|c| c.lead_us = 500_001), Err(SlaveConfigError::Lead));
        assert_eq!(with(|c| c.blind_timeout_us = 0), Err(SlaveConfigError::Blind));
        let scale = SlaveConfigError::Teleop(TeleopConfigError::Scale);
        assert_eq!(with(|c| c.teleop.scale = -1.0), Err(scale));
        let length = SlaveConfigError::Puma(PumaConfigError::Length);
        assert_eq!(with(|c| c.puma.lengths.forearm_m = 0.0), Err(length));
    }
}
