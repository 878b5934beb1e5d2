use super::*;
use crate::settings::Mode;
use crate::source::{Frame, Labels, Options, SourceInfo, View};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use tetrad_core::observation::ObservationState;
use tetrad_core::vision::frame::PixelFormat;

const LABEL: Label = Label { camera: 2, session: 77 };
const PERIOD_US: u64 = 20_000;

/// What a camera in memory does next.
#[derive(Clone, Copy)]
enum Act {
    /// Frame n of the scene.
    Show(usize),
    /// A picture without a hand.
    Nothing,
    /// The frame, so many after the one before.
    Skip(usize, u64),
    Fail,
}

/// A camera whose clock is an hour ahead of the station's.
struct Memory {
    info: SourceInfo,
    scene: Scene,
    acts: Arc<Mutex<VecDeque<Act>>>,
    clock: Clock,
    pixels: Vec<u8>,
    number: u64,
}

const AHEAD_US: u64 = 3_600_000_000;
/// From the exposure until the picture is in memory.
const READY_US: u64 = 700;

impl Source for Memory {
    fn info(&self) -> &SourceInfo {
        &self.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        let Some(act) = self.acts.lock().unwrap().pop_front() else { return Ok(None) };
        let missed = if let Act::Skip(_, missed) = act { missed } else { 0 };
        match act {
            Act::Fail => {
                let reason = "the camera went away".to_owned();
                return Err(SourceError::DeviceLost { device: self.info.name.clone(), reason });
            }
            Act::Show(frame) | Act::Skip(frame, _) => self.scene.render_rgb(frame, 0, &mut self.pixels),
            Act::Nothing => self.pixels.fill(90),
        }
        self.clock.set(self.clock.now_us() + PERIOD_US * (1 + missed));
        let exposed_us = self.clock.now_us() - READY_US;
        let SourceInfo { width, height, format, .. } = self.info;
        let view = FrameView::packed(&self.pixels, width, height, format).unwrap();
        let index = self.number;
        self.number += 1;
        let gap = if missed > 0 { Gap::Missed(missed) } else { Gap::None };
        let t_s = (exposed_us + AHEAD_US) as f64 * 1e-6;
        Ok(Some(Frame { view, index, number: index, t_s, gap }))
    }

    fn now_s(&self) -> Option<f64> {
        Some((self.clock.now_us() + AHEAD_US) as f64 * 1e-6)
    }
}

/// A station whose camera does this, and opens again with these answers.
fn station(acts: &[Act], live: bool, openings: Vec<Result<(), &'static str>>) -> (CameraStation, Clock) {
    let scene = Scene::named("linear-0.25-30fps").unwrap();
    let clock = Clock::given();
    clock.set(1_000_000);
    let acts = Arc::new(Mutex::new(acts.iter().copied().collect::<VecDeque<_>>()));
    let info = SourceInfo {
        name: "/dev/video9".to_owned(),
        width: scene.width,
        height: scene.height,
        format: PixelFormat::Rgb888,
        fps: Some(50.0),
        frames: None,
        live,
        labels: Labels::Order,
    };
    let source = {
        let (scene, clock, info) = (scene.clone(), clock.clone(), info.clone());
        move || {
            let (scene, clock, info) = (scene.clone(), clock.clone(), info.clone());
            Memory { info, scene, acts: Arc::clone(&acts), clock, pixels: Vec::new(), number: 0 }
        }
    };
    let known = LocalCamera {
        source: "sim:linear-0.25-30fps".to_owned(),
        options: Options::default(),
        start: Known::OfScene,
        focal_px: None,
        mode: Mode::Refined,
    };
    let mut first = source();
    let start = start_of(&known, &mut first).unwrap();
    let mut openings = VecDeque::from(openings);
    let open: Opener = {
        let source = source.clone();
        Box::new(move || match openings.pop_front() {
            Some(Ok(())) => Ok(Box::new(source())),
            Some(Err(reason)) => {
                Err(SourceError::DeviceLost { device: "/dev/video9".to_owned(), reason: reason.to_owned() })
            }
            None => panic!("opened once too often"),
        })
    };
    let config = known.mode.pipeline().tracker;
    let station = CameraStation::of(Box::new(first), open, &start, config, LABEL, clock.clone()).unwrap();
    (station, clock)
}

/// Steps until the recording ends; the packets, and how often the station found the camera lost.
fn run(station: &mut CameraStation, clock: &Clock) -> (Vec<ObservationPacket>, u32) {
    let (mut packets, mut lost) = (Vec::new(), 0);
    let mut sink = |packet: &ObservationPacket| packets.push(*packet);
    for _ in 0..10_000 {
        match station.step(&mut sink).unwrap() {
            Step::Observed => {}
            Step::Lost(wait) => {
                lost += 1;
                clock.set(clock.now_us() + wait.as_micros() as u64);
            }
            Step::Ended => return (packets, lost),
        }
    }
    panic!("it does not end");
}

