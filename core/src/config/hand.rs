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
    /// The refined pose ([`crate::hand::pose`]).
    pub pose: PoseConfig,
}

impl Default for HandConfig {
    fn default() -> Self {
        Self {
            min_conditioning: 0.03,
            min_arm_px: 2.0,
            min_arm_sine: 0.5,
            max_predicted_frames: 5,
            pose: PoseConfig::default(),
        }
    }
}

/// Thresholds of the refined pose ([`crate::hand::pose`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PoseConfig {
    /// How well a nominal focal length is known: the standard deviation of its logarithm.
    ///
    /// A lens that is 10 % off is taken in at once, and one that is 30 % off a little later.
    pub focal_sigma: f32,
    /// A centre is never taken for better than this, px: a tenth of what the refined centre reaches on
    /// a ball of 16 px. It keeps one equation from outweighing all others.
    pub centre_floor_px: f32,
    /// What a centre without a covariance is taken for, px: the paper's own figure (section 5).
    pub centre_default_px: f32,
    /// Beyond so many standard deviations a centre counts linearly instead of squared.
    pub huber_sigmas: f32,
    /// Beyond so many standard deviations, and [`PoseConfig::wrong_px`], a ball is not what it is
    /// taken for, or its camera is not where it was.
    pub wrong_sigmas: f32,
    /// See [`PoseConfig::wrong_sigmas`], px. Where lens distortion, arms of another length, or cameras
    /// that are not exposed at one time make more of it, the standard deviations have grown with it.
    pub wrong_px: f32,
    /// A pose so many standard deviations from where the hand was expected is believed only if balls
    /// that are seen whole show it.
    pub leap_sigmas: f32,
    /// A camera is latched where the four balls fit the hand to so many pixels.
    pub latch_px: f32,
    /// How far the hand may be from its prediction, metres. Weak beside any measurement; it only
    /// decides what nothing was measured of.
    pub prior_m: f32,
    /// The same, radians.
    pub prior_rad: f32,
    /// The hand has moved, and there is something to learn of the cameras, when a ball is so many arm
    /// lengths from where it was in the last frame that was learnt from.
    pub key_arms: f32,
    /// How many such frames are remembered.
    pub key_frames: f32,
    /// How many more frames are learnt from at one place. Few: a centre's error there is nearly the same
    /// in each (what lies behind a ball pulls its rim), and what is learnt would claim to be known better
    /// than it is.
    pub key_repeats: u32,
    /// For how long after the last measured frame the hand is carried on, microseconds: a sixth of a
    /// second, about what a hand takes to turn round.
    pub predict_us: u64,
    /// For how long after that the pose is held, microseconds.
    pub hold_us: u64,
    /// How many frames are waited for a second camera before one alone is latched.
    pub latch_wait_frames: u32,
    /// How many frames a camera may contradict the others before it is taken for moved, latched anew,
    /// and trusted again if it agrees from there on while the hand moves.
    pub relatch_frames: u32,
}

impl Default for PoseConfig {
    fn default() -> Self {
        Self {
            focal_sigma: 0.1,
            centre_floor_px: 0.002,
            centre_default_px: 0.1,
            huber_sigmas: 3.0,
            wrong_sigmas: 6.0,
            wrong_px: 1.0,
            leap_sigmas: 4.0,
            latch_px: 5.0,
            prior_m: 0.03,
            prior_rad: 0.26,
            key_arms: 0.25,
            key_frames: 64.0,
            key_repeats: 2,
            predict_us: 170_000,
            hold_us: 500_000,
            latch_wait_frames: 15,
            relatch_frames: 30,
        }
    }
}
