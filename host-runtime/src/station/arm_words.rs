//! The arm's state in words: what the operator reads of why the arm is slow, or stopped.

use tetrad_core::arm::governor::Limits;
use tetrad_core::arm::teleop::{ArmedReason, FaultReason, HoldReason, Note, Notes, State, StopReason};
use tetrad_core::wire::{ArmReason, ArmState, ArmStatePacket, ControllerState};

/// State and reason, and what would mend it, as the slave's own law says it.
#[must_use]
pub fn standing(packet: &ArmStatePacket) -> String {
    let state = state_name(packet.state);
    let reason = match packet.reason {
        ArmReason::None => return state.to_owned(),
        ArmReason::Started => StopReason::Started.to_string(),
        ArmReason::Asked => {
            "stop was pressed, or the slave station ends; when all is clear, let go of hold-to-run and reset"
                .to_owned()
        }
        ArmReason::TwoSenders => StopReason::TwoSenders.to_string(),
        ArmReason::SetPointRefused => StopReason::SetPointRefused.to_string(),
        ArmReason::ArmNotReady => FaultReason::ArmNotReady.to_string(),
        ArmReason::Arm => FaultReason::Arm.to_string(),
        ArmReason::ArmCannotStart => FaultReason::ArmCannotStart.to_string(),
        ArmReason::ArmAstray => FaultReason::ArmAstray.to_string(),
        ArmReason::ArmBlind => FaultReason::ArmBlind.to_string(),
        ArmReason::ArmPose => FaultReason::ArmPoseNotFinite.to_string(),
        ArmReason::ClockWentBack => FaultReason::ClockWentBack.to_string(),
        ArmReason::NoCommand => HoldReason::NoCommand.to_string(),
        ArmReason::NoHoldToRun => HoldReason::NoHoldToRun.to_string(),
        ArmReason::BadCommand => {
            "the operator station sends numbers that cannot be used; restart it".to_owned()
        }
        ArmReason::HandNotSeen => HoldReason::HandNotSeen.to_string(),
        ArmReason::HandNotMeasured => HoldReason::HandNotMeasured.to_string(),
        ArmReason::Press => ArmedReason::Press.to_string(),
        ArmReason::Engage => ArmedReason::Engage.to_string(),
        ArmReason::LetGo => "let go of hold-to-run and press again".to_owned(),
        ArmReason::NewSender => ArmedReason::NewSender.to_string(),
        ArmReason::PressChanged => ArmedReason::PressChanged.to_string(),
    };
    let controller = match packet.state {
        ArmState::Stopped | ArmState::Fault => controller_words(packet.controller),
        ArmState::Armed | ArmState::Engaged | ArmState::Hold => None,
    };
    let controller = controller.map_or_else(String::new, |words| format!(" ({words})"));
    format!("{state}: {reason}{controller}")
}

/// Everything that keeps the arm from following as it was asked, while it follows.
#[must_use]
pub fn limits(packet: &ArmStatePacket) -> Vec<String> {
    if packet.state != ArmState::Engaged {
        return Vec::new();
    }
    let notes = Notes::from_bits(packet.notes);
    let notes = notes.iter().filter(|note| *note != Note::Latched).map(|note| note.to_string());
    notes.chain(Limits::from_bits(packet.limits).iter().map(|limit| limit.to_string())).collect()
}

/// Whether the arm stands because it was not started yet, or because somebody stopped it.
#[must_use]
pub const fn is_asked(packet: &ArmStatePacket) -> bool {
    matches!(packet.state, ArmState::Stopped)
        && matches!(packet.reason, ArmReason::Started | ArmReason::Asked)
}

/// The law's word for a state.
#[must_use]
pub const fn state_name(state: ArmState) -> &'static str {
    match state {
        ArmState::Stopped => State::Stopped.name(),
        ArmState::Armed => State::Armed.name(),
        ArmState::Engaged => State::Engaged.name(),
        ArmState::Hold => State::Hold.name(),
        ArmState::Fault => State::Fault.name(),
    }
}

/// How the controller stands.
#[must_use]
pub fn controller(controller: ControllerState) -> String {
    controller_words(controller).unwrap_or_else(|| "ready".to_owned())
}

/// How the controller stands, where that is not in order.
fn controller_words(controller: ControllerState) -> Option<String> {
    Some(match controller {
        ControllerState::Ready => return None,
        ControllerState::Disabled => "no power on the joints".to_owned(),
        ControllerState::Enabling => "being switched on".to_owned(),
        ControllerState::NotHomed => "its joints are not homed".to_owned(),
        ControllerState::Stopped => "stopped at its controller".to_owned(),
        ControllerState::Fault { joint: 0, code } => format!("controller fault {code:#x}"),
        ControllerState::Fault { joint, code } => format!("fault {code:#x} at joint {joint}"),
        ControllerState::Lost => "its controller does not answer".to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;
    use tetrad_core::wire::ArmVerdict;
    use tetrad_fixtures::packets;

    fn packet(state: ArmState, reason: ArmReason) -> ArmStatePacket {
        ArmStatePacket {
            notes: 0b1001,
            verdict: ArmVerdict::Clamp,
            limits: 1 << 9,
            controller: ControllerState::Fault { joint: 3, code: 0x2310 },
            ..packets::arm_state(state, reason)
        }
    }

    #[test]
    fn every_reason_has_words_of_its_own() {
        let words: HashSet<String> =
            ArmReason::ALL.map(|reason| standing(&packet(ArmState::Hold, reason))).into();
        assert_eq!(words.len(), ArmReason::ALL.len());
        let fault = standing(&packet(ArmState::Fault, ArmReason::Arm));
        assert!(fault.starts_with("fault: ") && fault.ends_with("(fault 0x2310 at joint 3)"), "{fault}");
    }

    #[test]
    fn what_limits_is_told_while_the_arm_follows() {
        let limits = limits(&packet(ArmState::Engaged, ArmReason::None));
        assert_eq!(limits.len(), 2, "{limits:?}");
        assert!(super::limits(&packet(ArmState::Hold, ArmReason::NoCommand)).is_empty());
    }
}
