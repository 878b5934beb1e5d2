//! The files of a run: where the hand was, what the slave said, how long it took.

use crate::link::Received;
use crate::output::{ArmStateCsv, OutputError, PoseCsv, write_delays};
use crate::station::delays::Delays;
use crate::station::operator::OperatorStep;
use std::path::{Path, PathBuf};
use tetrad_core::wire::ArmStatePacket;

/// See the [module's text](self).
pub(super) struct Record {
    pub(super) dir: PathBuf,
    pose: PoseCsv,
    filtered: PoseCsv,
    arm: ArmStateCsv,
    frame: u64,
}

impl Record {
    pub(super) fn create(dir: &Path) -> Result<Self, OutputError> {
        Ok(Self {
            dir: dir.to_owned(),
            pose: PoseCsv::create(dir)?,
            filtered: PoseCsv::create_filtered(dir)?,
            arm: ArmStateCsv::create(dir)?,
            frame: 0,
        })
    }

    /// An instant, by the operator's clock.
    pub(super) fn step(&mut self, step: &OperatorStep) -> Result<(), OutputError> {
        let at = (self.frame, step.joined.t_us as f64 * 1e-6);
        let report = &step.hand.report;
        self.pose.write(at, report.pose.as_ref(), report.state)?;
        self.filtered.write(at, step.hand.filtered.as_ref(), report.state)?;
        self.frame += 1;
        Ok(())
    }

    pub(super) fn arm(&mut self, state: &Received<ArmStatePacket>) -> Result<(), OutputError> {
        self.arm.write(state)
    }

    pub(super) fn end(&self, delays: &Delays) -> Result<(), OutputError> {
        write_delays(&self.dir, delays)
    }
}
