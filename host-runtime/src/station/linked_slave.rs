//! The slave station at the end of a link: motion and buttons of one operator in, the arm's state out.
//!
//! ```text
//!               motion, buttons                        set-points
//!   carrier  ------------------->  LinkedSlave  ----------------->  robot port
//!            <-------------------               <-----------------
//!               arm state                               joints
//! ```
//!
//! What it makes of them is [core's](tetrad_core::arm::station::OperatedSlave): the same as at the end of a
//! microcontroller's serial line. What is added here is how closely the arm follows the hand.

use super::slave::{Cycle, SlaveStation};
use super::trail::Trail;
use crate::link::{Carrier, Received};
use crate::robot::Robot;
use crate::robot::clock::Clock;
use std::time::Instant;
use tetrad_core::arm::port::PortError;
use tetrad_core::arm::station::{NoReset, OperatedSlave};
use tetrad_core::arm::teleop::Counts;
use tetrad_core::config::{SlaveConfig, SlaveConfigError};
use tetrad_core::wire::CommandEcho;

/// A slave with its arm and its operator.
#[derive(Debug)]
pub struct LinkedSlave<C> {
    slave: OperatedSlave<f64, Box<dyn Robot>>,
    carrier: C,
    trail: Trail,
}

impl<C: Carrier> LinkedSlave<C> {
    /// A slave that is stopped; its arm is switched on by the operator's first reset. `session` is what
    /// the carrier has said this station's packets are of.
    ///
    /// # Errors
    /// [`SlaveConfigError`] for a setting that cannot be worked with.
    pub fn new(
        config: &SlaveConfig,
        robot: Box<dyn Robot>,
        carrier: C,
        session: u32,
    ) -> Result<Self, SlaveConfigError> {
        let slave = OperatedSlave::new(config, robot, session)?;
        Ok(Self { slave, carrier, trail: Trail::new(&config.teleop) })
    }

    /// The slave and its arm.
    #[must_use]
    pub const fn station(&self) -> &SlaveStation {
        self.slave.station()
    }

    /// Waits until the next cycle is [due](Robot::pace).
    pub fn pace(&mut self, due: Instant) {
        self.slave.port_mut().pace(due);
    }

    /// How many commands came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.slave.counts()
    }

    /// Why the operator's last reset was not done, once.
    pub const fn take_refusal(&mut self) -> Option<NoReset> {
        self.slave.take_refusal()
    }

    /// How closely the arm has followed the hand lately.
    #[must_use]
    pub const fn trail(&self) -> &Trail {
        &self.trail
    }

    /// The newest motion that moved the arm, and when it passed each stage.
    #[must_use]
    pub const fn command(&self) -> Option<CommandEcho> {
        self.slave.command()
    }

    /// Somebody at the arm stops it. The operator may reset it, once the stop is known there.
    pub const fn stop(&mut self) {
        self.slave.stop();
    }

    /// The station ends: the arm comes to rest, and no reset of the operator changes that. To be called in
    /// each cycle until it has.
    pub const fn end(&mut self) {
        self.slave.end();
    }

    /// Somebody at the arm vouches for it that every joint is homed.
    pub fn confirm_homed(&mut self) {
        self.slave.port_mut().confirm_homed();
    }

    /// Stops the arm at its port too, as at the end of a run, and tells so.
    ///
    /// # Errors
    /// [`PortError`] where the port cannot be told.
    pub fn shut_down(&mut self) -> Result<(), PortError> {
        self.slave.shut_down()
    }

    /// One cycle: what came, the law, the limits, the port, and the arm's state. The clock is the
    /// carrier's.
    pub fn cycle(&mut self, clock: &Clock) -> Cycle {
        self.slave.begin_cycle(clock.now_us());
        self.hear(clock);
        // after what came, so that nothing has come in the future
        let now_us = clock.now_us();
        let cycle = self.slave.cycle(now_us, || clock.now_us());
        self.trail.cycle(&cycle, now_us);
        let carrier = &self.carrier;
        self.slave.tell(&cycle, now_us, |state| carrier.send(&state.into()).is_ok());
        cycle
    }

    fn hear(&mut self, clock: &Clock) {
        if let Some(Received { what, received_us, captured_us }) = self.carrier.motion()
            && self.slave.take_motion(&what, received_us)
        {
            self.trail.motion(&what, captured_us);
        }
        if let Some(Received { what, received_us, captured_us }) = self.carrier.buttons() {
            let told_us = captured_us.unwrap_or(received_us);
            self.slave.take_buttons(&what, received_us, told_us, clock.now_us());
        }
    }
}

#[cfg(test)]
mod tests;
