//! What a replay writes: the files of `tetrad track`, or for stations those that there is something for.

use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::{MotionCsv, ObservationsCsv, OutputError, PoseCsv, RecordedCamera, Recorder, Stamp};
use crate::pipeline::HandStep;
use crate::session::schema::tetrad::Chain;
use crate::session::{Beginning, Made};
use std::path::Path;

/// See the [module's text](self).
pub(super) enum Results {
    Pairs(Box<Recorder>),
    Stations(Box<Stations>),
}

pub(super) struct Stations {
    names: Vec<String>,
    beginning: Beginning,
    observations: ObservationsCsv,
    pose: PoseCsv,
    filtered: PoseCsv,
    motion: MotionCsv,
}

/// The first camera's name, then the second's.
const NAMES: [&str; 2] = ["left", "right"];

impl Results {
    pub(super) fn create(dir: &Path, beginning: &Beginning) -> Result<Self, Failure> {
        if beginning.chain == Chain::Stations {
            return Stations::create(dir, beginning)
                .map(|stations| Self::Stations(Box::new(stations)))
                .or_exit(Exit::Failed);
        }
        let cameras = NAMES.into_iter().zip(&beginning.cameras).map(|(name, camera)| RecordedCamera {
            name,
            source: camera.source.clone(),
            size: camera.pictures.as_ref().map_or((0, 0), |pictures| pictures.size),
        });
        let recorder = Recorder::create(dir, beginning.mode.name(), cameras.collect(), beginning.balls());
        Ok(Self::Pairs(Box::new(recorder.or_exit(Exit::Failed)?)))
    }

    pub(super) fn take(&mut self, made: &Made<'_>) -> Result<(), Failure> {
        let written = match (self, made) {
            (Self::Pairs(recorder), Made::Step(stamps, step)) => recorder.step(stamps, step),
            (Self::Stations(stations), Made::Seen(camera, stamp, seen)) => {
                let name = stations.names.get(*camera).map_or("camera", String::as_str);
                let balls = stations.beginning.balls();
                stations.observations.write((stamp.frame, stamp.t_s), name, balls, seen)
            }
            (Self::Stations(stations), Made::Hand(stamp, step)) => stations.hand(stamp, step),
            // a chain makes what it makes
            _ => Ok(()),
        };
        written.or_exit(Exit::Failed)
    }

    pub(super) fn finish(self, stopped_by: Option<String>) -> Result<(), Failure> {
        match self {
            Self::Pairs(recorder) => recorder.finish(stopped_by).map(drop).or_exit(Exit::Failed),
            // every row is on its way already
            Self::Stations(_) => Ok(()),
        }
    }
}

impl Stations {
    fn create(dir: &Path, beginning: &Beginning) -> Result<Self, OutputError> {
        Ok(Self {
            names: beginning.names(),
            beginning: beginning.clone(),
            observations: ObservationsCsv::create(dir)?,
            pose: PoseCsv::create(dir)?,
            filtered: PoseCsv::create_filtered(dir)?,
            motion: MotionCsv::create(dir)?,
        })
    }

    fn hand(&mut self, stamp: &Stamp, step: &HandStep) -> Result<(), OutputError> {
        let at = (stamp.frame, stamp.t_s);
        let report = &step.report;
        self.pose.write(at, report.pose.as_ref(), report.state)?;
        self.filtered.write(at, step.filtered.as_ref(), report.state)?;
        self.motion.write(at, report.motion.as_ref().ok())
    }
}
