//! What the parts of core cost on a microcontroller: instructions and stack, and the size of their state.
//!
//! It is run by QEMU with one instruction counting as 1024 ns (`-icount shift=10`), so that the board's
//! timer counts instructions: exactly, and the same on every computer. Pictures come from `tetrad.tape`.
//! Each figure is a line on standard output: `name value unit`.
#![no_std]
#![no_main]

use core::f32::consts::FRAC_PI_6;
use core::hint::black_box;
use core::mem::size_of;
use nalgebra::{Matrix3, Rotation3, Vector3};
use semihosting::{println, process};
use static_cell::ConstStaticCell;
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::config::{HandConfig, LearnConfig, PumaConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::{AffineFrame, Arms};
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::node::Node;
use tetrad_core::observation::{BALLS, Ball, ImageCovariance, Observation, ObservationState};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::learn;
use tetrad_core::vision::tracker::CameraTracker;
use tetrad_core::wire::{Command, Decoder, Packet};
use tetrad_firmware::board::mps2::tape::{Record, Tape};
use tetrad_firmware::board::mps2::{self, time};
use tetrad_firmware::handover::PictureBuffer;

/// Ticks of 40 ns in ten instructions of 1024 ns each.
const TICKS_OF_TEN: u64 = 256;

/// Two pictures a thirtieth of a second apart, microseconds.
const FRAME_US: u64 = 33_333;

const CAMERAS: usize = 2;

/// Runs `work` and tells its instructions, less those of looking at the clock.
fn instructions(work: impl FnOnce()) -> u32 {
    let empty = time::ticks();
    let begin = time::ticks();
    work();
    let end = time::ticks();
    let ticks = end.wrapping_sub(begin).saturating_sub(begin.wrapping_sub(empty));
    u32::try_from(u64::from(ticks) * 10 / TICKS_OF_TEN).unwrap_or(u32::MAX)
}

/// The same work done twice: instructions of the first, stack of the second.
fn both(name: &str, mut work: impl FnMut()) {
    println!("{name} {} instructions", instructions(&mut work));
    println!("{name} {} stack", mps2::stack_of(&mut work));
}

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

/// What the field does instead: every pixel of RGB565, high byte first, against bounds of one colour, and the
/// mean of those that pass.
fn threshold(picture: &[u8], width: usize, least: [u16; 3]) -> Option<ImagePoint> {
    let (mut u, mut v, mut count) = (0_u32, 0_u32, 0_u32);
    let (pixels, _) = picture.as_chunks::<2>();
    for (y, row) in (0..).zip(pixels.chunks_exact(width.max(1))) {
        for (x, bytes) in (0..).zip(row) {
            let pixel = u16::from_be_bytes(*bytes);
            let [red, green, blue] = [pixel >> 11, pixel >> 5 & 63, pixel & 31];
            if red >= least[0] && green <= least[1] && blue <= least[2] {
                (u, v, count) = (u + x, v + y, count + 1);
            }
        }
    }
    (count > 0).then(|| ImagePoint::new(u as f32 / count as f32, v as f32 / count as f32))
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
                let bytes = buffer.0.get(..captured.length).unwrap_or_default();
                let view = FrameView::packed(bytes, captured.width, captured.height, captured.format);
                let view = view.expect("the tape's pictures are whole");
                match &mut trackers {
                    None => {
                        for ball in Ball::ALL {
                            let Some(at) = places[ball.index()] else { continue };
                            let mut found = None;
                            let cost = instructions(|| {
                                found = learn(&view, Primary::of(ball), at, &LearnConfig::default()).ok();
                            });
                            if ball == Ball::Red {
                                println!("learn {cost} instructions");
                            }
                            taught[ball.index()] = found.map(|found| (LearntBall::of(&found), found.centre));
                        }
                        both("threshold", || {
                            let (bytes, width) = (black_box(bytes), usize::from(captured.width));
                            black_box(threshold(bytes, width, black_box([16, 24, 12])));
                        });
                        let mut anywhere = tracker(TrackerConfig::default(), &taught, false);
                        let mut all = false;
                        let cost = instructions(|| {
                            let report = anywhere.step(&view, captured.capture_us, &[None; BALLS]);
                            all = report.observations.iter().all(|ball| ball.state.is_measured());
                        });
                        assert!(all, "the global search finds every ball");
                        println!("global-search {cost} instructions");
                        let modes = [TrackerConfig::paper(), TrackerConfig::default()];
                        trackers = Some(modes.map(|mode| tracker(mode, &taught, true)));
                    }
                    Some([first, second]) => {
                        paper.step(first, &view, captured.capture_us);
                        refined.step(second, &view, captured.capture_us);
                    }
                }
            }
            Record::TooLong | Record::Unknown => {}
        }
        // behind the sequence the camera is told to stop, and shown its first picture again
        if paper.frames == 15 {
            break;
        }
    }
    paper.print("track-paper");
    refined.print("track-refined");
}

