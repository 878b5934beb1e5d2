//! Any number of cameras anywhere: far apart, alone, many, moved, joining late.

use super::simulated::{Eye, about, circular, demo, hide, linear, pair};
use super::tally::{after, error_mm, holds, is_honest, run, see, untouched};
use crate::config::HandConfig;
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use crate::observation::Ball;
use nalgebra::Vector3;
use std::vec;

#[test]
fn cameras_thirty_to_a_hundred_and_twenty_degrees_apart() {
    for half_deg in [15.0, 30.0, 45.0, 60.0] {
        let tally = run("apart", &pair(half_deg), demo, 300, 0.03, 4, untouched);
        holds(&tally, 1.5, 0.6, 0.3);
        is_honest(&tally);
    }
}

#[test]
fn one_camera_alone_gives_the_whole_pose() {
    for path in [linear, circular] {
        for nominal in [800.0, 880.0, 720.0] {
            let mut eye = Eye::looking(-30.0, 12.0, 1.0);
            eye.nominal = nominal;
            let tally = run("one camera", &[eye], path, 300, 0.02, 6, untouched);
            holds(&tally, 6.0, 1.5, 1.0);
            is_honest(&tally);
        }
    }
}

#[cfg(feature = "eight-views")]
#[test]
fn eight_cameras_are_better_than_two() {
    let ring = |count: usize| -> std::vec::Vec<Eye> {
        (0..count).map(|i| Eye::looking(-60.0 + 17.0 * i as f64, 12.0 + 5.0 * (i % 3) as f64, 1.0)).collect()
    };
    let of = |count| {
        let tally = run("ring", &ring(count), demo, 200, 0.03, 1, untouched);
        is_honest(&tally);
        tally.sum / tally.n as f64
    };
    assert!(of(8) < 0.8 * of(2));
}

#[test]
fn a_camera_that_was_moved_is_left_out_and_latched_anew() {
    let mut eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 90);
    // knocked by two degrees
    eyes[1].rotation = about(Vector3::new(1.0, 2.0, 0.5), 2.0) * eyes[1].rotation;
    let mut states = vec![];
    for frame in 90..300 {
        let hand = demo(frame as f64 / 30.0);
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        states.push(report.state);
        let error = error_mm(&demo(0.0), &hand, &report);
        assert!(error < 3.0, "frame {frame}, {}: {error} mm", report.state.name());
    }
    let patience = HandConfig::default().pose.relatch_frames as usize;
    assert!(states[..patience].iter().all(|state| *state == PoseState::One));
    assert!(states[patience + 1..].iter().all(|state| *state == PoseState::Both));
}

#[test]
fn a_camera_that_joins_later_is_latched_from_the_pose_of_the_others() {
    let late = |frame: usize, views: &mut [HandView]| {
        if frame < 100 {
            hide(views, 1, &Ball::ALL);
        }
    };
    let tally = run("late", &pair(30.0), demo, 400, 0.03, 4, late);
    assert!(tally.states.contains_key(&PoseState::Both) && tally.states.contains_key(&PoseState::One));
    is_honest(&tally);
}
