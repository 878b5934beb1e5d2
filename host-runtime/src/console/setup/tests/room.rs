//! Two cameras that see the four balls, and the console's routes.

use super::super::*;
use crate::console::access::Access;
use crate::console::app::app;
use crate::console::snapshot::{ArmView, Snapshot};
use crate::console::{Desk, ViewKind};
use crate::learning::{learn_at, tracked_as};
use crate::link::Doorbell;
use crate::pipeline::CameraStart;
use crate::robot::clock::Clock;
use crate::source::{Frame, Gap, Labels, Source, SourceError, SourceInfo};
use crate::station::camera::Taught;
use crate::station::{CameraStation, CameraThread, Label};
use axum::body::{Body, to_bytes};
use axum::http::{Method, Request, StatusCode};
use serde_json::Value;
use std::sync::atomic::AtomicBool;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::BALLS;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{ArmReason, ArmState};
use tetrad_fixtures::{Scene, packets};
use tower::ServiceExt as _;

/// A camera before which nothing moves.
struct Standing {
    info: SourceInfo,
    rgb: Vec<u8>,
    /// The same with a palm close before it.
    covered: Vec<u8>,
    number: u64,
    palm: Arc<Palm>,
}

/// A hand before a camera, or not.
#[derive(Default)]
struct Palm {
    covers: AtomicBool,
    /// Pictures that were taken so far.
    taken: AtomicU64,
}

impl Source for Standing {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        std::thread::sleep(Duration::from_millis(2));
        self.number += 1;
        self.palm.taken.fetch_add(1, Ordering::SeqCst);
        let SourceInfo { width, height, format, .. } = self.info;
        let seen = if self.palm.covers.load(Ordering::SeqCst) { &self.covered } else { &self.rgb };
        let view = FrameView::packed(seen, width, height, format).unwrap();
        let (index, t_s) = (self.number, self.number as f64 * 2e-3);
        Ok(Some(Frame { view, index, number: index, t_s, gap: Gap::None }))
    }
}

/// What is seen of a palm, red, green and blue.
const PALM: [u8; 3] = [180, 140, 120];

const NAMES: [&str; 2] = ["left", "right"];

/// Two cameras that see the four balls, and the console's routes.
pub(super) struct Room {
    pub(super) desk: Desk,
    pub(super) clock: Clock,
    /// Where the balls are in each camera.
    pub(super) places: Vec<[ImagePoint; BALLS]>,
    pub(super) dir: tempfile::TempDir,
    pub(super) threads: Vec<CameraThread>,
    palms: Vec<Arc<Palm>>,
}

