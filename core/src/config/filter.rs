//! Smoothing of the pose and prediction against latency; the paper has neither.

use core::fmt;

/// The longest lead that can be asked for, microseconds. A hand changes its mind about five times a
/// second; further ahead an extrapolation is worse than none.
pub const MAX_LEAD_US: u32 = 200_000;

/// The longest time a pose may be carried on without a measurement, microseconds.
pub const MAX_COAST_US: u32 = 500_000;

/// How the pose is carried on beyond the last measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Prediction {
    /// At constant velocity, linear and angular.
    #[default]
    Velocity,
    /// At constant acceleration: less late where a movement begins, ends or turns, and noisier.
    Acceleration,
}

/// The smoothing rule of the One Euro filter (Casiez, Roussel and Vogel, CHI 2012): a low pass whose
/// cut-off rises with the speed, `cutoff = min_cutoff + gain * speed`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OneEuroConfig {
    /// Cut-off of the place at rest, Hz. 1 Hz at 30 frames/s passes 0.31 of white noise.
    pub min_cutoff_hz: f32,
    /// What each m/s adds to it, Hz. With 24 the place is 12 ms late at 0.5 m/s (a third of a frame
    /// at 30 frames/s), and a noise of 1 mm at rest raises the cut-off by no more than 0.2 Hz.
    pub cutoff_per_m_s: f32,
    /// Cut-off of the orientation at rest, Hz.
    pub turn_min_cutoff_hz: f32,
    /// What each rad/s adds to it, Hz. With 6 the orientation is 23 ms late at 1 rad/s.
    pub turn_cutoff_per_rad_s: f32,
}

impl Default for OneEuroConfig {
    fn default() -> Self {
        Self { min_cutoff_hz: 1.0, cutoff_per_m_s: 24.0, turn_min_cutoff_hz: 1.0, turn_cutoff_per_rad_s: 6.0 }
    }
}

/// Whether the measured pose is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Smoothing {
    /// By the One Euro filter.
    OneEuro(OneEuroConfig),
    /// Not at all: with no lead the filter gives back what it is given, bit for bit.
    Off,
}

/// The pose filter ([`crate::hand::filter`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FilterConfig {
    /// How noise is taken out.
    pub smoothing: Smoothing,
    /// How the pose is carried on.
    pub prediction: Prediction,
    /// The pose given is that expected so long after the measurement, microseconds, at most
    /// [`MAX_LEAD_US`]: the latency to be made up for. 0 makes up for none.
    pub lead_us: u32,
    /// How far back the velocity remembers, microseconds: a measurement this old weighs 1/e.
    ///
    /// Measured on a simulated hand at 30 frames/s (tests/snapshots/filter.txt): with 50 ms a lead of
    /// 50 ms leaves 0.6 of the noise of a place at rest; twice as long, 0.4, but on a circle of 0.1 m
    /// at 0.5 m/s the prediction comes 20 ms later.
    pub memory_us: u32,
    /// How long the pose is carried on without a measurement before it stands still, microseconds,
    /// at most [`MAX_COAST_US`].
    pub coast_us: u32,
    /// A measurement that comes later than this after the last one starts the filter anew, at rest,
    /// microseconds: what the velocity was then says nothing any more.
    pub restart_us: u32,
    /// The fastest movement that is believed, m/s. Throwing aside, hands stay below 3.
    pub max_speed_m_s: f32,
    /// The fastest turn that is believed, rad/s.
    pub max_turn_rad_s: f32,
    /// The largest acceleration that is believed, m/s^2 (and, of turns, ten times this in rad/s^2).
    pub max_acceleration_m_s2: f32,
}

impl Default for FilterConfig {
    fn default() -> Self {
        Self {
            smoothing: Smoothing::OneEuro(OneEuroConfig::default()),
            prediction: Prediction::Velocity,
            lead_us: 0,
            memory_us: 50_000,
            coast_us: 100_000,
            restart_us: 500_000,
            max_speed_m_s: 4.0,
            max_turn_rad_s: 20.0,
            max_acceleration_m_s2: 30.0,
        }
    }
}

/// Which setting of the filter cannot be worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FilterConfigError {
    /// The lead is beyond [`MAX_LEAD_US`].
    Lead,
    /// The memory of the velocity must be between 1 ms and 1 s.
    Memory,
    /// The pose would be carried on for longer than [`MAX_COAST_US`] or than the filter lives.
    Coast,
    /// A cut-off must be a number above 0 and its gain one from 0 on, up to 1000.
    Cutoff,
    /// A bound of speed, turn or acceleration must be a number above 0 and up to 1000.
    Bound,
}

impl fmt::Display for FilterConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Lead => "the lead must be at most 200 ms",
            Self::Memory => "the velocity's memory must be between 1 ms and 1 s",
            Self::Coast => {
                "a pose may be carried on for at most 500 ms, and no longer than until the restart"
            }
            Self::Cutoff => "a cut-off must be above 0 Hz, its gain 0 or more, both at most 1000",
            Self::Bound => "the bounds of speed, turn and acceleration must be above 0 and at most 1000",
        })
    }
}

impl core::error::Error for FilterConfigError {}

impl FilterConfig {
    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`FilterConfigError`] met.
    pub fn check(&self) -> Result<(), FilterConfigError> {
        let positive = |x: f32| x > 0.0 && x <= 1000.0;
        if self.lead_us > MAX_LEAD_US {
            return Err(FilterConfigError::Lead);
        }
        if !(1_000..=1_000_000).contains(&self.memory_us) {
            return Err(FilterConfigError::Memory);
        }
        if self.coast_us > MAX_COAST_US || self.coast_us > self.restart_us {
            return Err(FilterConfigError::Coast);
        }
        if let Smoothing::OneEuro(c) = self.smoothing
            && !([c.min_cutoff_hz, c.turn_min_cutoff_hz].into_iter().all(positive)
                && [c.cutoff_per_m_s, c.turn_cutoff_per_rad_s].iter().all(|x| (0.0..=1000.0).contains(x)))
        {
            return Err(FilterConfigError::Cutoff);
        }
        let bounds = [self.max_speed_m_s, self.max_turn_rad_s, self.max_acceleration_m_s2];
        if bounds.into_iter().all(positive) { Ok(()) } else { Err(FilterConfigError::Bound) }
    }
}
