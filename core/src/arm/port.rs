//! What every controller of an arm can be asked: one trait between the slave station and whatever
//! turns joint set-points into motion (a simulated plant, a CANopen bus, a VAL II terminal).
//!
//! # The contract
//!
//! - Angles are radians, joints in order from base to wrist, zero and sense as in
//!   [`puma560`](crate::arm::puma560). A port that drives another convention converts.
//! - No call waits for motion. Each gives back within the port's own cycle; what takes longer
//!   (enabling, homing) is begun, and [`RobotPort::status`] tells how far it is.
//! - A set-point is a place for the joints to be at the end of the next cycle. It is the caller who
//!   keeps set-points apart by no more than the joints can do; a port refuses what is not finite or
//!   out of its range, and never moves towards a part of what it refused.
//! - Only the newest set-point counts. A port queues none: what was written before a stop, a loss or
//!   a fault is never gone to after it.
//! - Loss: a port that hears nothing from its controller, or gets no set-point for longer than its own
//!   watchdog allows, brings the arm to rest within its limits, says [`PortStatus::Lost`] or
//!   [`PortStatus::Stopped`], and stays there until it is enabled again. It never comes back by
//!   itself, and where it comes back the first set-point must be where the arm is.
//! - [`RobotPort::stop`] is obeyed in every status and may be called again and again.

use super::puma560::Joints;
use super::teleop::ArmCondition;
use crate::real::Real;
use core::fmt;

/// A joint's number as its maker counts: 1 to 6.
pub type JointNumber = u8;

/// What the controller calls a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PortFault {
    /// Which joint's drive; `None` for the controller as a whole.
    pub joint: Option<JointNumber>,
    /// The controller's own number, as its manual lists it.
    pub code: u32,
}

impl fmt::Display for PortFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.joint {
            Some(joint) => write!(f, "the drive of joint {joint} reports fault {:#06x}", self.code),
            None => write!(f, "the controller reports fault {:#06x}", self.code),
        }
    }
}

/// How a port stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PortStatus {
    /// Connected, without power on the joints.
    #[default]
    Disabled,
    /// On the way to [`PortStatus::Ready`].
    Enabling,
    /// Homing, or waiting for somebody to home it: angles are not to be trusted.
    NotHomed,
    /// Set-points are followed.
    Ready,
    /// Asked to stop, or without a set-point for too long: at rest or coming to rest; set-points are
    /// refused until it is enabled again.
    Stopped,
    /// The controller reports a fault: at rest or coming to rest; it is to be cleared at the arm, then
    /// enabled.
    Fault(PortFault),
    /// The controller does not answer.
    Lost,
}

impl PortStatus {
    /// What the slave's law makes of it.
    #[must_use]
    pub const fn condition(self) -> ArmCondition {
        match self {
            Self::Ready => ArmCondition::Ready,
            Self::Disabled | Self::Enabling | Self::NotHomed | Self::Stopped => ArmCondition::NotReady,
            Self::Fault(_) | Self::Lost => ArmCondition::Fault,
        }
    }
}

impl fmt::Display for PortStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Disabled => "the arm is switched off; enable it",
            Self::Enabling => "the arm is being switched on",
            Self::NotHomed => "the arm does not know where its joints are; home it",
            Self::Ready => "the arm is ready",
            Self::Stopped => "the arm was stopped; enable it to go on",
            Self::Fault(fault) => return write!(f, "{fault}; clear it at the arm, then enable"),
            Self::Lost => "the arm's controller does not answer; check its power and its cable",
        })
    }
}

/// Where the joints were measured to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointReading<T> {
    /// Radians.
    pub joints: Joints<T>,
    /// How old the reading was when it was given, microseconds; a controller that is asked over a slow
    /// line gives the last one it has.
    pub age_us: u32,
}

/// Why a port did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PortError {
    /// It takes set-points only when ready.
    NotReady(PortStatus),
    /// An angle of the set-point is not finite.
    NotFinite(JointNumber),
    /// An angle of the set-point is beyond what the port lets this joint do.
    OutOfRange(JointNumber),
    /// The set-point is further from the last one than this joint can go in a cycle.
    TooFar(JointNumber),
    /// Nothing has been measured yet.
    NotMeasured,
    /// The controller answered with something that makes no sense.
    Nonsense,
    /// The controller refused, with its own number.
    Refused(PortFault),
    /// The controller does not answer.
    Lost,
}

