//! The robot port of a program without threads: whoever holds it feeds it the frames that come, and once a
//! cycle sends what it gives.

use super::frame::Frame;
use super::master::{Counters, Master, Reason};
use crate::arm::port::{JointReading, PortError, PortStatus, RobotPort};
use crate::arm::puma560::{BeyondCounts, Counts, Drives, Joints};
use crate::arm::set_point::SetPointGate;
use crate::config::{CanopenConfig, CanopenConfigError, JOINTS, PumaConfig, PumaConfigError};
use crate::real::Real;
use core::fmt;

/// For so long after a fault or a loss nobody can have read what it was: enabling is refused, so that a
/// program that asks again and again does not reset what nobody has seen. Microseconds.
const READABLE_US: u64 = 1_000_000;

/// Why there is no arm to be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CanopenArmError {
    /// The settings of bus or drives.
    Config(CanopenConfigError),
    /// The settings of the arm.
    Puma(PumaConfigError),
}

impl fmt::Display for CanopenArmError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Config(error) => error.fmt(f),
            Self::Puma(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for CanopenArmError {}

impl From<CanopenConfigError> for CanopenArmError {
    fn from(error: CanopenConfigError) -> Self {
        Self::Config(error)
    }
}

impl From<PumaConfigError> for CanopenArmError {
    fn from(error: PumaConfigError) -> Self {
        Self::Puma(error)
    }
}

/// The most frames that a cycle begins with: to each drive an NMT command, its target and an SDO request, the
/// master's heartbeat and SYNC.
const MAX_FRAMES: usize = 3 * JOINTS + 2;

/// The frames of a cycle.
#[derive(Clone, Debug, Default)]
pub struct Frames(heapless::Vec<Frame, MAX_FRAMES>);

impl Frames {
    /// In the order in which they are to be sent.
    #[must_use]
    pub fn as_slice(&self) -> &[Frame] {
        &self.0
    }
}

impl Extend<Frame> for Frames {
    fn extend<I: IntoIterator<Item = Frame>>(&mut self, frames: I) {
        for frame in frames {
            // there is room for those of a cycle
            let _ = self.0.push(frame);
        }
    }
}

/// Six CiA 402 drives on a CAN bus.
///
/// In each cycle: the frames that came, then [the time](Self::begin_cycle), then whatever drives the arm
/// through the port, then [the frames to send](Self::end_cycle).
#[derive(Debug)]
pub struct CanopenArm {
    master: Master,
    drives: Drives,
    gate: SetPointGate,
    /// Where the drives were sent last, or were when they became ready.
    last: Counts,
    now_us: u64,
    status: PortStatus,
    /// When the status last became another.
    changed_us: Option<u64>,
}

impl CanopenArm {
    /// An arm that is switched off, and has heard nothing.
    ///
    /// # Errors
    /// [`CanopenArmError`] for a setting that cannot be worked with.
    pub fn new(puma: &PumaConfig, config: &CanopenConfig) -> Result<Self, CanopenArmError> {
        puma.check()?;
        let master = Master::new(config, puma)?;
        let drives = Drives::new(&config.drives()).map_err(CanopenConfigError::from)?;
        let gate = SetPointGate::new(puma, config.period_s() * config.step_margin);
        let status = master.status();
        Ok(Self { master, drives, gate, last: [0; JOINTS], now_us: 0, status, changed_us: None })
    }

    /// Takes a frame that came from the bus.
    pub fn receive(&mut self, now_us: u64, frame: &Frame) {
        self.master.receive(now_us, frame);
    }

    /// So many bytes of the line to the bus, since it was opened, belong to no frame.
    pub const fn hear_garbage(&mut self, bytes: u64) {
        self.master.hear_garbage(bytes);
    }

    /// It is `now_us`, microseconds of one clock that only goes forward: what is asked of the port next is
    /// asked now.
    pub fn begin_cycle(&mut self, now_us: u64) {
        self.now_us = now_us;
        self.look();
    }

    /// Ends the cycle: what was asked for is done, and the frames are to be sent, in their order.
    pub fn end_cycle(&mut self, out: &mut impl Extend<Frame>) {
        self.master.cycle(self.now_us, out);
        self.look();
    }

    /// Somebody has seen to it that every drive is homed.
    pub fn confirm_homed(&mut self) {
        self.master.confirm_homed();
    }

    /// Why it was stopped.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.master.reason()
    }

    /// What went over the bus.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.master.counters()
    }

    fn look(&mut self) {
        let status = self.master.status();
        if status == self.status {
            return;
        }
        if status == PortStatus::Ready {
            self.last = self.master.targets();
        }
        self.status = status;
        self.changed_us = Some(self.now_us);
    }
}

impl<T: Real> RobotPort<T> for CanopenArm {
    fn read_joints(&mut self) -> Result<JointReading<T>, PortError> {
        if self.status == PortStatus::Lost && !self.master.is_partly_lost() {
            return Err(PortError::Lost);
        }
        let (counts, at_us) = self.master.positions().ok_or(PortError::NotMeasured)?;
        let age_us = u32::try_from(self.now_us.saturating_sub(at_us)).unwrap_or(u32::MAX);
        Ok(JointReading { joints: self.drives.joints(&counts), age_us })
    }

    fn write_set_point(&mut self, joints: &Joints<T>) -> Result<(), PortError> {
        if self.status != PortStatus::Ready {
            return Err(PortError::NotReady(self.status));
        }
        self.gate.check(&self.drives.joints(&self.last), joints)?;
        let counts =
            self.drives.counts(joints).map_err(|BeyondCounts(joint)| PortError::OutOfRange(joint))?;
        self.last = counts;
        self.master.set_point(counts);
        Ok(())
    }

    fn enable(&mut self) -> Result<(), PortError> {
        let since_us = self.changed_us.map(|at_us| self.now_us.saturating_sub(at_us));
        let is_new = since_us.is_some_and(|us| us < READABLE_US);
        match self.status {
            PortStatus::Ready => return Ok(()),
            PortStatus::Fault(fault) if is_new => return Err(PortError::Refused(fault)),
            PortStatus::Lost if is_new => return Err(PortError::Lost),
            _ => {}
        }
        self.master.enable();
        self.look();
        Ok(())
    }

    fn stop(&mut self) -> Result<(), PortError> {
        let is_lost = self.status == PortStatus::Lost && !self.master.is_partly_lost();
        self.master.stop();
        self.look();
        if is_lost { Err(PortError::Lost) } else { Ok(()) }
    }

    fn status(&self) -> PortStatus {
        self.status
    }
}
