//! The slave's law: what the hand may ask of the arm, and for how long its word stands.
//!
//! Lengths and angles in double precision whatever the arm is computed in, as in
//! [`PumaConfig`](super::PumaConfig).

use core::fmt;
use nalgebra::Matrix3;

/// The longest time that any word may stand, microseconds.
const MAX_TIMEOUT_US: u32 = 5_000_000;

/// The largest scale of places. More than this turns the tremor of a hand into a movement.
const MAX_SCALE: f64 = 10.0;

/// The largest scale of turns.
const MAX_TURN_SCALE: f64 = 3.0;

/// The farthest corner of a workspace that is believed, metres.
const MAX_WORKSPACE_M: f64 = 100.0;

/// The farthest that the goal may be turned ahead of the arm, radians. Towards half a turn the short
/// way round becomes the other way.
const MAX_TURN_LEAD_RAD: f64 = 2.0;

/// How far R^T R of the rotation between hand and robot may be from the identity.
const MAX_SKEW: f64 = 1e-9;

/// Which law leads from the hand to the goal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TeleopMode {
    /// The set-point latched at engage, moved by the hand's motion since engage.
    #[default]
    SinceEngage,
    /// As printed in section 5: each increment is added to what is measured, X + alpha and M Phi. A
    /// lost packet is lost motion, and an arm that sags drifts. For comparison.
    Paper,
}

/// What a turn of the hand does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Turning {
    /// The tool turns by so many times the angle of the hand. Above 0, at most 3. With anything but
    /// 1 a hand turned by over 2.6 rad since engage no longer leads back to the same turn of the tool.
    Scaled(f64),
    /// The tool keeps its orientation.
    Locked,
}

/// A box in which the tool may be, in the axes of the robot's base, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Workspace {
    /// The least x, y and z.
    pub min_m: [f64; 3],
    /// The largest x, y and z.
    pub max_m: [f64; 3],
}

/// How fast a hand is believed to move from one command to the next. What goes beyond is taken for a
/// mistake of the tracker or for motion made unseen, and never reaches the arm.
///
/// Over a gap of t seconds (told by the sender's pictures) a hand may have moved by
/// `slack_m + speed_m_s t`, but never by more than `most_m`; turns alike.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BelievedMotion {
    /// What noise may add, metres.
    pub slack_m: f64,
    /// The fastest hand, m/s. Reaching hands stay below 2.
    pub speed_m_s: f64,
    /// The most that the arm is made to catch up with after a gap, however long it was, metres.
    pub most_m: f64,
    /// What noise may add to a turn, radians.
    pub slack_rad: f64,
    /// The fastest turn, rad/s.
    pub speed_rad_s: f64,
    /// The most turn to catch up with, radians.
    pub most_rad: f64,
}

/// The slave's law ([`crate::arm::teleop`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeleopConfig {
    /// Which law.
    pub mode: TeleopMode,
    /// Metres of the tool for one metre of the hand. The default is the paper's "replica".
    pub scale: f64,
    /// What a turn of the hand does.
    pub turning: Turning,
    /// The robot's base axes from those of the hand at engage (red ball to green x, to blue y, to
    /// yellow z): a proper rotation.
    pub robot_from_hand: Matrix3<f64>,
    /// Where the goal may be.
    pub workspace: Workspace,
    /// How far the goal may be ahead of the set-point, metres: half a second of a tool at 0.5 m/s. So
    /// long the arm may go on after the hand stopped.
    pub max_lead_m: f64,
    /// The same of turns, radians, at most 2.
    pub max_lead_rad: f64,
    /// A command stands for so long after it came, on this receiver's clock, microseconds. 100 ms as
    /// in MoveIt Servo: three frames at 30 frames/s.
    pub command_timeout_us: u32,
    /// The same of hold-to-run, microseconds. A pedal is read a hundred times a second.
    pub hold_to_run_timeout_us: u32,
    /// For how long a predicted hand is followed since it was last measured, microseconds. The hand
    /// tracker's own bound is 170 ms; this one is for senders that have none.
    pub predicted_us: u32,
    /// A hold of over so long ends the engagement: it takes a release and a fresh press to go on,
    /// microseconds.
    pub resume_us: u32,
    /// How fast the hand is believed to move.
    pub believed: BelievedMotion,
}

