//! What stops the arm: who else sends, and what is told of the drives at the end of each cycle.

use super::super::cause::{Cause, Foreign};
use super::super::cia402::State;
use super::super::frame::{Frame, HEARTBEAT, NMT, NmtState, RPDO1, SDO_REQUEST, SYNC};
use super::super::node::Node;
use super::{Master, Phase};
use crate::config::JOINTS;
use core::fmt;

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
    pub(super) fn obedience(&self) -> Option<Obedience> {
        let mut stopped = [false; JOINTS];
        for (stopped, node) in stopped.iter_mut().zip(&self.nodes) {
            *stopped =
                node.missing == 0 && node.state().is_some_and(|state| state != State::OperationEnabled);
        }
        let is_mixed = stopped.contains(&true) && stopped.contains(&false);
        is_mixed.then_some(Obedience { stopped })
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

/// Which drives confirmed that they were stopped, and which did not: some of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Obedience {
    stopped: [bool; JOINTS],
}

impl Obedience {
    /// The joints that did, or those that did not: `joint 2` or `joints 1, 3`.
    fn joints(&self, stopped: bool, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let numbers = || (1..).zip(&self.stopped).filter(|(_, is)| **is == stopped).map(|(number, _)| number);
        f.write_str(if numbers().count() > 1 { "joints " } else { "joint " })?;
        let mut between = "";
        numbers().try_for_each(|number: u8| {
            write!(f, "{between}{number}")?;
            between = ", ";
            Ok(())
        })
    }
}

impl fmt::Display for Obedience {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("stopped: ")?;
        self.joints(true, f)?;
        f.write_str("; not known to have stopped: ")?;
        self.joints(false, f)?;
        f.write_str(", which only its drive's own watch or the emergency stop can stop")
    }
}
