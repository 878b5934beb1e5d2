//! `summary.json`: what a run came to.

use super::csv::OutputError;
use crate::balls::BallSet;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::Duration;
use tetrad_core::observation::{BALLS, ObservationState, Observations};

/// How a figure spreads over the frames of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The arithmetic mean.
    pub mean: f64,
    /// The median.
    pub p50: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// The spread of these values by nearest rank; `None` of no values.
    #[must_use]
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().collect();
        sorted.sort_by(f64::total_cmp);
        let (&min, &max) = (sorted.first()?, sorted.last()?);
        let rank = |percent: usize| sorted[(sorted.len() * percent).div_ceil(100).max(1) - 1];
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        Some(Self { min, mean, p50: rank(50), p99: rank(99), max })
    }
}

fn microseconds(times: &[Duration]) -> Option<Spread> {
    Spread::of(times.iter().map(|t| t.as_secs_f64() * 1e6))
}

/// Frames in each state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StateCounts {
    /// Seen whole.
    pub visible: u64,
    /// Seen in part.
    pub occluded: u64,
    /// Not seen, put where its motion leads.
    pub predicted: u64,
    /// Not seen, without a place.
    pub lost: u64,
}

impl StateCounts {
    fn count(&mut self, state: ObservationState) {
        *match state {
            ObservationState::Visible => &mut self.visible,
            ObservationState::Occluded => &mut self.occluded,
            ObservationState::Predicted => &mut self.predicted,
            ObservationState::Lost => &mut self.lost,
        } += 1;
    }
}

/// One camera's part, gathered frame by frame.
#[derive(Clone, Debug)]
pub struct CameraSummary {
    source: String,
    size: (u16, u16),
    balls: BallSet,
    tracking: Vec<Duration>,
    tested: Vec<u32>,
    missed: u64,
    states: [StateCounts; BALLS],
}

impl CameraSummary {
    /// A camera of which nothing was seen yet.
    #[must_use]
    pub fn new(source: String, size: (u16, u16), balls: BallSet) -> Self {
        let states = [StateCounts::default(); BALLS];
        Self { source, size, balls, tracking: Vec::new(), tested: Vec::new(), missed: 0, states }
    }

    /// Adds a frame: how long tracking took (decoding excluded), pixels tested, what was seen.
    pub fn add(&mut self, tracking: Duration, tested: u32, observations: &Observations) {
        self.tracking.push(tracking);
        self.tested.push(tested);
        for (counts, seen) in self.states.iter_mut().zip(observations) {
            counts.count(seen.state);
        }
    }

    /// Adds frames that the source knows to be missing.
    pub fn add_missed(&mut self, frames: u64) {
        self.missed += frames;
    }

    /// Frames that are missing between those tracked.
    #[must_use]
    pub const fn missed(&self) -> u64 {
        self.missed
    }

    /// Microseconds of tracking a frame.
    #[must_use]
    pub fn tracking_us(&self) -> Option<Spread> {
        microseconds(&self.tracking)
    }

    /// Pixels tested a frame.
    #[must_use]
    pub fn pixels_tested(&self) -> Option<Spread> {
        Spread::of(self.tested.iter().map(|&n| f64::from(n)))
    }

    /// Frames of each tracked ball in each state.
    #[must_use]
    pub fn states(&self) -> BTreeMap<&'static str, StateCounts> {
        self.balls.iter().map(|ball| (ball.name(), self.states[ball.index()])).collect()
    }

    fn report(&self) -> CameraReport<'_> {
        CameraReport {
            source: &self.source,
            width: self.size.0,
            height: self.size.1,
            frames: self.tracking.len(),
            frames_missed: self.missed,
            tracking_us: self.tracking_us(),
            pixels_tested: self.pixels_tested(),
            states: self.states(),
        }
    }
}

/// The whole run.
#[derive(Clone, Debug)]
pub struct Summary {
    /// `paper` or `refined`.
    pub mode: &'static str,
    /// Frames (pairs of frames with two cameras) tracked to the end.
    pub frames: u64,
    /// The cameras by name, in the order of the command line.
    pub cameras: Vec<(&'static str, CameraSummary)>,
    /// How long the hand's solver took in each frame; empty without a pose.
    pub solving: Vec<Duration>,
    /// Frames of each state of the pose; empty without a pose.
    pub pose_states: BTreeMap<String, u64>,
    /// The message of the error that ended the run early.
    pub stopped_by: Option<String>,
}

#[derive(Serialize)]
struct CameraReport<'a> {
    source: &'a str,
    width: u16,
    height: u16,
    frames: usize,
    frames_missed: u64,
    tracking_us: Option<Spread>,
    pixels_tested: Option<Spread>,
    states: BTreeMap<&'static str, StateCounts>,
}

