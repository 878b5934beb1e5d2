//! The words the vision, hand and wire layers share: balls and what was seen of them.

use crate::geometry::ImagePoint;
use serde::{Deserialize, Serialize};

/// How many balls a feature frame has.
pub const BALLS: usize = 4;

/// One of the four balls, in the paper's order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Ball {
    /// The origin of the feature frame.
    Red = 0,
    /// The end of E1.
    Green = 1,
    /// The end of E2.
    Blue = 2,
    /// The end of E3.
    Yellow = 3,
}

impl Ball {
    /// All four, in the paper's order: red, green, blue, yellow.
    pub const ALL: [Self; BALLS] = [Self::Red, Self::Green, Self::Blue, Self::Yellow];

    /// The index of this ball in any array ordered as [`Ball::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// The English name in lower case, as it stands in files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
            Self::Yellow => "yellow",
        }
    }
}

/// How a ball's place in one picture is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ObservationState {
    /// Seen whole; the centre is measured (eq. 2).
    Visible = 0,
    /// Seen in part (another ball, a hand, or the picture's edge hides the rest); the centre is
    /// corrected by eq. 3 where the cause is known.
    Occluded = 1,
    /// Not seen; the place is where its past motion puts it. Never a measurement.
    Predicted = 2,
    /// Not seen and no longer predicted; it has no place.
    #[default]
    Lost = 3,
}

impl ObservationState {
    /// The word written to files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Visible => "visible",
            Self::Occluded => "occluded",
            Self::Predicted => "predicted",
            Self::Lost => "lost",
        }
    }

    /// Whether pixels of this ball were measured in this frame.
    #[must_use]
    pub const fn is_measured(self) -> bool {
        matches!(self, Self::Visible | Self::Occluded)
    }
}

/// How well a point in a picture is known: the covariance of measured minus true, px^2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImageCovariance {
    /// The variance of `u`.
    pub uu: f32,
    /// The covariance of `u` and `v`.
    pub uv: f32,
    /// The variance of `v`.
    pub vv: f32,
}

impl ImageCovariance {
    /// The same standard deviation, px, in every direction.
    #[must_use]
    pub const fn isotropic(sigma_px: f32) -> Self {
        let variance = sigma_px * sigma_px;
        Self { uu: variance, uv: 0.0, vv: variance }
    }

    /// Whether it is one: finite, and no direction with a negative variance.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        // rounding may leave a line's determinant just below zero
        let slack = 1e-5 * self.uu * self.vv;
        self.uu.is_finite()
            && self.uv.is_finite()
            && self.vv.is_finite()
            && self.uu >= 0.0
            && self.vv >= 0.0
            && self.uu * self.vv + slack >= self.uv * self.uv
    }
}

/// One ball in one picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Observation {
    /// How the centre is known.
    pub state: ObservationState,
    /// The ball's centre in pixels; meaningless when `state` is `Lost`.
    pub centre: ImagePoint,
    /// The ball's diameter in pixels: of the last pass without occlusion when hidden.
    pub diameter: f32,
    /// How well the centre is known, px^2; zero when `state` is `Lost`.
    pub covariance: ImageCovariance,
    /// The share of the rim that was seen, 0 to 1; 0 when it was not measured.
    pub visible: f32,
}

/// The four balls in one picture, ordered as [`Ball::ALL`].
pub type Observations = [Observation; BALLS];
