//! The flags of the pose filter, which `track` and `demo` share.

use clap::{Args, ValueEnum};
use tetrad_core::config::{FilterConfig, MAX_LEAD_US, Prediction, Smoothing};

/// How the pose in filtered.csv is smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SmoothingFlag {
    /// A low pass whose cut-off rises with the speed.
    OneEuro,
    /// Not at all.
    Off,
}

/// How it is carried on over the lead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PredictionFlag {
    /// At constant velocity.
    Velocity,
    /// At constant acceleration: less late in curves, noisier.
    Acceleration,
}

/// The flags.
#[derive(Args, Clone, Copy, Debug)]
pub struct FilterArgs {
    /// How the pose in filtered.csv is smoothed
    #[arg(long, value_enum, default_value_t = SmoothingFlag::OneEuro)]
    pub smoothing: SmoothingFlag,
    /// Latency to make up for: filtered.csv has the pose expected so many milliseconds later
    #[arg(long, value_name = "MS", default_value_t = 0,
          value_parser = clap::value_parser!(u32).range(0..=i64::from(MAX_LEAD_US / 1000)))]
    pub lead_ms: u32,
    /// How the pose is carried on over them, and over frames without a measurement
    #[arg(long, value_enum, default_value_t = PredictionFlag::Velocity)]
    pub prediction: PredictionFlag,
}

impl FilterArgs {
    /// The settings of the filter.
    #[must_use]
    pub fn config(&self) -> FilterConfig {
        let default = FilterConfig::default();
        FilterConfig {
            smoothing: match self.smoothing {
                SmoothingFlag::OneEuro => default.smoothing,
                SmoothingFlag::Off => Smoothing::Off,
            },
            prediction: match self.prediction {
                PredictionFlag::Velocity => Prediction::Velocity,
                PredictionFlag::Acceleration => Prediction::Acceleration,
            },
            lead_us: self.lead_ms.saturating_mul(1000),
            ..default
        }
    }
}
