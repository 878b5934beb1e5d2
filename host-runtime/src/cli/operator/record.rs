//! The files of a run: where the hand was, what the slave said, how long it took. Rows are written on a thread
//! of their own: the motion does not wait for a disk.

use crate::link::Received;
use crate::output::{ArmStateCsv, Aside, OutputError, PoseCsv, SentCsv, write_delays};
use crate::pipeline::HandStep;
use crate::station::delays::{Delays, SentMotion};
use crate::station::operator::OperatorStep;
use std::path::{Path, PathBuf};
use tetrad_core::wire::ArmStatePacket;

/// What a run may write into its folder: these, and what `pictures` and an arm of this process do.
pub(super) const FILES: [&str; 9] = [
    "pose.csv",
    "filtered.csv",
    "arm_state.csv",
    "sent.csv",
    "delays.csv",
    "arm.csv",
    "left.jpg",
    "right.jpg",
    "pictures.csv",
];

/// So many rows wait for the disk at most: some seconds of instants and arm states.
const WAITING: usize = 2_048;

/// See the [module's text](self).
pub(super) struct Record {
    pub(super) dir: PathBuf,
    rows: Aside<Row>,
    frame: u64,
}

/// What a row is made of.
enum Row {
    /// The instant's number, and its time by the operator's clock, seconds.
    Hand((u64, f64), HandStep),
    Sent(SentMotion),
    Arm(Received<ArmStatePacket>),
}

impl Record {
    pub(super) fn create(dir: &Path) -> Result<Self, OutputError> {
        let mut pose = PoseCsv::create(dir)?;
        let mut filtered = PoseCsv::create_filtered(dir)?;
        let mut sent = SentCsv::create(dir)?;
        let mut arm = ArmStateCsv::create(dir)?;
        let rows = Aside::start(WAITING, move |row: &Row| match row {
            Row::Hand(at, HandStep { report, filtered: smoothed, .. }) => {
                pose.write(*at, report.pose.as_ref(), report.state)?;
                filtered.write(*at, smoothed.as_ref(), report.state)
            }
            Row::Sent(motion) => sent.write(motion),
            Row::Arm(state) => arm.write(state),
        })
        .map_err(|cause| OutputError { path: dir.to_owned(), cause })?;
        Ok(Self { dir: dir.to_owned(), rows, frame: 0 })
    }

    /// An instant, by the operator's clock.
    pub(super) fn step(&mut self, step: &OperatorStep) -> Result<(), OutputError> {
        let at = (self.frame, step.joined.t_us as f64 * 1e-6);
        self.frame += 1;
        self.rows.put(Row::Hand(at, step.hand))?;
        step.sent.map_or(Ok(()), |motion| self.rows.put(Row::Sent(motion)))
    }

    pub(super) fn arm(&mut self, state: &Received<ArmStatePacket>) -> Result<(), OutputError> {
        self.rows.put(Row::Arm(*state))
    }

    /// Waits until all is written; how many rows were lost.
    pub(super) fn end(&mut self, delays: &Delays) -> Result<u64, OutputError> {
        let lost = self.rows.end()?;
        write_delays(&self.dir, delays)?;
        Ok(lost)
    }
}
