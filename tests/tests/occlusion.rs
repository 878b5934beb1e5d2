//! Promise: balls that are covered, cross each other, lose half their light or meet another ball of
//! their colour keep their labels; a hidden ball is never called visible; no ball, hidden or in sight,
//! is measured more than its diameter away from where it is; a ball that comes back is measured again
//! within three frames.

mod common;

use common::Tracked;
use tetrad::pipeline::PipelineConfig;
use tetrad_core::observation::{BALLS, Ball, ObservationState};
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::Scene;

/// From this share of its outline on a ball is in sight: recovery is counted from there.
const IN_SIGHT: f64 = 0.7;

/// Below this share a ball is as good as hidden: nothing of it can be measured as whole.
const HIDDEN: f64 = 0.02;

/// Frames from being in sight again to being measured again.
const RECOVERY_FRAMES: usize = 3;

/// What tracking a scene broke, and how often the scene put the promise to the test.
#[derive(Default)]
struct Findings {
    broken: Vec<String>,
    /// How often a ball came back into sight.
    returns: usize,
    /// Frames in which a ball was hidden.
    hidden: usize,
}

/// Where one ball stands with being in sight.
#[derive(Clone, Copy, Default)]
struct Sight {
    was_hidden: bool,
    in_sight_since: usize,
}

/// Tracks both cameras of a scene, each for itself or with the hand they see `predicting` the balls,
/// and holds every frame to the promise.
fn findings(scene: &Scene, config: PipelineConfig, predicting: bool) -> Findings {
    let name = &scene.name;
    let mut findings = Findings::default();
    let mut sights = vec![[Sight::default(); BALLS]; scene.cameras()];
    let mut hold = |camera: usize, tracked: &Tracked| {
        for (ball, sight) in Ball::ALL.into_iter().zip(&mut sights[camera]) {
            if let Some(broken) = judge(tracked, ball, sight, &mut findings) {
                let (truth, seen) = tracked.ball(ball);
                findings.broken.push(format!(
                    "{name}{}, camera {camera}, frame {}, {}: {broken} ({}, {:.1} px off, {:.2} in sight)",
                    if predicting { ", hand predicting" } else { "" },
                    tracked.frame,
                    ball.name(),
                    seen.state.name(),
                    tracked.error_px(ball),
                    truth.visible_fraction,
                ));
            }
        }
    };
    if predicting {
        common::track_hand_with(scene, config, hold);
    } else {
        for camera in 0..scene.cameras() {
            common::track_as(scene, camera, config.tracker, PixelFormat::Rgb888, |tracked| {
                hold(camera, tracked)
            });
        }
    }
    findings
}

/// What is wrong with a ball in a frame.
fn judge(tracked: &Tracked, ball: Ball, sight: &mut Sight, findings: &mut Findings) -> Option<&'static str> {
    let (truth, seen) = tracked.ball(ball);
    if truth.visible_fraction < HIDDEN {
        findings.hidden += 1;
        sight.was_hidden = true;
        if seen.state == ObservationState::Visible {
            return Some("hidden, and called visible");
        }
    }
    if truth.visible_fraction <= IN_SIGHT {
        sight.in_sight_since = tracked.frame + 1;
    } else {
        if sight.was_hidden {
            findings.returns += 1;
            sight.was_hidden = false;
        }
        if tracked.frame >= sight.in_sight_since + RECOVERY_FRAMES && !tracked.holds(ball) {
            return Some("in sight for three frames, and not measured");
        }
    }
    // A measurement, of a part of a ball too, belongs to the ball it is named after: at least to the
    // place where that ball is, and never to another one.
    if seen.state.is_measured() {
        let own = tracked.error_px(ball);
        if own > truth.diameter {
            return Some("measured where it is not");
        }
        let other = Ball::ALL.into_iter().filter(|other| *other != ball);
        let nearest = other.map(|other| tracked.distance_px(ball, other)).fold(f64::INFINITY, f64::min);
        if nearest < own && nearest < truth.diameter / 2.0 {
            return Some("another ball's place");
        }
    }
    None
}

fn check(name: &str) -> Findings {
    check_scene(&common::scene(name), PipelineConfig::paper())
}

fn check_scene(scene: &Scene, config: PipelineConfig) -> Findings {
    let [mut alone, predicted] = [false, true].map(|predicting| findings(scene, config, predicting));
    alone.broken.extend(predicted.broken);
    assert!(alone.broken.is_empty(), "{}", alone.broken.join("\n"));
    alone
}

#[test]
fn a_covered_ball_is_predicted_and_comes_back() {
    let findings = check("cover");
    assert!(findings.hidden >= 20 && findings.returns >= 2, "the scene covers no ball");
}

#[test]
fn four_covered_balls_come_back_under_their_own_names() {
    let findings = check("cover-all");
    assert!(findings.hidden >= 80 && findings.returns >= 8, "the scene does not cover all balls");
}

/// Nine seconds of a moving hand before a desk full of coloured things, of which a palm hides the hand
/// three times for longer than anybody predicts it. `paper` mode, which knows no rims, does take some for
/// balls.
#[test]
fn while_the_hand_is_covered_nothing_on_a_cluttered_desk_is_taken_for_a_ball() {
    let mut scene = common::scene("demo");
    scene.frames = 270;
    scene.occluders = common::scene("cover-all").occluders;
    for palm in &mut scene.occluders {
        let once = palm.reach.clone();
        let at = |after_s: f64| once.iter().map(move |(t_s, reach)| (t_s + after_s, *reach));
        palm.reach = [0.0, 2.7, 5.4].into_iter().flat_map(at).collect();
    }
    let findings = check_scene(&scene, PipelineConfig::refined());
    assert!(findings.hidden >= 1000 && findings.returns >= 16, "the scene does not cover all balls");
}

#[test]
fn crossing_balls_keep_their_names() {
    let findings = check("crossing");
    assert!(findings.hidden >= 4 && findings.returns >= 2, "no ball passes behind another");
}

#[test]
fn half_the_light_loses_no_ball() {
    check("dimming");
}

#[test]
fn a_ball_of_the_same_colour_is_not_taken_for_a_covered_one() {
    let findings = check("distractor");
    assert!(findings.hidden >= 20 && findings.returns >= 2, "the scene covers no ball");
}

#[test]
fn a_ball_that_leaves_the_picture_comes_back() {
    let findings = check("edge");
    assert!(findings.returns >= 1, "no ball leaves the picture");
}

#[test]
fn a_finger_on_the_rim_takes_no_ball_away() {
    check("finger");
}