impl fmt::Display for PortError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotReady(status) => write!(f, "no set-point taken: {status}"),
            Self::NotFinite(joint) => {
                write!(f, "joint {joint}: the set-point is not a finite number; the arm keeps the last one")
            }
            Self::OutOfRange(joint) => write!(
                f,
                "joint {joint}: the set-point is beyond the joint's range; move away from it, or set the range"
            ),
            Self::TooFar(joint) => {
                write!(f, "joint {joint}: the set-point is too far from the last one; start where the arm is")
            }
            Self::NotMeasured => f.write_str("the joints have not been measured yet; wait, then ask again"),
            Self::Nonsense => f.write_str(
                "the arm's controller answers nonsense; check the line's speed and the program at its end",
            ),
            Self::Refused(fault) => write!(f, "refused: {fault}; its manual lists the number"),
            Self::Lost => PortStatus::Lost.fmt(f),
        }
    }
}

impl core::error::Error for PortError {}

/// A controller of an arm with six joints. Object-safe; see the [contract](self).
pub trait RobotPort<T: Real = f64> {
    /// Where the joints are measured to be.
    ///
    /// # Errors
    /// [`PortError::NotMeasured`], [`PortError::Nonsense`], [`PortError::Lost`].
    fn read_joints(&mut self) -> Result<JointReading<T>, PortError>;

    /// Sends the joints to `joints` radians. The port must be [`PortStatus::Ready`].
    ///
    /// # Errors
    /// [`PortError`]; the arm keeps the last set-point, or stops where the status says so.
    fn write_set_point(&mut self, joints: &Joints<T>) -> Result<(), PortError>;

    /// Begins to switch the arm on, from any status; also after a stop, a fault that was cleared, or a
    /// loss. The arm does not move by it: its first set-point is where it is.
    ///
    /// # Errors
    /// [`PortError::Refused`], [`PortError::Lost`]. That it is still being switched on is none.
    fn enable(&mut self) -> Result<(), PortError>;

    /// Brings the arm to rest, as fast as its limits allow, and forgets the set-point.
    ///
    /// # Errors
    /// [`PortError::Lost`] where the controller cannot be told; its own watchdog has to stop it then.
    fn stop(&mut self) -> Result<(), PortError>;

    /// How the port stands, as far as it has heard.
    fn status(&self) -> PortStatus;
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::boxed::Box;
    use std::string::ToString;

    /// The least that keeps the contract: joints that are at once where they are sent.
    #[derive(Default)]
    struct Ideal {
        joints: Joints<f64>,
        status: PortStatus,
    }

    impl RobotPort for Ideal {
        fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
            Ok(JointReading { joints: self.joints, age_us: 0 })
        }

        fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
            if self.status != PortStatus::Ready {
                return Err(PortError::NotReady(self.status));
            }
            if let Some((number, _)) = (1..).zip(joints).find(|(_, angle)| !angle.is_finite()) {
                return Err(PortError::NotFinite(number));
            }
            self.joints = *joints;
            Ok(())
        }

        fn enable(&mut self) -> Result<(), PortError> {
            self.status = PortStatus::Ready;
            Ok(())
        }

        fn stop(&mut self) -> Result<(), PortError> {
            self.status = PortStatus::Stopped;
            Ok(())
        }

        fn status(&self) -> PortStatus {
            self.status
        }
    }

    #[test]
    fn a_port_is_an_object_and_refuses_by_name() {
        let mut port: Box<dyn RobotPort> = Box::new(Ideal::default());
        let refused = port.write_set_point(&[0.1; 6]).unwrap_err();
        assert_eq!(refused.to_string(), "no set-point taken: the arm is switched off; enable it");
        assert_eq!(port.status().condition(), ArmCondition::NotReady);
        port.enable().unwrap();
        assert_eq!(port.status().condition(), ArmCondition::Ready);
        port.write_set_point(&[0.1; 6]).unwrap();
        let mut bad = [0.2; 6];
        bad[4] = f64::NAN;
        assert_eq!(port.write_set_point(&bad), Err(PortError::NotFinite(5)));
        assert_eq!(port.read_joints().unwrap().joints, [0.1; 6]);
        port.stop().unwrap();
        assert_eq!(port.write_set_point(&[0.2; 6]), Err(PortError::NotReady(PortStatus::Stopped)));
    }

    #[test]
    fn a_fault_names_joint_and_code() {
        let fault = PortStatus::Fault(PortFault { joint: Some(3), code: 0x8611 });
        assert_eq!(fault.condition(), ArmCondition::Fault);
        let text = "the drive of joint 3 reports fault 0x8611; clear it at the arm, then enable";
        assert_eq!(fault.to_string(), text);
        let text = "the controller reports fault 0x0002";
        assert_eq!(PortFault { joint: None, code: 2 }.to_string(), text);
    }
}
