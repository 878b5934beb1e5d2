//! The governor of the arm: how far, how fast and how abruptly the joints may go.
//!
//! Double precision whatever the arm is computed in, as in [`PumaConfig`](super::PumaConfig), where the
//! ranges and speeds of the joints are.

use super::{JOINTS, Workspace};
use core::fmt;

/// The shortest and the longest cycle, microseconds: 1000 and 10 Hz.
const CYCLE_US: [u32; 2] = [1_000, 100_000];

/// The farthest corner of a workspace that is believed, metres.
const MAX_WORKSPACE_M: f64 = 100.0;

/// Accelerations at which the joints of a PUMA 560 are still driven, rad/s^2: torque left beside
/// gravity over inertia, the least of 600 random poses. No published limit was found.
pub const DRIVEN_RAD_S2: [f64; JOINTS] = [19.0, 27.0, 86.0, 125.0, 117.0, 110.0];

/// How much of [`DRIVEN_RAD_S2`] is used: inertia and friction of an arm that is held together by
/// forty years of repairs are not known any better.
const DRIVEN_SHARE: f64 = 0.3;

/// How long an acceleration takes to build up, seconds: what changes over 0.1 s stirs little above
/// 10 Hz, and an arm of this size swings above it.
const BUILD_UP_S: f64 = 0.1;

/// The longest that joints may take to come to rest, seconds. A stop that takes longer is none.
const MAX_STOP_S: f64 = 2.0;

/// Through which singularities the arm may pass where the goal leads through. It is told each time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AllowedPassages {
    /// The wrist's: q5 changes its sign while all joints go on as they did. By default it may: a hand
    /// that turns the tool straight through does not know of it.
    pub wrist: bool,
    /// The elbow's, at the edge of reach. By default not: the arm would come back bent the other way.
    pub elbow: bool,
    /// The shoulder's. By default not: the arm would go over to its other side.
    pub shoulder: bool,
}

/// How speed falls as the hand is known less well ([`crate::arm::teleop::Uncertainty`]): full up to
/// `full`, then falling in proportion, [`GovernorConfig::creep_share`] from `creep` on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowedByUncertainty {
    /// Up to here at full speed, metres.
    pub full_m: f64,
    /// From here on at a creep, metres.
    pub creep_m: f64,
    /// Up to here at full speed, radians.
    pub full_rad: f64,
    /// From here on at a creep, radians.
    pub creep_rad: f64,
}

/// The governor ([`crate::arm::governor`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GovernorConfig {
    /// From one set-point to the next, microseconds. 100 Hz: what six drives on one CAN bus take
    /// without hurry.
    pub cycle_us: u32,
    /// Where the tool may be. The default is that of [`super::TeleopConfig`].
    pub workspace: Workspace,
    /// The share of each joint's own speed that is used, above 0 and at most 1. A tenth is left for the
    /// servos to catch up with.
    pub speed_share: f64,
    /// The largest acceleration of each joint, rad/s^2: 30 % of what was computed from torques and
    /// inertias.
    pub max_acceleration_rad_s2: [f64; JOINTS],
    /// The largest jerk of each joint, rad/s^3: the acceleration builds up in 0.1 s.
    pub max_jerk_rad_s3: [f64; JOINTS],
    /// The largest speed of the tool, m/s. VAL's figure for straight lines. No set-point is farther
    /// from the one before; the arm is steered at 0.86 of it.
    pub max_tool_speed_m_s: f64,
    /// How quickly what is left of the way is gone, as a share of it a second: the arm follows a moving
    /// hand 1/8 s behind. Capped at a fifth of the way a cycle.
    pub response_per_s: f64,
    /// From here to its limit a joint is slowed in proportion, radians. As in MoveIt Servo.
    pub limit_margin_rad: f64,
    /// How far outside its range a joint may be at the start, radians. It then may only come back.
    pub max_outside_rad: f64,
    /// Nearer than this to a singularity the approach is slowed in proportion: each factor of det J as a
    /// share of the largest it can have. The wrist's is the sine of 8.6 degrees.
    pub singularity_margin: f64,
    /// What slowing leaves of the speed at least, above 0 and at most 1, so that the arm always goes on.
    pub creep_share: f64,
    /// Through which singularities the arm may pass.
    pub passages: AllowedPassages,
    /// Joints at which the tool is home, radians; `None`: where the arm was when it was first started. The arm
    /// goes to where the tool is then, in the posture in which it stands.
    pub home_rad: Option<[f64; JOINTS]>,
    /// The share of its speed with which the arm goes home, 0.05 to 1: nobody leads it by the hand.
    pub home_speed_share: f64,
    /// How speed falls as the hand is known less well. The refined tracker's own figures stay around a
    /// millimetre and a hundredth of a radian.
    pub uncertainty: SlowedByUncertainty,
}

/// Slower than this on its way home an arm would be taken for one that has come to rest.
const LEAST_HOME_SPEED_SHARE: f64 = 0.05;

