//! One camera at work: pictures in, observation packets out.
//!
//! ```text
//! source --frame--> CameraTracker --observations--> ObservationPacket --> sink: peers of a link,
//!    ^ opened again where it is lost                                      or a place in this process
//! ```
//!
//! Nobody tells this camera where the hand will be: the tracker goes by its own prediction, and searches
//! a ball that is lost in the whole picture until it is there again.

mod counts;
mod handle;
mod thread;

pub use counts::CameraCounts;
pub use handle::{CameraHandle, Grab, Order, Still, Taught};
pub use thread::{CameraThread, Onlooker};

use super::back_off::BackOff;
use crate::camera_start::{Named, camera_start};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::pipeline::{CameraStart, tracker_of};
use crate::robot::clock::Clock;
use crate::settings::Start;
use crate::settings::station::{CameraStart as Known, LocalCamera};
use crate::source::{self, Gap, Source, SourceError, SourceInfo, Spec};
use anyhow::Context as _;
use std::time::Duration;
use tetrad_core::config::TrackerConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::BALLS;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::search::Region;
use tetrad_core::vision::tracker::CameraTracker;
use tetrad_core::wire::ObservationPacket;
use tetrad_fixtures::Scene;

/// Where a camera's observations go.
pub trait CameraSink {
    /// They are made.
    fn observed(&mut self, packet: &ObservationPacket);

    /// The picture they were made of, after that, and where each ball was looked for first.
    fn pictured(&mut self, _picture: &FrameView<'_>, _packet: &ObservationPacket, _windows: &Windows) {}

    /// It was taught anew: the picture of that number, which is its next, is the first that is looked at so.
    fn taught(&mut self, _order: &Order, _from: u32, _now_us: u64) {}
}

/// Where each ball was looked for first; `None` where it was searched in the whole picture.
pub type Windows = [Option<Region>; BALLS];

impl<F: FnMut(&ObservationPacket)> CameraSink for F {
    fn observed(&mut self, packet: &ObservationPacket) {
        self(packet);
    }
}

/// How a station's packets are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Label {
    /// The camera's place among the sender's.
    pub camera: u8,
    /// The sender's session.
    pub session: u32,
}

/// What a step came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A picture was tracked, and its observations are with the sink.
    Observed,
    /// The camera is lost; there is nothing to do for so long.
    Lost(Duration),
    /// It was a recording, which is over.
    Ended,
}

/// Opens the camera, the first time as every later one.
pub type Opener = Box<dyn FnMut() -> Result<Box<dyn Source>, SourceError> + Send>;

/// See the [module's text](self).
pub struct CameraStation {
    name: String,
    label: Label,
    clock: Clock,
    open: Opener,
    /// `None` while it is lost.
    source: Option<Box<dyn Source>>,
    tracker: CameraTracker,
    handle: CameraHandle,
    /// What the tracker began with.
    start: CameraStart,
    info: SourceInfo,
    sequence: u32,
    /// When the last picture was taken.
    last_us: Option<u64>,
    back_off: BackOff,
    /// Why the camera could not be opened again, as it was told.
    told: String,
    counts: CameraCounts,
    notices: Vec<String>,
}

impl CameraStation {
    /// Opens a camera and teaches its tracker the balls.
    ///
    /// # Errors
    /// The camera is not there, or its balls cannot be tracked; later on a camera that goes away is no
    /// error.
    pub fn open(camera: &LocalCamera, label: Label, clock: Clock) -> Result<Self, Failure> {
        let (spec, options) = (camera.source.clone(), camera.options);
        let mut open: Opener = Box::new(move || source::open_live(&spec, &options));
        let mut source = open()?;
        let start = start_of(camera, source.as_mut())?;
        let mut config = camera.mode.pipeline().tracker;
        config.rigid = start.balls.iter().all(Option::is_some);
        Self::of(source, open, &start, config, label, clock)
    }

