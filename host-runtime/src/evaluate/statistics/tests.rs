use super::*;
use crate::evaluate::headline::{Headline, NOTHING, table};
use crate::evaluate::run::Variant;
use crate::evaluate::trace::Times;
use crate::settings::Mode;
use std::time::Duration;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{Observation, ObservationState};
use tetrad_fixtures::BallTruth;

/// A run of these hands, of no balls.
pub(crate) fn trace(hands: Vec<HandTrace>) -> Trace {
    let mut trace = Trace::new(Variant::of(Mode::Refined));
    let times = Times { rendering: Duration::ZERO, tracking: Vec::new(), hand: Duration::ZERO };
    let frame = |hand| TraceFrame { t_s: 0.0, cameras: Vec::new(), hand: Some(hand), times: times.clone() };
    trace.frames = hands.into_iter().map(frame).collect();
    trace
}

/// A hand in a state and so many millimetres off; lost without.
pub(crate) fn pose_mm(pose: Option<(PoseState, f64)>) -> HandTrace {
    let error = pose.map(|(_, mm)| PoseError {
        translation_m: Vector3::new(mm / 1e3, 0.0, 0.0),
        rotation_rad: Vector3::zeros(),
        covariance: None,
    });
    let state = pose.map_or(PoseState::Lost, |(state, _)| state);
    HandTrace { state, truth_m: Vector3::zeros(), error, step_error_m: None }
}

/// What stands in the first table for `refined`, and the verdict.
fn line(refined: Told) -> (String, String) {
    let headline = Headline {
        what: String::new(),
        published: NOTHING,
        promised: "something",
        refined,
        paper: Told::words(""),
    };
    let row: Vec<String> = table(&[headline]).rows[0].iter().map(Cell::text).collect();
    (row[2].clone(), row[4].clone())
}

fn ball(state: ObservationState, off_px: f64) -> BallTrace {
    let truth = BallTruth {
        outline_centre: (10.0, 10.0),
        centre: (10.0, 10.0),
        diameter: 16.0,
        visible_fraction: 1.0,
    };
    let centre = ImagePoint { u: (10.0 + off_px) as f32, v: 10.0 };
    BallTrace { truth, seen: Observation { state, centre, ..Observation::default() } }
}

fn centres(balls: &[BallTrace]) -> Centres {
    let mut trace = trace(vec![pose_mm(None)]);
    trace.frames[0].cameras = balls.iter().map(|&ball| [ball; 4]).collect();
    Centres::of(&trace, |_| true)
}

const CENTRE_BOUNDS: (Bound, Bound) = (Bound::Most(0.1), Bound::Most(0.2));

fn of_centres(several: &[Centres]) -> (String, String) {
    line(Centres::worst(several.iter(), CENTRE_BOUNDS))
}

#[test]
fn a_whole_ball_that_is_said_to_be_covered_counts_with_its_error() {
    let good = centres(&[ball(ObservationState::Visible, 0.0625)]);
    assert_eq!(
        of_centres(std::slice::from_ref(&good)),
        ("0.062 px, at most 0.06".to_owned(), "held".to_owned())
    );
    let covered = centres(&[ball(ObservationState::Visible, 0.0625), ball(ObservationState::Occluded, 0.5)]);
    assert_eq!(of_centres(&[covered]).1, "NOT held");
    let predicted =
        centres(&[ball(ObservationState::Visible, 0.0625), ball(ObservationState::Predicted, 0.5)]);
    assert_eq!(of_centres(&[good, predicted]).0, "0.062 px, at most 0.06, 50.0 % measured");
}

#[test]
fn a_cell_without_a_measured_ball_is_no_good_figure() {
    let good = centres(&[ball(ObservationState::Visible, 0.0625)]);
    let lost = centres(&[ball(ObservationState::Lost, 0.0)]);
    let broken = centres(&[ball(ObservationState::Visible, f64::NAN), ball(ObservationState::Visible, 0.0)]);
    for bad in [lost.clone(), broken, Centres::default()] {
        for several in [[good.clone(), bad.clone()], [bad.clone(), good.clone()]] {
            let (text, verdict) = of_centres(&several);
            assert!(text.starts_with("not measured"), "{text}");
            assert_eq!(verdict, "NOT held");
        }
    }
    assert_eq!(of_centres(&[good, lost]).0, "not measured, 0.0 % measured");
    assert_eq!(of_centres(&[]).0, "not measured");
}

const POSE_BOUNDS: PoseBounds = PoseBounds { mean_mm: Bound::Most(0.6), ..PoseBounds::FREE };

fn of_poses(several: &[Poses]) -> (String, String) {
    line(Poses::worst(several.iter(), &POSE_BOUNDS))
}

#[test]
fn a_run_without_a_measured_pose_is_not_left_out() {
    let good = Poses::of(&trace(vec![pose_mm(Some((PoseState::Both, 0.5))); 4]));
    assert_eq!(good.share(), 1.0);
    assert_eq!(of_poses(std::slice::from_ref(&good)).1, "held");
    let held = Poses::of(&trace(vec![pose_mm(Some((PoseState::Held, 0.5))), pose_mm(None)]));
    let broken = Poses::of(&trace(vec![
        pose_mm(Some((PoseState::Both, f64::NAN))),
        pose_mm(Some((PoseState::Both, 0.1))),
    ]));
    for bad in [held, broken, Poses::of(&trace(Vec::new()))] {
        for several in [[good.clone(), bad.clone()], [bad.clone(), good.clone()]] {
            let (text, verdict) = of_poses(&several);
            assert!(text.starts_with("not measured") || text.contains("mean not measured"), "{text}");
            assert_eq!(verdict, "NOT held");
        }
    }
}

#[test]
fn the_share_of_poses_is_told_and_the_lowest_of_several() {
    let pose = pose_mm(Some((PoseState::One, 0.5)));
    let runs = [vec![pose; 4], vec![pose, pose, pose, pose_mm(None)]].map(|hands| Poses::of(&trace(hands)));
    let (text, verdict) = of_poses(&runs);
    assert!(text.ends_with(", 75.0 % measured"), "{text}");
    assert_eq!(verdict, "held");
}
