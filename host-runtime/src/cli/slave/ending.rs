//! How a run ends by how its arm stands: the exit code and the words.

use crate::exit::Exit;
use crate::station::Cycle;
use tetrad_core::arm::port::PortStatus;
use tetrad_core::arm::teleop::{Status, StopReason};

/// How a run ends whose last cycle this is; `None` where all is well. `reason` is the port's own word on
/// how it stands.
///
/// A stop that somebody asked for is no failure, nor an arm that was never reset. A fault is, and a stop
/// that nobody asked for: whoever watched it may end the run without having mended it. To be asked before
/// the run itself stops the arm, which hides why it was stopped before, and after it.
pub(in crate::cli) fn standing(cycle: &Cycle, reason: Option<String>) -> Option<(Exit, String)> {
    judged(cycle.step.decision.status, cycle.reading.status, reason)
}

fn judged(status: Status, port: PortStatus, reason: Option<String>) -> Option<(Exit, String)> {
    let by_law = match status {
        Status::Fault(_) | Status::Stopped(StopReason::TwoSenders | StopReason::SetPointRefused) => true,
        Status::Stopped(StopReason::Started | StopReason::Asked | StopReason::Ending)
        | Status::Armed(_)
        | Status::Engaged
        | Status::Hold(_) => false,
    };
    let exit = match port {
        PortStatus::Lost => Exit::DeviceLost,
        PortStatus::Fault(_) => Exit::Safety,
        _ if by_law => Exit::Safety,
        _ => return None,
    };
    let reason = reason.unwrap_or_else(|| port.to_string());
    Some((exit, if by_law { format!("{status} ({reason})") } else { reason }))
}

/// How a run ends whose arm could not be stopped at its port.
pub(in crate::cli) fn unstopped(error: impl std::fmt::Display) -> (Exit, String) {
    (Exit::DeviceLost, format!("the arm could not be stopped at its port: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::arm::port::PortFault;
    use tetrad_core::arm::teleop::{ArmedReason, FaultReason};

    #[test]
    fn a_fault_is_told_from_a_stop_and_a_lost_arm_from_both() {
        let fault = PortStatus::Fault(PortFault { joint: Some(3), code: 0x8611 });
        let asked = Status::Stopped(StopReason::Asked);
        let armed = Status::Armed(ArmedReason::Press);
        let astray = Status::Fault(FaultReason::ArmAstray);
        let exit = |status, port| judged(status, port, None).map(|(exit, _)| exit);
        assert_eq!(exit(armed, PortStatus::Ready), None);
        assert_eq!(exit(asked, PortStatus::Stopped), None);
        assert_eq!(exit(Status::Stopped(StopReason::Started), PortStatus::Disabled), None);
        assert_eq!(exit(astray, PortStatus::Ready), Some(Exit::Safety));
        assert_eq!(exit(Status::Stopped(StopReason::TwoSenders), PortStatus::Ready), Some(Exit::Safety));
        assert_eq!(exit(asked, fault), Some(Exit::Safety));
        assert_eq!(exit(astray, PortStatus::Lost), Some(Exit::DeviceLost));
        let (_, words) = judged(asked, fault, None).expect("a fault");
        assert!(words.contains("joint 3") && !words.contains("stop was pressed"), "{words}");
        let (_, words) = judged(astray, PortStatus::Ready, Some("its word".to_owned())).expect("a fault");
        assert!(words.starts_with("fault") && words.ends_with("(its word)"), "{words}");
    }
}