impl Default for TeleopConfig {
    fn default() -> Self {
        Self {
            mode: TeleopMode::SinceEngage,
            scale: 1.0,
            turning: Turning::Scaled(1.0),
            robot_from_hand: Matrix3::identity(),
            // what a PUMA 560 reaches (0.92 m about a shoulder at 0.67 m), down to its mounting surface
            workspace: Workspace { min_m: [-0.95, -0.95, 0.0], max_m: [0.95, 0.95, 1.6] },
            max_lead_m: 0.25,
            max_lead_rad: 1.0,
            command_timeout_us: 100_000,
            hold_to_run_timeout_us: 200_000,
            predicted_us: 200_000,
            resume_us: 500_000,
            believed: BelievedMotion {
                slack_m: 0.03,
                speed_m_s: 2.0,
                most_m: 0.15,
                slack_rad: 0.15,
                speed_rad_s: 10.0,
                most_rad: 0.6,
            },
        }
    }
}

/// Which setting of the slave's law cannot be worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TeleopConfigError {
    /// A scale must be above 0, that of places at most 10, that of turns at most 3.
    Scale,
    /// The rotation from hand to robot is not orthonormal and right-handed.
    RobotFromHand,
    /// The workspace must be a box with each least below its largest, within 100 m.
    Workspace,
    /// The lead must be above 0, that of turns at most 2 rad.
    Lead,
    /// A command must stand for 1 us to 5 s.
    CommandTimeout,
    /// Hold-to-run must stand for 1 us to 5 s.
    HoldToRunTimeout,
    /// A predicted hand must be followed for 1 us to 5 s.
    Predicted,
    /// The hold that ends an engagement must be 1 us to 5 s long.
    Resume,
    /// That hold must be no shorter than a command or hold-to-run stands.
    ResumeTooShort,
    /// The motion that is believed must be finite, its most above 0 and no less than its slack.
    Believed,
}

impl fmt::Display for TeleopConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Scale => "the scale of places must be above 0 and at most 10, that of turns at most 3",
            Self::RobotFromHand => "robot_from_hand must be a rotation: orthonormal and right-handed",
            Self::Workspace => "the workspace must have each least below its largest, within 100 m",
            Self::Lead => "the lead over the arm must be above 0, at most 100 m and 2 rad",
            Self::CommandTimeout => "the time that a command stands must be between 1 us and 5 s",
            Self::HoldToRunTimeout => "the time that hold-to-run stands must be between 1 us and 5 s",
            Self::Predicted => "the time that a predicted hand is followed must be between 1 us and 5 s",
            Self::Resume => {
                "the pause after which it takes a fresh press to go on must be between 1 us and 5 s"
            }
            Self::ResumeTooShort => {
                "the pause after which it takes a fresh press to go on must be no shorter than a command or \
                 hold-to-run stands"
            }
            Self::Believed => "the believed motion must be finite, its most above 0 and at least its slack",
        })
    }
}

impl core::error::Error for TeleopConfigError {}

