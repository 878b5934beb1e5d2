use super::*;
use crate::config::MAX_VIEWS;
use crate::geometry::ImagePoint;
use crate::hand::perspective::{Sighting, project};
use crate::hand::pose::square_root::SquareRoot;
use crate::hand::so3;
use crate::hand::synthetic::arms;
use nalgebra::{SMatrix, SVector, Vector3, Vector6};

const VIEWS: usize = if MAX_VIEWS < 3 { MAX_VIEWS } else { 3 };

const N: usize = POSE + CAMERA * VIEWS;

/// How well each unknown of the cameras is known besides.
const KNOWN: f32 = 20.0;

/// Cameras a metre from the hand, what they see of it (balls that are missing: `hidden`), and its pose as it is
/// taken for, some pixels off.
fn scene(hidden: &[(usize, usize)]) -> (Pose, [(Camera, Sightings); VIEWS]) {
    let arms = arms();
    let hand = Pose {
        rotation: so3::exp(&Vector3::new(0.3, -0.2, 0.4)),
        translation: Vector3::new(0.02, -0.01, 0.03),
    };
    let taken_for = Pose { translation: hand.translation + Vector3::new(0.002, 0.003, -0.004), ..hand };
    let views = core::array::from_fn(|view| {
        let turn = view as f32 * 0.8 - 0.5;
        let latched = Pose {
            rotation: so3::exp(&Vector3::new(0.1, turn, 0.2)),
            translation: Vector3::new(0.05, 0.02, 1.0),
        };
        let camera = Camera::new(&latched, &Pose::identity(), &Vector3::repeat(0.02), 800.0);
        let seen = camera.sees(&hand);
        let mut sightings = arms.balls_in_frame().map(|ball| {
            let x = project(&(seen.rotation * ball + seen.translation), 800.0).unwrap().x_px;
            let origin = ImagePoint::new(0.0, 0.0);
            Sighting::new(ImagePoint::new(x.x, x.y), origin, 0.0, 800.0, [0.25, 0.1, 0.5])
        });
        for (_, ball) in hidden.iter().filter(|(of, _)| *of == view) {
            sightings[*ball] = None;
        }
        (camera, sightings)
    });
    (taken_for, views)
}

/// The cameras' unknowns and their covariance, by normal equations in double precision with the pose among the
/// unknowns.
fn reference(pose: &Pose, views: &[(Camera, Sightings)]) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let mut information = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for unknown in POSE..N {
        information[(unknown, unknown)] = f64::from(KNOWN * KNOWN);
    }
    for (view, (camera, sightings)) in views.iter().enumerate() {
        compare_view(pose, camera, sightings, arms(), |_, at| {
            for (axis, of_camera) in camera.sensitivity(at).iter().enumerate() {
                let mut row = SVector::<f64, N>::zeros();
                for (to, from) in row.iter_mut().zip(&at.pose[axis]) {
                    *to = f64::from(*from);
                }
                for (to, from) in row.iter_mut().skip(POSE + CAMERA * view).zip(of_camera) {
                    *to = f64::from(*from);
                }
                information += row * row.transpose();
                right += row * f64::from(at.residual[axis]);
            }
        });
    }
    let covariance = information.try_inverse().unwrap();
    (covariance * right, covariance)
}

/// What is known of the cameras from what they see of a hand whose pose is not known.
fn known(pose: &Pose, views: &[(Camera, Sightings)]) -> SquareRoot {
    let mut known = SquareRoot::new(VIEWS);
    for unknown in 0..CAMERA * VIEWS {
        let mut row = [[0.0]; UNKNOWNS + 1];
        row[1 + unknown] = [KNOWN];
        known.insert(&mut row);
    }
    let mut gathered = OfView::EMPTY;
    for (view, (camera, sightings)) in views.iter().enumerate() {
        let mut equations = OfView::EMPTY;
        equations.write((view, camera), pose, sightings, arms(), 1.0);
        if view == 0 {
            gathered = equations;
            known.insert(&mut gathered.gather_pose(view));
        } else {
            equations.take_pose_out(&mut gathered, CAMERA * VIEWS);
            known.insert(&mut equations.cameras);
        }
    }
    known
}

#[test]
fn what_is_left_of_the_cameras_is_what_the_equations_say_whatever_the_pose_is() {
    let nothing_of_the_first: [(usize, usize); BALLS] = core::array::from_fn(|ball| (0, ball));
    let hidden: [&[(usize, usize)]; 5] =
        [&[], &[(0, 1)], &[(1, 0), (1, 3)], &[(0, 0), (0, 1), (0, 3)], &nothing_of_the_first];
    for hidden in hidden {
        let (pose, views) = scene(hidden);
        // one view that sees at most four balls, and another, fix the pose
        let (solution, covariance) = reference(&pose, &views);
        let known = known(&pose, &views);
        let solved = known.solve_cameras();
        for (place, (value, expected)) in
            solved.as_flattened().iter().zip(solution.iter().skip(POSE)).enumerate()
        {
            let sigma = covariance[(POSE + place, POSE + place)].sqrt();
            assert!(
                (f64::from(*value) - expected).abs() < 1e-2 * sigma,
                "{hidden:?} {place}: {value} {expected}"
            );
        }
        for place in 0..CAMERA * VIEWS {
            let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
            columns[place][0] = 1.0;
            let (spread, expected) =
                (known.spread(&mut columns)[(0, 0)], covariance[(POSE + place, POSE + place)]);
            assert!(
                (f64::from(spread) / expected - 1.0).abs() < 1e-3,
                "{hidden:?} {place}: {spread} {expected}"
            );
        }
    }
}

#[test]
fn noise_is_a_matter_of_units() {
    let (pose, [(camera, sightings), ..]) = scene(&[(0, 2)]);
    let (mut plain, mut noisy) = (OfView::EMPTY, OfView::EMPTY);
    plain.write((0, &camera), &pose, &sightings, arms(), 1.0);
    noisy.write((0, &camera), &pose, &sightings, arms(), 4.0);
    let columns = |of: &OfView| of.pose.into_iter().chain(of.cameras);
    for (plain, noisy) in columns(&plain).zip(columns(&noisy)) {
        assert_eq!(plain, noisy.map(|value| 4.0 * value));
    }
    let told = |of: &OfView, ball: usize| columns(of).any(|column| column[2 * ball..][..2] != [0.0; 2]);
    assert_eq!([0, 1, 2, 3].map(|ball| told(&plain, ball)), [true, true, false, true]);
}
