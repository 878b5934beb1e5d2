//! From where the pose is told, and the increments beside it.

use super::simulated::{Noise, demo, hide, pair, view};
use super::tally::{after, error_mm, see};
use crate::config::HandConfig;
use crate::geometry::Pose;
use crate::hand::motion::MotionRefusal;
use crate::hand::pose::PoseTracker;
use crate::hand::report::HandReport;
use crate::hand::view::HandView;
use crate::observation::Ball;
use std::format;
use std::vec::Vec;

#[test]
fn engage_tells_the_pose_from_where_the_hand_is() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 100);
    let latched = demo(99.0 / 30.0);
    tracker.engage();
    assert_eq!(tracker.engagements(), 1);
    for frame in 100..300 {
        let hand = demo(frame as f64 / 30.0);
        let report = see(&mut tracker, &eyes, &hand, frame, &mut noise);
        let error = error_mm(&latched, &hand, &report);
        assert!(error < 0.6, "frame {frame}: {error} mm");
        assert_eq!(report.motion.map(|motion| (motion.engagements, motion.spans)), Ok((1, 1)));
    }
}

#[test]
fn engage_with_the_hand_unseen_waits_for_it() {
    let eyes = pair(30.0);
    let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    tracker.engage();
    assert_eq!(tracker.engagements(), 0);
    let mut noise = Noise(3);
    let report = see(&mut tracker, &eyes, &demo(3.0), 0, &mut noise);
    let motion = report.motion.unwrap();
    assert_eq!((motion.engagements, motion.spans, report.pose), (1, 0, Some(Pose::identity())));
    let mut hidden: Vec<HandView> = eyes.iter().map(|eye| view(eye, &demo(3.0), 0.03, &mut noise)).collect();
    hide(&mut hidden, 0, &Ball::ALL);
    hide(&mut hidden, 1, &Ball::ALL);
    let report = tracker.update(&hidden, 33_333);
    assert_eq!(report.motion, Err(MotionRefusal::BallMissing { view: 0, ball: Ball::Red }));
    tracker.engage();
    assert_eq!(tracker.engagements(), 1);
    let report = see(&mut tracker, &eyes, &demo(4.0), 2, &mut noise);
    let motion = report.motion.unwrap();
    assert_eq!((motion.engagements, motion.spans, motion.since_engage), (2, 2, Pose::identity()));
    assert!(motion.alpha.norm() > 0.005, "the increment still tells what was moved");
}

#[test]
fn increments_add_up_to_the_pose() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 60);
    let mut sum = see(&mut tracker, &eyes, &demo(2.0), 60, &mut noise).pose.unwrap();
    for frame in 61..120 {
        let report = see(&mut tracker, &eyes, &demo(frame as f64 / 30.0), frame, &mut noise);
        let motion = report.motion.unwrap();
        sum = sum.compose(&motion.increment());
        assert!((sum.translation - motion.since_engage.translation).norm() < 1e-5);
        assert_eq!(Some(motion.since_engage), report.pose);
    }
}

#[test]
fn a_latch_forgets_what_was_not_known_before_it() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, demo, 150);
    let sigma = |report: &HandReport| report.covariance.unwrap().fixed_view::<3, 3>(0, 0).trace().sqrt();
    let mut one: Vec<HandView> = eyes.iter().map(|eye| view(eye, &demo(5.0), 0.03, &mut noise)).collect();
    hide(&mut one, 1, &Ball::ALL);
    let alone = tracker.update(&one, 150 * 33_333);
    hide(&mut one, 0, &Ball::ALL);
    tracker.update(&one, 151 * 33_333);
    tracker.engage();
    let latched = see(&mut tracker, &eyes, &demo(152.0 / 30.0), 152, &mut noise);
    assert_eq!(latched.pose, Some(Pose::identity()));
    // after the latch it is as well known as in the first frame of all
    let mut fresh = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    let first = see(&mut fresh, &eyes, &demo(152.0 / 30.0), 0, &mut noise);
    assert!(sigma(&latched) < 1.2 * sigma(&first), "{} {}", sigma(&latched), sigma(&first));
    assert!(sigma(&latched) < sigma(&alone));
}

#[test]
fn a_restarted_tracker_is_as_a_new_one() {
    let (mut tracker, _) = after(&pair(30.0), demo, 100);
    tracker.restart();
    let new = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    assert_eq!(format!("{tracker:?}"), format!("{new:?}"));
}
