//! How near the pose is to the truth, and that it stays there.

use super::simulated::{Noise, circular, demo, linear, pair};
use super::tally::{after, error_mm, holds, is_honest, run, see, untouched};
use crate::config::HandConfig;
use crate::hand::pose::PoseTracker;

#[test]
fn movements_are_followed_within_a_millimetre() {
    for sigma in [0.02, 0.04] {
        for path in [linear, circular, demo] {
            let tally = run("two cameras", &pair(30.0), path, 300, sigma, 6, untouched);
            holds(&tally, 1.0, 0.3, 0.3);
            is_honest(&tally);
        }
    }
}

#[test]
fn focal_lengths_ten_percent_off_are_mended_by_the_motion() {
    for (first, second) in [(1.1, 1.1), (0.9, 0.9), (1.1, 0.9), (0.9, 1.1)] {
        let mut eyes = pair(30.0);
        eyes[0].nominal *= first;
        eyes[1].nominal *= second;
        for path in [linear, circular] {
            let tally = run("focal lengths off", &eyes, path, 300, 0.03, 4, untouched);
            holds(&tally, 1.5, 0.5, 0.3);
            is_honest(&tally);
        }
    }
}

#[test]
fn a_hand_that_comes_back_after_ten_minutes_is_where_it_was() {
    for seed in 0..3 {
        let eyes = pair(30.0);
        let mut noise = Noise(seed);
        let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
        let mut worst = 0.0_f64;
        for frame in 0..18_000 {
            let hand = demo(frame as f64 / 30.0);
            let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
            worst = worst.max(error_mm(&demo(0.0), &hand, &report));
        }
        // and at rest for a second where it began
        for frame in 18_000..18_030 {
            let report = see(&mut tracker, &eyes, &demo(0.0), frame, &mut noise);
            let error = error_mm(&demo(0.0), &demo(0.0), &report);
            assert!(error < 0.3, "{error} mm");
        }
        assert!(worst < 0.6, "{worst} mm on the way");
    }
}

#[test]
fn a_hand_at_rest_does_not_creep() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 200);
    let hand = demo(200.0 / 30.0);
    let settled = see(&mut tracker, &eyes, &hand, 200, &mut noise);
    let focal = tracker.focal_px(0);
    for frame in 201..800 {
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        let off = (report.pose.unwrap().translation - settled.pose.unwrap().translation).norm();
        assert!(off < 0.3e-3, "{off} m");
    }
    // a frame or two may have been learnt from on the way to where it stopped, no more
    let change = (tracker.focal_px(0).unwrap() - focal.unwrap()).abs();
    assert!(change < 4.0, "{change} px");
}