    /// The station of a source that is open already; `open` opens it again.
    ///
    /// # Errors
    /// A ball that cannot be tracked as it was taught.
    pub fn of(
        mut source: Box<dyn Source>,
        open: Opener,
        start: &CameraStart,
        config: TrackerConfig,
        label: Label,
        clock: Clock,
    ) -> Result<Self, Failure> {
        let info = source.info().clone();
        let name = info.name.clone();
        let tracker = tracker_of(config, start)
            .with_context(|| format!("{name} cannot be tracked"))
            .or_exit(Exit::BadArguments)?;
        let notices = source.take_notices();
        let handle = CameraHandle::new(config, start, (source.info().width, source.info().height));
        Ok(Self {
            name,
            label,
            clock,
            open,
            source: Some(source),
            tracker,
            handle,
            start: *start,
            info,
            sequence: 0,
            last_us: None,
            back_off: BackOff::default(),
            told: String::new(),
            counts: CameraCounts::new(),
            notices,
        })
    }

    /// Waits for the next picture and tracks it; where the camera is lost, tries to have it back.
    ///
    /// # Errors
    /// A recording that cannot be read on.
    pub fn step(&mut self, sink: &mut dyn CameraSink) -> Result<Step, Failure> {
        if let Some((order, tracker)) = self.handle.take_order() {
            self.tracker = tracker;
            sink.taught(&order, self.sequence, self.clock.now_us());
            self.notices.push(format!("{}: it looks for balls as they were taught anew", self.name));
        }
        let Some(source) = &mut self.source else { return Ok(self.open_again()) };
        // before the wait, for the picture is lent: clocks do not part by a microsecond meanwhile
        let clocks = (self.clock.now_us(), source.now_s());
        let live = source.info().live;
        let frame = match source.next() {
            Ok(Some(frame)) => frame,
            Ok(None) => return Ok(Step::Ended),
            Err(error) if live => return Ok(self.lose(&error)),
            Err(error) => return Err(error.into()),
        };
        let ready_at_us = self.clock.now_us();
        let capture_us = capture_us(frame.t_s, clocks).unwrap_or(ready_at_us);
        // the tracker's clock goes forward, whatever the source's does
        let capture_us = self.last_us.map_or(capture_us, |last_us| capture_us.max(last_us + 1));
        let report = self.tracker.step(&frame.view, capture_us, &[None; BALLS]);
        let observed_at_us = self.clock.now_us();
        let after = |at_us: u64| u32::try_from(at_us.saturating_sub(capture_us)).unwrap_or(u32::MAX);
        let packet = ObservationPacket {
            camera: self.label.camera,
            session: self.label.session,
            sequence: self.sequence,
            capture_us,
            ready_us: after(ready_at_us),
            observed_us: after(observed_at_us),
            width: frame.view.width(),
            height: frame.view.height(),
            pixels_tested: report.tested,
            balls: report.observations,
        };
        sink.observed(&packet);
        sink.pictured(&frame.view, &packet, &report.windows);
        self.handle.serve(&frame.view, &packet);
        let missed = if let Gap::Missed(missed) = frame.gap { missed } else { 0 };
        self.counts.add(&packet, missed);
        self.sequence = self.sequence.wrapping_add(1);
        self.last_us = Some(capture_us);
        self.notices.append(&mut source.take_notices());
        Ok(Step::Observed)
    }

    /// Where it is asked for pictures and taught anew while it works.
    #[must_use]
    pub fn handle(&self) -> CameraHandle {
        self.handle.clone()
    }

    /// What its tracker began with.
    #[must_use]
    pub const fn start(&self) -> &CameraStart {
        &self.start
    }

    /// What was known of its source when it was first opened.
    #[must_use]
    pub const fn info(&self) -> &SourceInfo {
        &self.info
    }

