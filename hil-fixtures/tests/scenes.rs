//! Every named scene shows what its name says, and the same bytes every time.

use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::Rgb;
use tetrad_fixtures::{Background, BallTruth, Picture, Scene, golden};

fn scene(name: &str) -> Scene {
    Scene::named(name).unwrap_or_else(|| panic!("{name}: no such scene"))
}

fn rendered(scene: &Scene, frame: usize, camera: usize) -> Vec<u8> {
    let mut rgb = Vec::new();
    scene.render_rgb(frame, camera, &mut rgb);
    rgb
}

/// Least distance between two balls, in the larger one's diameters.
fn least_gap(truth: &[BallTruth; BALLS]) -> f64 {
    let mut least = f64::INFINITY;
    for (i, a) in truth.iter().enumerate() {
        for b in &truth[..i] {
            let (du, dv) = (a.centre.0 - b.centre.0, a.centre.1 - b.centre.1);
            least = least.min(du.hypot(dv) / a.diameter.max(b.diameter));
        }
    }
    least
}

fn visible(scene: &Scene, ball: Ball, frame: usize, camera: usize) -> f64 {
    scene.truth(frame, camera)[ball.index()].visible_fraction
}

#[test]
fn every_scene_starts_with_four_balls_apart_in_both_pictures() {
    let names = Scene::names();
    assert!(names.len() >= 37, "{}", names.len());
    for (name, about) in names {
        let scene = scene(&name);
        assert_eq!(scene.name, name);
        assert!(!about.is_empty());
        assert_eq!(scene.cameras(), 2);
        assert!(scene.frames() >= 60);
        for camera in 0..2 {
            assert_eq!(rendered(&scene, 0, camera).len(), 640 * 480 * 3, "{name}");
            let truth = scene.truth(0, camera);
            assert!(truth.iter().all(|ball| ball.visible_fraction > 0.999), "{name}: {truth:?}");
            assert!(least_gap(&truth) > 1.5, "{name}: {}", least_gap(&truth));
        }
    }
}

#[test]
fn unknown_names_and_values_out_of_range_are_refused() {
    for name in [
        "",
        "Demo",
        "static-2px",
        "static-81px",
        "static-16",
        "static-side-px",
        "linear-0.5",
        "linear-0-30fps",
        "linear-nan-30fps",
        "linear-9-30fps",
        "circular-0.5-0fps",
        "square-0.5-30fps",
    ] {
        assert!(Scene::named(name).is_none(), "{name}");
    }
    assert_eq!(scene("linear-0.4-25fps").fps, 25.0);
}

#[test]
fn static_scenes_have_the_size_they_are_named_after() {
    for size in [5, 8, 12, 16, 24, 32, 48, 65] {
        for kind in ["static", "static-side"] {
            let scene = scene(&format!("{kind}-{size}px"));
            for camera in 0..2 {
                let mean = scene.truth(0, camera).iter().map(|ball| ball.diameter).sum::<f64>() / 4.0;
                assert!((mean / f64::from(size) - 1.0).abs() < 0.05, "{kind}-{size}px: {mean}");
            }
            assert_ne!(scene.truth(0, 0), scene.truth(1, 0));
        }
    }
}

#[test]
fn moving_scenes_keep_the_balls_in_sight() {
    for name in ["demo", "linear-0.7-30fps", "circular-0.7-30fps", "linear-0.25-10fps", "dimming"] {
        let scene = scene(name);
        for frame in (0..scene.frames()).step_by(if name == "demo" { 7 } else { 1 }) {
            for camera in 0..2 {
                let truth = scene.truth(frame, camera);
                assert!(truth.iter().all(|ball| ball.visible_fraction > 0.999), "{name} {frame}: {truth:?}");
                assert!(least_gap(&truth) > 1.3, "{name} {frame}: {}", least_gap(&truth));
            }
        }
    }
}

#[test]
fn cover_hides_red_alone_for_a_second() {
    let scene = scene("cover");
    for camera in 0..2 {
        for frame in 60..=90 {
            assert_eq!(visible(&scene, Ball::Red, frame, camera), 0.0, "{frame}");
            for ball in [Ball::Green, Ball::Blue, Ball::Yellow] {
                assert!(visible(&scene, ball, frame, camera) > 0.999, "{frame}: {ball:?}");
            }
        }
        for frame in (0..36).chain(120..180) {
            assert_eq!(visible(&scene, Ball::Red, frame, camera), 1.0, "{frame}");
        }
    }
}

#[test]
fn cover_all_hides_all_for_a_second() {
    let scene = scene("cover-all");
    for camera in 0..2 {
        for ball in Ball::ALL {
            assert!((60..=90).all(|frame| visible(&scene, ball, frame, camera) == 0.0), "{ball:?}");
            assert!((120..180).all(|frame| visible(&scene, ball, frame, camera) == 1.0), "{ball:?}");
        }
    }
}

#[test]
fn crossing_hides_red_behind_green_in_each_camera_at_another_time() {
    let scene = scene("crossing");
    let hidden = |camera: usize| -> Vec<usize> {
        (0..scene.frames()).filter(|&frame| visible(&scene, Ball::Red, frame, camera) < 0.01).collect()
    };
    let (left, right) = (hidden(0), hidden(1));
    assert!(left.len() >= 3 && right.len() >= 3, "{left:?} {right:?}");
    assert!(left.last() < right.first(), "{left:?} {right:?}");
    for camera in 0..2 {
        for frame in 0..scene.frames() {
            for ball in [Ball::Green, Ball::Blue, Ball::Yellow] {
                assert_eq!(visible(&scene, ball, frame, camera), 1.0, "{frame}: {ball:?}");
            }
        }
        assert_eq!(visible(&scene, Ball::Red, scene.frames() - 1, camera), 1.0);
    }
}

