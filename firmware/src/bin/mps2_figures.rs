//! What a smart camera costs on a microcontroller: instructions and stack, and the size of its state.
//!
//! `board/mps2/cost.rs` says how it is counted. Pictures come from `tetrad.tape`.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::mem::size_of;
use semihosting::{println, process};
use static_cell::ConstStaticCell;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::observation::{BALLS, Ball, ObservationState};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::learn;
use tetrad_core::vision::tracker::CameraTracker;
use tetrad_core::wire::{Command, CommandPacket, Decoder, Notice, Packet};
use tetrad_firmware::board::mps2;
use tetrad_firmware::board::mps2::cost::{both, instructions};
use tetrad_firmware::board::mps2::tape::{Record, Tape};
use tetrad_firmware::handover::{Captured, PictureBuffer};

const CAMERAS: usize = 2;

/// Two pictures a thirtieth of a second apart, microseconds.
const FRAME_US: u64 = 33_333;

/// The four balls as they were learnt, and where.
type Taught = [Option<(LearntBall, ImagePoint)>; BALLS];

fn tracker(config: TrackerConfig, taught: &Taught, placed: bool) -> CameraTracker {
    let balls = taught.map(|ball| ball.map(|(learnt, _)| learnt));
    let mut tracker = CameraTracker::new(config, balls).expect("balls that were learnt can be tracked");
    for (ball, taught) in Ball::ALL.into_iter().zip(taught) {
        if let Some((_, at)) = taught
            && placed
        {
            tracker.place(ball, *at);
        }
    }
    tracker
}

/// What comes of one mode: the mean and the most of its frames, and its stack.
#[derive(Default)]
struct Costs {
    frames: u32,
    sum: u32,
    most: u32,
    stack: usize,
}

impl Costs {
    fn step(&mut self, tracker: &mut CameraTracker, view: &FrameView<'_>, t_us: u64) {
        let mut whole = false;
        let mut twin = tracker.clone();
        let cost = instructions(|| {
            let report = black_box(tracker.step(view, t_us, &[None; BALLS]));
            whole = report.observations.iter().all(|ball| ball.state == ObservationState::Visible);
        });
        let stack = mps2::stack_of(|| {
            black_box(twin.step(view, t_us, &[None; BALLS]));
        });
        assert!(whole, "every ball is seen in every picture");
        self.frames += 1;
        self.sum += cost;
        self.most = self.most.max(cost);
        self.stack = self.stack.max(stack);
    }

    fn print(&self, name: &str) {
        println!("{name} {} instructions", self.sum / self.frames.max(1));
        println!("{name}-most {} instructions", self.most);
        println!("{name} {} stack", self.stack);
    }
}

/// Red in RGB565 as bounds of its fields, each in its place.
#[derive(Clone, Copy)]
struct Bounds {
    least_red: u16,
    most_green: u16,
    most_blue: u16,
}

/// What the field does instead: every pixel of RGB565, high byte first, against bounds of one colour, and the
/// mean of those that pass. Written to be fast: one comparison ends most pixels, for nearly all have more
/// green than a red ball; and a row's number is added once a row.
fn threshold(picture: &[u8], width: usize, bounds: &Bounds) -> Option<ImagePoint> {
    let (mut u, mut v, mut count) = (0_u32, 0_u32, 0_u32);
    let (pixels, _) = picture.as_chunks::<2>();
    for (y, row) in (0..).zip(pixels.chunks_exact(width.max(1))) {
        let before = count;
        for (x, bytes) in (0..).zip(row) {
            let pixel = u16::from_be_bytes(*bytes);
            if pixel & GREEN <= bounds.most_green && bounds.hold_the_rest_of(pixel) {
                (u, count) = (u + x, count + 1);
            }
        }
        v += y * (count - before);
    }
    (count > 0).then(|| ImagePoint::new(u as f32 / count as f32, v as f32 / count as f32))
}

/// The fields below red.
const GREEN: u16 = 0x07E0;
const BLUE: u16 = 0x001F;

impl Bounds {
    /// Apart, so that it is a branch and not what every pixel has computed for it.
    #[cold]
    #[inline(never)]
    const fn hold_the_rest_of(&self, pixel: u16) -> bool {
        // red has the highest bits: it is more where the pixel is
        pixel >= self.least_red && pixel & BLUE <= self.most_blue
    }
}

