//! A PUMA 560 that is not there: `sim:`, the arm that everything runs with when there is none.
//!
//! | job | file |
//! |---|---|
//! | what it can be told | `options` |
//! | motors, servos, encoders, by an explicit time | `plant` |
//! | off, on, stopped, in fault, silent | `switch` |
//!
//! [`Plant`] moves on when it is told the time. [`SimulatedArm`] is a [port](tetrad_core::arm::port)
//! around it that goes by a [`Clock`]: the computer's, or one that whoever simulates sets. Nothing runs
//! in between: what was due since the last call is made up for in the next, in order, so the arm comes
//! to rest in time even if nobody looks.

mod options;
mod plant;
mod switch;

pub use options::{SimulatedOptions, TimedFault};
pub use plant::{Plant, PlantError};

use super::Robot;
use super::clock::Clock;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use switch::{Action, Switch, Trouble};
use tetrad_core::arm::port::{JointNumber, JointReading, PortError, PortFault, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::arm::set_point::SetPointGate;
use tetrad_core::config::PumaConfig;

/// The port.
#[derive(Debug)]
pub struct SimulatedArm {
    clock: Clock,
    opened_us: u64,
    plant: Plant,
    switch: Switch,
    gate: SetPointGate,
    mischief: Mischief,
}

/// A hand on the simulated arm's plugs: it makes faults and pulls cables while somebody else drives.
/// Clones are hands on the same arm.
#[derive(Clone, Debug, Default)]
pub struct Mischief(Arc<Mutex<Trouble>>);

impl Mischief {
    /// A drive (or, without a joint, the controller) reports a fault, until [`mend`](Self::mend).
    pub fn fault(&self, joint: Option<JointNumber>, code: u32) {
        self.trouble().fault = Some(PortFault { joint, code });
    }

    /// The cause of the fault goes away. The arm still has to be enabled.
    pub fn mend(&self) {
        self.trouble().fault = None;
    }

    /// Nothing is heard of the controller any more.
    pub fn silence(&self) {
        self.trouble().silent = true;
    }

    /// It is heard again. The arm still has to be enabled.
    pub fn answer(&self) {
        self.trouble().silent = false;
    }

    fn trouble(&self) -> MutexGuard<'_, Trouble> {
        // what is in there is whole at any time
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl SimulatedArm {
    /// Opens it by the computer's clock, switched off.
    ///
    /// # Errors
    /// [`PlantError`].
    pub fn new(puma: &PumaConfig, options: &SimulatedOptions) -> Result<Self, PlantError> {
        Self::with_clock(puma, options, Clock::wall())
    }

    /// Opens it by another clock.
    ///
    /// # Errors
    /// [`PlantError`].
    pub fn with_clock(
        puma: &PumaConfig,
        options: &SimulatedOptions,
        clock: Clock,
    ) -> Result<Self, PlantError> {
        let opened_us = clock.now_us();
        Ok(Self {
            opened_us,
            plant: Plant::new(puma, options)?,
            switch: Switch::new(options),
            gate: SetPointGate::new(puma, options.cycle_us() as f64 / 1e6),
            mischief: Mischief::default(),
            clock,
        })
    }

    /// The arm behind the port, as it was when the port was last asked or told something: the truth to
    /// compare with.
    #[must_use]
    pub const fn plant(&self) -> &Plant {
        &self.plant
    }

    /// A hand on its plugs.
    #[must_use]
    pub fn mischief(&self) -> Mischief {
        self.mischief.clone()
    }

    /// Since it was opened.
    fn now_us(&self) -> u64 {
        self.clock.now_us().saturating_sub(self.opened_us)
    }

    /// Makes up for the time since the last call.
    ///
    /// # Errors
    /// [`PortError::Lost`] while it is silent.
    fn catch_up(&mut self) -> Result<u64, PortError> {
        let now_us = self.now_us();
        let trouble = *self.mischief.trouble();
        let plant = &mut self.plant;
        self.switch.advance(now_us, trouble, |at_us, action| {
            plant.advance_to(at_us);
            match action {
                Action::Release => plant.release(),
                Action::Stop => plant.stop(),
            }
        });
        self.plant.advance_to(now_us);
        if self.switch.status() == PortStatus::Lost { Err(PortError::Lost) } else { Ok(now_us) }
    }

    /// How it stands now, without making up for the time.
    fn peek(&self) -> Switch {
        let mut switch = self.switch;
        switch.advance(self.now_us(), *self.mischief.trouble(), |_, _| ());
        switch
    }
}

impl RobotPort<f64> for SimulatedArm {
    fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
        let now_us = self.catch_up()?;
        let age_us = u32::try_from(now_us.saturating_sub(self.plant.now_us())).unwrap_or(u32::MAX);
        Ok(JointReading { joints: self.plant.measured().ok_or(PortError::Nonsense)?, age_us })
    }

    fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        let now_us = self.catch_up()?;
        let status = self.switch.status();
        if status != PortStatus::Ready {
            return Err(PortError::NotReady(status));
        }
        self.gate.check(self.plant.set_point(), joints)?;
        self.plant.go_to(joints);
        self.switch.fed(now_us);
        Ok(())
    }

    fn enable(&mut self) -> Result<(), PortError> {
        let now_us = self.catch_up()?;
        self.switch.enable(now_us, self.plant.rest_us()).map_err(PortError::Refused)
    }

    fn stop(&mut self) -> Result<(), PortError> {
        self.catch_up()?;
        self.switch.stop();
        self.plant.stop();
        Ok(())
    }

    fn status(&self) -> PortStatus {
        self.peek().status()
    }
}

impl Robot for SimulatedArm {
    fn reason(&self) -> Option<String> {
        self.peek().reason()
    }
}

#[cfg(test)]
mod tests;
