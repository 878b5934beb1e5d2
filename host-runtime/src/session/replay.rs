//! A session run through the same pipeline again, and compared with what was recorded.

use super::compare::{Compared, Comparison};
use super::configuration::Beginning;
use super::convert;
use super::error::SessionError;
use super::picture;
use super::reader::{Entry, Reader, damaged};
use super::schema::foxglove::RawImage;
use super::schema::tetrad as msg;
use super::tape::LEFT_OUT;
use super::topic::Topic;
use crate::output::Stamp;
use crate::pipeline::{HandStage, HandStep, Pipeline, Step};
use crate::station::pairing::{Joined, Pairing, Sighting, Source};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Ball, Observations};
use tetrad_core::vision::tracker::CameraTracker;

/// The size of a camera's pictures before the first has come, px; as the operator has it.
const UNKNOWN_SIZE: (u16, u16) = (640, 480);

/// What was computed anew.
#[derive(Debug)]
pub enum Made<'a> {
    /// A step of a pipeline, and its frames.
    Step(&'a [Stamp], &'a Step),
    /// What one camera of a station saw.
    Seen(usize, Stamp, &'a Observations),
    /// The hand at an instant.
    Hand(Stamp, &'a HandStep),
}

/// What a replay came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Kind by kind.
    pub compared: Vec<Compared>,
    /// Pictures that were tracked again.
    pub pictures: u64,
    /// Whether the file ended before its end.
    pub cut: bool,
    /// What else there is to tell.
    pub notes: Vec<String>,
}

impl Outcome {
    /// Whether there was something to compare, and all of it came out the same.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        let counted = self.compared.iter().any(|compared| compared.count > 0);
        counted && self.compared.iter().all(Compared::is_identical)
    }
}