impl Default for GovernorConfig {
    fn default() -> Self {
        let acceleration = DRIVEN_RAD_S2.map(|most| most * DRIVEN_SHARE);
        Self {
            cycle_us: 10_000,
            workspace: super::TeleopConfig::default().workspace,
            speed_share: 0.9,
            max_acceleration_rad_s2: acceleration,
            max_jerk_rad_s3: acceleration.map(|most| most / BUILD_UP_S),
            max_tool_speed_m_s: 0.5,
            response_per_s: 8.0,
            limit_margin_rad: 0.1,
            max_outside_rad: 0.1,
            singularity_margin: 0.15,
            creep_share: 0.1,
            passages: AllowedPassages { wrist: true, elbow: false, shoulder: false },
            home_rad: None,
            home_speed_share: 0.25,
            uncertainty: SlowedByUncertainty { full_m: 0.005, creep_m: 0.03, full_rad: 0.05, creep_rad: 0.3 },
        }
    }
}

/// Which setting of the governor cannot be worked with. Joints count from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GovernorConfigError {
    /// `cycle_us` must be from 1,000 to 100,000.
    Cycle,
    /// `workspace` must be a box with each least below its largest, within 100 m.
    Workspace,
    /// `speed_share` must be above 0 and at most 1.
    SpeedShare,
    /// `max_acceleration_rad_s2` of this joint must be above 0 and at most 10,000.
    Acceleration(u8),
    /// `max_jerk_rad_s3` of this joint must be above 0 and at most 1,000,000.
    Jerk(u8),
    /// With its speed, acceleration and jerk this joint takes over 2 s to stop.
    SlowToStop(u8),
    /// `max_tool_speed_m_s` must be above 0 and at most 10.
    ToolSpeed,
    /// `response_per_s` must be from 0.1 to 100.
    Response,
    /// `limit_margin_rad` must be from 0 to 1.
    LimitMargin,
    /// `max_outside_rad` must be from 0 to 1.
    MaxOutside,
    /// `singularity_margin` must be from 0 to 0.9.
    SingularityMargin,
    /// `creep_share` must be above 0 and at most 1.
    CreepShare,
    /// In `uncertainty` each creep must lie above its full, both from 0 to 10.
    Uncertainty,
    /// `home_speed_share` must be from 0.05 to 1.
    HomeSpeedShare,
    /// `home_rad` of this joint must be within the joint's range.
    Home(u8),
    /// With the joints at `home_rad` the tool must be in the workspace.
    HomeOutside,
}

impl fmt::Display for GovernorConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cycle => "cycle_us must be from 1000 to 100000",
            Self::Workspace => "workspace must have each least below its largest, within 100 m",
            Self::SpeedShare => "speed_share must be above 0 and at most 1",
            Self::Acceleration(joint) => {
                return write!(
                    f,
                    "max_acceleration_rad_s2 of joint {joint} must be above 0 and at most 10000"
                );
            }
            Self::Jerk(joint) => {
                return write!(f, "max_jerk_rad_s3 of joint {joint} must be above 0 and at most 1000000");
            }
            Self::SlowToStop(joint) => {
                return write!(
                    f,
                    "joint {joint} would take over 2 s to stop; raise its max_acceleration_rad_s2 or \
                     max_jerk_rad_s3, or lower speed_share"
                );
            }
            Self::ToolSpeed => "max_tool_speed_m_s must be above 0 and at most 10",
            Self::Response => "response_per_s must be from 0.1 to 100",
            Self::LimitMargin => "limit_margin_rad must be from 0 to 1",
            Self::MaxOutside => "max_outside_rad must be from 0 to 1",
            Self::SingularityMargin => "singularity_margin must be from 0 to 0.9",
            Self::CreepShare => "creep_share must be above 0 and at most 1",
            Self::Uncertainty => "in uncertainty each creep must be above its full, both from 0 to 10",
            Self::HomeSpeedShare => "home_speed_share must be from 0.05 to 1",
            Self::Home(joint) => return write!(f, "home_rad of joint {joint} must be within its range"),
            Self::HomeOutside => "with the joints at home_rad the tool must be in the workspace",
        })
    }
}

impl core::error::Error for GovernorConfigError {}

