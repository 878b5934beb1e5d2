//! Promise: a recorded session replays to the same observations and poses, bit by bit, in debug and in
//! release builds; what was changed in it is noticed; and readers that others wrote open it.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test session` rewrites hil-fixtures/data/session.txt.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use tetrad::learning;
use tetrad::pipeline::{CameraStart, Pipeline};
use tetrad::session::schema::tetrad::{Chain, Colour, Hand, HandBegins, LearntBall, Observations, Taught};
use tetrad::session::{
    Beginning, CameraBeginning, Outcome, Pictures, Reader, SessionError, Steps, Tape, Topic, replay,
};
use tetrad::settings::Mode;
use tetrad::source::{Frame, SimulatedSource, Source, View};
use tetrad_core::config::{FilterConfig, LearnConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::{Scene, golden};
use tetrad_tests::{peers, skip};

const SCENE: &str = "linear-0.25-10fps";
const VIEWS: [View; 2] = [View::Left, View::Right];

fn source(view: View, format: PixelFormat, seconds: f64) -> SimulatedSource {
    SimulatedSource::open(SCENE, SCENE, view, format).unwrap().lasting(seconds)
}

/// What both cameras start with, as somebody teaches it who points at the balls.
fn starts(format: PixelFormat) -> Vec<CameraStart> {
    let scene = Scene::named(SCENE).unwrap();
    let taught = VIEWS.map(|view| {
        let mut source = source(view, format, 1.0);
        let points = scene.truth(0, view.index()).map(|ball| {
            let (u, v) = ball.outline_centre;
            Some(ImagePoint::new(u.round() as f32, v.round() as f32))
        });
        let frame = source.next().unwrap().unwrap();
        learning::start_with(&learning::learn_at(&frame.view, &points, &LearnConfig::default()).unwrap())
    });
    taught.to_vec()
}

/// Records the scene for so many simulated seconds.
fn record(path: &Path, format: PixelFormat, seconds: f64) {
    let scene = Scene::named(SCENE).unwrap();
    let arm_m = scene.arm_m as f32;
    let starts = starts(format);
    let mode = Mode::Refined;
    let cameras = VIEWS.iter().zip(&starts).map(|(view, start)| CameraBeginning {
        name: view.name().to_owned(),
        source: format!("sim:{SCENE}"),
        pictures: Some(Pictures { size: (scene.width, scene.height), format, fps: Some(scene.fps) }),
        start: *start,
        mode,
        rigid: true,
    });
    let beginning = Beginning {
        chain: Chain::Pairs,
        mode,
        epoch_us: 0,
        arm_m: Some(arm_m),
        filter: FilterConfig::default(),
        cameras: cameras.collect(),
    };
    let mut pipeline = Pipeline::new(&starts, mode.pipeline(), Some(Arms::equal(arm_m).unwrap()))
        .unwrap()
        .with_filter(PoseFilter::new(beginning.filter).unwrap());
    let tape = Tape::start(path, &beginning.message()).unwrap();
    let steps = Steps::new(tape.feed().clone(), beginning.names());
    let [mut left, mut right] = VIEWS.map(|view| source(view, format, seconds));
    while let (Some(left), Some(right)) = (left.next().unwrap(), right.next().unwrap()) {
        let timed = [left, right].map(|frame: Frame<'_>| (frame, (frame.t_s * 1e6).round() as u64));
        let views = timed.map(|(frame, t_us)| (frame.view, t_us));
        let step = pipeline.step(&views);
        assert!(steps.step(&timed, &step));
    }
    assert!(tape.finish(BTreeMap::new()).unwrap().left_out.is_empty());
}

fn replayed(path: &Path) -> Result<Outcome, SessionError> {
    replay(&mut Reader::open(path)?, |_| Ok(()))
}

#[test]
fn sixty_seconds_replay_to_the_same_bits_in_every_build() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("session.mcap");
    // of the formats the one with the fewest bytes
    record(&path, PixelFormat::Nv12, 60.0);
    let outcome = replayed(&path).unwrap();
    assert!(outcome.is_identical() && !outcome.cut && outcome.notes.is_empty(), "{outcome:?}");
    assert_eq!(outcome.pictures, 1_200);
    for compared in &outcome.compared {
        assert_eq!(compared.count, 600, "{compared:?}");
        let name = compared.what.replace(' ', "-");
        golden::check(&golden::data("session.txt"), &name, compared.recorded)
            .unwrap_or_else(|e| panic!("{e}"));
    }
    assert_eq!(outcome.compared.len(), 3, "two cameras and the hand");
}

/// The same session with one of its pictures changed by `change`, its check sums right again.
fn rewritten(from: &Path, to: &Path, frame: u32, change: impl Fn(&mut Vec<u8>)) {
    let mut reader = Reader::open(from).unwrap();
    let tape = Tape::start(to, &reader.beginning().message()).unwrap();
    while let Some(entry) = reader.next_entry().unwrap() {
        let mut bytes = entry.bytes;
        if entry.topic == Topic::Image(1) && entry.sequence == frame {
            change(&mut bytes);
        }
        tape.feed().put(entry.topic, entry.time_us, entry.sequence, |into| into.append(&mut bytes));
    }
    tape.finish(BTreeMap::new()).unwrap();
}

#[test]
fn a_picture_that_is_another_gives_another_result_and_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let [path, other] = ["a.mcap", "b.mcap"].map(|name| dir.path().join(name));
    record(&path, PixelFormat::Rgb888, 1.0);
    rewritten(&path, &other, 3, |_| ());
    let same = replayed(&other).unwrap();
    assert!(same.is_identical(), "{same:?}");
    assert_eq!(same.compared, replayed(&path).unwrap().compared);
    // the whole picture a shade darker: the balls' colours with it
    rewritten(&path, &other, 3, |bytes| bytes.iter_mut().skip(200).for_each(|b| *b = b.saturating_sub(30)));
    let changed = replayed(&other).unwrap();
    assert!(!changed.is_identical());
    let [left, right, poses] = changed.compared.as_slice() else { panic!("{changed:?}") };
    let first = right.first.as_ref().expect("the right camera sees something else");
    assert!(first.starts_with("frame 3 (0.300000 s)"), "{first}");
    assert!(poses.first.as_ref().is_some_and(|first| first.starts_with("frame 3 ")), "{poses:?}");
    assert_ne!(right.recorded, right.replayed);
    assert_eq!(left.recorded, same.compared[0].recorded, "what was recorded is what it was");
}