#[test]
fn edge_cuts_and_returns() {
    let scene = scene("edge");
    for camera in 0..2 {
        let least = |ball| (0..210).map(|f| visible(&scene, ball, f, camera)).fold(1.0, f64::min);
        assert_eq!(least(Ball::Yellow), 0.0);
        assert!(least(Ball::Red) > 0.0 && least(Ball::Red) < 0.9);
        assert!(Ball::ALL.iter().all(|&ball| visible(&scene, ball, 209, camera) == 1.0));
    }
}

#[test]
fn the_second_red_ball_is_120_px_away_and_in_sight() {
    let scene = scene("distractor");
    let second = &scene.distractors[0];
    assert_eq!(second.albedo, scene.colours()[Ball::Red.index()]);
    for (camera, seen_by) in scene.cameras.iter().enumerate() {
        let (u, v) = seen_by.project(&second.centre_m).expect("in front");
        let truth = scene.truth(0, camera);
        let distance = |ball: &BallTruth| (ball.centre.0 - u).hypot(ball.centre.1 - v);
        assert!((distance(&truth[0]) - 120.0).abs() < 6.0, "{}", distance(&truth[0]));
        assert!(truth.iter().all(|ball| distance(ball) > 48.0));
    }
    assert_eq!(visible(&scene, Ball::Red, 75, 0), 0.0);
}

#[test]
fn dimming_ends_with_half_the_light() {
    let mut scene = scene("dimming");
    let mean = |rgb: Vec<u8>| rgb.iter().map(|&v| f64::from(v)).sum::<f64>() / rgb.len() as f64;
    let at_end = mean(rendered(&scene, 209, 0));
    scene.light.level.clear();
    let undimmed = mean(rendered(&scene, 209, 0));
    assert!((at_end / undimmed - 0.5).abs() < 0.002, "{at_end} {undimmed}");
}

#[test]
fn each_ball_matches_its_own_reference_colour_best() {
    let colours = scene("demo").colours().map(|[r, g, b]| Rgb::new(r as u8, g as u8, b as u8));
    for ball in Ball::ALL {
        let own = Primary::of(ball).luminance(colours[ball.index()]);
        for other in Ball::ALL.iter().filter(|&&other| other != ball) {
            let theirs = Primary::of(ball).luminance(colours[other.index()]);
            assert!(own > theirs + 100, "{ball:?} {own}, {other:?} {theirs}");
        }
    }
}

#[test]
fn frames_do_not_depend_on_what_was_rendered_before() {
    let (one, two) = (scene("demo"), scene("demo"));
    let forwards: Vec<_> = (40..44).map(|frame| rendered(&one, frame, 1)).collect();
    let mut backwards: Vec<_> = (40..44).rev().map(|frame| rendered(&two, frame, 1)).collect();
    backwards.reverse();
    assert_eq!(forwards, backwards);
    assert_ne!(forwards[0], forwards[1]);
    let mut reseeded = two;
    reseeded.seed += 1;
    assert_ne!(rendered(&reseeded, 40, 1), forwards[0]);
}

#[test]
fn frames_are_the_golden_ones() {
    let mut wrong = Vec::new();
    for (name, frames) in [
        ("demo", vec![0, 100, 17_999]),
        ("still", vec![0]),
        ("static-5px", vec![3]),
        ("static-side-65px", vec![3]),
        ("linear-0.7-10fps", vec![9]),
        ("circular-0.5-30fps", vec![50]),
        ("cover", vec![55, 75]),
        ("cover-all", vec![52]),
        ("crossing", vec![88]),
        ("dimming", vec![100]),
        ("distractor", vec![10]),
        ("edge", vec![90]),
        ("finger", vec![60]),
    ] {
        let scene = scene(name);
        for frame in frames {
            for camera in 0..scene.cameras() {
                let mut hash = golden::Fnv1a::default();
                hash.write(&rendered(&scene, frame, camera));
                for ball in scene.truth(frame, camera) {
                    for value in [
                        ball.centre.0,
                        ball.centre.1,
                        ball.outline_centre.0,
                        ball.outline_centre.1,
                        ball.diameter,
                        ball.visible_fraction,
                    ] {
                        hash.write(&value.to_bits().to_le_bytes());
                    }
                }
                let line = format!("{name}/{frame}/{camera}");
                wrong.extend(golden::check(&golden::data("frames.txt"), &line, hash.finish()).err());
            }
        }
    }
    let lines: Vec<String> = wrong.iter().map(ToString::to_string).collect();
    assert!(lines.is_empty(), "{}", lines.join("\n"));
}

#[test]
fn rods_are_drawn_when_asked_for_and_hide_no_ball() {
    let without = scene("still");
    let mut with = without.clone();
    with.rods = true;
    let changed = |a: &[u8], b: &[u8]| a.iter().zip(b).filter(|(p, q)| p.abs_diff(**q) > 20).count();
    for camera in 0..2 {
        let pixels = changed(&rendered(&without, 0, camera), &rendered(&with, 0, camera)) / 3;
        assert!(pixels > 100 && pixels < 1000, "{pixels}");
        for (bare, held) in without.truth(0, camera).iter().zip(with.truth(0, camera)) {
            assert_eq!(bare.outline_centre, held.outline_centre);
            assert!(held.visible_fraction > 0.95, "{held:?}");
        }
    }
}

#[test]
fn a_picture_given_is_the_background() {
    let mut scene = scene("still");
    let photograph = Picture::new(320, 240, [10, 200, 90].repeat(320 * 240)).expect("the right size");
    scene.background = Background::Pictures(vec![photograph]);
    scene.noise_sigma = 0.0;
    assert_eq!(rendered(&scene, 0, 1)[..3], [10, 200, 90]);
}
