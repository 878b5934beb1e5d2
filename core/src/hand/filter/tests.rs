use super::*;
use crate::config::{OneEuroConfig, Prediction};
use crate::hand::synthetic::rotation;
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::vec::Vec;

const FRAME_US: u64 = 33_333;

fn off(lead_us: u32) -> FilterConfig {
    FilterConfig { smoothing: Smoothing::Off, lead_us, ..FilterConfig::default() }
}

fn vector(most: f32) -> impl Strategy<Value = Vector3<f32>> {
    prop::array::uniform3(-most..most).prop_map(Vector3::from)
}

fn any_pose() -> impl Strategy<Value = Pose> {
    (rotation(3.1), vector(1.0)).prop_map(|(rotation, translation)| Pose { rotation, translation })
}

/// Where a hand is after `s` seconds at these constant velocities.
fn moved(start: &Pose, velocity: Vector3<f32>, turn: Vector3<f32>, s: f32) -> Pose {
    Pose { rotation: so3::exp(&(turn * s)) * start.rotation, translation: start.translation + velocity * s }
}

/// Metres and radians between two poses.
fn apart(a: &Pose, b: &Pose) -> (f32, f32) {
    let turned = so3::log(&(a.rotation * b.rotation.transpose()));
    ((a.translation - b.translation).norm(), turned.norm())
}

fn is_finite(pose: &Pose) -> bool {
    pose.translation.iter().chain(pose.rotation.iter()).all(|x| x.is_finite())
}

proptest! {
    #[test]
    fn a_steady_motion_is_predicted_exactly(
        start in any_pose(),
        velocity in vector(1.0),
        turn in vector(3.0),
        gaps in prop::collection::vec(5_000_u64..80_000, 3..30),
        lead_us in 0_u32..200_000,
        accelerated in any::<bool>(),
    ) {
        let prediction = if accelerated { Prediction::Acceleration } else { Prediction::Velocity };
        let mut filter = PoseFilter::new(FilterConfig { prediction, ..off(lead_us) }).unwrap();
        let (mut t_us, mut seen) = (1_000_000, 0);
        for gap in gaps {
            let now = moved(&start, velocity, turn, (t_us - 1_000_000) as f32 * 1e-6);
            let given = filter.measure(t_us, &now).unwrap();
            seen += 1;
            if seen >= 3 {
                // single precision of the measurements, seen over 5 ms or more and carried on by 0.2 s
                let expected = moved(&now, velocity, turn, lead_us as f32 * 1e-6);
                let (metres, radians) = apart(&given, &expected);
                prop_assert!(metres < 3e-4 && radians < 3e-4, "{seen}: {metres} m, {radians} rad");
            }
            t_us += gap;
        }
    }

    #[test]
    fn without_smoothing_and_lead_nothing_is_changed(
        poses in prop::collection::vec(any_pose(), 1..20),
    ) {
        let mut filter = PoseFilter::new(off(0)).unwrap();
        for (frame, pose) in poses.iter().enumerate() {
            prop_assert_eq!(filter.measure(frame as u64 * FRAME_US, pose), Ok(*pose));
        }
    }

    /// Whatever axes the hand is seen in, it is smoothed and carried on alike.
    #[test]
    fn the_axes_do_not_matter(
        a_from_b in any_pose(),
        start in any_pose(),
        steps in prop::collection::vec((vector(0.03), vector(0.2)), 2..20),
        lead_us in 0_u32..100_000,
    ) {
        let config = FilterConfig { lead_us, prediction: Prediction::Acceleration, ..FilterConfig::default() };
        let (mut in_b, mut in_a) = (PoseFilter::new(config).unwrap(), PoseFilter::new(config).unwrap());
        let mut pose = start;
        for (frame, (step, turn)) in steps.into_iter().enumerate() {
            pose = moved(&pose, step, turn, 1.0);
            pose.rotation = nearest(&pose.rotation);
            let t_us = frame as u64 * FRAME_US;
            let expected = a_from_b.compose(&in_b.measure(t_us, &pose).unwrap());
            let given = in_a.measure(t_us, &a_from_b.compose(&pose)).unwrap();
            let (metres, radians) = apart(&given, &expected);
            prop_assert!(metres < 1e-4 && radians < 1e-4, "{frame}: {metres} m, {radians} rad");
        }
    }

    /// Whatever comes at whatever time: what is given is finite, a rotation, and within reach.
    #[test]
    fn nothing_wild_comes_out(
        inputs in prop::collection::vec((any::<bool>(), 0_u64..3_000_000, rotation(3.1), vector(999.0)), 1..40),
        lead_us in 0_u32..200_000,
        accelerated in any::<bool>(),
        smooth in any::<bool>(),
    ) {
        let prediction = if accelerated { Prediction::Acceleration } else { Prediction::Velocity };
        let smoothing = if smooth { FilterConfig::default().smoothing } else { Smoothing::Off };
        let config = FilterConfig { prediction, smoothing, lead_us, ..FilterConfig::default() };
        let mut filter = PoseFilter::new(config).unwrap();
        // fastest and hardest for the whole of coast and lead
        let s = 0.3;
        let reach = config.max_speed_m_s * s + 0.5 * config.max_acceleration_m_s2 * s * s;
        for (measured, t_us, rotation, translation) in inputs {
            let pose = Pose { rotation, translation };
            let given = if measured { filter.measure(t_us, &pose).ok() } else { filter.coast(t_us) };
            if let Some(given) = given {
                prop_assert!(is_finite(&given));
                let skew = given.rotation.transpose() * given.rotation - Matrix3::identity();
                prop_assert!(skew.norm() < 1e-4, "{skew}");
                let smoothed = filter.state.as_ref().unwrap().smoothed;
                prop_assert!((given.translation - smoothed.translation).norm() <= reach + 1e-3);
            }
        }
    }

    #[test]
    fn any_numbers_are_taken_or_refused(
        numbers in prop::array::uniform12(any::<f32>()),
        t_us in any::<u64>(),
    ) {
        let mut filter = PoseFilter::new(FilterConfig::default()).unwrap();
        filter.measure(1, &Pose::identity()).unwrap();
        let pose = Pose {
            rotation: Matrix3::from_column_slice(&numbers[..9]),
            translation: Vector3::from_column_slice(&numbers[9..]),
        };
        if let Ok(given) = filter.measure(t_us, &pose) {
            prop_assert!(is_finite(&given));
        }
    }
}