fn view<'a>(buffer: &'a PictureBuffer, captured: &Captured) -> FrameView<'a> {
    let bytes = buffer.0.get(..captured.length).unwrap_or_default();
    let view = FrameView::packed(bytes, captured.width, captured.height, captured.format);
    view.expect("the tape's pictures are whole")
}

fn vision(tape: &mut Tape, buffer: &mut PictureBuffer) {
    let mut decoder = Decoder::new();
    let mut places = [None; BALLS];
    let mut taught: Taught = [None; BALLS];
    let mut trackers: Option<[CameraTracker; 2]> = None;
    let (mut paper, mut refined) = (Costs::default(), Costs::default());
    while let Ok(record) = tape.next(buffer) {
        match record {
            Record::Line(length) => {
                for packet in decoder.packets(buffer.0.get(..length).unwrap_or_default()) {
                    if let Ok(Packet::Command(told)) = packet
                        && let Command::Learn { ball, at } = told.command
                    {
                        places[ball.index()] = Some(at);
                    }
                }
            }
            Record::Picture(captured) => {
                let view = view(buffer, &captured);
                match &mut trackers {
                    None => {
                        for ball in Ball::ALL {
                            let Some(at) = places[ball.index()] else { continue };
                            let mut found = None;
                            let mut teach =
                                || found = learn(&view, Primary::of(ball), at, &LearnConfig::default()).ok();
                            if ball == Ball::Red {
                                both("learn", teach);
                            } else {
                                teach();
                            }
                            taught[ball.index()] = found.map(|found| (LearntBall::of(&found), found.centre));
                        }
                        let red = Bounds { least_red: 16 << 11, most_green: 24 << 5, most_blue: 12 };
                        both("threshold", || {
                            let (bytes, width) = (black_box(view.data()), usize::from(captured.width));
                            assert!(black_box(threshold(bytes, width, &black_box(red))).is_some());
                        });
                        let mut lost = Costs::default();
                        let mut anywhere = tracker(TrackerConfig::default(), &taught, false);
                        lost.step(&mut anywhere, &view, captured.capture_us);
                        println!("global-search {} instructions", lost.most);
                        println!("global-search {} stack", lost.stack);
                        let modes = [TrackerConfig::paper(), TrackerConfig::default()];
                        trackers = Some(modes.map(|mode| tracker(mode, &taught, true)));
                    }
                    Some([first, second]) => {
                        paper.step(first, &view, captured.capture_us);
                        refined.step(second, &view, captured.capture_us);
                    }
                }
            }
            Record::Pause(_) | Record::Case(_) | Record::TooLong | Record::Unknown => {}
        }
        // behind the sequence the camera is told to stop, and shown its first picture again
        if paper.frames == 15 {
            // in the dark: the larger windows and the whole picture are searched, and nothing is there
            if let (Some([_, tracker]), Record::Picture(captured)) = (&mut trackers, record) {
                let captured = Captured { capture_us: captured.capture_us + FRAME_US, ..captured };
                buffer.0.fill(0);
                let view = view(buffer, &captured);
                both("lost-ball", || {
                    let report = black_box(tracker.step(&view, captured.capture_us, &[None; BALLS]));
                    let lost =
                        report.observations.iter().all(|ball| ball.state == ObservationState::Predicted);
                    assert!(lost, "no ball is seen in the dark");
                });
            }
            break;
        }
    }
    paper.print("track-paper");
    refined.print("track-refined");
}

fn self_test() {
    let (tracker, learn) = (TrackerConfig::default(), LearnConfig::default());
    let config = NodeConfig { camera: 0, session: 1, tracker, learn, started: false };
    let mut node = Node::new(&config).expect("the settings are core's own");
    let mut told = CommandPacket { session: 1, sequence: 0, command: Command::SelfTest };
    both("self-test", || {
        // what was told already is not done again
        told.sequence += 1;
        let notice = black_box(node.command(black_box(&told))).expect("it is answered at once");
        assert!(notice.notice == Notice::Done, "it passes");
    });
}

#[cortex_m_rt::entry]
fn main() -> ! {
    static BUFFER: ConstStaticCell<PictureBuffer> = ConstStaticCell::new(PictureBuffer::new());
    mps2::start();
    let Some(mut tape) = Tape::open() else {
        println!("no tape: write one to tetrad.tape in the folder that QEMU runs in");
        process::exit(2)
    };
    vision(&mut tape, BUFFER.take());
    self_test();
    println!("trackers-of-two-cameras {} bytes", CAMERAS * size_of::<CameraTracker>());
    println!("node {} bytes", size_of::<Node>());
    process::exit(0)
}
