//! A replay of cameras for themselves, joined by time.

use super::{Made, Outcome, camera, missing, observations_of, seconds};
use crate::output::Stamp;
use crate::pipeline::{HandStage, tracker_of};
use crate::session::compare::Comparison;
use crate::session::configuration::{Beginning, CameraBeginning};
use crate::session::convert;
use crate::session::error::SessionError;
use crate::session::picture;
use crate::session::reader::{Entry, Reader, damaged};
use crate::session::schema::foxglove::RawImage;
use crate::session::schema::tetrad as msg;
use crate::session::taught;
use crate::session::topic::Topic;
use crate::station::pairing::{Joined, Pairing, Sighting};
use tetrad_core::config::TrackerConfig;
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::BALLS;
use tetrad_core::vision::tracker::CameraTracker;

/// The size of a camera's pictures before the first has come, px; as the operator has it.
const UNKNOWN_SIZE: (u16, u16) = (640, 480);

/// Cameras for themselves, joined by time.
pub(super) struct Stations {
    trackers: Vec<Option<CameraTracker>>,
    /// How they track, but for whether the balls are one rigid frame.
    configs: Vec<TrackerConfig>,
    focal_px: Vec<Option<f32>>,
    names: Vec<String>,
    /// Each camera's last picture.
    last: Vec<Option<u32>>,
    /// Pictures that were tracked and are not in the file.
    left_out: Vec<u64>,
    seen: Vec<Option<Comparison<msg::Observations>>>,
    pairing: Pairing,
    instants: Comparison<msg::Instant>,
    stage: Option<HandStage>,
    hand: Comparison<msg::Hand>,
    instant: u64,
    pictures: u64,
}

impl Stations {
    pub(super) fn new(beginning: &Beginning) -> Result<Self, String> {
        let mut trackers = Vec::new();
        for (at, it) in beginning.cameras.iter().enumerate() {
            let tracker = it.pictures.as_ref().map(|_| tracker_of(it.tracker(), &it.start));
            trackers.push(tracker.transpose().map_err(|error| camera(beginning, at, error))?);
        }
        let config = beginning.pipeline();
        let filter = beginning.pose_filter()?;
        let stage = beginning.arms()?.map(|arms| HandStage::new(config.hand_mode, arms, config.hand, filter));
        let names = beginning.names();
        let seen = observations_of(&names);
        Ok(Self {
            seen: seen
                .into_iter()
                .zip(&trackers)
                .map(|(comparison, tracker)| tracker.as_ref().map(|_| comparison))
                .collect(),
            last: vec![None; trackers.len()],
            left_out: vec![0; trackers.len()],
            focal_px: beginning.cameras.iter().map(|camera| camera.start.focal_px).collect(),
            pairing: Pairing::new(trackers.len()),
            configs: beginning.cameras.iter().map(CameraBeginning::tracker).collect(),
            trackers,
            names,
            instants: Comparison::new("instants".to_owned()),
            stage,
            hand: Comparison::new("poses".to_owned()),
            instant: 0,
            pictures: 0,
        })
    }

