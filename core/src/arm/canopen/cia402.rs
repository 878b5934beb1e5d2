//! The state machine of a CiA 402 drive, as its statusword tells it and its controlword moves it.

use core::fmt;

/// Quick stop: the drive brakes on its own ramp.
pub const QUICK_STOP: u16 = 0x02;
/// No voltage on the motor.
pub const DISABLE_VOLTAGE: u16 = 0x00;
/// Shutdown, which leads to ready to switch on.
pub const SHUTDOWN: u16 = 0x06;
/// Switch on.
pub const SWITCH_ON: u16 = 0x07;
/// Enable operation.
pub const ENABLE_OPERATION: u16 = 0x0F;
/// Fault reset, on its rising edge.
pub const FAULT_RESET: u16 = 0x80;

/// The mode of operation in which a new target comes with every SYNC.
pub const CYCLIC_SYNCHRONOUS_POSITION: u8 = 8;

/// Where a drive stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum State {
    /// Starting or testing itself.
    NotReady,
    /// No voltage may be put on the motor.
    SwitchOnDisabled,
    /// Voltage may be put on.
    ReadyToSwitchOn,
    /// Voltage is on, without torque.
    SwitchedOn,
    /// It follows its targets.
    OperationEnabled,
    /// It brakes, or has braked and holds.
    QuickStopActive,
    /// It brakes because of a fault.
    FaultReaction,
    /// A fault waits to be reset.
    Fault,
}

impl State {
    /// By the statusword; `None` for bits that no state has.
    #[must_use]
    pub const fn of(statusword: u16) -> Option<Self> {
        match (statusword & 0x4F, statusword & 0x6F) {
            (0x00, _) => Some(Self::NotReady),
            (0x40, _) => Some(Self::SwitchOnDisabled),
            (0x0F, _) => Some(Self::FaultReaction),
            (0x08, _) => Some(Self::Fault),
            (_, 0x21) => Some(Self::ReadyToSwitchOn),
            (_, 0x23) => Some(Self::SwitchedOn),
            (_, 0x27) => Some(Self::OperationEnabled),
            (_, 0x07) => Some(Self::QuickStopActive),
            _ => None,
        }
    }

    /// Whether a fault is present or being reacted to.
    #[must_use]
    pub const fn is_fault(self) -> bool {
        matches!(self, Self::Fault | Self::FaultReaction)
    }

    /// The controlword of the next step towards operation enabled.
    ///
    /// In quick stop this asks to go on (transition 16), which a drive grants only if its quick stop
    /// option holds the axis (5 to 8); others leave quick stop by themselves. A fault is not reset by
    /// it.
    #[must_use]
    pub const fn towards_operation(self) -> u16 {
        match self {
            Self::NotReady | Self::FaultReaction | Self::Fault => DISABLE_VOLTAGE,
            Self::SwitchOnDisabled => SHUTDOWN,
            Self::ReadyToSwitchOn => SWITCH_ON,
            Self::SwitchedOn | Self::OperationEnabled | Self::QuickStopActive => ENABLE_OPERATION,
        }
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotReady => "not ready to switch on",
            Self::SwitchOnDisabled => "switch on disabled",
            Self::ReadyToSwitchOn => "ready to switch on",
            Self::SwitchedOn => "switched on",
            Self::OperationEnabled => "operation enabled",
            Self::QuickStopActive => "quick stop active",
            Self::FaultReaction => "fault reaction active",
            Self::Fault => "fault",
        })
    }
}

/// What an error code of EMCY or 0x603F is about (CiA 402, error codes), and where to look.
#[must_use]
pub const fn about_error(code: u16) -> &'static str {
    match code {
        0x0000 => "no error code told; read the drive's display",
        0x2000..=0x2FFF => "current: a short circuit, a stalled joint or wrong current limits",
        0x3000..=0x3FFF => "voltage: check the motor supply and the braking resistor",
        0x4000..=0x4FFF => "temperature: let it cool, check its fan",
        0x5000..=0x5FFF => "the drive's hardware, or its safe torque off input: check the emergency stop",
        0x6000..=0x6FFF => "the drive's software or parameters: check how it was commissioned",
        0x7000..=0x7FFF => "encoder, brake or another module: check its cable",
        0x8100..=0x81FF => "communication: check bus cable, terminators and heartbeats",
        0x8611 => "following error: the joint is blocked, overloaded or badly tuned",
        0x8612 => "a reference or position limit was reached",
        0x8000..=0x8FFF => "monitoring: a limit of speed, torque or position was passed",
        0x9000..=0x9FFF => "an external error was wired to it: check its inputs",
        _ => "its manual lists the code",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    #[test]
    fn statuswords_are_read_whatever_their_other_bits() {
        let table = [
            (0x00, State::NotReady),
            (0x40, State::SwitchOnDisabled),
            (0x21, State::ReadyToSwitchOn),
            (0x23, State::SwitchedOn),
            (0x27, State::OperationEnabled),
            (0x07, State::QuickStopActive),
            (0x0F, State::FaultReaction),
            (0x08, State::Fault),
        ];
        for (word, state) in table {
            for others in [0x0000, 0xFF90, 0x1290] {
                assert_eq!(State::of(word | others), Some(state), "{word:#x}");
            }
        }
        // switch on disabled and faults do not look at the quick stop bit
        assert_eq!(State::of(0x60), Some(State::SwitchOnDisabled));
        assert_eq!(State::of(0x28), Some(State::Fault));
        assert_eq!(State::of(0xFFFF), None);
        assert_eq!(State::of(0x25), None);
    }

    #[test]
    fn each_step_leads_on() {
        let mut state = State::SwitchOnDisabled;
        let mut words = Vec::new();
        while state != State::OperationEnabled {
            let word = state.towards_operation();
            words.push(word);
            state = match word {
                SHUTDOWN => State::ReadyToSwitchOn,
                SWITCH_ON => State::SwitchedOn,
                _ => State::OperationEnabled,
            };
        }
        assert_eq!(words, [SHUTDOWN, SWITCH_ON, ENABLE_OPERATION]);
        assert_eq!(State::Fault.towards_operation() & FAULT_RESET, 0);
    }

    #[test]
    fn known_error_codes_say_where_to_look() {
        assert!(about_error(0x8611).starts_with("following error"));
        assert!(about_error(0x8130).starts_with("communication"));
        assert!(about_error(0xFF01).contains("manual"));
    }
}
