//! The cameras of the slave's scene: pictures for the operator, as JPEG, never at motion's cost.
//!
//! ```text
//!   slave's loop --joints--> | drawing of the arm  \
//!                            | or a camera's frame  > JPEG --> line: the newest of each camera waits
//!                  a thread a camera                /  ^
//!                                          quality, rate  <-- what the line says of itself
//! ```
//!
//! Each camera has a thread of its own. Nothing is made while nobody is there to see it, and nothing
//! queues: what was not sent when the next is there is overtaken by it.

use super::back_off::BackOff;
use super::jpeg::encode_jpeg;
use super::picture_rate::{LOOK_US, LineState, PictureRate};
use crate::link::local::LocalEnd;
use crate::link::{Carrier as _, Peer, Picture};
use crate::locked::lock;
use crate::precedence::step_back;
use crate::robot::clock::Clock;
use crate::settings::station::{SceneCamera, SceneCameraSettings};
use crate::source::simulated_arm::ArmDrawing;
use crate::source::{self, Source, SourceError};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::{PumaConfig, PumaConfigError};
use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// The size of a drawing where none is asked for.
const DRAWING: (u16, u16) = (640, 480);

/// The longest sleep, so that the end is heard of.
const NAP_US: u64 = 50_000;

/// Whom pictures go to.
pub trait PictureLine: Clone + Send + 'static {
    /// Whether anybody is there to see them.
    fn is_there(&self) -> bool;

    /// Hands a picture over; where one of its camera waits, it goes in its place.
    fn send(&self, picture: Picture);

    /// What the line says of itself.
    fn state(&self) -> LineState;
}

impl PictureLine for Peer {
    fn is_there(&self) -> bool {
        self.is_connected()
    }

    fn send(&self, picture: Picture) {
        // one that is too large is one that nobody sees; the next has less quality
        let _ = self.send_picture(&picture);
    }

    fn state(&self) -> LineState {
        let stats = self.stats();
        LineState {
            pictures_sent: stats.pictures_sent.sent,
            pictures_overtaken: stats.pictures_sent.overtaken,
            round_trip_us: stats.round_trip_us,
            packets_sent: stats.sent_packets,
            packets_lost: stats.lost_packets,
        }
    }
}

/// Within a process nothing is crowded.
impl PictureLine for LocalEnd {
    fn is_there(&self) -> bool {
        true
    }

    fn send(&self, picture: Picture) {
        self.send_picture(picture);
    }

    fn state(&self) -> LineState {
        LineState::default()
    }
}

