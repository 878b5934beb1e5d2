//! The arm: lengths, ranges and speeds of a PUMA 560, and the tool.
//!
//! Double precision whatever the arm is computed in: these are facts, read once.
//!
//! Published figures differ (the shoulder offset from 124 to 150 mm), so all of it can be set.
//! Defaults: lengths of Corke and Armstrong-Helouvry, "A search for consensus among model parameters
//! reported for the PUMA 560 robot" (ICRA 1994); ranges of Wang and Chen, "A combined optimization
//! method for solving the inverse kinematics problem" (IEEE T-RA 1991), the strictest set found;
//! speeds of Corke, "Robotics, Vision and Control" toolbox data (1996).

use crate::geometry::Pose;
use core::fmt;
use nalgebra::{Matrix3, Vector3};

/// Joints of the arm.
pub const JOINTS: usize = 6;

/// From the wrist centre to the mounting flange, metres, along the last axis.
pub const FLANGE_M: f64 = 0.05625;

/// The shortest and the longest length of an arm that is believed, metres.
const LENGTHS_M: [f64; 2] = [0.001, 10.0];

/// The largest angle that a range may reach, radians: two turns.
const MAX_ANGLE_RAD: f64 = 4.0 * core::f64::consts::PI;

/// How far R^T R of the tool's rotation may be from the identity.
const MAX_TOOL_SKEW: f64 = 1e-9;

/// The lengths in the standard Denavit-Hartenberg table; the angles in it are the arm's design:
///
/// | joint | d | a | alpha |
/// |---|---|---|---|
/// | 1 | `base_m` | 0 | +90 deg |
/// | 2 | 0 | `upper_arm_m` | 0 |
/// | 3 | `offset_m` | `elbow_m` | -90 deg |
/// | 4 | `forearm_m` | 0 | +90 deg |
/// | 5 | 0 | 0 | -90 deg |
/// | 6 | 0 | 0 | 0 |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumaLengths {
    /// d1: from the mounting surface up to the shoulder, metres.
    pub base_m: f64,
    /// a2: from shoulder to elbow, metres.
    pub upper_arm_m: f64,
    /// d3: from the first axis sideways to the plane of the arm, metres.
    pub offset_m: f64,
    /// a3: by which the forearm's axis misses the elbow's, metres; may be 0 or negative.
    pub elbow_m: f64,
    /// d4: from elbow to wrist centre, metres.
    pub forearm_m: f64,
}

/// What one joint can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointConfig {
    /// The least angle, radians.
    pub min_rad: f64,
    /// The largest angle, radians. The range may exceed a turn; a pose then has more than one angle.
    pub max_rad: f64,
    /// The largest speed, rad/s.
    pub max_speed_rad_s: f64,
}

impl JointConfig {
    const fn from_degrees(min: f64, max: f64, max_speed_rad_s: f64) -> Self {
        Self { min_rad: min.to_radians(), max_rad: max.to_radians(), max_speed_rad_s }
    }
}

/// A PUMA 560 and what it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PumaConfig {
    /// The link table.
    pub lengths: PumaLengths,
    /// From base to wrist.
    pub joints: [JointConfig; JOINTS],
    /// `wrist_from_tool`: where the tool is held, seen from the wrist centre in the axes of the last
    /// link. By default the mounting flange, [`FLANGE_M`] along z.
    pub tool: Pose<f64>,
}

impl Default for PumaLengths {
    fn default() -> Self {
        Self { base_m: 0.67183, upper_arm_m: 0.4318, offset_m: 0.15005, elbow_m: 0.0203, forearm_m: 0.4318 }
    }
}

impl Default for PumaConfig {
    fn default() -> Self {
        Self {
            lengths: PumaLengths::default(),
            joints: [
                JointConfig::from_degrees(-160.0, 160.0, 1.92),
                JointConfig::from_degrees(-45.0, 225.0, 1.51),
                JointConfig::from_degrees(-225.0, 45.0, 2.40),
                JointConfig::from_degrees(-110.0, 170.0, 5.34),
                JointConfig::from_degrees(-100.0, 100.0, 5.09),
                JointConfig::from_degrees(-266.0, 266.0, 5.74),
            ],
            tool: Pose { rotation: Matrix3::identity(), translation: Vector3::new(0.0, 0.0, FLANGE_M) },
        }
    }
}