impl TeleopConfig {
    /// The paper's law, for comparison.
    #[must_use]
    pub fn paper() -> Self {
        Self { mode: TeleopMode::Paper, ..Self::default() }
    }

    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`TeleopConfigError`] met.
    pub fn check(&self) -> Result<(), TeleopConfigError> {
        // comparisons written so that NaN fails them
        let within = |x: f64, most: f64| x > 0.0 && x <= most;
        let turning = match self.turning {
            Turning::Scaled(scale) => within(scale, MAX_TURN_SCALE),
            Turning::Locked => true,
        };
        if !within(self.scale, MAX_SCALE) || !turning {
            return Err(TeleopConfigError::Scale);
        }
        let r = &self.robot_from_hand;
        let skew = r.transpose() * r - Matrix3::identity();
        let is_rotation = skew.iter().all(|x| x.abs() <= MAX_SKEW) && r.determinant() > 0.0;
        if !is_rotation {
            return Err(TeleopConfigError::RobotFromHand);
        }
        let sides = self.workspace.min_m.iter().zip(&self.workspace.max_m);
        let within_reach = |x: &f64| x.abs() <= MAX_WORKSPACE_M;
        if !sides.into_iter().all(|(min, max)| min < max && within_reach(min) && within_reach(max)) {
            return Err(TeleopConfigError::Workspace);
        }
        if !within(self.max_lead_m, MAX_WORKSPACE_M) || !within(self.max_lead_rad, MAX_TURN_LEAD_RAD) {
            return Err(TeleopConfigError::Lead);
        }
        for (us, error) in [
            (self.command_timeout_us, TeleopConfigError::CommandTimeout),
            (self.hold_to_run_timeout_us, TeleopConfigError::HoldToRunTimeout),
            (self.predicted_us, TeleopConfigError::Predicted),
            (self.resume_us, TeleopConfigError::Resume),
        ] {
            if !(1..=MAX_TIMEOUT_US).contains(&us) {
                return Err(error);
            }
        }
        if self.resume_us < self.command_timeout_us.max(self.hold_to_run_timeout_us) {
            return Err(TeleopConfigError::ResumeTooShort);
        }
        let b = &self.believed;
        let kinds = [(b.slack_m, b.speed_m_s, b.most_m), (b.slack_rad, b.speed_rad_s, b.most_rad)];
        let believed = |(slack, speed, most): &(f64, f64, f64)| {
            *slack >= 0.0 && within(*most, 10.0) && slack <= most && (0.0..=1000.0).contains(speed)
        };
        if kinds.iter().all(believed) { Ok(()) } else { Err(TeleopConfigError::Believed) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(change: impl FnOnce(&mut TeleopConfig)) -> Result<(), TeleopConfigError> {
        let mut config = TeleopConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_defaults_can_be_worked_with() {
        assert_eq!(TeleopConfig::default().check(), Ok(()));
        assert_eq!(TeleopConfig::paper().check(), Ok(()));
        assert_eq!(with(|c| c.turning = Turning::Locked), Ok(()));
        assert_eq!(with(|c| c.robot_from_hand = Matrix3::new(0., -1., 0., 1., 0., 0., 0., 0., 1.)), Ok(()));
    }

    #[test]
    fn what_cannot_be_worked_with_is_named() {
        use TeleopConfigError::{
            Believed, CommandTimeout, HoldToRunTimeout, Lead, Predicted, Resume, ResumeTooShort,
            RobotFromHand, Scale, Workspace,
        };
        assert_eq!(with(|c| c.scale = 0.0), Err(Scale));
        assert_eq!(with(|c| c.scale = f64::NAN), Err(Scale));
        assert_eq!(with(|c| c.turning = Turning::Scaled(-1.0)), Err(Scale));
        assert_eq!(with(|c| c.robot_from_hand *= 1.1), Err(RobotFromHand));
        assert_eq!(with(|c| c.robot_from_hand[(2, 2)] = -1.0), Err(RobotFromHand));
        assert_eq!(with(|c| c.robot_from_hand[(0, 0)] = f64::NAN), Err(RobotFromHand));
        assert_eq!(with(|c| c.workspace.min_m[1] = 0.95), Err(Workspace));
        assert_eq!(with(|c| c.workspace.max_m[2] = f64::INFINITY), Err(Workspace));
        assert_eq!(with(|c| c.max_lead_m = 0.0), Err(Lead));
        assert_eq!(with(|c| c.max_lead_rad = 3.0), Err(Lead));
        assert_eq!(with(|c| c.command_timeout_us = 0), Err(CommandTimeout));
        assert_eq!(with(|c| c.hold_to_run_timeout_us = 0), Err(HoldToRunTimeout));
        assert_eq!(with(|c| c.predicted_us = 6_000_000), Err(Predicted));
        assert_eq!(with(|c| c.resume_us = 6_000_000), Err(Resume));
        assert_eq!(with(|c| c.resume_us = 150_000), Err(ResumeTooShort));
        assert_eq!(with(|c| c.believed.most_m = 0.01), Err(Believed));
        assert_eq!(with(|c| c.believed.speed_rad_s = f64::NAN), Err(Believed));
    }
}