    /// Whether the camera is there.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.source.is_some()
    }

    /// What the operator should know and was not told yet: a camera lost or back, a changed rate.
    pub fn take_notices(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notices)
    }

    /// What was seen so far, and how long it took.
    #[must_use]
    pub const fn counts(&self) -> &CameraCounts {
        &self.counts
    }

    fn lose(&mut self, error: &SourceError) -> Step {
        if let Some(mut lost) = self.source.take() {
            self.notices.append(&mut lost.take_notices());
        }
        self.counts.lost += 1;
        tracing::warn!(camera = self.name, %error, "the camera is lost");
        self.notices.push(format!("{error}; it is lost, and opened again when it is back"));
        self.told.clear();
        self.fail()
    }

    fn fail(&mut self) -> Step {
        let now_us = self.clock.now_us();
        self.back_off.failed(now_us);
        Step::Lost(self.back_off.wait(now_us).unwrap_or_default())
    }

    fn open_again(&mut self) -> Step {
        if let Some(wait) = self.back_off.wait(self.clock.now_us()) {
            return Step::Lost(wait);
        }
        match (self.open)() {
            Ok(mut source) => {
                tracing::info!(camera = self.name, "the camera is back");
                self.notices.push(format!("{}: it is back", self.name));
                self.notices.append(&mut source.take_notices());
                self.source = Some(source);
                self.back_off = BackOff::default();
                Step::Lost(Duration::ZERO)
            }
            Err(error) => {
                let reason = error.to_string();
                if self.told != reason {
                    self.notices.push(format!("{reason}; it is tried again and again"));
                    self.told = reason;
                }
                self.fail()
            }
        }
    }
}

/// When a picture was taken, by the station's clock: as long ago as by the source's. Both clocks were
/// read together. `None` where the source's times are of no clock.
fn capture_us(t_s: f64, (here_us, there_s): (u64, Option<f64>)) -> Option<u64> {
    let later_us = (t_s - there_s?) * 1e6;
    // a picture from before the station's clock began is of its beginning
    Some((here_us as f64 + later_us).round() as u64)
}

/// What the tracker starts with. A scene's places are those of its own first picture, and that is not
/// the one it plays first.
fn start_of(camera: &LocalCamera, source: &mut dyn Source) -> Result<CameraStart, Failure> {
    let spec = &camera.source;
    let named = Named { name: camera.options.view.name(), source: spec };
    let start = match &camera.start {
        Known::Given(Start::Colours(colours)) => {
            let balls = colours.learnt_balls();
            let size = (source.info().width, source.info().height);
            crate::camera_start::fits(named, &balls, size)?;
            return Ok(CameraStart::anywhere(balls));
        }
        Known::Given(start) => start.clone(),
        Known::OfScene => Start::Seeds { seeds: seeds_of(camera)?, file: spec.clone() },
    };
    let simulated = matches!(Spec::parse(spec)?, Spec::Simulated { .. });
    let mut first = if simulated { Some(source::open(spec, &camera.options)?) } else { None };
    let teacher = first.as_deref_mut().unwrap_or(source);
    let picture = teacher.next()?.ok_or_else(|| {
        Failure::new(Exit::Failed, anyhow::anyhow!("{spec} has no picture to learn the balls from"))
    })?;
    let start = camera_start(named, &start, &picture.view)?;
    Ok(if simulated { CameraStart::anywhere(start.balls) } else { start })
}

/// Where a scene has its balls in its first picture.
fn seeds_of(camera: &LocalCamera) -> Result<[Option<ImagePoint>; BALLS], Failure> {
    let unknown = || Failure::bad_arguments(format!("{}: no scene that knows its balls", camera.source));
    let Spec::Simulated { name, .. } = Spec::parse(&camera.source)? else { return Err(unknown()) };
    let scene = Scene::named(&name).ok_or_else(unknown)?;
    let truth = scene.truth(0, camera.options.view.index());
    Ok(truth.map(|ball| {
        let (u, v) = ball.outline_centre;
        Some(ImagePoint::new(u.round() as f32, v.round() as f32))
    }))
}

#[cfg(test)]
mod tests;
