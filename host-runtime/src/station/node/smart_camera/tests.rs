//! A smart camera without its board at the other end of a pseudo terminal, and a line that loses frames.

use super::*;
use serialport::TTYPort;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{MAX_FRAME_LEN, encode};

const WIDTH: u16 = 160;
const HEIGHT: u16 = 120;

const AT: ImagePoint = ImagePoint { u: 80.0, v: 60.0 };

/// A red disc of 20 px before grey.
fn picture() -> Vec<u8> {
    let pixel = |index: i32| {
        let (x, y) = (index % i32::from(WIDTH), index / i32::from(WIDTH));
        let (du, dv) = (x - 80, y - 60);
        if du * du + dv * dv <= 100 { [200, 36, 40] } else { [70, 72, 74] }
    };
    (0..i32::from(WIDTH) * i32::from(HEIGHT)).flat_map(pixel).collect()
}

/// The camera, with a picture every few milliseconds.
struct Board {
    device: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// The terminal lives while this is open.
    _slave: TTYPort,
}

impl Board {
    /// Every so many frames the line loses one, each way; none where that is 0.
    fn start(loses: u32, session: impl Fn(u32) -> u32 + Send + 'static) -> Self {
        let (mut master, slave) = TTYPort::pair().unwrap();
        let device = slave.name().unwrap().into();
        master.set_timeout(Duration::from_millis(2)).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let (tracker, learn) = (TrackerConfig::default(), LearnConfig::default());
            let config = NodeConfig { camera: 0, session: 0, tracker, learn, started: false };
            let mut node = Node::new(&config).unwrap();
            let (mut decoder, bytes, mut frames, mut time_us) = (Decoder::new(), picture(), 0, 0);
            let mut is_lost = move || {
                frames += 1;
                loses > 0 && frames % loses == 0
            };
            while !stopped.load(Ordering::Relaxed) {
                let mut said: Vec<Packet> = Vec::new();
                let mut read = [0; 64];
                let count = master.read(&mut read).unwrap_or(0);
                for packet in decoder.packets(&read[..count]) {
                    match packet {
                        Ok(Packet::Command(_)) if is_lost() => {}
                        Ok(Packet::Command(command)) => said.extend(node.command(&command).map(Packet::from)),
                        _ => said.push(node.not_understood().into()),
                    }
                }
                let view = FrameView::packed(&bytes, WIDTH, HEIGHT, PixelFormat::Rgb888).unwrap();
                let seen = node.picture(&view, time_us, 10);
                time_us += 10_000;
                said.extend(seen.notices.iter().map(|notice| Packet::from(*notice)));
                said.extend(seen.observation.map(|mut observation| {
                    observation.session = session(observation.sequence);
                    Packet::from(observation)
                }));
                for packet in said {
                    let mut frame = [0; MAX_FRAME_LEN];
                    let length = encode(&packet, &mut frame).unwrap();
                    if is_lost() {
                        frame[length / 2] ^= 0x40;
                    }
                    // nobody may listen
                    let _ = master.write_all(&frame[..length]);
                }
            }
        });
        Self { device, stop, thread: Some(thread), _slave: slave }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

fn only_red<T: Copy>(what: T) -> [Option<T>; BALLS] {
    [Some(what), None, None, None]
}

#[test]
fn a_ball_is_learnt_given_back_and_tracked() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    let taught = camera.learn(&only_red(AT)).unwrap();
    assert!((taught[0].unwrap().diameter - 20.5).abs() < 1.0 && taught[1].is_none(), "{taught:?}");
    camera.teach(&taught).unwrap();
    camera.place(&only_red(AT)).unwrap();
    camera.start().unwrap();
    for number in 0..20 {
        let Seen { packet, missed } = camera.next(|| false).unwrap().unwrap();
        assert_eq!((packet.sequence, missed, packet.width), (number, 0, WIDTH), "each, in order");
        assert!(packet.balls[0].state.is_measured(), "{packet:?}");
    }
    camera.stop().unwrap();
    assert_eq!(camera.take_notices(), Vec::<String>::new());
}

#[test]
fn a_line_that_loses_every_third_frame_costs_observations_and_no_command() {
    let board = Board::start(3, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    camera.learn(&only_red(AT)).unwrap();
    camera.start().unwrap();
    let (mut seen, mut missed) = (0, 0);
    while seen < 40 {
        let next = camera.next(|| false).unwrap().unwrap();
        assert!(next.packet.balls[0].state.is_measured(), "{next:?}");
        seen += 1;
        missed += next.missed;
    }
    assert!((10..40).contains(&missed), "{missed} of {}", seen + missed);
    camera.stop().unwrap();
}

#[test]
fn what_cannot_be_learnt_is_told_with_its_reason() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    for (at, why, exit) in [
        (ImagePoint::new(10.0, 10.0), NotTaught::Background, Exit::Failed),
        (ImagePoint::new(1000.0, 10.0), NotTaught::Outside, Exit::BadArguments),
    ] {
        let refused = camera.learn(&only_red(at)).unwrap_err();
        assert!(matches!(refused, SmartCameraError::NotTaught(Ball::Red, told) if told == why), "{refused}");
        assert_eq!(refused.exit(), exit);
        assert!(refused.to_string().contains("red"), "{refused}");
    }
    let placed = camera.place(&only_red(AT)).unwrap_err();
    assert!(
        matches!(placed, SmartCameraError::OtherAnswer(Notice::Untaught { ball: Ball::Red })),
        "{placed}"
    );
}

#[test]
fn a_camera_that_begins_anew_has_forgotten_what_it_was_taught() {
    // one packet alone may be damage
    let board = Board::start(0, |sequence| if sequence == 3 || sequence > 6 { 6 } else { 5 });
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    camera.start().unwrap();
    let numbers: Vec<u32> = (0..6).map(|_| camera.next(|| false).unwrap().unwrap().packet.sequence).collect();
    assert_eq!(numbers, [0, 1, 2, 4, 5, 6]);
    let error = camera.next(|| false).unwrap_err();
    assert!(matches!(error, SmartCameraError::BeganAnew), "{error}");
    assert_eq!(error.exit(), Exit::DeviceLost);
}

#[test]
fn a_port_that_is_not_there_is_named_with_what_mends_it() {
    let Err(error) = SmartCamera::open(Path::new("/no/port"), 115_200, 1) else { panic!("there is none") };
    assert!(error.to_string().contains("tetrad devices"), "{error}");
    assert_eq!(error.exit(), Exit::DeviceLost);
}

#[test]
fn whoever_waits_may_stop_waiting() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    assert_eq!(camera.next(|| true).unwrap(), None, "it was never started");
}
