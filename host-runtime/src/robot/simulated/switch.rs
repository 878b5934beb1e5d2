//! How the simulated controller stands: switched on, stopped, in fault, silent. Times decide; nothing
//! moves here.

use super::options::{SimulatedOptions, TimedFault};
use tetrad_core::arm::port::{PortFault, PortStatus};

/// How long a fault that came by itself stays before it can be cleared, microseconds.
const FAULT_STAYS_US: u64 = 2_000_000;

/// What somebody does to the arm, or what happens to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Trouble {
    /// A drive's fault whose cause is there.
    pub(super) fault: Option<PortFault>,
    /// Nothing is heard of the controller.
    pub(super) silent: bool,
}

/// What the joints are to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    /// The servos hold and follow.
    Release,
    /// Slow down to rest.
    Stop,
}

/// Why it stands as it does, where the status does not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reason {
    Starved,
    WasSilent,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Disabled,
    Enabling {
        ready_us: u64,
    },
    Ready {
        deadline_us: u64,
    },
    Stopped,
    /// The drive keeps telling of it until it is enabled again.
    Fault(PortFault),
}

/// The controller's state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Switch {
    state: State,
    reason: Option<Reason>,
    trouble: Trouble,
    watchdog_us: u64,
    enable_us: u64,
    /// Not yet happened, by this clock.
    timed_fault: Option<TimedFault>,
    timed_silence_us: Option<u64>,
    /// Until when the fault that came by itself cannot be cleared.
    stays_until_us: u64,
}

impl Switch {
    /// Switched off, at time 0.
    pub(super) fn new(options: &SimulatedOptions) -> Self {
        Self {
            state: State::Disabled,
            reason: None,
            trouble: Trouble::default(),
            watchdog_us: options.watchdog_us,
            enable_us: options.enable_us,
            timed_fault: options.fault,
            timed_silence_us: options.silence_us,
            stays_until_us: 0,
        }
    }

    /// Moves on to `now_us`, through everything that is due by then, in order; `act` is told what the
    /// joints are to do and when. `trouble` is what is found at the arm now.
    pub(super) fn advance(&mut self, now_us: u64, trouble: Trouble, mut act: impl FnMut(u64, Action)) {
        let timed_silence_us = self.timed_silence_us;
        let silent_at = |at_us| trouble.silent || timed_silence_us.is_some_and(|from_us| from_us <= at_us);
        let was_silent = self.trouble.silent;
        loop {
            let timer_us = match self.state {
                State::Enabling { ready_us } => Some(ready_us),
                State::Ready { deadline_us } => Some(deadline_us),
                _ => None,
            };
            let fault_us = self.timed_fault.map(|timed| timed.at_us);
            let due = [timer_us, fault_us].into_iter().flatten().min().filter(|at_us| *at_us <= now_us);
            let Some(at_us) = due else { break };
            if let Some(timed) = self.timed_fault.filter(|timed| timed.at_us == at_us) {
                self.timed_fault = None;
                self.stays_until_us = at_us.saturating_add(FAULT_STAYS_US);
                self.fail(timed.fault, at_us, &mut act);
            } else if matches!(self.state, State::Enabling { .. }) && (was_silent || silent_at(at_us)) {
                // it takes somebody who is heard to switch it on
                self.state = State::Stopped;
                self.reason = Some(Reason::WasSilent);
            } else if let State::Enabling { .. } = self.state {
                self.state = State::Ready { deadline_us: self.deadline(at_us) };
                act(at_us, Action::Release);
            } else {
                self.state = State::Stopped;
                self.reason = Some(Reason::Starved);
                act(at_us, Action::Stop);
            }
        }
        let silent = silent_at(now_us);
        let before = std::mem::replace(&mut self.trouble, Trouble { silent, ..trouble });
        if let Some(fault) = trouble.fault.filter(|_| before.fault != trouble.fault) {
            self.fail(fault, now_us, &mut act);
        }
        // it does not go on by itself once it is heard again
        if before.silent && !silent && matches!(self.state, State::Enabling { .. } | State::Ready { .. }) {
            self.state = State::Stopped;
            self.reason = Some(Reason::WasSilent);
            act(now_us, Action::Stop);
        }
    }

    fn fail(&mut self, fault: PortFault, at_us: u64, act: &mut impl FnMut(u64, Action)) {
        self.state = State::Fault(fault);
        self.reason = None;
        act(at_us, Action::Stop);
    }

    /// The last microsecond that is not too late for a set-point is the one before.
    fn deadline(&self, now_us: u64) -> u64 {
        now_us.saturating_add(self.watchdog_us).saturating_add(1)
    }

    pub(super) fn status(&self) -> PortStatus {
        if self.trouble.silent {
            return PortStatus::Lost;
        }
        match self.state {
            State::Disabled => PortStatus::Disabled,
            State::Enabling { .. } => PortStatus::Enabling,
            State::Ready { .. } => PortStatus::Ready,
            State::Stopped => PortStatus::Stopped,
            State::Fault(fault) => PortStatus::Fault(fault),
        }
    }

    pub(super) fn reason(&self) -> Option<String> {
        if self.trouble.silent {
            return Some("the simulated controller was told to be silent".to_owned());
        }
        self.reason.map(|reason| match reason {
            Reason::Starved => format!("no set-point came for {} ms", self.watchdog_us / 1000),
            Reason::WasSilent => "the controller was not heard for a while".to_owned(),
        })
    }

    /// Begins to switch on; the joints are at rest by `rest_us`. Nothing changes where it is on, or
    /// on the way to it.
    ///
    /// # Errors
    /// The fault that is still there.
    pub(super) fn enable(&mut self, now_us: u64, rest_us: u64) -> Result<(), PortFault> {
        match self.state {
            State::Enabling { .. } | State::Ready { .. } => return Ok(()),
            State::Fault(fault) if self.trouble.fault.is_some() || now_us < self.stays_until_us => {
                return Err(fault);
            }
            State::Fault(_) | State::Disabled | State::Stopped => {}
        }
        self.state = State::Enabling { ready_us: now_us.saturating_add(self.enable_us).max(rest_us) };
        self.reason = None;
        Ok(())
    }

    /// A set-point was taken.
    pub(super) fn fed(&mut self, now_us: u64) {
        if let State::Ready { .. } = self.state {
            self.state = State::Ready { deadline_us: self.deadline(now_us) };
        }
    }

    /// Stops. A fault stays, and what is off stays off.
    pub(super) fn stop(&mut self) {
        if let State::Enabling { .. } | State::Ready { .. } = self.state {
            self.state = State::Stopped;
            self.reason = None;
        }
    }
}