fn seen(packet: &ObservationPacket) -> usize {
    packet.balls.iter().filter(|ball| ball.state == ObservationState::Visible).count()
}

#[test]
fn observations_carry_when_the_picture_was_taken_by_the_stations_clock() {
    let acts: Vec<_> = (0..5).map(Act::Show).chain([Act::Skip(7, 2)]).collect();
    let (mut station, clock) = station(&acts, true, vec![]);
    let (packets, lost) = run(&mut station, &clock);
    assert_eq!((packets.len(), lost), (6, 0));
    for (number, packet) in (0_u32..).zip(&packets) {
        assert_eq!((packet.camera, packet.session, packet.sequence), (2, 77, number));
        assert_eq!((packet.width, packet.height), (640, 480));
        let since = if number == 5 { 8 } else { u64::from(number) + 1 };
        let expected_us = 1_000_000 + since * PERIOD_US - READY_US;
        assert!(packet.capture_us.abs_diff(expected_us) <= 1, "{number}: {}", packet.capture_us);
        assert!(packet.ready_us.abs_diff(READY_US as u32) <= 1 && packet.observed_us >= packet.ready_us);
        assert_eq!(seen(packet), BALLS, "{packet:?}");
        assert!(packet.pixels_tested > 0);
    }
    assert_eq!((station.counts().frames, station.counts().missed), (6, 2));
    assert_eq!(station.counts().balls, [[6, 0, 0, 0]; BALLS]);
}

#[test]
fn balls_that_were_lost_are_searched_for_and_found_elsewhere() {
    let mut acts = vec![Act::Show(0), Act::Show(1)];
    acts.extend([Act::Nothing; 60]);
    // the hand has gone 0.25 m meanwhile
    acts.extend((30..36).map(Act::Show));
    let (mut station, clock) = station(&acts, true, vec![]);
    let (packets, _) = run(&mut station, &clock);
    assert!(packets[61].balls.iter().all(|ball| ball.state == ObservationState::Lost));
    let scene = Scene::named("linear-0.25-30fps").unwrap();
    for (packet, frame) in packets[64..].iter().zip(32..) {
        assert_eq!(seen(packet), BALLS, "frame {frame}: {packet:?}");
        for (ball, truth) in packet.balls.iter().zip(scene.truth(frame, 0)) {
            let (u, v) = truth.outline_centre;
            assert!((f64::from(ball.centre.u) - u).hypot(f64::from(ball.centre.v) - v) < 0.5, "{ball:?}");
        }
    }
}

#[test]
fn a_camera_that_goes_away_is_opened_again_and_told_of() {
    let acts = [Act::Show(0), Act::Fail, Act::Show(20), Act::Show(21), Act::Show(22)];
    let missing = "no such camera: plug it in";
    let openings = vec![Err(missing), Err(missing), Err("in use by another program"), Ok(())];
    let (mut station, clock) = station(&acts, true, openings);
    let began_us = clock.now_us();
    let (packets, lost) = run(&mut station, &clock);
    assert_eq!(packets.len(), 4);
    assert_eq!(packets[3].sequence, 3, "the numbers go on");
    assert_eq!(seen(&packets[3]), BALLS, "it knows its balls");
    assert!(station.is_open() && station.counts().lost == 1);
    // 0.1 + 0.2 + 0.4 + 0.8 s, and four pictures
    let took_ms = (clock.now_us() - began_us) / 1_000;
    assert!((1_500..1_700).contains(&took_ms) && lost >= 30, "{took_ms} ms, {lost}");
    let told = station.take_notices();
    assert_eq!(told.len(), 4, "{told:#?}");
    for (line, words) in told.iter().zip(["went away", missing, "in use", "it is back"]) {
        assert!(line.contains("/dev/video9") && line.contains(words), "{line}");
    }
    assert!(station.take_notices().is_empty());
}

/// What a camera tells, in order.
#[derive(Default)]
struct Told {
    orders: Vec<(Order, u32, u64)>,
    /// How many orders came before each picture.
    pictures: Vec<usize>,
}

impl CameraSink for Told {
    fn observed(&mut self, packet: &ObservationPacket) {
        assert_eq!(packet.sequence as usize, self.pictures.len());
        self.pictures.push(self.orders.len());
    }

    fn taught(&mut self, order: &Order, from: u32, now_us: u64) {
        self.orders.push((*order, from, now_us));
    }
}

