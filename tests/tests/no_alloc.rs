//! Promise: no step of core allocates. Not learning, not tracking (found, lost and searched for in
//! the whole picture), not the hand's motion, not packets, not the
//! slave's cycle. And what is kept between two frames is
//! small.

mod common;

use nalgebra::Vector3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::hint::black_box;
use tetrad::pipeline::PipelineConfig;
use tetrad_core::arm::port::{JointReading, PortStatus};
use tetrad_core::arm::slave::{ArmReading, PortOrder, Slave};
use tetrad_core::arm::teleop::Command;
use tetrad_core::config::{LearnConfig, ProposeConfig, SlaveConfig};
use tetrad_core::geometry::Pose;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::HandTracker;
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::observation::{BALLS, Ball, Observation};
use tetrad_core::real::Real;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::learn::propose::propose;
use tetrad_core::vision::learn::{HorizontalScan, learn};
use tetrad_core::vision::tracker::CameraTracker;
use tetrad_core::wire::{
    Covariance, Decoder, Feed, MAX_BODY_LEN, MAX_FRAME_LEN, MotionPacket, ObservationPacket, Packet,
    decode_body, encode, encode_body,
};
use tetrad_fixtures::packets;

thread_local! {
    /// Allocations of this thread: tests run in threads, and each looks at its own.
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting.
struct Counting;

// SAFETY: every call is passed on unchanged to the system's allocator, which keeps the contract; the
// counter is a plain cell that needs no allocation of its own.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: as this function's own contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as this function's own contract.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        // SAFETY: as this function's own contract.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `work` gives, and how often it allocated.
fn counted<T>(work: impl FnOnce() -> T) -> (T, usize) {
    let before = ALLOCATIONS.with(Cell::get);
    let result = work();
    (result, ALLOCATIONS.with(Cell::get) - before)
}

#[test]
fn the_counter_counts() {
    assert_eq!(counted(|| drop(black_box(vec![1, 2, 3]))).1, 1);
    assert_eq!(counted(|| black_box(1 + 1)).1, 0);
}

/// On a desktop; on a microcontroller words are half as long.
#[test]
fn the_tracker_of_one_camera_is_under_4_kib() {
    let bytes = size_of::<CameraTracker>();
    assert!(bytes < 4096, "{bytes} bytes");
}

/// With what is known of eight cameras; on a microcontroller much the same.
#[test]
fn the_tracker_of_the_hand_is_under_40_kib() {
    let bytes = size_of::<HandTracker>();
    assert!(bytes < 40 * 1024, "{bytes} bytes");
}

#[test]
fn learning_allocates_nothing() {
    let scene = common::scene("still");
    let mut rgb = Vec::new();
    scene.render_rgb(0, 0, &mut rgb);
    let view = common::view(&scene, &rgb);
    for (ball, truth) in Ball::ALL.into_iter().zip(scene.truth(0, 0)) {
        let at = common::centre(&truth);
        let (learnt, allocations) = counted(|| learn(&view, Primary::of(ball), at, &LearnConfig::default()));
        let learnt = learnt.unwrap_or_else(|refused| panic!("{}: {refused}", ball.name()));
        assert_eq!(allocations, 0, "learning {}", ball.name());
        let (scan, allocations) = counted(|| {
            HorizontalScan::<128>::through(&view, &learnt.reference, 128, learnt.centre, learnt.diameter)
        });
        assert!(scan.is_ok());
        assert_eq!(allocations, 0, "scanning {}", ball.name());
    }
}

#[test]
fn proposing_the_balls_allocates_nothing() {
    let scene = common::scene("demo");
    let pictures = [0, 1].map(|camera| {
        let mut rgb = Vec::new();
        scene.render_rgb(0, camera, &mut rgb);
        rgb
    });
    let views = pictures.each_ref().map(|rgb| common::view(&scene, rgb));
    let (proposal, allocations) = counted(|| propose(&views, &ProposeConfig::default()));
    assert!(proposal.is_complete());
    assert_eq!(allocations, 0);
}

/// Tracks both cameras of a scene and the hand, and gives the states of the hand that were met.
fn states_without_an_allocation(name: &str, config: &PipelineConfig) -> BTreeSet<PoseState> {
    let scene = common::scene(name);
    let mut rgb = Vec::new();
    let mut trackers = [0, 1].map(|camera| {
        scene.render_rgb(0, camera, &mut rgb);
        common::taught_with(&common::view(&scene, &rgb), &scene.truth(0, camera), config.tracker)
    });
    let arms = Arms::equal(scene.arm_m as f32).expect("the arms of a scene");
    let mut hand = HandTracker::new(config.hand_mode, arms, config.hand);
    let mut states = BTreeSet::new();
    for frame in 0..scene.frames() {
        let t_us = common::time_us(&scene, frame);
        let camera = CameraModel::nominal(scene.width, scene.height);
        let mut views = [HandView { balls: [Observation::default(); BALLS], camera }; 2];
        for (camera, (tracker, seen)) in trackers.iter_mut().zip(&mut views).enumerate() {
            scene.render_rgb(frame, camera, &mut rgb);
            let view = common::view(&scene, &rgb);
            let (report, allocations) = counted(|| tracker.step(&view, t_us, &hand.predict(camera, t_us)));
            assert_eq!(allocations, 0, "{name}: tracking, camera {camera}, frame {frame}");
            seen.balls = report.observations;
        }
        let (report, allocations) = counted(|| {
            if frame == 10 {
                hand.engage();
            }
            hand.update(&views, t_us)
        });
        assert_eq!(allocations, 0, "{name}: hand, frame {frame}");
        states.insert(report.state);
    }
    states
}

/// `cover-all` hides all balls, so that they are searched for wider and wider, lost, and found again;
/// `cover` one of them.
#[test]
fn tracking_and_motion_allocate_nothing() {
    let paper = PipelineConfig::paper();
    let met = states_without_an_allocation("cover-all", &paper);
    assert!([PoseState::Both, PoseState::Held].iter().all(|state| met.contains(state)), "{met:?}");
    let refined = PipelineConfig::refined();
    let mut met = states_without_an_allocation("cover-all", &refined);
    met.extend(states_without_an_allocation("cover", &refined));
    let all = [PoseState::Both, PoseState::Three, PoseState::Predicted, PoseState::Held];
    assert!(all.iter().all(|state| met.contains(state)), "{met:?}");
}

#[test]
fn packets_allocate_nothing() {
    let observations = ObservationPacket {
        capture_us: u64::MAX,
        ready_us: u32::MAX,
        observed_us: u32::MAX,
        ..packets::observation(7, u32::MAX)
    };
    let motion = MotionPacket { covariance: Some(Covariance { upper: [0.0; 21] }), ..packets::motion(7, 8) };
    for packet in [Packet::from(observations), motion.into()] {
        let ((), allocations) = counted(|| {
            let mut body = [0; MAX_BODY_LEN];
            let length = encode_body(&packet, &mut body).unwrap_or(0);
            assert_eq!(body.get(..length).map(decode_body), Some(Ok(packet)));
            let mut frame = [0; MAX_FRAME_LEN];
            let length = encode(&packet, &mut frame).unwrap_or(0);
            let mut decoder = Decoder::new();
            let received = decoder.feed(&frame[..length]);
            assert!(matches!(received, Feed::Frame { result: Ok(p), .. } if p == packet));
        });
        assert_eq!(allocations, 0);
    }
}

/// A second of an engaged arm, in both precisions: commands, button, law, limits, kinematics; then a
/// stop.
fn slave_without_an_allocation<T: Real>() {
    let mut slave = Slave::<T>::new(&SlaveConfig::default()).expect("the default");
    let mut joints = [0.0_f64, 0.8, -3.0, 0.1, 0.9, 0.0].map(T::of);
    let states = Cell::new(0_u8);
    let ((), allocations) = counted(|| {
        for cycle in 0..130_u32 {
            let now_us = 1_000_000 + u64::from(cycle) * 10_000;
            let joints_read = Some(JointReading { joints, age_us: 0 });
            let reading = ArmReading { joints: joints_read, status: PortStatus::Ready };
            slave.hold_to_run(cycle > 10, now_us);
            if cycle == 10 {
                slave.reset(now_us, &reading).expect("it is armed");
            }
            if cycle == 120 {
                slave.stop();
            }
            let moved = cycle as f32 * 1e-3;
            let command = Command {
                session: 1,
                sequence: cycle,
                capture_us: now_us,
                received_us: now_us,
                engaged: true,
                engagements: 1,
                state: PoseState::Both,
                increment: Pose::identity(),
                since_engage: Pose { translation: Vector3::new(moved, -moved, moved), ..Pose::identity() },
                covariance: None,
            };
            slave.take(&command).expect("it is newer");
            let step = slave.step(now_us, &reading);
            if let PortOrder::Write(next) = step.order {
                joints = next;
            }
            states.set(states.get() | 1 << step.decision.status.state() as u8);
        }
    });
    assert_eq!(allocations, 0);
    // stopped, armed and engaged
    assert_eq!(states.get() & 0b111, 0b111);
}

#[test]
fn the_slave_allocates_nothing() {
    slave_without_an_allocation::<f64>();
    slave_without_an_allocation::<f32>();
}
