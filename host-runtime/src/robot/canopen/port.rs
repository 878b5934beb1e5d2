//! The robot port: joint angles in radians for whoever drives the arm, counts and threads behind it.

use super::bus::Bus;
use super::cycle::{Link, Opener, Request, spawn};
use crate::robot::Robot;
use crate::robot::lateness::Lateness;
use std::io;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tetrad_core::arm::canopen::master::{Counters, Master};
use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::{BeyondCounts, Drives, Joints};
use tetrad_core::arm::set_point::SetPointGate;
use tetrad_core::config::{CanopenConfig, CanopenConfigError, JOINTS, PumaConfig, PumaConfigError};

/// For so long after a fault or a loss nobody can have read what it was: enabling is refused, so that a
/// program that asks again and again does not reset what nobody has seen.
const READABLE: Duration = Duration::from_secs(1);

/// Why a CANopen robot could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum CanopenError {
    /// The settings of bus or drives.
    #[error("[canopen] {0}")]
    Config(#[from] CanopenConfigError),
    /// The settings of the arm.
    #[error("the arm's settings cannot be worked with: {0}")]
    Puma(#[from] PumaConfigError),
    /// The bus.
    #[error(
        "the bus cannot be opened: {0}; plug the adapter in, or bring the interface up: \
         ip link set can0 up type can bitrate 1000000"
    )]
    Open(#[source] io::Error),
}

/// Six CiA 402 drives on a CAN bus. Closed when dropped: the arm is stopped first.
#[derive(Debug)]
pub struct CanopenPort {
    link: Link,
    thread: Option<JoinHandle<()>>,
    drives: Drives,
    gate: SetPointGate,
    last: Joints<f64>,
    period: Duration,
    /// The beat that was waited for last, or after which a set-point was last written.
    beat: u64,
}

impl CanopenPort {
    /// Opens the bus and begins to set the drives up; no voltage is put on any motor.
    ///
    /// `opener` is called now, and again when the arm is to be enabled after the bus was lost.
    ///
    /// # Errors
    /// [`CanopenError`].
    pub fn start(opener: Opener, puma: &PumaConfig, config: &CanopenConfig) -> Result<Self, CanopenError> {
        puma.check()?;
        let master = Master::new(config, puma)?;
        let drives = Drives::new(&config.drives()).map_err(CanopenConfigError::from)?;
        let gate = SetPointGate::new(puma, config.period_s() * config.step_margin);
        let bus: Bus = opener().map_err(CanopenError::Open)?;
        let link = Link::default();
        let period = Duration::from_micros(u64::from(config.period_us));
        let thread = Some(spawn(master, bus, opener, period, &link).map_err(CanopenError::Open)?);
        Ok(Self { link, thread, drives, gate, last: [0.0; JOINTS], period, beat: 0 })
    }

    /// What went over the bus.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.link.lock().counters
    }

    /// How late cycles began.
    #[must_use]
    pub fn lateness(&self) -> Lateness {
        self.link.lock().lateness.clone()
    }

    /// The motors.
    #[must_use]
    pub const fn drives(&self) -> &Drives {
        &self.drives
    }
}

impl RobotPort<f64> for CanopenPort {
    fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
        let shared = self.link.lock();
        if shared.status == PortStatus::Lost && !shared.reachable {
            return Err(PortError::Lost);
        }
        let (counts, at) = shared.positions.ok_or(PortError::NotMeasured)?;
        drop(shared);
        let age_us = u32::try_from(at.elapsed().as_micros()).unwrap_or(u32::MAX);
        Ok(JointReading { joints: self.drives.joints(&counts), age_us })
    }

    fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        let mut shared = self.link.lock();
        if shared.status != PortStatus::Ready {
            return Err(PortError::NotReady(shared.status));
        }
        if let Some(start) = shared.start.take() {
            self.last = self.drives.joints(&start);
        }
        self.gate.check(&self.last, joints)?;
        let counts =
            self.drives.counts(joints).map_err(|BeyondCounts(joint)| PortError::OutOfRange(joint))?;
        self.last = *joints;
        shared.set_point = Some(counts);
        self.beat = shared.beats;
        Ok(())
    }

    fn enable(&mut self) -> Result<(), PortError> {
        let mut shared = self.link.lock();
        let is_new = shared.changed.is_some_and(|at| at.elapsed() < READABLE);
        match shared.status {
            PortStatus::Ready => return Ok(()),
            PortStatus::Fault(fault) if is_new => return Err(PortError::Refused(fault)),
            PortStatus::Lost if is_new => return Err(PortError::Lost),
            _ => {}
        }
        shared.status = PortStatus::Enabling;
        shared.request = Some(Request::Enable);
        Ok(())
    }

    fn stop(&mut self) -> Result<(), PortError> {
        let mut shared = self.link.lock();
        shared.set_point = None;
        shared.request = Some(Request::Stop);
        match shared.status {
            // every drive is being told; the reason says which of them obeyed
            PortStatus::Lost if shared.reachable => {}
            PortStatus::Lost => return Err(PortError::Lost),
            PortStatus::Ready | PortStatus::Enabling => shared.status = PortStatus::Stopped,
            _ => {}
        }
        Ok(())
    }

    fn status(&self) -> PortStatus {
        self.link.lock().status
    }
}

impl Robot for CanopenPort {
    fn reason(&self) -> Option<String> {
        self.link.lock().reason.clone()
    }

    /// By the beat of the bus; a thread that is gone is not waited for.
    fn pace(&mut self, due: Instant) {
        self.beat = self.link.wait_for_beat(self.beat, due + self.period);
    }

    /// Needed where the configuration says [`Homing::Confirm`](tetrad_core::config::Homing::Confirm).
    fn confirm_homed(&mut self) {
        self.link.lock().confirm_homed = true;
    }

    fn report(&self) -> Vec<String> {
        let shared = self.link.lock();
        let Counters { cycles, incomplete, stale_answers, emergencies, set_points } = shared.counters;
        let mut lines = vec![
            format!("CANopen: {cycles} cycles, {set_points} set-points sent, {}", shared.lateness),
            format!(
                "CANopen: {incomplete} cycles without every drive's answer, {} frames the bus did not take, \
                 {emergencies} emergencies, {stale_answers} SDO answers out of turn",
                shared.unsent
            ),
        ];
        if shared.garbage > 0 {
            lines.push(format!(
                "CANopen: {} bytes that are no CAN frames; where they go on, check `baud` in the adapter's address",
                shared.garbage
            ));
        }
        if shared.crowded_out > 0 {
            lines.push(format!(
                "CANopen: {} frames more than a bus can bring were left out; check what is at the adapter's port",
                shared.crowded_out
            ));
        }
        lines
    }
}

impl Drop for CanopenPort {
    fn drop(&mut self) {
        self.link.end();
        if let Some(thread) = self.thread.take() {
            // a thread that panicked has nothing left to stop the arm with; the drives' own watch has
            let _ = thread.join();
        }
    }
}