#[test]
fn what_it_is_taught_is_told_before_the_first_picture_that_is_looked_at_so() {
    let acts: Vec<_> = (0..5).map(Act::Show).collect();
    let (mut station, clock) = station(&acts, true, vec![]);
    let mut told = Told::default();
    let handle = station.handle();
    let known = station.start().balls;
    let [red, ..] = known;
    for at in 0..5 {
        match at {
            // of two at once the last counts
            2 => [known, [red, None, None, None]].iter().for_each(|balls| handle.teach(balls).unwrap()),
            4 => handle.teach(&known).unwrap(),
            _ => {}
        }
        let before_us = clock.now_us();
        assert_eq!(station.step(&mut told).unwrap(), Step::Observed);
        assert!(told.orders.iter().all(|(_, from, us)| *from < at || *us == before_us), "{at}");
    }
    assert_eq!(told.pictures, [0, 0, 1, 1, 2]);
    let [(one, from_one, _), (all, from_all, _)] = told.orders.as_slice() else { panic!("two orders") };
    assert_eq!((*from_one, *from_all), (2, 4));
    assert_eq!((one.balls, one.config.rigid), ([red, None, None, None], false));
    assert_eq!((all.balls, all.config.rigid), (known, true));
    assert_eq!(TrackerConfig { rigid: true, ..one.config }, all.config, "all else is the camera's own");
}

#[test]
fn a_recording_that_cannot_be_read_on_ends_the_station() {
    let (mut station, _) = station(&[Act::Show(0), Act::Fail], false, vec![]);
    let mut count = 0;
    let mut sink = |_: &ObservationPacket| count += 1;
    assert_eq!(station.step(&mut sink).unwrap(), Step::Observed);
    let failure = station.step(&mut sink).unwrap_err();
    assert!(failure.to_string().contains("went away"), "{failure}");
    assert_eq!(count, 1);
}

#[test]
fn times_of_another_clock_become_the_stations() {
    assert_eq!(capture_us(10.0, (5_000_000, None)), None);
    assert_eq!(capture_us(10.25, (5_000_000, Some(10.0))), Some(5_250_000));
    assert_eq!(capture_us(9.5, (5_000_000, Some(10.0))), Some(4_500_000));
    assert_eq!(capture_us(1.0, (5_000_000, Some(10.0))), Some(0), "before the clock began");
}

#[test]
fn a_scene_is_opened_in_real_time_and_knows_its_balls() {
    let camera = LocalCamera {
        source: "sim:static-16px?format=yuyv".to_owned(),
        options: Options { view: View::Right, fps: Some(10.0), ..Options::default() },
        start: Known::OfScene,
        focal_px: None,
        mode: Mode::Refined,
    };
    let station = CameraStation::open(&camera, LABEL, Clock::wall()).unwrap();
    let (rung, rings) = std::sync::mpsc::channel();
    let thread = CameraThread::start(station, move || rung.send(()).unwrap(), Vec::new()).unwrap();
    let mut last = None;
    for _ in 0..5 {
        rings.recv_timeout(Duration::from_secs(60)).unwrap();
        if let Some(newest) = thread.observation() {
            assert_eq!(newest.captured_us, Some(newest.what.capture_us));
            assert!(last < newest.captured_us && newest.received_us >= newest.what.capture_us);
            last = newest.captured_us;
        }
    }
    assert!(last.is_some() && !thread.is_over());
    let (counts, ended) = thread.end();
    ended.unwrap();
    assert!(counts.frames >= 5, "{counts:?}");
    let whole: Vec<_> = counts.balls.iter().map(|states| states[0]).collect();
    assert_eq!(whole, [counts.frames; BALLS], "{counts:?}");
}

#[test]
fn what_cannot_be_opened_or_taught_is_refused_at_once() {
    let camera = |source: &str, start| LocalCamera {
        source: source.to_owned(),
        options: Options::default(),
        start,
        focal_px: None,
        mode: Mode::Paper,
    };
    let refused = |camera: &LocalCamera| {
        let failure = CameraStation::open(camera, LABEL, Clock::given()).err().unwrap();
        (failure.exit, failure.to_string())
    };
    let (exit, message) = refused(&camera("sim:nothing", Known::OfScene));
    assert!(exit == Exit::BadArguments && message.contains("no scene is called 'nothing'"), "{message}");
    let seeds = [Some(ImagePoint::new(5_000.0, 5.0)), None, None, None];
    let start = Known::Given(Start::Seeds { seeds, file: "scene.json".to_owned() });
    let (exit, message) = refused(&camera("sim:still?format=rgb", start));
    assert!(exit == Exit::BadArguments && message.contains("seeds.left.red"), "{message}");
}