fn nearest(rotation: &Matrix3<f32>) -> Matrix3<f32> {
    crate::hand::orientation::nearest_rotation_step(rotation)
}

/// A hand along x, in metres at the times of the frames.
fn run(filter: &mut PoseFilter, frames: std::ops::Range<u64>, x_at: impl Fn(f32) -> f32) -> Vec<f32> {
    frames
        .map(|frame| {
            let t_us = frame * FRAME_US;
            let translation = Vector3::x() * x_at(t_us as f32 * 1e-6);
            filter.measure(t_us, &Pose { translation, ..Pose::identity() }).unwrap().translation.x
        })
        .collect()
}

#[test]
fn constant_acceleration_is_predicted_by_the_model_of_it_alone() {
    let x_at = |t: f32| 0.5 * 2.0 * t * t - 0.3 * t;
    let error = |prediction| {
        let mut filter = PoseFilter::new(FilterConfig { prediction, ..off(100_000) }).unwrap();
        let given = run(&mut filter, 0..20, x_at);
        (given[19] - x_at(19.0 * FRAME_US as f32 * 1e-6 + 0.1)).abs()
    };
    assert!(error(Prediction::Acceleration) < 2e-4, "{}", error(Prediction::Acceleration));
    assert!(error(Prediction::Velocity) > 0.01, "{}", error(Prediction::Velocity));
}

/// The low pass alone is 1 / (2 pi cutoff) late: see `OneEuroConfig`.
#[test]
fn the_lag_at_half_a_metre_a_second_is_a_third_of_a_frame() {
    let mut filter = PoseFilter::new(FilterConfig::default()).unwrap();
    let x_at = |t: f32| 0.5 * t;
    let given = run(&mut filter, 0..60, x_at);
    let lag_s = (x_at(59.0 * FRAME_US as f32 * 1e-6) - given[59]) / 0.5;
    assert!((lag_s - 0.01224).abs() < 2e-4, "{lag_s}");
}