/// Why there are no pictures of the scene.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// A camera cannot be opened.
    #[error("[[slave.camera]] {0} cannot be opened")]
    Source(usize, #[source] SourceError),
    /// The arm cannot be drawn.
    #[error("the arm cannot be drawn")]
    Arm(#[from] PumaConfigError),
    /// The system has no thread left.
    #[error("the thread of a camera of the scene cannot be started")]
    Thread(#[from] io::Error),
}

/// The cameras at work. Where it is dropped, their threads end.
#[derive(Debug)]
pub struct SceneCameras {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    clock: Clock,
    /// Where the joints were last measured, and when.
    joints: Mutex<Option<(Joints<f64>, u64)>>,
    rate: Mutex<(PictureRate, u64)>,
    notices: Mutex<Vec<String>>,
    over: AtomicBool,
    pictures: AtomicU64,
    bytes: AtomicU64,
    /// The lowest quality that was sent.
    lowest: AtomicU64,
}

impl SceneCameras {
    /// Starts a thread for each camera. Their pictures are of this session, counted from camera 0, with
    /// times of this clock.
    ///
    /// # Errors
    /// [`SceneError`]; a camera that goes away later is waited for instead.
    pub fn start<L: PictureLine>(
        cameras: &[SceneCameraSettings],
        puma: &PumaConfig,
        line: &L,
        session: u32,
        clock: &Clock,
    ) -> Result<Self, SceneError> {
        let best = cameras.iter().map(|camera| camera.quality).max().unwrap_or(100);
        let shared = Arc::new(Shared {
            clock: clock.clone(),
            joints: Mutex::new(None),
            rate: Mutex::new((PictureRate::new(best), 0)),
            notices: Mutex::default(),
            over: AtomicBool::new(false),
            pictures: AtomicU64::new(0),
            bytes: AtomicU64::new(0),
            lowest: AtomicU64::new(u64::from(best)),
        });
        // all are opened before any is at work
        let eyes = (0u8..).zip(cameras).map(|(number, camera)| Eye::open(number, camera, puma));
        let eyes = eyes.collect::<Result<Vec<_>, SceneError>>()?;
        let mut scene = Self { shared, threads: Vec::new() };
        for ((number, camera), eye) in (0u8..).zip(cameras).zip(eyes) {
            let worker = Worker {
                shared: Arc::clone(&scene.shared),
                line: line.clone(),
                number,
                session,
                sequence: 0,
                best: camera.quality,
                period_us: (1e6 / camera.fps.max(0.1)) as u64,
                due_us: 0,
                count: 0,
                jpeg: Vec::new(),
            };
            let thread = std::thread::Builder::new().name(format!("scene {number}"));
            scene.threads.push(thread.spawn(move || worker.run(eye))?);
        }
        Ok(scene)
    }

    /// The joints were measured to be here at `at_us`.
    pub fn arm_is_at(&self, joints: &Joints<f64>, at_us: u64) {
        *lock(&self.shared.joints) = Some((*joints, at_us));
    }

    /// What there is to tell of the cameras, once.
    #[must_use]
    pub fn take_notices(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.shared.notices))
    }

    /// Ends them; a line on what was sent, if there are any.
    #[must_use]
    pub fn end(mut self) -> Option<String> {
        let any = !self.threads.is_empty();
        self.stop();
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        let Shared { pictures, bytes, lowest, .. } = &*self.shared;
        let (pictures, kb, lowest) = (count(pictures), count(bytes) / 1000, count(lowest));
        any.then(|| format!("{pictures} of the scene made, {kb} kB, JPEG quality at least {lowest}"))
    }

    fn stop(&mut self) {
        self.shared.over.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // one that panicked has said so
            let _ = thread.join();
        }
    }
}

impl Drop for SceneCameras {
    fn drop(&mut self) {
        self.stop();
    }
}

impl Shared {
    fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    fn tell(&self, line: String) {
        lock(&self.notices).push(line);
    }

    /// The quality of the next picture, and how many of them are left out; looks at the line when it is
    /// time to.
    fn rate(&self, line: &impl PictureLine) -> PictureRate {
        let mut rate = lock(&self.rate);
        let now_us = self.clock.now_us();
        if now_us >= rate.1 {
            rate.1 = now_us + LOOK_US;
            rate.0.look(line.state());
        }
        rate.0
    }
}

/// Where a camera's pictures come from.
enum Eye {
    Drawing(Box<ArmDrawing>),
    Source { camera: SceneCameraSettings, spec: String, source: Option<Box<dyn Source>> },
}

impl Eye {
    fn open(number: u8, camera: &SceneCameraSettings, puma: &PumaConfig) -> Result<Self, SceneError> {
        match &camera.place {
            SceneCamera::SimulatedArm => {
                let size = camera.options.size.unwrap_or(DRAWING);
                Ok(Self::Drawing(Box::new(ArmDrawing::new(puma, camera.options.view, size)?)))
            }
            SceneCamera::Source(spec) => {
                let source = source::open_live(spec, &camera.options);
                let source = source.map_err(|error| SceneError::Source(usize::from(number) + 1, error))?;
                Ok(Self::Source { camera: camera.clone(), spec: spec.clone(), source: Some(source) })
            }
        }
    }
}

/// One camera's thread.
struct Worker<L> {
    shared: Arc<Shared>,
    line: L,
    number: u8,
    session: u32,
    sequence: u32,
    best: u8,
    period_us: u64,
    due_us: u64,
    /// Pictures that were due.
    count: u32,
    jpeg: Vec<u8>,
}

impl<L: PictureLine> Worker<L> {
    fn run(mut self, eye: Eye) {
        step_back();
        match eye {
            Eye::Drawing(drawing) => self.draw(*drawing),
            Eye::Source { camera, spec, source } => self.watch(&camera, &spec, source),
        }
    }

