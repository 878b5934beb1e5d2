//! Two cameras become one hand: section 4.

/// The shortest arm the hand stages accept, metres: below it the balls themselves would touch.
pub const MIN_ARM_M: f32 = 0.005;

/// The longest arm the hand stages accept, metres. A hand-held frame is a tenth of it; the bound is
/// there to catch an arm given in millimetres.
pub const MAX_ARM_M: f32 = 2.0;

/// Thresholds of the hand stages ([`crate::hand`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HandConfig {
    /// The least ratio of the smallest to the largest singular value of M (eq. 7), no unit.
    ///
    /// For two cameras an angle t apart it is sin(t / 2), and its inverse is how much worse depth
    /// is known than the sideways place. 0.03 is 3.4 degrees, or cameras 6 cm apart at 1 m.
    pub min_conditioning: f32,
    /// The least length in pixels of each arm in the view that shows it longest.
    ///
    /// At 2 px the 0.1 px of a ball's centre (section 5) is 7 % of the arm's length.
    pub min_arm_px: f32,
    /// The least sine of the angle between an arm and what the arms before it span, no unit.
    ///
    /// The arms of a feature frame are at right angles (section 4), so it is near 1 for a real
    /// one; 0.5 is 30 degrees, which only wrong centres give.
    pub min_arm_sine: f32,
    /// The most frames after the last complete one for which a prediction is made (section 3.5).
    ///
    /// Five is a sixth of a second at 30 frames/s, about what a hand takes to turn round.
    pub max_predicted_frames: u32,
}

impl Default for HandConfig {
    fn default() -> Self {
        Self { min_conditioning: 0.03, min_arm_px: 2.0, min_arm_sine: 0.5, max_predicted_frames: 5 }
    }
}