#[test]
fn a_dropout_is_carried_over_and_then_stands() {
    let mut filter = PoseFilter::new(off(20_000)).unwrap();
    assert_eq!(filter.coast(0), None);
    run(&mut filter, 0..10, |t| 0.5 * t);
    let last_us = 9 * FRAME_US;
    let x = |t_us| filter.coast(t_us).map(|pose| pose.translation.x);
    let at = |s: f32| 0.5 * (last_us as f32 * 1e-6 + s);
    for (after_us, s) in [(0, 0.02), (50_000, 0.07), (100_000, 0.12), (300_000, 0.12), (500_000, 0.12)] {
        let given = x(last_us + after_us).unwrap();
        assert!((given - at(s)).abs() < 1e-5, "{after_us}: {given}");
    }
    assert_eq!(x(last_us + 500_001), None);
    assert!((x(0).unwrap() - at(0.02)).abs() < 1e-5, "a time before the measurement is that of it");

    // what was unseen for less than half a second is gone on with; then the velocity is forgotten
    let seen = |after_us, filter: &PoseFilter| {
        let pose = Pose { translation: Vector3::x() * at(after_us as f32 * 1e-6), ..Pose::identity() };
        filter.clone().measure(last_us + after_us, &pose).unwrap().translation.x
    };
    assert!((seen(400_000, &filter) - at(0.42)).abs() < 1e-4);
    assert!((seen(600_000, &filter) - at(0.6)).abs() < 1e-6);
}

#[test]
fn after_a_reset_the_hand_is_where_it_is_and_at_rest() {
    let mut filter = PoseFilter::new(FilterConfig { lead_us: 100_000, ..FilterConfig::default() }).unwrap();
    run(&mut filter, 0..10, |t| 0.5 * t);
    filter.reset();
    assert_eq!(filter.coast(10 * FRAME_US), None);
    let given = run(&mut filter, 10..20, |_| -0.2);
    assert_eq!(given, [-0.2; 10]);
    // a clock that was set back is no trouble after a reset
    filter.reset();
    assert_eq!(filter.measure(5, &Pose::identity()), Ok(Pose::identity()));
}

#[test]
fn what_is_refused_changes_nothing() {
    let mut filter = PoseFilter::new(FilterConfig { lead_us: 50_000, ..FilterConfig::default() }).unwrap();
    run(&mut filter, 0..10, |t| 0.5 * t);
    let before = filter.coast(9 * FRAME_US);
    let pose = Pose::identity();
    let far = Pose { translation: Vector3::y() * 1001.0, ..pose };
    let nan = Pose { rotation: pose.rotation * f32::NAN, ..pose };
    let mirror = Pose { rotation: -pose.rotation, ..pose };
    let scaled = Pose { rotation: pose.rotation * 1.01, ..pose };
    for (t_us, pose, reason) in [
        (9 * FRAME_US, pose, FilterRefusal::NotLater),
        (0, pose, FilterRefusal::NotLater),
        (10 * FRAME_US, far, FilterRefusal::NotFinite),
        (10 * FRAME_US, nan, FilterRefusal::NotFinite),
        (10 * FRAME_US, mirror, FilterRefusal::NotARotation),
        (10 * FRAME_US, scaled, FilterRefusal::NotARotation),
    ] {
        assert_eq!(filter.measure(t_us, &pose), Err(reason));
        assert_eq!(filter.coast(9 * FRAME_US), before);
    }
}

#[test]
fn settings_that_cannot_be_worked_with_are_named() {
    use FilterConfigError::*;
    let good = FilterConfig::default();
    assert!(PoseFilter::new(good).is_ok(), "and so PoseFilter::default is one");
    let euro = |euro| FilterConfig { smoothing: Smoothing::OneEuro(euro), ..good };
    let plain = OneEuroConfig::default();
    for (config, error) in [
        (FilterConfig { lead_us: 200_001, ..good }, Lead),
        (FilterConfig { memory_us: 0, ..good }, Memory),
        (FilterConfig { coast_us: 500_001, restart_us: 600_000, ..good }, Coast),
        (FilterConfig { restart_us: 99_999, ..good }, Coast),
        (euro(OneEuroConfig { min_cutoff_hz: 0.0, ..plain }), Cutoff),
        (euro(OneEuroConfig { turn_cutoff_per_rad_s: f32::NAN, ..plain }), Cutoff),
        (FilterConfig { max_speed_m_s: f32::INFINITY, ..good }, Bound),
    ] {
        assert_eq!(PoseFilter::new(config).map(|_| ()), Err(error));
    }
}