/// Which setting of the arm cannot be worked with. Joints count from 1, as their makers do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PumaConfigError {
    /// A length must be between 1 mm and 10 m; the elbow's may also be 0 or negative.
    Length,
    /// The range of this joint is empty, not finite or beyond two turns.
    Range(u8),
    /// The speed of this joint must be above 0 and at most 100 rad/s.
    Speed(u8),
    /// The tool's place must be finite and within 10 m, its rotation orthonormal and right-handed.
    Tool,
}

impl fmt::Display for PumaConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length => f.write_str(
                "an arm's lengths must be between 0.001 and 10 m (the elbow's also 0 or negative)",
            ),
            Self::Range(joint) => {
                write!(f, "joint {joint}: the range must go from a least to a larger angle within two turns")
            }
            Self::Speed(joint) => {
                write!(f, "joint {joint}: the largest speed must be above 0 and at most 100 rad/s")
            }
            Self::Tool => f.write_str(
                "the tool must be within 10 m of the wrist, its rotation orthonormal and right-handed",
            ),
        }
    }
}

impl core::error::Error for PumaConfigError {}

impl PumaConfig {
    /// The arm without a tool: what is placed is the wrist centre.
    #[must_use]
    pub fn bare() -> Self {
        Self { tool: Pose::identity(), ..Self::default() }
    }

    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`PumaConfigError`] met.
    pub fn check(&self) -> Result<(), PumaConfigError> {
        let [shortest, longest] = LENGTHS_M;
        let l = &self.lengths;
        // comparisons written so that NaN fails them
        if ![l.base_m, l.upper_arm_m, l.offset_m, l.forearm_m]
            .iter()
            .all(|m| (shortest..=longest).contains(m))
            || !(-longest..=longest).contains(&l.elbow_m)
        {
            return Err(PumaConfigError::Length);
        }
        for (number, joint) in (1..).zip(&self.joints) {
            let widest = -MAX_ANGLE_RAD..=MAX_ANGLE_RAD;
            if !(joint.min_rad < joint.max_rad
                && widest.contains(&joint.min_rad)
                && widest.contains(&joint.max_rad))
            {
                return Err(PumaConfigError::Range(number));
            }
            if !(joint.max_speed_rad_s > 0.0 && joint.max_speed_rad_s <= 100.0) {
                return Err(PumaConfigError::Speed(number));
            }
        }
        let tool = &self.tool;
        let skew = tool.rotation.transpose() * tool.rotation - Matrix3::identity();
        let held = tool.translation.iter().all(|m| m.abs() <= longest)
            && skew.iter().all(|x| x.abs() <= MAX_TOOL_SKEW)
            && tool.rotation.determinant() > 0.0;
        if held { Ok(()) } else { Err(PumaConfigError::Tool) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut PumaConfig)) -> Result<(), PumaConfigError> {
        let mut config = PumaConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_defaults_can_be_worked_with() {
        assert_eq!(PumaConfig::default().check(), Ok(()));
        assert_eq!(PumaConfig::bare().check(), Ok(()));
        assert_eq!(with(|c| c.lengths.elbow_m = -0.02), Ok(()));
    }

    #[test]
    fn what_cannot_be_worked_with_is_named() {
        assert_eq!(with(|c| c.lengths.forearm_m = 0.0), Err(PumaConfigError::Length));
        assert_eq!(with(|c| c.lengths.elbow_m = f64::NAN), Err(PumaConfigError::Length));
        assert_eq!(with(|c| c.lengths.offset_m = 11.0), Err(PumaConfigError::Length));
        assert_eq!(with(|c| c.joints[1].max_rad = c.joints[1].min_rad), Err(PumaConfigError::Range(2)));
        assert_eq!(with(|c| c.joints[5].max_rad = f64::INFINITY), Err(PumaConfigError::Range(6)));
        assert_eq!(with(|c| c.joints[0].min_rad = f64::NAN), Err(PumaConfigError::Range(1)));
        assert_eq!(with(|c| c.joints[2].max_speed_rad_s = 0.0), Err(PumaConfigError::Speed(3)));
        assert_eq!(with(|c| c.tool.rotation *= 1.1), Err(PumaConfigError::Tool));
        assert_eq!(with(|c| c.tool.rotation[(2, 2)] = -1.0), Err(PumaConfigError::Tool));
        assert_eq!(with(|c| c.tool.translation.x = f64::NAN), Err(PumaConfigError::Tool));
    }
}
