//! How a pose of the hand is known, and how well.

use nalgebra::Matrix6;
use serde::{Deserialize, Serialize};

/// How the pose that goes with a frame is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum PoseState {
    /// Measured by two cameras or more, each of which saw all four balls.
    Both = 0,
    /// Measured by two cameras or more, and at least one of them missed a ball: the rigid frame
    /// supplies it.
    Three = 1,
    /// Measured by one camera alone.
    One = 2,
    /// Not measured: carried on by the hand's past motion, for a bounded time.
    Predicted = 3,
    /// Not measured: the last pose stands, for a bounded time. Never a measurement.
    Held = 4,
    /// There has been no measured frame yet, or none for too long.
    #[default]
    Lost = 5,
}

impl PoseState {
    /// Every state, in the order of their numbers.
    pub const ALL: [Self; 6] = [Self::Both, Self::Three, Self::One, Self::Predicted, Self::Held, Self::Lost];

    /// The word written to files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::Three => "three",
            Self::One => "one",
            Self::Predicted => "predicted",
            Self::Held => "held",
            Self::Lost => "lost",
        }
    }

    /// Whether the pose was measured in this frame.
    #[must_use]
    pub const fn is_measured(self) -> bool {
        matches!(self, Self::Both | Self::Three | Self::One)
    }
}

/// How well a pose `a_from_b` is known: the covariance of its error, in this order: measured minus
/// true translation (metres, axes of a), then the rotation vector w (radians, axes of a) with
/// R_measured = exp(w) R_true.
pub type PoseCovariance = Matrix6<f32>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_are_pinned() {
        assert_eq!(PoseState::ALL.map(|state| state as u8), [0, 1, 2, 3, 4, 5]);
        let words = ["both", "three", "one", "predicted", "held", "lost"];
        assert_eq!(PoseState::ALL.map(PoseState::name), words);
        assert_eq!(PoseState::ALL.map(PoseState::is_measured), [true, true, true, false, false, false]);
    }
}