/// A hand before two cameras 60 degrees apart, a metre away, turned and moved a little with every step.
fn hand(step: u32, arms: &Arms) -> [HandView; CAMERAS] {
    let camera = CameraModel { width: 320, height: 240, focal_px: 400.0 };
    let turn = step as f32 * 0.02;
    let hand = Rotation3::from_euler_angles(turn, 0.5 * turn, 0.3 - turn);
    let shift = Vector3::new(0.002, -0.001, 0.0015) * step as f32;
    [-FRAC_PI_6, FRAC_PI_6].map(|angle| {
        let from_world = Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
        let balls = arms.balls_in_frame().map(|ball| {
            let seen: Vector3<f32> = from_world * (hand * ball + shift) + Vector3::new(0.0, 0.0, 1.0);
            let centre = ImagePoint::new(159.5 + 400.0 * seen.x / seen.z, 119.5 + 400.0 * seen.y / seen.z);
            let covariance = ImageCovariance::isotropic(0.05);
            Observation { state: ObservationState::Visible, centre, diameter: 8.0, covariance, visible: 1.0 }
        });
        HandView { balls, camera }
    })
}

fn poses() {
    let arms = Arms::equal(0.08).expect("a length");
    for (name, mode) in [("pose-paper", HandMode::Paper), ("pose-refined", HandMode::Refined)] {
        let mut tracker = HandTracker::new(mode, arms, HandConfig::default());
        let (mut sum, mut most, mut stack) = (0, 0, 0);
        for step in 0..20_u32 {
            let views = black_box(hand(step, &arms));
            let t_us = u64::from(step) * FRAME_US;
            let mut twin = tracker.clone();
            let mut measured = false;
            let cost =
                instructions(|| measured = black_box(tracker.update(&views, t_us)).state.is_measured());
            stack = stack.max(mps2::stack_of(|| {
                black_box(twin.update(&views, t_us));
            }));
            assert!(measured, "the hand is seen");
            sum += cost;
            most = most.max(cost);
        }
        println!("{name} {} instructions", sum / 20);
        println!("{name}-most {most} instructions");
        println!("{name} {stack} stack");
    }
    let views = hand(0, &arms).map(|view| view.balls.map(|ball| ball.centre));
    let frame = AffineFrame::new(&views, arms, &HandConfig::default()).expect("a frame that is seen");
    let points = hand(1, &arms).map(|view| view.balls[1].centre);
    both("solve-3x3", || {
        black_box(frame.locate(black_box(&points))).ok();
    });
}

fn arm() {
    let arm = Puma560::<f32>::new(&PumaConfig::default()).expect("the default");
    let joints = [0.3, 1.9, -2.6, 0.4, 0.9, -0.5];
    let pose = arm.forward(&joints);
    let mut solutions = 0;
    both("puma-inverse", || {
        solutions = black_box(arm.inverse(black_box(&pose), &joints)).map_or(0, |all| all.iter().count());
    });
    assert!(solutions >= 4, "a pose in reach");
    both("puma-forward", || {
        black_box(arm.forward(black_box(&joints)));
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
    both("matrix-inverse", || {
        black_box(black_box(Matrix3::new(2.0_f32, 0.1, 0.2, 0.3, 3.0, 0.1, 0.2, 0.4, 4.0)).try_inverse());
    });
    vision(&mut tape, BUFFER.take());
    poses();
    arm();
    println!("trackers-of-two-cameras {} bytes", CAMERAS * size_of::<CameraTracker>());
    println!("hand-tracker {} bytes", size_of::<HandTracker>());
    println!("node {} bytes", size_of::<Node>());
    process::exit(0)
}
