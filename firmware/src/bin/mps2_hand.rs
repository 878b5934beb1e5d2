//! What the hand's pose and the arm cost on a microcontroller: instructions and stack, and the size of their
//! state. `board/mps2/cost.rs` says how it is counted.
#![no_std]
#![no_main]

use core::f32::consts::FRAC_PI_6;
use core::hint::black_box;
use core::mem::size_of;
use nalgebra::{Matrix3, Rotation3, Vector3};
use semihosting::{println, process};
use tetrad_core::arm::puma560::Puma560;
use tetrad_core::config::{HandConfig, PumaConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::{AffineFrame, Arms};
use tetrad_core::hand::tracker::{HandMode, HandTracker};
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{ImageCovariance, Observation, ObservationState};
use tetrad_firmware::board::mps2;
use tetrad_firmware::board::mps2::cost::{both, instructions};

/// Two pictures a thirtieth of a second apart, microseconds.
const FRAME_US: u64 = 33_333;

const CAMERAS: usize = 2;

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
    mps2::start();
    both("matrix-inverse", || {
        black_box(black_box(Matrix3::new(2.0_f32, 0.1, 0.2, 0.3, 3.0, 0.1, 0.2, 0.4, 4.0)).try_inverse());
    });
    poses();
    arm();
    println!("hand-tracker {} bytes", size_of::<HandTracker>());
    process::exit(0)
}
