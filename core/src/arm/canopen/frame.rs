//! Frames on the bus, and what each means to a master of CiA 301: the COB-IDs of the predefined
//! connection set.

use core::fmt;

/// The most bytes in a frame.
pub const MAX_DATA: usize = 8;

/// NMT commands, one COB-ID for all.
pub const NMT: u16 = 0x000;
/// SYNC.
pub const SYNC: u16 = 0x080;
/// EMCY of node n is this and n.
pub const EMERGENCY: u16 = 0x080;
/// TPDO1 of node n is this and n.
pub const TPDO1: u16 = 0x180;
/// RPDO1 of node n is this and n.
pub const RPDO1: u16 = 0x200;
/// What node n answers to SDO requests is this and n.
pub const SDO_ANSWER: u16 = 0x580;
/// SDO requests to node n are this and n.
pub const SDO_REQUEST: u16 = 0x600;
/// The heartbeat of node n is this and n.
pub const HEARTBEAT: u16 = 0x700;

/// A data frame with an 11-bit identifier: all that CANopen uses.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    id: u16,
    length: u8,
    data: [u8; MAX_DATA],
}

impl Frame {
    /// A frame; `None` for an identifier of more than 11 bits or more than eight bytes.
    #[must_use]
    pub fn new(id: u16, data: &[u8]) -> Option<Self> {
        if id > 0x7FF || data.len() > MAX_DATA {
            return None;
        }
        let mut padded = [0; MAX_DATA];
        padded.iter_mut().zip(data).for_each(|(to, from)| *to = *from);
        Some(Self { id, length: data.len() as u8, data: padded })
    }

    /// A frame of fixed size of node `node` (1 to 127), or of all where that is 0.
    #[must_use]
    pub(super) fn of<const N: usize>(function: u16, node: u8, data: [u8; N]) -> Self {
        const { assert!(N <= MAX_DATA) }
        let mut padded = [0; MAX_DATA];
        padded.iter_mut().zip(data).for_each(|(to, from)| *to = from);
        Self { id: (function + u16::from(node & 0x7F)) & 0x7FF, length: N as u8, data: padded }
    }

    /// The identifier, 11 bits.
    #[must_use]
    pub const fn id(&self) -> u16 {
        self.id
    }

    /// The bytes.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.data.get(..usize::from(self.length)).unwrap_or_default()
    }

    /// The function code: the identifier without the node.
    #[must_use]
    pub const fn function(&self) -> u16 {
        self.id & 0x780
    }

    /// The node, 1 to 127; 0 where it is meant for all.
    #[must_use]
    pub const fn node(&self) -> u8 {
        (self.id & 0x7F) as u8
    }
}

/// As candump prints it: `201#0F00`.
impl fmt::Debug for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:03X}#", self.id)?;
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

/// What a node's heartbeat says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NmtState {
    /// It was switched on or reset.
    BootUp,
    /// Neither PDOs nor SDOs.
    Stopped,
    /// PDOs and SDOs.
    Operational,
    /// SDOs alone.
    PreOperational,
}

impl NmtState {
    /// By the heartbeat's byte; the toggle bit of node guarding is left out.
    #[must_use]
    pub const fn of(byte: u8) -> Option<Self> {
        match byte & 0x7F {
            0 => Some(Self::BootUp),
            4 => Some(Self::Stopped),
            5 => Some(Self::Operational),
            0x7F => Some(Self::PreOperational),
            _ => None,
        }
    }
}

impl fmt::Display for NmtState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BootUp => "starting",
            Self::Stopped => "stopped",
            Self::Operational => "operational",
            Self::PreOperational => "pre-operational",
        })
    }
}

/// What an NMT master can tell a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NmtCommand {
    /// PDOs from now on.
    Start,
    /// SDOs only, to be configured.
    PreOperational,
}

impl NmtCommand {
    /// The frame that tells `node` so.
    #[must_use]
    pub fn to(self, node: u8) -> Frame {
        let command = match self {
            Self::Start => 0x01,
            Self::PreOperational => 0x80,
        };
        Frame::of(NMT, 0, [command, node])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn frames_are_taken_apart() {
        let frame = Frame::new(0x705, &[5]).unwrap();
        assert_eq!((frame.function(), frame.node(), frame.data()), (HEARTBEAT, 5, &[5u8][..]));
        assert_eq!(format!("{frame:?}"), "705#05");
        assert_eq!(Frame::new(0x800, &[]), None);
        assert_eq!(Frame::new(0x100, &[0; 9]), None);
        assert_eq!(format!("{:?}", NmtCommand::Start.to(3)), "000#0103");
        assert_eq!(NmtState::of(0xFF), Some(NmtState::PreOperational));
        assert_eq!(NmtState::of(0x22), None);
    }
}