impl GovernorConfig {
    /// Whether every setting can be worked with by joints of these speeds, rad/s.
    ///
    /// # Errors
    /// The first [`GovernorConfigError`] met.
    pub fn check(&self, joint_speeds_rad_s: &[f64; JOINTS]) -> Result<(), GovernorConfigError> {
        // comparisons written so that NaN fails them
        let above_0 = |x: f64, most: f64| x > 0.0 && x <= most;
        let [shortest, longest] = CYCLE_US;
        if !(shortest..=longest).contains(&self.cycle_us) {
            return Err(GovernorConfigError::Cycle);
        }
        let mut sides = self.workspace.min_m.iter().zip(&self.workspace.max_m);
        let within_reach = |x: &f64| x.abs() <= MAX_WORKSPACE_M;
        if !sides.all(|(min, max)| min < max && within_reach(min) && within_reach(max)) {
            return Err(GovernorConfigError::Workspace);
        }
        if !above_0(self.speed_share, 1.0) {
            return Err(GovernorConfigError::SpeedShare);
        }
        let limits = self.max_acceleration_rad_s2.iter().zip(&self.max_jerk_rad_s3);
        for (number, ((acceleration, jerk), speed)) in (1..).zip(limits.zip(joint_speeds_rad_s)) {
            if !above_0(*acceleration, 10_000.0) {
                return Err(GovernorConfigError::Acceleration(number));
            }
            if !above_0(*jerk, 1_000_000.0) {
                return Err(GovernorConfigError::Jerk(number));
            }
            // the acceleration that there is, away; the speed; the deceleration, away
            let stop_s = speed * self.speed_share / acceleration + 2.0 * acceleration / jerk;
            if !above_0(stop_s, MAX_STOP_S) {
                return Err(GovernorConfigError::SlowToStop(number));
            }
        }
        if !above_0(self.max_tool_speed_m_s, 10.0) {
            return Err(GovernorConfigError::ToolSpeed);
        }
        if !(0.1..=100.0).contains(&self.response_per_s) {
            return Err(GovernorConfigError::Response);
        }
        if !(0.0..=1.0).contains(&self.limit_margin_rad) {
            return Err(GovernorConfigError::LimitMargin);
        }
        if !(0.0..=1.0).contains(&self.max_outside_rad) {
            return Err(GovernorConfigError::MaxOutside);
        }
        if !(0.0..=0.9).contains(&self.singularity_margin) {
            return Err(GovernorConfigError::SingularityMargin);
        }
        if !above_0(self.creep_share, 1.0) {
            return Err(GovernorConfigError::CreepShare);
        }
        let u = &self.uncertainty;
        let falls = |full: f64, creep: f64| full >= 0.0 && full < creep && creep <= 10.0;
        if !falls(u.full_m, u.creep_m) || !falls(u.full_rad, u.creep_rad) {
            return Err(GovernorConfigError::Uncertainty);
        }
        if (LEAST_HOME_SPEED_SHARE..=1.0).contains(&self.home_speed_share) {
            Ok(())
        } else {
            Err(GovernorConfigError::HomeSpeedShare)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::PumaConfig;

    fn with(change: impl FnOnce(&mut GovernorConfig)) -> Result<(), GovernorConfigError> {
        let mut config = GovernorConfig::default();
        change(&mut config);
        config.check(&PumaConfig::default().joints.map(|joint| joint.max_speed_rad_s))
    }

    #[test]
    fn the_defaults_can_be_worked_with() {
        assert_eq!(with(|_| {}), Ok(()));
        assert_eq!(with(|c| c.cycle_us = 1_000), Ok(()));
        assert_eq!(with(|c| c.cycle_us = 100_000), Ok(()));
    }

    #[test]
    fn what_cannot_be_worked_with_is_named() {
        use GovernorConfigError::*;
        assert_eq!(with(|c| c.cycle_us = 999), Err(Cycle));
        assert_eq!(with(|c| c.workspace.min_m[2] = 1.6), Err(Workspace));
        assert_eq!(with(|c| c.workspace.max_m[0] = f64::NAN), Err(Workspace));
        assert_eq!(with(|c| c.speed_share = 1.1), Err(SpeedShare));
        assert_eq!(with(|c| c.max_acceleration_rad_s2[3] = 0.0), Err(Acceleration(4)));
        assert_eq!(with(|c| c.max_jerk_rad_s3[5] = f64::NAN), Err(Jerk(6)));
        assert_eq!(with(|c| c.max_acceleration_rad_s2[0] = 0.5), Err(SlowToStop(1)));
        assert_eq!(with(|c| c.max_jerk_rad_s3[1] = 5.0), Err(SlowToStop(2)));
        assert_eq!(with(|c| c.max_tool_speed_m_s = 0.0), Err(ToolSpeed));
        assert_eq!(with(|c| c.response_per_s = f64::INFINITY), Err(Response));
        assert_eq!(with(|c| c.limit_margin_rad = -0.1), Err(LimitMargin));
        assert_eq!(with(|c| c.max_outside_rad = f64::NAN), Err(MaxOutside));
        assert_eq!(with(|c| c.singularity_margin = 1.0), Err(SingularityMargin));
        assert_eq!(with(|c| c.creep_share = 0.0), Err(CreepShare));
        assert_eq!(with(|c| c.uncertainty.creep_m = 0.005), Err(Uncertainty));
        assert_eq!(with(|c| c.uncertainty.full_rad = f64::NAN), Err(Uncertainty));
        assert_eq!(with(|c| c.home_speed_share = 0.04), Err(HomeSpeedShare));
        assert_eq!(with(|c| c.home_speed_share = 0.05), Ok(()));
        assert_eq!(with(|c| c.home_speed_share = f64::NAN), Err(HomeSpeedShare));
    }
}
