//! Balls hidden, wrong, or worse than they say: the state and the covariance tell it.

use super::simulated::{Hand, circular, demo, hide, linear, pair, slow, view};
use super::tally::{after, holds, is_honest, run};
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use crate::observation::{BALLS, Ball, ImageCovariance};
use std::vec::Vec;

#[test]
fn degraded_states_are_named_and_honest() {
    // five seconds whole, then half a second each of a missing ball, a missing camera, and nothing
    let cover = |frame: usize, views: &mut [HandView]| match frame % 90 {
        0..15 => {}
        15..30 => hide(views, 1, &[Ball::Blue]),
        30..40 => hide(views, 0, &Ball::ALL),
        40..50 => hide(views, 1, &Ball::ALL),
        50..56 => {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &[Ball::Red]);
        }
        70..85 => {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &Ball::ALL);
        }
        _ => {}
    };
    for (name, path) in
        [("slow", slow as fn(f64) -> Hand), ("demo", demo), ("linear", linear), ("circular", circular)]
    {
        let tally = run(name, &pair(30.0), path, 720, 0.03, 8, cover);
        for (state, (n, ..)) in &tally.states {
            assert!(*n > 100, "{}: {n}", state.name());
        }
        assert_eq!(tally.states.len(), 5);
        is_honest(&tally);
    }
}

#[test]
fn a_hand_that_is_covered_again_and_again_is_as_well_known_as_it_says() {
    // a second in sight, then more than a second without: the gaps' own velocities teach nothing
    let palm = |frame: usize, views: &mut [HandView]| {
        if frame % 80 >= 35 {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &Ball::ALL);
        }
    };
    for (name, path) in
        [("slow", slow as fn(f64) -> Hand), ("demo", demo), ("linear", linear), ("circular", circular)]
    {
        let tally = run(name, &pair(30.0), path, 2400, 0.02, 1, palm);
        for state in [PoseState::Predicted, PoseState::Held] {
            assert!(tally.states[&state].0 >= 140, "{} of {name}", state.name());
        }
        is_honest(&tally);
    }
}

/// Red hidden in every second second, seen by one camera alone.
fn red_hidden(frame: usize, views: &mut [HandView]) {
    if frame % 60 >= 30 {
        hide(views, 0, &[Ball::Red]);
    }
}

#[test]
fn three_balls_in_one_view_feign_no_pose() {
    // on these paths the plane of the three comes to face the camera: two poses become one and part again
    for (name, path) in [("slow", slow as fn(f64) -> Hand), ("demo", demo)] {
        for eye in pair(30.0) {
            let tally = run(name, &[eye], path, 600, 0.02, 6, red_hidden);
            for state in [PoseState::One, PoseState::Held] {
                let (n, squares, ..) = tally.states[&state];
                let ratio = (squares / n as f64).sqrt();
                assert!(n >= 900 && (0.7..1.4).contains(&ratio), "{}: {ratio} of {n}", state.name());
            }
            // also across the line of sight, where one camera is ten times surer than along it
            let (n, squares, ..) = tally.states[&PoseState::Predicted];
            let ratio = (squares / n as f64).sqrt();
            assert!((0.6..1.2).contains(&ratio), "predicted: {ratio} of {n}");
        }
    }
}

#[test]
fn a_wrong_ball_is_left_out() {
    let wrong = |frame: usize, views: &mut [HandView]| {
        if frame % 20 > 10 {
            views[1].balls[Ball::Green.index()].centre.u += 12.0;
        }
    };
    let tally = run("wrong ball", &pair(30.0), demo, 300, 0.03, 4, wrong);
    holds(&tally, 1.0, 0.3, 0.3);
    assert!(tally.states.contains_key(&PoseState::Three), "and the state says so");
    is_honest(&tally);
}

#[test]
fn centres_that_are_worse_than_they_say_are_found_out() {
    let liar = |_: usize, views: &mut [HandView]| {
        for ball in views.iter_mut().flat_map(|view| &mut view.balls) {
            ball.covariance = ImageCovariance::isotropic(0.02);
        }
    };
    let tally = run("liar", &pair(30.0), demo, 600, 0.1, 3, liar);
    is_honest(&tally);
}

#[test]
fn balls_are_expected_where_they_will_be_also_in_a_blind_camera() {
    let eyes = pair(30.0);
    let (mut tracker, mut noise) = after(&eyes, slow, 120);
    for frame in 120..180 {
        let hand = slow(frame as f64 / 30.0);
        let truth: Vec<HandView> = eyes.iter().map(|eye| view(eye, &hand, 0.0, &mut noise)).collect();
        for (camera, truth) in truth.iter().enumerate() {
            let expected = tracker.predict(camera, frame as u64 * 33_333);
            for (expected, truth) in expected.iter().zip(&truth.balls) {
                let off = expected.expect("a place").distance(truth.centre);
                assert!(off < 2.0, "frame {frame}, camera {camera}: {off} px");
            }
        }
        let mut views: Vec<HandView> = eyes.iter().map(|eye| view(eye, &hand, 0.03, &mut noise)).collect();
        hide(&mut views, 0, &Ball::ALL);
        assert_eq!(tracker.update(&views, frame as u64 * 33_333).state, PoseState::One);
    }
    assert_eq!(tracker.predict(2, 180 * 33_333), [None; BALLS]);
    assert_eq!(tracker.predict(0, 1 << 40), [None; BALLS], "too long ago");
}