/// Replays a session; `sink` is given everything as it is made.
///
/// # Errors
/// A file that cannot be read on, something in it that cannot be replayed, or what `sink` returned.
pub fn replay<E: From<SessionError>>(
    reader: &mut Reader,
    mut sink: impl FnMut(Made<'_>) -> Result<(), E>,
) -> Result<Outcome, E> {
    let beginning = reader.beginning().clone();
    let refused = |reason: String| SessionError::not_a_session(reader.path(), reason);
    let mut outcome = match beginning.chain {
        msg::Chain::Stations => {
            let mut stations = Stations::new(&beginning).map_err(refused)?;
            while let Some(entry) = reader.next_entry()? {
                stations.take(reader, &entry, &mut sink)?;
            }
            stations.finish()
        }
        msg::Chain::Pairs | msg::Chain::Unknown => {
            let mut pairs = Pairs::new(&beginning).map_err(refused)?;
            while let Some(entry) = reader.next_entry()? {
                pairs.take(reader, &entry, &mut sink)?;
            }
            pairs.finish()
        }
    };
    outcome.cut = reader.cut();
    for (key, count) in reader.end().into_iter().flatten() {
        if let Some(topic) = key.strip_prefix(LEFT_OUT) {
            outcome.notes.push(format!("{count} of {topic} were left out when it was recorded"));
        }
    }
    if reader.version() != env!("CARGO_PKG_VERSION") {
        let (then, now) = (reader.version(), env!("CARGO_PKG_VERSION"));
        outcome.notes.push(format!("recorded by tetrad {then}, replayed by tetrad {now}"));
    }
    Ok(outcome)
}

fn observations_of(names: &[String]) -> Vec<Comparison<msg::Observations>> {
    names.iter().map(|name| Comparison::new(format!("{name} observations"))).collect()
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// Frames that are missing between two numbers, as a camera counts them.
fn missing(last: Option<u32>, number: u32) -> u64 {
    last.map_or(0, |last| u64::from(number.saturating_sub(last).saturating_sub(1)))
}

/// Pictures in pairs through one pipeline.
struct Pairs {
    pipeline: Pipeline,
    /// Those of the next step that have come.
    waiting: Vec<Option<(Entry, RawImage)>>,
    last: Vec<Option<u32>>,
    seen: Vec<Comparison<msg::Observations>>,
    hand: Option<Comparison<msg::Hand>>,
    pictures: u64,
    unpaired: u64,
}

impl Pairs {
    fn new(beginning: &Beginning) -> Result<Self, String> {
        let starts: Vec<_> = beginning.cameras.iter().map(|camera| camera.start).collect();
        let arms = beginning.arms()?;
        let pipeline = Pipeline::new(&starts, beginning.pipeline(), arms)
            .map_err(|(at, error)| camera(beginning, at, error))?;
        Ok(Self {
            pipeline: pipeline.with_filter(beginning.pose_filter()?),
            waiting: vec![None; starts.len()],
            last: vec![None; starts.len()],
            seen: observations_of(&beginning.names()),
            hand: arms.map(|_| Comparison::new("poses".to_owned())),
            pictures: 0,
            unpaired: 0,
        })
    }

    fn take<E: From<SessionError>>(
        &mut self,
        reader: &Reader,
        entry: &Entry,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match entry.topic {
            Topic::Image(camera) => {
                let image: RawImage = reader.decode(entry)?;
                // the message is decoded: its bytes are not kept
                let head = Entry { bytes: Vec::new(), ..*entry };
                if let Some(slot) = self.waiting.get_mut(camera) {
                    self.unpaired += u64::from(slot.replace((head, image)).is_some());
                }
                if self.waiting.iter().all(Option::is_some) {
                    self.step(reader, sink)?;
                }
            }
            Topic::Observations(camera) => {
                if let Some(comparison) = self.seen.get_mut(camera) {
                    comparison.recorded(reader.decode(entry)?);
                }
            }
            Topic::Hand => {
                if let Some(comparison) = &mut self.hand {
                    comparison.recorded(reader.decode(entry)?);
                }
            }
            _ => {}
        }
        Ok(())
    }

    fn step<E: From<SessionError>>(
        &mut self,
        reader: &Reader,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let pictures: Vec<(Entry, RawImage)> = self.waiting.iter_mut().filter_map(Option::take).collect();
        let mut frames = Vec::new();
        for (entry, image) in &pictures {
            let view = picture::view(image).map_err(|reason| damaged(reader.path(), entry.at, reason))?;
            frames.push((view, entry.time_us));
        }
        let step = self.pipeline.step(&frames);
        self.pictures += pictures.len() as u64;
        let mut stamps = Vec::new();
        for ((entry, _), last) in pictures.iter().zip(&mut self.last) {
            let missed = missing(last.replace(entry.sequence), entry.sequence);
            let frame = u64::from(entry.sequence);
            stamps.push(Stamp { frame, t_s: seconds(entry.time_us), missed });
        }
        for (((entry, _), camera), comparison) in pictures.iter().zip(&step.cameras).zip(&mut self.seen) {
            comparison.replayed(msg::Observations {
                frame: u64::from(entry.sequence),
                capture_us: entry.time_us,
                pixels_tested: camera.report.tested,
                balls: convert::balls(&camera.report.observations),
                ..msg::Observations::default()
            });
        }
        if let (Some(comparison), Some(hand), Some((entry, _))) =
            (&mut self.hand, &step.hand, pictures.first())
        {
            comparison.replayed(convert::hand(u64::from(entry.sequence), entry.time_us, hand));
        }
        sink(Made::Step(&stamps, &step))
    }

    fn finish(self) -> Outcome {
        let seen = self.seen.into_iter().map(Comparison::finish);
        let compared = seen.chain(self.hand.map(Comparison::finish)).collect();
        let alone = self.unpaired + self.waiting.iter().flatten().count() as u64;
        let notes = (alone > 0)
            .then(|| format!("{alone} pictures have no partner in the file: they were not tracked again"));
        Outcome { compared, pictures: self.pictures, cut: false, notes: notes.into_iter().collect() }
    }
}

fn camera(beginning: &Beginning, at: usize, error: impl std::fmt::Display) -> String {
    let name = beginning.cameras.get(at).map_or("?", |camera| camera.name.as_str());
    format!("the {name} camera cannot be tracked: {error}")
}

/// Cameras for themselves, joined by time.
struct Stations {
    trackers: Vec<Option<CameraTracker>>,
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
    fn new(beginning: &Beginning) -> Result<Self, String> {
        let mut trackers = Vec::new();
        for (at, it) in beginning.cameras.iter().enumerate() {
            let tracker = it.pictures.as_ref().map(|_| CameraTracker::new(it.tracker(), it.start.balls));
            let mut tracker = tracker.transpose().map_err(|error| camera(beginning, at, error))?;
            for (ball, place) in Ball::ALL.into_iter().zip(it.start.places) {
                if let (Some(tracker), Some(place)) = (&mut tracker, place) {
                    tracker.place(ball, place);
                }
            }
            trackers.push(tracker);
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
            trackers,
            names,
            instants: Comparison::new("instants".to_owned()),
            stage,
            hand: Comparison::new("poses".to_owned()),
            instant: 0,
            pictures: 0,
        })
    }

    fn take<E: From<SessionError>>(
        &mut self,
        reader: &Reader,
        entry: &Entry,
        sink: &mut impl FnMut(Made<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        match entry.topic {
            Topic::Image(camera) => self.picture(reader, entry, camera, sink),
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
                    self.instants.replayed(instant_message(&joined, recorded.asked_us));
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

    fn finish(self) -> Outcome {
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

/// An instant as it is written.
pub(super) fn instant_message(joined: &Joined, asked_us: u64) -> msg::Instant {
    let views = joined.views.iter().map(|view| {
        let (known, between_us) = match view.source {
            Source::Missing => (msg::Known::Missing, 0),
            Source::Seen => (msg::Known::Seen, 0),
            Source::Between(us) => (msg::Known::Between, us),
        };
        msg::View { known: known.into(), between_us, balls: convert::balls(&view.balls) }
    });
    msg::Instant {
        capture_us: joined.t_us,
        asked_us,
        // at most eight
        reference: joined.reference as u32,
        views: views.collect(),
    }
}
