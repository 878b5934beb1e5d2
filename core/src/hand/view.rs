//! What one camera gives the hand stages: the balls it saw, and the little that is known of it.

use crate::observation::Observations;

/// A camera that was never calibrated: the size of its pictures and a guess of its focal length.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CameraModel {
    /// Width of its pictures, px.
    pub width: u16,
    /// Height of its pictures, px.
    pub height: u16,
    /// The nominal focal length, px. `paper` mode makes no use of it.
    pub focal_px: f32,
}

impl CameraModel {
    /// The focal length taken where nothing is known, in picture widths: a lens that sees 44 degrees
    /// from side to side.
    pub const NOMINAL_FOCAL_WIDTHS: f32 = 1.25;

    /// A camera of which nothing is known but the size of its pictures.
    #[must_use]
    pub fn nominal(width: u16, height: u16) -> Self {
        Self { width, height, focal_px: Self::NOMINAL_FOCAL_WIDTHS * f32::from(width) }
    }
}

/// One camera's part of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HandView {
    /// What it saw of the four balls.
    pub balls: Observations,
    /// What is known of it.
    pub camera: CameraModel,
}
