//! Why the arm was stopped: in words for the operator, as a status for the station.

use super::cia402::{State, about_error};
use super::frame::NmtState;
use super::sdo::{AbortCode, Object};
use crate::arm::port::{JointNumber, PortFault, PortStatus};
use core::fmt;

/// A drive, by its joint and its place on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DriveName {
    /// The joint, from 1.
    pub joint: JointNumber,
    /// The node number.
    pub node: u8,
}

impl fmt::Display for DriveName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the drive of joint {} (node {})", self.joint, self.node)
    }
}

/// What only a master sends, seen from somebody else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// An NMT command.
    Nmt,
    /// SYNC.
    Sync,
    /// Targets for one of our drives.
    Target(u8),
    /// An SDO request to one of our drives.
    Request(u8),
    /// Our own heartbeat.
    Heartbeat(u8),
}

impl fmt::Display for Foreign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Nmt => f.write_str("NMT commands"),
            Self::Sync => f.write_str("SYNC"),
            Self::Target(node) => write!(f, "set-points for node {node}"),
            Self::Request(node) => write!(f, "SDO requests to node {node}"),
            Self::Heartbeat(node) => write!(f, "a heartbeat as node {node}, the master's own number"),
        }
    }
}

/// What about a drive's answers makes no sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Nonsense {
    /// A TPDO of another length than was mapped.
    Length(u8),
    /// A statusword that no state has.
    Status(u16),
    /// A position that the joint cannot have come to, counts apart.
    Jump(i64),
    /// An SDO answer that is none to the request.
    Answer(Object),
}

impl fmt::Display for Nonsense {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(bytes) => write!(f, "{bytes} bytes where statusword and position are 6"),
            Self::Status(word) => write!(f, "statusword {word:#06x}, which is no state"),
            Self::Jump(counts) => write!(f, "a position {counts} counts from the last one"),
            Self::Answer(object) => write!(f, "an SDO answer about {object} of the wrong kind"),
        }
    }
}

/// Why the arm was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It was asked to.
    Asked,
    /// No set-point came for so many milliseconds.
    NoSetPoint(u32),
    /// A drive is not homed any more.
    HomingLost(DriveName),
    /// A drive is in fault, with the error code it told (0: none yet).
    Fault(DriveName, u16),
    /// A drive left operation without having been told to: an emergency stop, as a rule.
    LeftOperation(DriveName, State),
    /// A drive does not get to operation enabled.
    Stuck(DriveName, State),
    /// A drive is not operational any more as a node.
    NotOperational(DriveName, NmtState),
    /// Somebody else acts as master.
    OtherMaster(Foreign),
    /// A drive's answers make no sense.
    Nonsense(DriveName, Nonsense),
    /// A drive refused to be configured.
    Refused(DriveName, Object, AbortCode),
    /// A node is no CiA 402 drive: its device type.
    NotADrive(DriveName, u32),
    /// A drive of another vendor than was configured.
    OtherVendor(DriveName, u32),
    /// A drive does not take up the mode of operation; the one it has.
    OtherMode(DriveName, u8),
    /// A drive does not answer.
    Silent(DriveName),
    /// No drive answers.
    AllSilent,
    /// No drive answers, and so many bytes came that belong to no frame.
    Garbled(u64),
    /// A drive was switched off and on, or reset.
    Restarted(DriveName),
    /// The bus cannot be used; whoever opened it knows what the system said.
    Bus,
}

/// Codes of faults that are the master's own finding, beyond the 16 bits of a drive's error codes.
mod code {
    pub(super) const OTHER_MASTER: u32 = 0x1_0001;
    pub(super) const NONSENSE: u32 = 0x1_0002;
    pub(super) const LEFT_OPERATION: u32 = 0x1_0003;
    pub(super) const STUCK: u32 = 0x1_0004;
    pub(super) const NOT_OPERATIONAL: u32 = 0x1_0005;
    pub(super) const REFUSED: u32 = 0x1_0006;
    pub(super) const OTHER_DEVICE: u32 = 0x1_0007;
    pub(super) const OTHER_MODE: u32 = 0x1_0008;
}

