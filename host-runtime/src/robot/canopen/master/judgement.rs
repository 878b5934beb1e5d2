//! What stops the arm: who else sends, and what is told of the drives at the end of each cycle.

use super::{Master, Phase};
use crate::robot::canopen::cause::{Cause, Foreign};
use crate::robot::canopen::cia402::State;
use crate::robot::canopen::frame::{Frame, HEARTBEAT, NMT, NmtState, RPDO1, SDO_REQUEST, SYNC};
use crate::robot::canopen::node::Node;

/// Between the end of the set-up and the first answer to SYNC a drive may take its time: cycles.
const FIRST_ANSWER_CYCLES: u32 = 100;

/// Bytes that belong to no frame and need no explanation: an adapter that was open already begins inside
/// a line.
const TORN_BYTES: u64 = 30;

impl Master {
    /// What only a master sends: no bus gives back our own frames.
    pub(super) fn foreign(&self, frame: &Frame) -> Option<Foreign> {
        let node = frame.node();
        let ours = self.nodes.iter().any(|known| known.name.node == node);
        match frame.function() {
            NMT if node == 0 => Some(Foreign::Nmt),
            SYNC if node == 0 => Some(Foreign::Sync),
            RPDO1 if ours => Some(Foreign::Target(node)),
            SDO_REQUEST if ours => Some(Foreign::Request(node)),
            HEARTBEAT if node == self.config.master => Some(Foreign::Heartbeat(node)),
            _ => None,
        }
    }

    /// That one drive is silent, or that all are.
    pub(super) fn widened(&self, cause: Cause) -> Cause {
        let unheard = |node: &Node| match self.operational {
            // in the cycle in which a bus is cut some drives have answered and some have not
            true => node.missing > 0 && node.missing + 1 >= self.patience(),
            false => node.nmt.is_none(),
        };
        match cause {
            Cause::Silent(_) if self.nodes.iter().all(unheard) => match self.garbage {
                ..=TORN_BYTES => Cause::AllSilent,
                bytes => Cause::Garbled(bytes),
            },
            cause => cause,
        }
    }

    /// Whether a drive is lost and others are not: they hear what they are told.
    pub fn is_partly_lost(&self) -> bool {
        self.operational
            && matches!(self.cause, Some(Cause::Silent(_) | Cause::Restarted(_)))
            && self.nodes.iter().any(|node| node.missing == 0)
    }

    /// Which drives confirmed that they were stopped; `None` where all did or none can be heard.
    pub(super) fn obedience(&self) -> Option<String> {
        let obeys = |node: &&Node| {
            node.missing == 0 && node.state().is_some_and(|state| state != State::OperationEnabled)
        };
        let (stopped, other): (Vec<_>, Vec<_>) = self.nodes.iter().partition(obeys);
        if stopped.is_empty() || other.is_empty() {
            return None;
        }
        let joints = |nodes: &[&Node]| {
            let numbers: Vec<_> = nodes.iter().map(|node| node.name.joint.to_string()).collect();
            let plural = if numbers.len() > 1 { "s" } else { "" };
            format!("joint{plural} {}", numbers.join(", "))
        };
        Some(format!(
            "stopped: {}; not known to have stopped: {}, which only its drive's own watch or the emergency \
             stop can stop",
            joints(&stopped),
            joints(&other)
        ))
    }

    /// Cycles that a drive may go without an answer.
    fn patience(&self) -> u32 {
        match self.phase {
            Phase::Enabling | Phase::Running | Phase::Stopped => self.config.missing_cycles,
            _ => self.config.missing_cycles.max(FIRST_ANSWER_CYCLES),
        }
    }

    /// The worst that can be told from what was heard.
    pub(super) fn judge(&self, now_us: u64) -> Option<Cause> {
        let timeout_us = u64::from(self.config.heartbeat_timeout_ms) * 1_000;
        let patience = self.patience();
        if let Some(fault) = self.nodes.iter().find(|node| {
            node.state().is_some_and(State::is_fault)
                && !(self.phase == Phase::Enabling && node.is_resetting())
        }) {
            return Some(Cause::Fault(fault.name, fault.error));
        }
        if let Some(cause) = self.nodes.iter().find_map(|node| node.complaint(now_us, timeout_us, patience)) {
            return Some(self.widened(cause));
        }
        if !matches!(self.phase, Phase::Enabling | Phase::Running) {
            return None;
        }
        for node in &self.nodes {
            if let Some(state @ (NmtState::PreOperational | NmtState::Stopped)) = node.nmt {
                return Some(Cause::NotOperational(node.name, state));
            }
            if let (Phase::Running, Some(state)) = (self.phase, node.state())
                && state != State::OperationEnabled
            {
                return Some(Cause::LeftOperation(node.name, state));
            }
        }
        self.not_homed().map(Cause::HomingLost)
    }

    /// Stops for `cause`, unless it is stopped for something that weighs as much.
    pub(super) fn consider(&mut self, cause: Cause) {
        let standing = self.cause.as_ref().filter(|_| self.phase == Phase::Stopped);
        if standing.is_none_or(|standing| standing.is_benign() && !cause.is_benign()) {
            self.halt(cause);
        }
    }
}
