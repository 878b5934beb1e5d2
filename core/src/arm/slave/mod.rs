//! One cycle of the slave station, the port aside: what came from the operator and what the arm's
//! controller says become the next set-point. Section 5; the same code on the host and on a
//! microcontroller.
//!
//! ```text
//! commands, hold-to-run --> teleop --goal--> governor --set-point--> port
//!                             ^                 |                      |
//!                             +--- set-point ---+     joints, status --+
//! ```
//!
//! - The governor starts where the joints are measured to be when the port becomes ready, and again
//!   after every loss, fault or stop of the port. In between the set-point is its own: an arm that
//!   sags does not pull it along.
//! - An arm that is not where it was sent is stopped at its port; it starts anew from where it is.
//! - An arm comes to its goal a little late, so a goal that moves on is told a little ahead
//!   (`lead`), within the same limits.
//! - While nothing is followed the set-point stands still and is still written, so that a port's
//!   watchdog tells a station that has died from one that waits.

mod report;

pub use report::Stamp;

use super::governor::{Governed, Governor, StartRefusal};
use super::port::{JointReading, PortStatus};
use super::puma560::{Joints, Puma560};
use super::teleop::{
    ArmCondition, ArmView, Command, CommandRefusal, Counts, Decision, Note, Order, ResetRefusal, StopReason,
    Teleop,
};
use crate::config::{SlaveConfig, SlaveConfigError, TeleopMode};
use crate::geometry::Pose;
use crate::real::Real;
use crate::wire::{PressFor, ScaleShare};
use lead::Lead;

mod lead;

#[cfg(test)]
mod tests;

/// Microseconds in a second.
const MICROSECONDS: f64 = 1e6;

/// What a port says in one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmReading<T> {
    /// Where the joints are; `None` where that could not be read.
    pub joints: Option<JointReading<T>>,
    /// How the port stands.
    pub status: PortStatus,
}

/// What is to be done at the port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PortOrder<T> {
    /// Write this set-point.
    Write(Joints<T>),
    /// Write nothing: the port is not ready.
    Nothing,
    /// Stop it: the arm is not where it was sent, or cannot be read. It is to be enabled before it moves again.
    Stop,
}

/// What came of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlaveStep<T> {
    /// What the law decided, and why.
    pub decision: Decision<T>,
    /// What the limits made of it; `None` while the port is not ready.
    pub governed: Option<Governed<T>>,
    /// Where the tool was measured to be; `None` where the joints could not be read.
    pub measured: Option<Pose<T>>,
    /// Why the arm cannot start where it is, if so.
    pub refusal: Option<StartRefusal>,
    /// What is to be done at the port.
    pub order: PortOrder<T>,
}

/// The arm's side of a slave station, in f32 or f64.
#[derive(Clone, Copy, Debug)]
pub struct Slave<T> {
    arm: Puma560<T>,
    teleop: Teleop<T>,
    governor: Governor<T>,
    lead: Lead<T>,
    /// When the pictures of the newest command were taken, sender's clock.
    capture_us: u64,
    /// Where the tool was last sent; `None` while the governor has not started.
    set_point: Option<Pose<T>>,
    refusal: Option<StartRefusal>,
    /// When the joints were last read while the arm was started.
    read_us: u64,
    max_following: T,
    blind_timeout_us: u64,
    command_timeout_us: u32,
}