    pub(super) fn take<E: From<SessionError>>(
        &mut self,
        reader: &Reader,
        entry: &Entry,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match entry.topic {
            Topic::Image(camera) => self.picture(reader, entry, camera, sink),
            Topic::Taught(camera) => Ok(self.teach(reader, entry, camera)?),
            Topic::HandBegins => Ok(self.begin(reader, entry)?),
            Topic::Observations(camera) => {
                let seen: msg::Observations = reader.decode(entry)?;
                let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
                self.pairing.take(
                    camera,
                    &Sighting {
                        capture_us: seen.capture_us,
                        ready_us: seen.ready_us,
                        received_us: seen.received_us,
                        balls: convert::observations(&seen.balls),
                        size: (side(seen.width), side(seen.height)),
                    },
                );
                if let Some(Some(comparison)) = self.seen.get_mut(camera) {
                    comparison.recorded(seen);
                }
                Ok(())
            }
            Topic::Instant => {
                let recorded: msg::Instant = reader.decode(entry)?;
                if let Some(joined) = self.pairing.next(recorded.asked_us) {
                    self.instants.replayed(convert::instant(&joined, recorded.asked_us));
                    self.pose(&joined, sink)?;
                }
                self.instants.recorded(recorded);
                Ok(())
            }
            Topic::Hand => {
                self.hand.recorded(reader.decode(entry)?);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn picture<E: From<SessionError>>(
        &mut self,
        reader: &Reader,
        entry: &Entry,
        camera: usize,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let (Some(Some(tracker)), Some(last), Some(left_out)) =
            (self.trackers.get_mut(camera), self.last.get_mut(camera), self.left_out.get_mut(camera))
        else {
            return Ok(());
        };
        *left_out += match last.replace(entry.sequence) {
            Some(last) => missing(Some(last), entry.sequence),
            None => u64::from(entry.sequence),
        };
        let image: RawImage = reader.decode(entry)?;
        let view = picture::view(&image).map_err(|reason| damaged(reader.path(), entry.at, reason))?;
        let report = tracker.step(&view, entry.time_us, &[None; BALLS]);
        self.pictures += 1;
        let frame = u64::from(entry.sequence);
        if let Some(Some(comparison)) = self.seen.get_mut(camera) {
            comparison.replayed(msg::Observations {
                frame,
                capture_us: entry.time_us,
                pixels_tested: report.tested,
                balls: convert::balls(&report.observations),
                ..msg::Observations::default()
            });
        }
        let stamp = Stamp { frame, t_s: seconds(entry.time_us), missed: 0 };
        sink(Made::Seen(camera, stamp, &report.observations))
    }

    /// The camera looks for other balls from its next picture on, as it did when it was taught anew.
    fn teach(&mut self, reader: &Reader, entry: &Entry, camera: usize) -> Result<(), SessionError> {
        let (Some(Some(tracker)), Some(config)) = (self.trackers.get_mut(camera), self.configs.get(camera))
        else {
            return Ok(());
        };
        let order = taught::order_of(&reader.decode(entry)?, *config);
        let taught = order.and_then(|order| order.tracker().map_err(|error| error.to_string()));
        *tracker = taught.map_err(|reason| damaged(reader.path(), entry.at, reason))?;
        Ok(())
    }

    /// The hand is another from here on, as it was when it was set up anew.
    fn begin(&mut self, reader: &Reader, entry: &Entry) -> Result<(), SessionError> {
        let arms = taught::arms_of(&reader.decode(entry)?)
            .map_err(|reason| damaged(reader.path(), entry.at, reason))?;
        if let Some(stage) = &mut self.stage {
            stage.set_up(arms);
        }
        Ok(())
    }

    fn pose<E>(
        &mut self,
        joined: &Joined,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some(stage) = &mut self.stage else { return Ok(()) };
        let views: Vec<HandView> = joined
            .views
            .iter()
            .zip(&self.focal_px)
            .map(|(view, focal_px)| {
                let (width, height) = view.size.unwrap_or(UNKNOWN_SIZE);
                let nominal = CameraModel::nominal(width, height);
                let focal_px = focal_px.unwrap_or(nominal.focal_px);
                HandView { balls: view.balls, camera: CameraModel { focal_px, ..nominal } }
            })
            .collect();
        let step = stage.step(&views, joined.t_us);
        self.hand.replayed(convert::hand(self.instant, joined.t_us, &step));
        let stamp = Stamp { frame: self.instant, t_s: seconds(joined.t_us), missed: 0 };
        self.instant += 1;
        sink(Made::Hand(stamp, &step))
    }

    pub(super) fn finish(self) -> Outcome {
        // a picture is kept after what was seen in it has gone on
        let seen = self.seen.into_iter().flatten().map(Comparison::finish_open);
        let compared = seen.chain([self.instants.finish(), self.hand.finish()]).collect();
        let left_out = self.left_out.iter().zip(&self.names).filter(|(count, _)| **count > 0);
        let notes = left_out.map(|(count, name)| {
            format!("{count} pictures of {name} were tracked and not recorded: what its tracker made of those after them may differ")
        });
        Outcome { compared, pictures: self.pictures, cut: false, notes: notes.collect() }
    }
}
