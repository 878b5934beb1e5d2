//! Pictures of the scene go to whoever is there, the newest only, with less quality where there is no room.

use super::*;
use crate::source::{Options, View};
use std::time::Instant;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;

const LONG: Duration = Duration::from_secs(60);

/// A line that keeps what it is given.
#[derive(Clone, Debug, Default)]
struct Kept(Arc<Mutex<Line>>);

#[derive(Debug, Default)]
struct Line {
    there: bool,
    state: LineState,
    /// Each look finds so many more overtaken.
    crowded: u64,
    pictures: Vec<Picture>,
}

impl PictureLine for Kept {
    fn is_there(&self) -> bool {
        lock(&self.0).there
    }

    fn send(&self, picture: Picture) {
        lock(&self.0).pictures.push(picture);
    }

    fn state(&self) -> LineState {
        let mut line = lock(&self.0);
        line.state.pictures_overtaken += line.crowded;
        line.state
    }
}

impl Kept {
    /// Waits for so many more pictures of a camera, and gives the last.
    #[track_caller]
    fn wait(&self, camera: u8, more: usize) -> Picture {
        lock(&self.0).pictures.clear();
        let began = Instant::now();
        loop {
            let line = lock(&self.0);
            let mut of_camera = line.pictures.iter().filter(|picture| picture.camera == camera);
            if let Some(last) = of_camera.nth(more - 1) {
                return last.clone();
            }
            drop(line);
            assert!(began.elapsed() < LONG, "no picture");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn camera(place: SceneCamera, view: View, fps: f64) -> SceneCameraSettings {
    SceneCameraSettings {
        place,
        options: Options { view, fps: Some(fps), ..Options::default() },
        fps,
        quality: 80,
    }
}

fn pixels(picture: &Picture) -> Vec<u8> {
    JpegDecoder::new(ZCursor::new(&picture.jpeg)).decode().unwrap()
}

const READY: Joints<f64> = [0.0, 0.8, -3.1, 0.0, 0.8, 0.0];

#[test]
fn both_eyes_see_the_arm_where_it_was_last_measured() {
    let line = Kept::default();
    lock(&line.0).there = true;
    let clock = Clock::wall();
    let cameras = [View::Left, View::Right].map(|view| camera(SceneCamera::SimulatedArm, view, 60.0));
    let scene = SceneCameras::start(&cameras, &PumaConfig::default(), &line, 9, &clock).unwrap();
    std::thread::sleep(Duration::from_millis(50));
    assert!(lock(&line.0).pictures.is_empty(), "nobody knows where the arm is");
    scene.arm_is_at(&READY, 1_234);
    let [left, right] = [0, 1].map(|camera| line.wait(camera, 2));
    assert_eq!((left.session, left.capture_us, left.width, left.height), (9, 1_234, 640, 480));
    let [left_pixels, right_pixels] = [&left, &right].map(pixels);
    assert_eq!(left_pixels.len(), 640 * 480 * 3);
    let apart = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>();
    assert!(apart(&left_pixels, &right_pixels) > 100_000);
    let mut drawing = ArmDrawing::new(&PumaConfig::default(), View::Left, (640, 480)).unwrap();
    let off = apart(&left_pixels, drawing.draw(&READY)) / (640 * 480 * 3);
    assert!(off < 4, "{off}");

    let mut moved = READY;
    moved[0] += 0.5;
    scene.arm_is_at(&moved, 5_678);
    // one may have been begun before
    let later = line.wait(0, 2);
    assert_eq!(later.capture_us, 5_678);
    assert!(apart(&pixels(&later), &left_pixels) > 100_000, "it has moved");
    assert!(later.sequence > left.sequence);
    let told = scene.end().unwrap();
    assert!(told.contains("JPEG quality at least 80"), "{told}");
}

#[test]
fn a_crowded_line_gets_smaller_pictures_and_one_where_nobody_is_gets_none() {
    let line = Kept::default();
    let clock = Clock::wall();
    let cameras = [camera(SceneCamera::SimulatedArm, View::Left, 60.0)];
    let scene = SceneCameras::start(&cameras, &PumaConfig::default(), &line, 9, &clock).unwrap();
    scene.arm_is_at(&READY, 0);
    std::thread::sleep(Duration::from_millis(100));
    assert!(lock(&line.0).pictures.is_empty(), "nobody is there");
    lock(&line.0).there = true;
    let best = line.wait(0, 2).jpeg.len();
    lock(&line.0).crowded = 10;
    let began = Instant::now();
    while line.wait(0, 1).jpeg.len() * 10 > best * 7 {
        assert!(began.elapsed() < LONG, "they do not get smaller");
    }
    drop(scene);
}

#[test]
fn a_frame_that_was_waited_for_is_as_old_as_its_camera_says() {
    assert_eq!(captured_us(Some((100.0, 5_000_000)), 100.02, 5_060_000), 5_020_000, "taken while waited for");
    assert_eq!(captured_us(Some((100.0, 5_000_000)), 99.9, 5_060_000), 4_900_000, "it lay there");
    assert_eq!(captured_us(Some((100.0, 5_000_000)), 101.0, 5_060_000), 5_060_000, "never in the future");
    assert_eq!(captured_us(None, 3.0, 5_060_000), 5_060_000);
}

#[test]
fn a_camera_of_the_scene_is_sent_as_it_is_and_one_that_is_none_is_refused() {
    let line = Kept::default();
    lock(&line.0).there = true;
    let clock = Clock::wall();
    let still = || SceneCamera::Source("sim:still".to_owned());
    let cameras = [camera(still(), View::Right, 20.0)];
    let scene = SceneCameras::start(&cameras, &PumaConfig::default(), &line, 9, &clock).unwrap();
    let picture = line.wait(0, 2);
    assert_eq!(pixels(&picture).len(), usize::from(picture.width) * usize::from(picture.height) * 3);
    let age_us = clock.now_us().saturating_sub(picture.capture_us);
    assert!(age_us < LONG.as_micros() as u64, "{age_us}");
    drop(scene);
    let wrong = [
        camera(still(), View::Left, 20.0),
        camera(SceneCamera::Source("/no/camera".to_owned()), View::Right, 20.0),
    ];
    let error = SceneCameras::start(&wrong, &PumaConfig::default(), &line, 9, &clock).unwrap_err();
    assert_eq!(error.to_string(), "[[slave.camera]] 2 cannot be opened");
}