pub(super) fn room() -> Room {
    let scene = Scene::named("static-32px").unwrap();
    let dir = tempfile::tempdir().unwrap();
    let (clock, desk) = desk();
    let (mut threads, mut cameras, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let mut palms = Vec::new();
    for (index, name) in NAMES.into_iter().enumerate() {
        let at = scene.truth(0, index).map(|ball| {
            let (u, v) = ball.outline_centre;
            ImagePoint::new(u as f32, v as f32)
        });
        let (source, balls) = standing(&scene, index, name, &at);
        let palm = Arc::new(Palm::default());
        let source = Box::new(Standing { palm: Arc::clone(&palm), ..source });
        palms.push(palm);
        let start = CameraStart::anywhere(balls);
        let label = Label { camera: index as u8, session: 1 };
        let open = Box::new(|| panic!("it is opened once"));
        let station = CameraStation::of(source, open, &start, TrackerConfig::paper(), label, clock.clone());
        let thread = CameraThread::start(station.unwrap(), || {}, Vec::new()).unwrap();
        // the right one has no file
        let file = (index == 0).then(|| dir.path().join("colours-left.toml"));
        let place = SetUpPlace::Here { handle: thread.handle().clone(), source: name.to_owned(), file };
        cameras.push(SetUpCamera { name: name.to_owned(), place });
        threads.push(thread);
        places.push(at);
    }
    cameras.push(SetUpCamera {
        name: "far".to_owned(),
        place: SetUpPlace::Elsewhere("it is at another computer"),
    });
    desk.set_up_with(SetUp::new(cameras, 0.08, None));
    Room { desk, clock, places, dir, threads, palms }
}

pub(super) fn desk() -> (Clock, Desk) {
    let clock = Clock::given();
    let views = NAMES.map(|name| (name.to_owned(), ViewKind::Hand)).into();
    let desk = Desk::new(true, views, clock.clone(), Doorbell::default());
    (clock, desk)
}

fn standing(scene: &Scene, camera: usize, name: &str, at: &[ImagePoint; BALLS]) -> (Standing, Taught) {
    let mut rgb = Vec::new();
    scene.render_rgb(0, camera, &mut rgb);
    let (width, height, format) = (scene.width, scene.height, PixelFormat::Rgb888);
    let frame = FrameView::packed(&rgb, width, height, format).unwrap();
    let taught = learn_at(&frame, &at.map(Some), &LearnConfig::default()).unwrap();
    let balls = taught.map(|learnt| learnt.as_ref().map(tracked_as));
    let info = SourceInfo {
        name: name.to_owned(),
        width,
        height,
        format,
        fps: None,
        frames: None,
        live: true,
        labels: Labels::Order,
    };
    let covered = PALM.repeat(rgb.len() / 3);
    (Standing { info, rgb, covered, number: 0, palm: Arc::default() }, balls)
}

impl Room {
    pub(super) async fn bytes(&self, method: Method, path: &str, body: String) -> (StatusCode, Vec<u8>) {
        bytes(&self.desk, method, path, body).await
    }

    pub(super) async fn get(&self, path: &str) -> (StatusCode, Value) {
        let (status, bytes) = self.bytes(Method::GET, path, String::new()).await;
        (status, serde_json::from_slice(&bytes).unwrap_or(Value::Null))
    }

    pub(super) async fn post(&self, path: &str, body: Value) -> (StatusCode, Value) {
        let (status, bytes) = self.bytes(Method::POST, path, body.to_string()).await;
        (status, serde_json::from_slice(&bytes).unwrap_or(Value::Null))
    }

    /// What is asked for is done.
    pub(super) async fn done(&self, path: &str, body: Value) -> Value {
        let (status, told) = self.post(path, body).await;
        assert_eq!(status, StatusCode::OK, "{path}: {told}");
        told
    }

    /// Why what is asked for is not done.
    #[track_caller]
    pub(super) fn why((status, told): (StatusCode, Value), expected: StatusCode) -> String {
        assert_eq!(status, expected, "{told}");
        told["why"].as_str().expect("words").to_owned()
    }

    /// A palm is before both cameras from the next pictures on, or no more.
    pub(super) fn cover(&self, covers: bool) {
        for palm in &self.palms {
            palm.covers.store(covers, Ordering::SeqCst);
            // the one that is looked at now may be of before
            let before = palm.taken.load(Ordering::SeqCst);
            while palm.taken.load(Ordering::SeqCst) < before + 2 {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
    }

    pub(super) fn taught(&self, camera: usize) -> Taught {
        self.threads[camera].handle().taught()
    }

    pub(super) fn engage(&self) {
        self.engaged(0);
    }

    /// The arm follows, as far as was heard so long ago.
    pub(super) fn engaged(&self, age_us: u64) {
        let packet = packets::arm_state(ArmState::Engaged, ArmReason::None);
        let arm = Some(ArmView::of(&packet, 0, true, age_us));
        self.desk.publish(Snapshot { arm, ..Snapshot::default() });
    }
}

pub(super) async fn bytes(desk: &Desk, method: Method, path: &str, body: String) -> (StatusCode, Vec<u8>) {
    let request = Request::builder().method(method).uri(path).header("host", "127.0.0.1:8080");
    let request = request.body(Body::from(body)).unwrap();
    let answer = app(desk.clone(), Access::loopback(), None).oneshot(request).await.unwrap();
    let status = answer.status();
    (status, to_bytes(answer.into_body(), 1 << 24).await.unwrap().to_vec())
}
