//! All result files of a run, kept in step.

use super::{
    CameraSummary, MotionCsv, ObservationsCsv, OutputError, PoseCovarianceCsv, PoseCsv, Summary,
    UncertaintyCsv,
};
use crate::balls::BallSet;
use crate::pipeline::Step;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// One camera of a run, as the summary names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedCamera {
    /// `left` or `right`.
    pub name: &'static str,
    /// SRC as it was given.
    pub source: String,
    /// Width and height in pixels.
    pub size: (u16, u16),
}

/// Which frame of a camera a step took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stamp {
    /// What the frame is called in the `frame` columns.
    pub frame: u64,
    /// When it was taken, seconds.
    pub t_s: f64,
    /// How many frames are missing before it.
    pub missed: u64,
}

/// Writes the CSV files as frames come, and summary.json at the end.
#[derive(Debug)]
pub struct Recorder {
    dir: PathBuf,
    balls: BallSet,
    observations: ObservationsCsv,
    uncertainty: UncertaintyCsv,
    pose: PoseCsv,
    filtered: PoseCsv,
    pose_covariance: PoseCovarianceCsv,
    motion: MotionCsv,
    summary: Summary,
}

impl Recorder {
    /// Creates the files in `dir`, which must be there.
    ///
    /// # Errors
    /// [`OutputError`] naming the file that cannot be created.
    pub fn create(
        dir: &Path,
        mode: &'static str,
        cameras: Vec<RecordedCamera>,
        balls: BallSet,
    ) -> Result<Self, OutputError> {
        let cameras = cameras
            .into_iter()
            .map(|camera| (camera.name, CameraSummary::new(camera.source, camera.size, balls)))
            .collect();
        Ok(Self {
            dir: dir.to_owned(),
            balls,
            observations: ObservationsCsv::create(dir)?,
            uncertainty: UncertaintyCsv::create(dir)?,
            pose: PoseCsv::create(dir)?,
            filtered: PoseCsv::create_filtered(dir)?,
            pose_covariance: PoseCovarianceCsv::create(dir)?,
            motion: MotionCsv::create(dir)?,
            summary: Summary {
                mode,
                frames: 0,
                cameras,
                solving: Vec::new(),
                pose_states: BTreeMap::new(),
                stopped_by: None,
            },
        })
    }

    /// Adds one step; `stamps` are the cameras' frames. The hand's rows carry the first camera's.
    ///
    /// # Errors
    /// [`OutputError`] when a row cannot be written.
    pub fn step(&mut self, stamps: &[Stamp], step: &Step) -> Result<(), OutputError> {
        for ((camera, stamp), (name, summary)) in
            step.cameras.iter().zip(stamps).zip(&mut self.summary.cameras)
        {
            let report = &camera.report;
            summary.add(camera.tracking, report.tested, &report.observations);
            summary.add_missed(stamp.missed);
            let stamp = (stamp.frame, stamp.t_s);
            self.observations.write(stamp, name, self.balls, &report.observations)?;
            self.uncertainty.write(stamp, name, self.balls, &report.observations)?;
        }
        if let (Some(hand), Some(stamp)) = (&step.hand, stamps.first()) {
            let stamp = (stamp.frame, stamp.t_s);
            self.summary.solving.push(hand.solving);
            self.filtered.write(stamp, hand.filtered.as_ref(), hand.report.state)?;
            let hand = &hand.report;
            self.pose.write(stamp, hand.pose.as_ref(), hand.state)?;
            let motion = hand.motion.as_ref().ok();
            let residual_px = motion.map(|motion| motion.residual_px);
            self.pose_covariance.write(stamp, residual_px, hand.covariance.as_ref())?;
            self.motion.write(stamp, motion)?;
            *self.summary.pose_states.entry(hand.state.name().to_owned()).or_default() += 1;
        }
        self.summary.frames += 1;
        Ok(())
    }

    /// What the run came to so far.
    #[must_use]
    pub const fn summary(&self) -> &Summary {
        &self.summary
    }

    /// Writes summary.json; `stopped_by` is the error that ended the run early.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn finish(mut self, stopped_by: Option<String>) -> Result<Summary, OutputError> {
        self.summary.stopped_by = stopped_by;
        self.summary.write(&self.dir)?;
        Ok(self.summary)
    }
}