/// The same session, as if something had been set up at its end.
fn set_up_at_the_end(from: &Path, to: &Path) {
    let mut reader = Reader::open(from).unwrap();
    let tape = Tape::start(to, &reader.beginning().message()).unwrap();
    let mut time_us = 0;
    while let Some(entry) = reader.next_entry().unwrap() {
        let mut bytes = entry.bytes;
        time_us = entry.time_us;
        tape.feed().put(entry.topic, time_us, entry.sequence, |into| into.append(&mut bytes));
    }
    let colour = Some(Colour { r: 200, g: 30, b: 40 });
    let (ball, aspect, diameter_px) = ("red".to_owned(), 1.0, 20.5);
    let (reference, typical, background) = (colour, colour, colour);
    let red = LearntBall {
        ball,
        primary: 1,
        reference,
        typical,
        background,
        diameter_px,
        aspect,
        ..LearntBall::default()
    };
    let taught = Taught { frame: 10, time_us, rigid: false, balls: vec![red] };
    tape.feed().insist(Topic::Taught(0), time_us, 10, &taught);
    let begins = HandBegins { frame: 10, time_us, arms_m: vec![0.08, 0.08, 0.09] };
    tape.feed().insist(Topic::HandBegins, time_us, 10, &begins);
    tape.finish(BTreeMap::new()).unwrap();
}

#[test]
fn others_read_every_channel() {
    let Some(python) = peers::python() else {
        skip("session::others_read_every_channel", peers::MISSING);
        return;
    };
    let dir = tempfile::tempdir().unwrap();
    let [recorded, path] = ["recorded.mcap", "session.mcap"].map(|name| dir.path().join(name));
    record(&recorded, PixelFormat::Rgb888, 1.0);
    set_up_at_the_end(&recorded, &path);
    let script = tetrad_tests::repository().join("tests/scripts/mcap_check.py");
    let run = Command::new(python).arg(script).arg(&path).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let said: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();

    let mut reader = Reader::open(&path).unwrap();
    let names = reader.names().to_vec();
    let mut counts: BTreeMap<String, u64> = BTreeMap::from([("/configuration".to_owned(), 1)]);
    let (mut balls, mut hands, mut firsts) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(entry) = reader.next_entry().unwrap() {
        *counts.entry(entry.topic.name(&names)).or_default() += 1;
        match entry.topic {
            Topic::Observations(0) => {
                let seen: Observations = reader.decode(&entry).unwrap();
                balls.push(seen.balls.first().map(|red| (red.u, red.v)).unwrap());
            }
            Topic::Hand => {
                let hand: Hand = reader.decode(&entry).unwrap();
                hands.push(hand.pose.map(|pose| pose.translation).unwrap());
            }
            Topic::Image(0) => firsts.push(entry.bytes),
            _ => {}
        }
    }
    let channels = said["channels"].as_object().unwrap();
    assert_eq!(channels.keys().collect::<Vec<_>>(), counts.keys().collect::<Vec<_>>());
    for (topic, count) in &counts {
        assert_eq!(channels[topic]["decoded"].as_u64(), Some(*count), "{topic}");
    }
    assert_eq!((counts["/left/image"], counts["/hand"]), (10, 10));
    assert_eq!((counts["/left/taught"], counts["/hand/begins"]), (1, 1));
    let number = |value: &serde_json::Value| value.as_f64().unwrap() as f32;
    for (at, (u, v)) in balls.iter().enumerate() {
        let red = &said["red"][at];
        assert_eq!((number(&red[0]), number(&red[1])), (*u, *v), "frame {at}");
    }
    for (at, place) in hands.iter().enumerate() {
        let theirs: Vec<f32> = said["hand"][at].as_array().unwrap().iter().map(number).collect();
        assert_eq!(&theirs, place, "frame {at}");
    }
    let picture = &said["picture"];
    assert_eq!(picture["size"], serde_json::json!([640, 480, "rgb8", 1920]));
    let last: Vec<u64> = picture["last"].as_array().unwrap().iter().filter_map(|b| b.as_u64()).collect();
    let pixels = firsts.last().unwrap();
    let ours: Vec<u64> = pixels.iter().rev().take(3).rev().map(|byte| u64::from(*byte)).collect();
    assert_eq!(last, ours, "the last pixel of the last picture");
    assert_eq!(said["foxglove"].as_u64(), Some(16), "schemas of Foxglove that are Foxglove's own");
}