    fn draw(&mut self, mut drawing: ArmDrawing) {
        while !self.shared.is_over() {
            let now_us = self.shared.clock.now_us();
            if now_us < self.due_us {
                std::thread::sleep(Duration::from_micros((self.due_us - now_us).min(NAP_US)));
                continue;
            }
            let joints = *lock(&self.shared.joints);
            let Some(quality) = self.due(now_us) else { continue };
            let Some((joints, at_us)) = joints else { continue };
            let (width, height) = drawing.size();
            // a drawing has the size that was asked for, which two bytes hold
            let (width, height) = (u16::try_from(width).unwrap_or(0), u16::try_from(height).unwrap_or(0));
            let (rgb, stride) = (drawing.draw(&joints), 3 * usize::from(width));
            let Ok(view) = FrameView::new(rgb, width, height, stride, PixelFormat::Rgb888) else { continue };
            self.send(&view, at_us, quality);
        }
    }

    /// A camera; one that goes away is opened again.
    fn watch(&mut self, camera: &SceneCameraSettings, spec: &str, mut source: Option<Box<dyn Source>>) {
        let mut back_off = BackOff::default();
        while !self.shared.is_over() {
            let now_us = self.shared.clock.now_us();
            let Some(open) = &mut source else {
                if let Some(pause) = back_off.wait(now_us) {
                    std::thread::sleep(pause);
                    continue;
                }
                match source::open_live(spec, &camera.options) {
                    Ok(opened) => {
                        self.shared.tell(format!("scene: {spec} is back"));
                        (source, back_off) = (Some(opened), BackOff::default());
                    }
                    Err(_) => back_off.failed(now_us),
                }
                continue;
            };
            for notice in open.take_notices() {
                self.shared.tell(format!("scene: {spec}: {notice}"));
            }
            let before = open.now_s().map(|now_s| (now_s, self.shared.clock.now_us()));
            match open.next() {
                Ok(Some(frame)) => {
                    let now_us = self.shared.clock.now_us();
                    let capture_us = captured_us(before, frame.t_s, now_us);
                    if now_us < self.due_us {
                        continue;
                    }
                    let Some(quality) = self.due(now_us) else { continue };
                    self.send(&frame.view, capture_us, quality);
                }
                Ok(None) => return self.shared.tell(format!("scene: {spec} is over")),
                Err(error) => {
                    self.shared.tell(format!("scene: {error}; it is waited for"));
                    source = None;
                    back_off.failed(self.shared.clock.now_us());
                }
            }
        }
    }

    /// A picture is due; its quality, where it is to be made.
    fn due(&mut self, now_us: u64) -> Option<u8> {
        // what was left out is not made up for
        self.due_us = (self.due_us + self.period_us).max(now_us.saturating_sub(self.period_us / 2));
        let rate = self.shared.rate(&self.line);
        self.count = self.count.wrapping_add(1);
        let sent = self.line.is_there() && self.count.is_multiple_of(rate.every());
        sent.then(|| rate.quality().min(self.best))
    }

    fn send(&mut self, view: &FrameView<'_>, capture_us: u64, quality: u8) {
        self.jpeg.clear();
        if encode_jpeg(&mut self.jpeg, view, quality).is_err() {
            // a picture without pixels
            return;
        }
        self.shared.pictures.fetch_add(1, Ordering::Relaxed);
        self.shared.bytes.fetch_add(self.jpeg.len() as u64, Ordering::Relaxed);
        self.shared.lowest.fetch_min(u64::from(quality), Ordering::Relaxed);
        self.line.send(Picture {
            camera: self.number,
            session: self.session,
            sequence: self.sequence,
            capture_us,
            width: view.width(),
            height: view.height(),
            jpeg: self.jpeg.clone(),
        });
        self.sequence = self.sequence.wrapping_add(1);
    }
}

/// When a frame was taken, by our clock: `before` is a moment by the source's clock, seconds, and by ours.
/// A source without a clock gives its frames at once.
fn captured_us(before: Option<(f64, u64)>, t_s: f64, now_us: u64) -> u64 {
    let Some((present_s, present_us)) = before else { return now_us };
    let captured_us = present_us as f64 + (t_s - present_s) * 1e6;
    (captured_us.round().max(0.0) as u64).min(now_us)
}

#[cfg(test)]
mod tests;