impl<T: Real> Slave<T> {
    /// A slave that is stopped and has heard nothing.
    ///
    /// # Errors
    /// [`SlaveConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &SlaveConfig) -> Result<Self, SlaveConfigError> {
        config.check()?;
        let arm = Puma560::new(&config.puma)?;
        // the paper's law is there to be compared with, as it is
        let lead_us = if config.teleop.mode == TeleopMode::Paper { 0 } else { config.lead_us };
        Ok(Self {
            arm,
            teleop: Teleop::new(&config.teleop)?,
            governor: Governor::new(&arm, &config.governor)?,
            lead: Lead::new(lead_us),
            capture_us: 0,
            set_point: None,
            refusal: None,
            read_us: 0,
            max_following: T::of(config.max_following_rad),
            blind_timeout_us: u64::from(config.blind_timeout_us),
            command_timeout_us: config.teleop.command_timeout_us,
        })
    }

    /// The arm.
    #[must_use]
    pub const fn arm(&self) -> &Puma560<T> {
        &self.arm
    }

    /// How many commands came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.teleop.counts()
    }

    /// Takes a command as it comes ([`Teleop::take`]).
    ///
    /// # Errors
    /// [`CommandRefusal`]; the command is dropped and counted.
    pub fn take(&mut self, command: &Command) -> Result<(), CommandRefusal> {
        self.teleop.take(command)?;
        self.capture_us = command.capture_us;
        Ok(())
    }

    /// The sender of commands has ended, and another may have begun ([`Teleop::end_sender`]).
    pub fn end_sender(&mut self) {
        self.teleop.end_sender();
    }

    /// Takes what the operator's press is for ([`Teleop::press_is_for`]).
    pub fn press_is_for(&mut self, press_for: PressFor, scale: ScaleShare) {
        self.teleop.press_is_for(press_for, scale);
    }

    /// Takes the state of the operator's button ([`Teleop::hold_to_run`]).
    pub fn hold_to_run(&mut self, pressed: bool, received_us: u64) {
        self.teleop.hold_to_run(pressed, received_us);
    }

    /// Stops the arm; it takes a reset to move it again ([`Teleop::stop`]).
    pub const fn stop(&mut self) {
        self.teleop.stop();
    }

    /// Stops the arm because the station ends.
    pub const fn end(&mut self) {
        self.teleop.stop_for(StopReason::Ending);
    }

    /// Stops the arm because its port refused a set-point.
    pub const fn stop_refused(&mut self) {
        self.teleop.stop_for(StopReason::SetPointRefused);
    }

    /// Ends a stop or a fault ([`Teleop::reset`]); nothing moves before the next press.
    ///
    /// # Errors
    /// [`ResetRefusal`] where hold-to-run is not heard to be released or the arm is not in order.
    pub fn reset(&mut self, now_us: u64, reading: &ArmReading<T>) -> Result<(), ResetRefusal> {
        let view = self.view(now_us, reading);
        self.teleop.reset(now_us, &view)
    }

    /// One cycle at `now_us`, microseconds of one clock that only goes forward. To be called at the
    /// governor's rate, also while nothing moves.
    pub fn step(&mut self, now_us: u64, reading: &ArmReading<T>) -> SlaveStep<T> {
        let view = self.view(now_us, reading);
        let mut decision = self.teleop.step(now_us, &view);
        let measured = reading.joints.map(|_| view.measured);
        let order = self.lead.ahead(&decision, self.capture_us, self.standing(&decision));
        let governed = self.set_point.map(|_| self.governor.step(&order, decision.uncertainty.as_ref()));
        self.set_point = governed.map(|governed| governed.pose);
        if decision.order == Order::Home && governed.is_some_and(|governed| governed.at_home) {
            decision.notes.add(Note::AtHome);
        }
        let order = match governed {
            _ if matches!(view.condition, ArmCondition::Astray | ArmCondition::Blind) => PortOrder::Stop,
            Some(governed) => PortOrder::Write(governed.set_point),
            None => PortOrder::Nothing,
        };
        SlaveStep { decision, governed, measured, refusal: self.refusal, order }
    }

    /// How stale the newest command is: 0 up to half of the time for which it stands, 1 at its end.
    fn standing(&self, decision: &Decision<T>) -> T {
        let age_us = decision.command_age_us.and_then(|us| u32::try_from(us).ok()).unwrap_or(u32::MAX);
        let share = T::of(f64::from(age_us) / f64::from(self.command_timeout_us.max(1)));
        (share * T::of(2.0) - T::one()).max(T::zero())
    }

    /// The arm as the law is told of it. A port that has become ready is started at; one that is not
    /// any more is forgotten.
    fn view(&mut self, now_us: u64, reading: &ArmReading<T>) -> ArmView<T> {
        if reading.status == PortStatus::NotHomed {
            self.governor.forget_home();
        }
        let joints = reading.joints.map(|reading| reading.joints);
        let measured = joints.map_or_else(Pose::identity, |joints| self.arm.forward(&joints));
        let condition = match (reading.status.condition(), &reading.joints) {
            (ArmCondition::Ready, Some(reading)) => {
                self.read_us = now_us;
                self.started(reading, &measured)
            }
            (ArmCondition::Ready, None) if self.set_point.is_none() => ArmCondition::NotReady,
            (ArmCondition::Ready, None) => {
                let blind_us = now_us.saturating_sub(self.read_us);
                if blind_us > self.blind_timeout_us { ArmCondition::Blind } else { ArmCondition::Ready }
            }
            (condition, _) => {
                (self.set_point, self.refusal) = (None, None);
                condition
            }
        };
        let set_point = self.set_point.unwrap_or(measured);
        ArmView { measured: if joints.is_some() { measured } else { set_point }, set_point, condition }
    }

    fn started(&mut self, reading: &JointReading<T>, measured: &Pose<T>) -> ArmCondition {
        if self.set_point.is_some() {
            return if self.follows(reading) { ArmCondition::Ready } else { ArmCondition::Astray };
        }
        self.refusal = self.governor.start(&reading.joints).err();
        if self.refusal.is_some() {
            return ArmCondition::CannotStart;
        }
        self.set_point = Some(*measured);
        ArmCondition::Ready
    }

    /// Whether every joint is about where it was sent. A reading that is not finite is nowhere.
    fn follows(&self, reading: &JointReading<T>) -> bool {
        let age_s = T::of(f64::from(reading.age_us) / MICROSECONDS);
        let limits = &self.arm.config().joints;
        let joints = reading.joints.iter().zip(self.governor.set_point()).zip(limits);
        joints.into_iter().all(|((measured, sent), limit)| {
            (*measured - sent).abs() <= self.max_following + age_s * T::of(limit.max_speed_rad_s)
        })
    }
}
