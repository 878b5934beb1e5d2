//! What the master does in a cycle of each phase, and how one leads to the next.

use super::super::cause::Cause;
use super::super::cia402::State;
use super::super::frame::NmtCommand;
use super::super::node::{Node, Progress};
use super::{Master, Phase};

impl Master {
    pub(super) fn begin_configuring(&mut self) {
        self.owning = true;
        self.operational = false;
        self.nodes.iter_mut().for_each(Node::begin);
        self.command = Some(NmtCommand::PreOperational);
        self.enter(Phase::Configuring);
    }

    pub(super) fn configure(&mut self) {
        let mut done = true;
        for node in &mut self.nodes {
            if node.restarted {
                // it was switched on just now: from the beginning
                node.begin();
            }
            match node.configure() {
                Ok(progress) => done &= progress == Progress::Done,
                Err(cause) => {
                    let cause = self.widened(cause);
                    return self.halt(cause);
                }
            }
        }
        if done {
            self.operational = true;
            self.command = Some(NmtCommand::Start);
            self.enter(Phase::Idle);
        }
    }

    pub(super) fn idle(&mut self) {
        for node in &mut self.nodes {
            node.tell_idle();
        }
        if self.nodes.iter().any(|node| node.position.is_none()) {
            return;
        }
        if self.not_homed().is_some() {
            // power comes on when somebody asks for it, not when homing happens to end
            self.wanted = false;
        } else if self.wanted {
            self.begin_enabling();
        }
    }

    pub(super) fn begin_enabling(&mut self) {
        self.wanted = false;
        if let Some(drive) = self.not_homed() {
            self.cause = Some(Cause::HomingLost(drive));
            return;
        }
        for node in &mut self.nodes {
            node.begin_reset();
        }
        self.enter(Phase::Enabling);
    }

    pub(super) fn enabling(&mut self, in_phase_us: u64) {
        let allowed_us = u64::from(self.config.enable_timeout_ms) * 1_000;
        let patient = in_phase_us < allowed_us / 2;
        for node in &mut self.nodes {
            node.tell_enable(patient);
        }
        match self.nodes.iter().find(|node| node.state() != Some(State::OperationEnabled)) {
            None => {
                self.set_point = None;
                self.goal = self.targets();
                self.without_set_point = 0;
                self.enter(Phase::Running);
            }
            Some(node) if in_phase_us >= allowed_us => {
                let cause = Cause::Stuck(node.name, node.state().unwrap_or(State::NotReady));
                self.halt(cause);
            }
            Some(_) => {}
        }
    }

    pub(super) fn running(&mut self) {
        match self.set_point.take() {
            Some(goal) => {
                self.goal = goal;
                self.without_set_point = 0;
                self.counters.set_points += 1;
            }
            None => self.without_set_point += 1,
        }
        if self.without_set_point > self.config.watchdog_cycles {
            let ms = self.config.watchdog_cycles * (self.config.period_us / 1_000);
            return self.halt(Cause::NoSetPoint(ms));
        }
        for (node, goal) in self.nodes.iter_mut().zip(self.goal) {
            node.tell_target(goal);
        }
    }

    pub(super) fn stopped(&mut self) {
        for node in &mut self.nodes {
            node.tell_stop();
        }
        if matches!(self.cause, Some(Cause::HomingLost(_))) && self.not_homed().is_none() {
            self.cause = Some(Cause::Asked);
        }
        if let Some(Cause::Fault(name, code)) = &mut self.cause
            && *code == 0
            && let Some(node) = self.nodes.iter_mut().find(|node| node.name == *name)
        {
            node.learn_error();
            *code = node.error;
        }
    }
}
