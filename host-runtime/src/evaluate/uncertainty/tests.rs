use super::*;
use crate::evaluate::headline::table;
use crate::evaluate::statistics::tests::{pose_mm, trace};
use nalgebra::{Matrix6, Vector3};
use tetrad_core::observation::ImageCovariance;

#[test]
fn an_error_of_one_sigma_in_every_direction_counts_as_its_dimensions() {
    let covariance = ImageCovariance { uu: 0.04, uv: 0.0, vv: 0.09 };
    let seen = Observation { covariance, ..Observation::default() };
    assert!((mahalanobis(&seen, (0.2, -0.3)) - 2.0).abs() < 1e-6);
    assert!(mahalanobis(&Observation::default(), (0.2, 0.3)).is_nan());
    let error = PoseError {
        translation_m: Vector3::new(0.001, -0.001, 0.001),
        rotation_rad: Vector3::new(0.01, 0.01, -0.01),
        covariance: Some(Matrix6::from_diagonal(&Vector6::new(1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4))),
    };
    assert!((normalised(&error) - 6.0).abs() < 1e-5);
    assert!(normalised(&PoseError { covariance: None, ..error }).is_nan());
}

fn ratio(squares: &[f64]) -> Ratio {
    let mut ratio = Ratio::default();
    squares.iter().for_each(|&square| ratio.add(square));
    ratio
}

fn by_scene(ratios: &[(&str, Ratio)]) -> Vec<(String, Ratio)> {
    ratios.iter().map(|(scene, ratio)| ((*scene).to_owned(), *ratio)).collect()
}

/// What stands in the first table, and the verdict.
fn line(ratios: &[(&str, Ratio)]) -> (String, String) {
    let headline = headline("centre", "visible", &by_scene(ratios), Told::words(""));
    let row: Vec<String> = table(&[headline]).rows[0].iter().map(Cell::text).collect();
    (row[2].clone(), row[4].clone())
}

#[test]
fn the_pooled_ratio_stands_beside_that_of_the_worst_scene() {
    let (text, verdict) = line(&[("rest", ratio(&[1.0; 6])), ("cover", ratio(&[0.04, 0.04]))]);
    assert_eq!(text, "0.87 of 8 samples; worst scene 0.20 (cover, 2 samples)");
    assert_eq!(verdict, "held");
    assert_eq!(line(&[("rest", ratio(&[4.0; 3]))]).1, "NOT held");
}

#[test]
fn a_ratio_that_cannot_be_formed_is_counted_and_breaks_the_promise() {
    let failed = ratio(&[1.0, f64::NAN, f64::INFINITY]);
    assert_eq!((failed.count, failed.failed), (1, 2));
    let (text, verdict) = line(&[("rest", ratio(&[1.0])), ("cover", failed)]);
    assert_eq!(text, "1.00 of 4 samples; worst scene none (cover, 3 samples); 2 have no usable covariance");
    assert_eq!(verdict, "NOT held");
}

#[test]
fn a_state_that_never_occurs_is_named_and_proves_nothing() {
    let (text, verdict) = line(&[("rest", Ratio::default())]);
    assert_eq!((text.as_str(), verdict.as_str()), ("did not occur", "NOT held"));
    assert_eq!(cells(Ratio::default())[2].text(), "did not occur");
    assert_eq!(cells(ratio(&[1.0, f64::NAN])).map(|cell| cell.text()), ["2", "1", "1.00"]);
}

#[test]
fn a_pose_without_an_error_or_a_covariance_is_a_failure_of_its_state() {
    let mut hands = vec![pose_mm(Some((PoseState::Held, 1.0)))];
    hands.push(HandTrace { error: None, ..hands[0] });
    let found = poses(&trace(hands), PoseState::Held);
    assert_eq!((found.count, found.failed), (0, 2));
}

#[test]
fn every_state_of_centre_and_pose_has_a_line() {
    let case = Case::new(format!("{LABEL}a"), Scene::named("static-16px").unwrap(), 1, &[]);
    let traced = [Traced { case, traces: vec![trace(vec![pose_mm(None)])] }];
    let outcome = outcome(Plan::new(1, true), &traced);
    let lines: Vec<String> = outcome.headlines.iter().map(|line| line.what.clone()).collect();
    for state in ["visible", "occluded", "predicted"] {
        assert!(lines.iter().any(|line| line.contains(&format!("centre {state}"))), "{lines:?}");
    }
    for state in ["both", "three", "one", "predicted", "held"] {
        assert!(lines.iter().any(|line| line.contains(&format!("pose {state}"))), "{lines:?}");
    }
}