#[derive(Serialize)]
struct Report<'a> {
    version: &'static str,
    mode: &'static str,
    complete: bool,
    stopped_by: Option<&'a str>,
    frames: u64,
    cameras: BTreeMap<&'static str, CameraReport<'a>>,
    pose_us: Option<Spread>,
    pose: &'a BTreeMap<String, u64>,
}

/// The file's name.
const FILE_NAME: &str = "summary.json";

/// What it is called until it is whole.
const UNFINISHED_NAME: &str = "summary.json.part";

impl Summary {
    /// Removes what an earlier run left in `dir`, so that its summary is not taken for this one's.
    ///
    /// # Errors
    /// [`OutputError`] when there is one that cannot be removed.
    pub fn remove(dir: &Path) -> Result<(), OutputError> {
        for path in [FILE_NAME, UNFINISHED_NAME].map(|name| dir.join(name)) {
            match std::fs::remove_file(&path) {
                Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                    return Err(OutputError { path, cause });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Microseconds of solving for the hand a frame.
    #[must_use]
    pub fn pose_us(&self) -> Option<Spread> {
        microseconds(&self.solving)
    }

    /// Writes `summary.json` into `dir`: all of it, or nothing under that name.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(&self, dir: &Path) -> Result<(), OutputError> {
        let report = Report {
            version: env!("CARGO_PKG_VERSION"),
            mode: self.mode,
            complete: self.stopped_by.is_none(),
            stopped_by: self.stopped_by.as_deref(),
            frames: self.frames,
            cameras: self.cameras.iter().map(|(name, camera)| (*name, camera.report())).collect(),
            pose_us: self.pose_us(),
            pose: &self.pose_states,
        };
        let (path, unfinished) = (dir.join(FILE_NAME), dir.join(UNFINISHED_NAME));
        serde_json::to_vec_pretty(&report)
            .map_err(io::Error::from)
            .and_then(|mut json| {
                json.push(b'\n');
                std::fs::write(&unfinished, json)?;
                std::fs::rename(&unfinished, &path)
            })
            .map_err(|cause| OutputError { path, cause })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::observation::Observation;

    #[test]
    fn percentiles_are_of_the_nearest_rank() {
        let spread = Spread::of((1..=200).rev().map(f64::from)).unwrap();
        assert_eq!(spread, Spread { min: 1.0, mean: 100.5, p50: 100.0, p99: 198.0, max: 200.0 });
        let one = Spread::of([7.0]).unwrap();
        assert_eq!((one.p50, one.p99), (7.0, 7.0));
        assert_eq!(Spread::of([]), None);
    }

    #[test]
    fn the_file_counts_frames_and_names_what_stopped_it() {
        let dir = tempfile::tempdir().unwrap();
        let mut camera = CameraSummary::new("sim:linear".into(), (640, 480), "red".parse().unwrap());
        let visible = Observation { state: ObservationState::Visible, ..Observation::default() };
        camera.add(Duration::from_micros(30), 400, &[visible; BALLS]);
        camera.add(Duration::from_micros(50), 800, &[Observation::default(); BALLS]);
        let mut summary = Summary {
            mode: "paper",
            frames: 2,
            cameras: vec![("left", camera)],
            solving: vec![Duration::from_micros(4), Duration::from_micros(6)],
            pose_states: BTreeMap::new(),
            stopped_by: None,
        };
        let read = || -> serde_json::Value {
            serde_json::from_slice(&std::fs::read(dir.path().join("summary.json")).unwrap()).unwrap()
        };
        summary.write(dir.path()).unwrap();
        let json = read();
        let left = &json["cameras"]["left"];
        assert_eq!((json["frames"].as_u64(), json["complete"].as_bool()), (Some(2), Some(true)));
        assert_eq!(
            (left["tracking_us"]["min"].as_f64(), left["tracking_us"]["p99"].as_f64()),
            (Some(30.0), Some(50.0))
        );
        assert_eq!(json["pose_us"]["mean"].as_f64(), Some(5.0));
        assert_eq!(left["pixels_tested"]["mean"].as_f64(), Some(600.0));
        assert_eq!(left["states"]["red"]["visible"].as_u64(), Some(1));
        assert_eq!(left["states"]["red"]["lost"].as_u64(), Some(1));
        assert_eq!(left["states"].get("green"), None);

        summary.stopped_by = Some("right ended".into());
        summary.write(dir.path()).unwrap();
        assert_eq!(
            (read()["complete"].as_bool(), read()["stopped_by"].as_str()),
            (Some(false), Some("right ended"))
        );
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "nothing but the summary is left");

        std::fs::write(dir.path().join("summary.json.part"), "{").unwrap();
        Summary::remove(dir.path()).unwrap();
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
        Summary::remove(dir.path()).unwrap();
    }
}
