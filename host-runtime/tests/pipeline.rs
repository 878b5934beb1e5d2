//! The pipeline as a library: frames in, hand out, with the hand's prediction going back.

use std::ops::Range;
use tetrad::learning;
use tetrad::pipeline::{HandStep, Pipeline, PipelineConfig};
use tetrad_core::config::{FilterConfig, HandConfig, LearnConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::HandReport;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_fixtures::{Background, Scene};

/// Both pictures of a frame.
fn pictures(scene: &Scene, frame: usize) -> [Vec<u8>; 2] {
    [0, 1].map(|camera| {
        let mut rgb = Vec::new();
        scene.render_rgb(frame, camera, &mut rgb);
        rgb
    })
}

fn views<'a>(scene: &Scene, rgb: &'a [Vec<u8>; 2]) -> [FrameView<'a>; 2] {
    [0, 1].map(|c| FrameView::packed(&rgb[c], scene.width, scene.height, PixelFormat::Rgb888).unwrap())
}

/// A pipeline that was taught the balls where they are in frame 0.
fn taught(scene: &Scene, config: PipelineConfig) -> Pipeline {
    let rgb = pictures(scene, 0);
    let starts = [0, 1].map(|camera| {
        let points = scene
            .truth(0, camera)
            .map(|ball| Some(ImagePoint::new(ball.outline_centre.0 as f32, ball.outline_centre.1 as f32)));
        let frame = views(scene, &rgb)[camera];
        learning::start_with(&learning::learn_at(&frame, &points, &LearnConfig::default()).unwrap())
    });
    let arms = Arms::equal(scene.arm_m as f32).unwrap();
    Pipeline::new(&starts, config, Some(arms)).unwrap()
}

/// The hand's step in a frame, seen in these pictures.
fn step(pipeline: &mut Pipeline, scene: &Scene, frame: usize, rgb: &[Vec<u8>; 2]) -> HandStep {
    let t_us = (scene.time_s(frame) * 1e6) as u64;
    pipeline.step(&views(scene, rgb).map(|view| (view, t_us))).hand.unwrap()
}

/// The hand's steps over some frames of a scene in `paper` mode. In the frames `dark` the pictures are
/// black.
fn track(scene: &Scene, frames: impl Iterator<Item = usize>, dark: &Range<usize>) -> Vec<HandReport> {
    let mut pipeline = taught(scene, PipelineConfig::paper());
    frames
        .map(|frame| {
            let mut rgb = pictures(scene, frame);
            if dark.contains(&frame) {
                rgb.iter_mut().for_each(|picture| picture.fill(0));
            }
            step(&mut pipeline, scene, frame, &rgb).report
        })
        .collect()
}

/// How far the hand is from where it should be, seen from where it was in frame 0, metres.
fn error_m(scene: &Scene, frame: usize, hand: &HandReport) -> f64 {
    let (first, now) = (scene.hand(0), scene.hand(frame));
    let moved = first.rotation.transpose() * (now.translation - first.translation);
    (hand.pose.unwrap().translation.cast::<f64>() - moved).norm()
}

/// How far the hand moves from one frame to another, metres.
fn moved_m(scene: &Scene, from: usize, to: usize) -> f64 {
    (scene.hand(to).translation - scene.hand(from).translation).norm()
}

#[test]
fn a_hand_out_of_sight_is_held_then_lost_and_comes_back_where_it_is() {
    let mut scene = Scene::named("linear-0.25-30fps").unwrap();
    scene.background = Background::Plain(168.0);
    // the lenses are covered for a second while the hand moves
    let dark = 20..50;
    let steps = track(&scene, 0..60, &dark);

    let hold = HandConfig::default().max_predicted_frames as usize;
    for (frame, step) in steps.iter().enumerate() {
        let state = match frame {
            _ if frame < dark.start => PoseState::Both,
            _ if frame < dark.start + hold => PoseState::Held,
            _ if frame < dark.end => PoseState::Lost,
            _ => continue,
        };
        assert_eq!((step.state, step.motion.is_ok()), (state, state == PoseState::Both), "frame {frame}");
        assert_eq!(step.pose.is_some(), state != PoseState::Lost, "frame {frame}");
    }
    assert_eq!(steps[dark.start].pose, steps[dark.start - 1].pose, "held where it was");

    let back = (dark.end..60).find(|&frame| steps[frame].motion.is_ok()).expect("it comes back");
    assert!(back < dark.end + 3, "frame {back}");
    assert!(steps[back].motion.unwrap().spans > 1, "its increment bridges what was unseen");
    assert_eq!(steps[59].state, PoseState::Both);
    let (away, error) = (moved_m(&scene, dark.start, back), error_m(&scene, back, &steps[back]));
    assert!(away > 0.1 && error < 0.15 * away, "{error} m off after {away} m unseen");
}

#[test]
fn one_frame_in_three_is_enough_for_a_calm_hand() {
    let scene = Scene::named("linear-0.25-30fps").unwrap();
    for (i, step) in track(&scene, (0..60).step_by(3), &(0..0)).iter().enumerate() {
        assert_eq!(step.state, PoseState::Both, "frame {}", 3 * i);
    }
}

#[test]
fn an_engage_in_motion_starts_the_filter_anew() {
    const AT: usize = 30;
    let mut scene = Scene::named("linear-0.25-30fps").unwrap();
    scene.background = Background::Plain(168.0);
    assert!(moved_m(&scene, 0, AT) > 0.05 && moved_m(&scene, AT - 1, AT) > 0.005, "in full motion");
    let lead = FilterConfig { lead_us: 50_000, ..FilterConfig::default() };
    for config in [PipelineConfig::paper(), PipelineConfig::refined()] {
        let mut pipeline = taught(&scene, config).with_filter(PoseFilter::new(lead).unwrap());
        for frame in 0..AT {
            step(&mut pipeline, &scene, frame, &pictures(&scene, frame));
        }
        pipeline.engage();
        let hand = step(&mut pipeline, &scene, AT, &pictures(&scene, AT));
        assert_eq!(hand.report.motion.unwrap().engagements, 1);
        // neither drawn back to where the hand was in the old axes, nor carried on at the old speed
        let (filtered, pose) = (hand.filtered.unwrap(), hand.report.pose.unwrap());
        // there and back through the turn's logarithm costs a bit
        let apart =
            (filtered.translation - pose.translation).norm() + (filtered.rotation - pose.rotation).norm();
        assert!(apart < 1e-6, "{:?}: {apart}", config.hand_mode);
        let off = filtered.translation.norm();
        assert!(f64::from(off) < 1.5 * moved_m(&scene, AT - 1, AT), "{off} m from where it was latched");
    }
}