impl Cause {
    /// The status it puts the port in.
    #[must_use]
    pub fn status(&self) -> PortStatus {
        let fault = |drive: &DriveName, code| PortStatus::Fault(PortFault { joint: Some(drive.joint), code });
        match self {
            Self::Asked | Self::NoSetPoint(_) => PortStatus::Stopped,
            Self::HomingLost(_) => PortStatus::NotHomed,
            Self::Fault(drive, error) => fault(drive, u32::from(*error)),
            Self::LeftOperation(drive, _) => fault(drive, code::LEFT_OPERATION),
            Self::Stuck(drive, _) => fault(drive, code::STUCK),
            Self::NotOperational(drive, _) => fault(drive, code::NOT_OPERATIONAL),
            Self::Nonsense(drive, _) => fault(drive, code::NONSENSE),
            Self::Refused(drive, ..) => fault(drive, code::REFUSED),
            Self::NotADrive(drive, _) | Self::OtherVendor(drive, _) => fault(drive, code::OTHER_DEVICE),
            Self::OtherMode(drive, _) => fault(drive, code::OTHER_MODE),
            Self::OtherMaster(_) => PortStatus::Fault(PortFault { joint: None, code: code::OTHER_MASTER }),
            Self::Silent(_) | Self::AllSilent | Self::Garbled(_) | Self::Restarted(_) | Self::Bus => {
                PortStatus::Lost
            }
        }
    }

    /// Whether anything worse than being told may take its place.
    #[must_use]
    pub const fn is_benign(&self) -> bool {
        matches!(self, Self::Asked | Self::NoSetPoint(_) | Self::HomingLost(_))
    }
}

/// What happened, and what would mend it.
impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked => f.write_str("stopped as asked; enable to go on"),
            Self::NoSetPoint(ms) => write!(f, "no set-point came for {ms} ms; enable to go on"),
            Self::HomingLost(drive) => write!(f, "{drive} is not homed any more; home it, then enable"),
            Self::Fault(drive, error) => write!(
                f,
                "{drive} is in fault {error:#06x} ({}); mend that, then enable to reset it",
                about_error(*error)
            ),
            Self::LeftOperation(drive, state) => write!(
                f,
                "{drive} went to '{state}' by itself; check the emergency stop and the motor supply, then enable"
            ),
            Self::Stuck(drive, state) => write!(
                f,
                "{drive} stays in '{state}'; check the emergency stop, the motor supply and its enable input"
            ),
            Self::NotOperational(drive, state) => write!(
                f,
                "{drive} became {state} as a node; check that nothing else commands the bus, then enable"
            ),
            Self::OtherMaster(what) => write!(
                f,
                "another master is on the bus: it sends {what}; stop it, then enable"
            ),
            Self::Nonsense(drive, what) => write!(
                f,
                "{drive} answers nonsense: {what}; check node numbers, bit rate and terminators"
            ),
            Self::Refused(drive, object, abort) => write!(
                f,
                "{drive} refused {object} ({abort}); it must allow PDO mapping and cyclic synchronous position"
            ),
            Self::NotADrive(drive, device) => write!(
                f,
                "{drive} is no CiA 402 drive: its device type is {device:#010x}; check the node numbers"
            ),
            Self::OtherVendor(drive, vendor) => write!(
                f,
                "{drive} is of vendor {vendor:#x}, not the one configured; check node numbers and `vendor`"
            ),
            Self::OtherMode(drive, mode) => write!(
                f,
                "{drive} stays in mode of operation {mode}; it must do 8, cyclic synchronous position"
            ),
            Self::Silent(drive) => write!(
                f,
                "{drive} does not answer; check its power, its bus cable and its node number, then enable"
            ),
            Self::AllSilent => f.write_str(
                "no drive answers; check the bus cable, its terminators, the bit rate and the drives' power, then enable",
            ),
            Self::Garbled(bytes) => write!(
                f,
                "no drive answers, and {bytes} bytes came that are no CAN frames; check `baud` in the adapter's \
                 address, that it is set to SLCAN, and its cable, then enable"
            ),
            Self::Restarted(drive) => {
                write!(f, "{drive} was restarted; check its supply, then enable")
            }
            Self::Bus => f.write_str("the CAN bus is gone; check adapter and interface, then enable"),
        }
    }
}
