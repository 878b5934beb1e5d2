//! A replay of pictures in pairs through one pipeline.

use super::{Made, Outcome, camera, missing, observations_of, seconds};
use crate::output::Stamp;
use crate::pipeline::Pipeline;
use crate::session::compare::Comparison;
use crate::session::configuration::Beginning;
use crate::session::convert;
use crate::session::error::SessionError;
use crate::session::picture;
use crate::session::reader::{Entry, Reader, damaged};
use crate::session::schema::foxglove::RawImage;
use crate::session::schema::tetrad as msg;
use crate::session::topic::Topic;

/// Pictures in pairs through one pipeline.
pub(super) struct Pairs {
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
    pub(super) fn new(beginning: &Beginning) -> Result<Self, String> {
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

    pub(super) fn take<E: From<SessionError>>(
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

    pub(super) fn finish(self) -> Outcome {
        let seen = self.seen.into_iter().map(Comparison::finish);
        let compared = seen.chain(self.hand.map(Comparison::finish)).collect();
        let alone = self.unpaired + self.waiting.iter().flatten().count() as u64;
        let notes = (alone > 0)
            .then(|| format!("{alone} pictures have no partner in the file: they were not tracked again"));
        Outcome { compared, pictures: self.pictures, cut: false, notes: notes.into_iter().collect() }
    }
}
