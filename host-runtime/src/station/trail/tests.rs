use super::*;
use nalgebra::{Matrix3, Vector3};
use tetrad_core::arm::port::{JointReading, PortStatus};
use tetrad_core::arm::slave::{ArmReading, Slave};
use tetrad_core::arm::teleop::Command;
use tetrad_core::config::SlaveConfig;
use tetrad_core::wire::{PressFor, ScaleShare, Transform};
use tetrad_fixtures::packets;

const FRAME_US: u64 = 16_667;
const CYCLE_US: u64 = 10_000;
const BEGINS_US: u64 = 1_000_000;

/// The hand goes round, slowly.
fn hand(now_us: u64) -> [f32; 3] {
    let phase = now_us.saturating_sub(BEGINS_US) as f64 * 1e-6 * 1.5;
    [0.06 * phase.sin(), 0.06 * (1.0 - phase.cos()), 0.0].map(|m| m as f32)
}

fn motion(sequence: u32, captured_us: u64) -> MotionPacket {
    MotionPacket { capture_us: captured_us, ..packets::motion_to(1, sequence, hand(captured_us)) }
}

/// What is held at a time, if anything.
type Press = Option<(PressFor, ScaleShare)>;

const FOLLOW: Press = Some((PressFor::Follow, ScaleShare::FULL));

/// An arm whose joints are where they are told to be follows the hand over a way of `way_us`.
fn followed(seconds: u64, way_us: u64) -> Trail {
    pressed(seconds, way_us, |_| FOLLOW)
}

/// The same with a button that is held now and then: `press` is told the seconds since the beginning.
fn pressed(seconds: u64, way_us: u64, press: impl Fn(f64) -> Press) -> Trail {
    let config = SlaveConfig::default();
    let mut slave = Slave::<f64>::new(&config).unwrap();
    let mut joints = [0.0_f64, 45.0, -170.0, 5.0, 50.0, 0.0].map(f64::to_radians);
    let mut trail = Trail::new(&config.teleop);
    let reading =
        |joints| ArmReading { joints: Some(JointReading { joints, age_us: 0 }), status: PortStatus::Ready };
    let (mut frame_us, mut sequence) = (BEGINS_US, 0);
    slave.hold_to_run(false, BEGINS_US - CYCLE_US);
    slave.reset(BEGINS_US - CYCLE_US, &reading(joints)).unwrap();
    let mut now_us = BEGINS_US;
    while now_us < BEGINS_US + seconds * 1_000_000 {
        if frame_us + way_us <= now_us {
            let packet = motion(sequence, frame_us);
            slave.take(&Command::new(&packet, now_us)).unwrap();
            trail.motion(&packet, Some(frame_us));
            (frame_us, sequence) = (frame_us + FRAME_US, sequence + 1);
        }
        let press = press((now_us - BEGINS_US) as f64 * 1e-6).filter(|_| now_us > BEGINS_US + 100_000);
        if let Some((press_for, scale)) = press {
            slave.press_is_for(press_for, scale);
        }
        slave.hold_to_run(press.is_some(), now_us);
        let step = slave.step(now_us, &reading(joints));
        if let Some(governed) = &step.governed {
            joints = governed.set_point;
        }
        let cycle = Cycle {
            step,
            reading: reading(joints),
            port_error: None,
            solved_us: now_us,
            written_us: Some(now_us),
        };
        trail.cycle(&cycle, now_us);
        now_us += CYCLE_US;
    }
    trail
}

#[test]
fn the_way_there_is_told_apart_from_what_is_left_beside_it() {
    let (near, far) = (followed(20, 5_000), followed(20, 65_000));
    let [near, far] = [&near, &far].map(|trail| trail.closeness().unwrap());
    assert!((far.delay_s - near.delay_s - 0.06).abs() < 0.012, "{near:?} {far:?}");
    for close in [near, far] {
        assert!(close.rms_m < 1.5e-3 && close.turn_rms_rad < 1e-2, "{close:?}");
        assert!(close.behind_rms_m > 2.0 * close.rms_m, "{close:?}");
    }
}

#[test]
fn what_does_not_follow_the_hand_as_it_is_is_no_error_of_following() {
    let tenth = ScaleShare::from_percent(10).unwrap();
    for other in [(PressFor::Home, ScaleShare::FULL), (PressFor::Follow, tenth)] {
        let trail = pressed(20, 5_000, |t_s| match t_s {
            0.0..8.0 | 15.0.. => FOLLOW,
            9.0..14.0 => Some(other),
            _ => None,
        });
        let close = trail.closeness().unwrap();
        assert!(close.rms_m < 1.5e-3 && close.turn_rms_rad < 1e-2, "{other:?}: {close:?}");
    }
    assert_eq!(pressed(5, 5_000, |_| Some((PressFor::Home, ScaleShare::FULL))).line(), None);
}

#[test]
fn a_long_run_holds_no_more_than_its_last_minute() {
    let trail = followed(200, 5_000);
    assert_eq!(trail.hand.len(), PLACES);
    let close = trail.closeness().unwrap();
    assert!(close.rms_m < 1.5e-3, "latched minutes ago, and still compared: {close:?}");
}

#[test]
fn where_clocks_are_not_known_or_nothing_was_followed_nothing_is_told() {
    let mut trail = Trail::new(&TeleopConfig::default());
    trail.motion(&motion(0, BEGINS_US), None);
    assert_eq!(trail.line(), None);
    trail.motion(&motion(1, BEGINS_US), Some(BEGINS_US));
    assert_eq!(trail.line(), None);
}

#[test]
fn a_hand_that_is_told_in_other_axes_begins_anew() {
    let mut trail = followed(5, 5_000);
    assert!(trail.line().is_some());
    let other = MotionPacket { engagements: 2, ..motion(10_000, BEGINS_US + 5_000_000) };
    trail.motion(&other, Some(BEGINS_US + 5_000_000));
    assert_eq!(trail.line(), None);
}

#[test]
fn between_two_places_the_hand_is_between_them() {
    let mut trail = Trail::new(&TeleopConfig::default());
    for (captured_us, x) in [(1_000_000, 0.0_f32), (1_100_000, 0.1)] {
        let since_engage = Transform { translation: [x, 0.0, 0.0], ..Transform::IDENTITY };
        trail.motion(&MotionPacket { since_engage, ..motion(0, 0) }, Some(captured_us));
    }
    for (t_s, x) in [(0.5, 0.0), (1.05, 0.05), (2.0, 0.1)] {
        let (turn, place) = trail.hand_at(t_s);
        assert_eq!(turn, Matrix3::identity());
        assert!((place - Vector3::new(x, 0.0, 0.0)).norm() < 1e-6, "{t_s}: {place}");
    }
}
