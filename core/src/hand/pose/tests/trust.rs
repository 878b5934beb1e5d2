//! Cameras that freeze, or are taken for each other: the pose is never told better than it is known.

use super::simulated::{Hand, Noise, circular, demo, hide, linear, pair, view};
use super::tally::errors;
use crate::config::HandConfig;
use crate::hand::pose::PoseTracker;
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use crate::observation::Ball;
use nalgebra::Vector3;
use std::vec::Vec;

/// Runs a movement in which the views are changed on the way; every measured pose is within four of
/// its standard deviations, whatever happens. Gives the states.
fn states(
    path: fn(f64) -> Hand,
    frames: usize,
    seed: u64,
    mut change: impl FnMut(usize, &mut Vec<HandView>),
) -> Vec<PoseState> {
    let eyes = pair(30.0);
    let mut noise = Noise(seed * 7919 + 17);
    let mut tracker = PoseTracker::new(crate::hand::synthetic::arms(), HandConfig::default());
    let mut states = Vec::new();
    for frame in 0..frames {
        let hand = path(frame as f64 / 30.0);
        let mut views: Vec<HandView> = eyes.iter().map(|eye| view(eye, &hand, 0.03, &mut noise)).collect();
        change(frame, &mut views);
        let report = tracker.update(&views, frame as u64 * 33_333);
        states.push(report.state);
        if let (true, Some(pose), Some(covariance)) =
            (report.state.is_measured(), report.pose, report.covariance)
        {
            let error: Vector3<f64> = errors(&path(0.0), &hand, &pose).fixed_rows::<3>(0).into();
            let sigma = f64::from(covariance.m11 + covariance.m22 + covariance.m33).sqrt();
            assert!(
                error.norm() < 4.0 * sigma,
                "seed {seed}, frame {frame}, {}: {} mm, sigma {} mm",
                report.state.name(),
                error.norm() * 1e3,
                sigma * 1e3
            );
        }
    }
    states
}

const PATHS: [fn(f64) -> Hand; 3] = [circular, linear, demo];

#[test]
fn a_frozen_camera_is_left_out_until_it_runs_again() {
    for path in PATHS {
        for seed in 0..4 {
            for frozen in 0..2 {
                let mut picture = None;
                let states = states(path, 200, seed, |frame, views| {
                    if (60..160).contains(&frame) {
                        views[frozen] = *picture.get_or_insert(views[frozen]);
                    }
                });
                assert!(states[..60].iter().all(|state| *state == PoseState::Both));
                assert!(states[64..160].iter().all(|state| *state == PoseState::One), "{states:?}");
                assert!(states[190..].iter().all(|state| *state == PoseState::Both), "{states:?}");
            }
        }
    }
}

#[test]
fn a_frozen_picture_with_noise_of_its_own_is_no_better() {
    for seed in 0..4 {
        for frozen in 0..2 {
            let (eyes, mut noise) = (pair(30.0), Noise(seed));
            let states = states(circular, 160, seed, |frame, views| {
                if frame >= 60 {
                    views[frozen] = view(&eyes[frozen], &circular(2.0), 0.03, &mut noise);
                }
            });
            assert!(states[64..].iter().all(|state| *state == PoseState::One), "{states:?}");
        }
    }
}

#[test]
fn a_frozen_camera_alone_measures_nothing() {
    let mut picture = None;
    let states = states(circular, 200, 1, |frame, views| {
        if frame >= 60 {
            views[1] = *picture.get_or_insert(views[1]);
        }
        // the other sees nothing for more than the time after which all is doubted
        if (80..150).contains(&frame) {
            hide(views, 0, &Ball::ALL);
        }
    });
    assert!(states[80..150].iter().all(|state| !state.is_measured()), "{states:?}");
    assert!(states[150..].iter().all(|state| *state == PoseState::One), "{states:?}");
}

#[test]
fn swapped_cameras_unseen_before_they_are_latched_anew_carry_on_the_doubt() {
    let states = states(circular, 150, 2, |frame, views| {
        if frame >= 60 {
            views.swap(0, 1);
        }
        if (91..110).contains(&frame) {
            hide(views, 0, &Ball::ALL);
            hide(views, 1, &Ball::ALL);
        }
    });
    assert!(states[60..110].iter().all(|state| !state.is_measured()), "{states:?}");
    assert_eq!(states[149], PoseState::Both);
}

#[test]
fn swapped_cameras_are_are_not_believed() {
    for path in PATHS {
        for seed in 0..4 {
            let states = states(path, 150, seed, |frame, views| {
                if frame >= 60 {
                    views.swap(0, 1);
                }
            });
            assert!(states[60..90].iter().all(|state| !state.is_measured()), "{states:?}");
            assert_eq!(states[149], PoseState::Both, "latched anew");
        }
    }
}
