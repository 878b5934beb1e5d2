use super::*;
use nalgebra::{SMatrix, SVector};
use std::vec::Vec;

/// Two cameras.
const N: usize = 2 * CAMERA;

/// Equations with seeded factors.
fn equations(count: usize, seed: u32) -> Vec<(SVector<f64, N>, f64)> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 23) - 1.0
    };
    (0..count).map(|_| (SVector::from_fn(|_, _| next()), next())).collect()
}

fn insert(into: &mut SquareRoot, equations: &[(SVector<f64, N>, f64)]) {
    for (factors, right) in equations {
        let mut row = [[0.0]; UNKNOWNS + 1];
        row[0] = [*right as f32];
        for (to, factor) in row[1..].iter_mut().zip(factors.iter()) {
            *to = [*factor as f32];
        }
        into.insert(&mut row);
    }
}

/// The solution and the covariance by normal equations in double precision.
fn reference(equations: &[(SVector<f64, N>, f64)]) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
    let mut information = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (factors, value) in equations {
        information += factors * factors.transpose();
        right += factors * *value;
    }
    let covariance = information.try_inverse().unwrap();
    (covariance * right, covariance)
}

#[test]
fn the_solution_is_that_of_the_normal_equations() {
    let told = equations(60, 1);
    let mut known = SquareRoot::new(2);
    insert(&mut known, &told);
    let (solution, covariance) = reference(&told);
    for (value, expected) in known.solve_cameras().as_flattened().iter().zip(&solution) {
        assert!((f64::from(*value) - expected).abs() < 1e-4, "{value} {expected}");
    }
    // six quantities that depend on the cameras
    let factors = equations(6, 2);
    let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
    for (k, (of, _)) in factors.iter().enumerate() {
        for (column, factor) in columns.iter_mut().zip(of.iter()) {
            column[k] = *factor as f32;
        }
    }
    let spread = known.spread(&mut columns);
    for (a, (left, _)) in factors.iter().enumerate() {
        for (b, (right, _)) in factors.iter().enumerate() {
            let expected = (left.transpose() * covariance * right)[0];
            assert!((f64::from(spread[(a, b)]) - expected).abs() < 1e-4, "{a} {b}");
        }
    }
}

#[test]
fn several_equations_at_once_are_as_one_after_the_other() {
    let mut told = equations(64, 6);
    // what is not told of, in some of the equations or in all
    for (factors, _) in told.iter_mut().skip(12) {
        factors.fixed_rows_mut::<3>(3).fill(0.0);
    }
    for (factors, _) in &mut told {
        factors[9] = 0.0;
    }
    let mut known = SquareRoot::new(2);
    insert(&mut known, &told);
    let mut together = SquareRoot::new(2);
    for eight in told.as_chunks::<8>().0 {
        let mut columns = [[0.0; 8]; UNKNOWNS + 1];
        for (k, (factors, right)) in eight.iter().enumerate() {
            columns[0][k] = *right as f32;
            for (to, factor) in columns[1..].iter_mut().zip(factors.iter()) {
                to[k] = *factor as f32;
            }
        }
        together.insert(&mut columns);
    }
    for (a, b) in together.rows.as_flattened().iter().zip(known.rows.as_flattened()) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

#[test]
fn a_shifted_origin_moves_the_solution_and_nothing_else() {
    let mut known = SquareRoot::new(2);
    insert(&mut known, &equations(60, 3));
    let before = known.solve_cameras();
    known.shift_cameras(&before);
    assert!(known.solve_cameras().as_flattened().iter().all(|x| x.abs() < 1e-5));
}

#[test]
fn what_is_taken_out_leaves_the_rest_as_it_was() {
    let told = equations(60, 4);
    let (solution, covariance) = reference(&told);
    let mut known = SquareRoot::new(2);
    insert(&mut known, &told);
    known.forget_camera(0);
    let after = known.solve_cameras();
    assert_eq!(after[0], [0.0; CAMERA]);
    for (value, expected) in after[1].iter().zip(solution.iter().skip(CAMERA)) {
        assert!((f64::from(*value) - expected).abs() < 1e-4, "{value} {expected}");
    }
    let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
    for (k, column) in columns.iter_mut().skip(CAMERA).take(6).enumerate() {
        column[k] = 1.0;
    }
    let spread = known.spread(&mut columns);
    let block = covariance.fixed_view::<6, 6>(CAMERA, CAMERA);
    assert!((spread.cast::<f64>() - block).amax() < 1e-4);

    // the other one, from a fresh start: its place is in the middle of the row
    let mut known = SquareRoot::new(2);
    insert(&mut known, &told);
    known.forget_camera(1);
    let after = known.solve_cameras();
    assert_eq!(after[1], [0.0; CAMERA]);
    for (value, expected) in after[0].iter().zip(&solution) {
        assert!((f64::from(*value) - expected).abs() < 1e-4, "{value} {expected}");
    }
}

#[test]
fn fading_widens_and_moves_nothing() {
    let mut known = SquareRoot::new(2);
    insert(&mut known, &equations(60, 5));
    let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
    columns[3][0] = 1.0;
    let (before, of_before) = (known.solve_cameras(), known.spread(&mut columns.clone())[(0, 0)]);
    known.fade(0.5);
    let (after, of_after) = (known.solve_cameras(), known.spread(&mut columns)[(0, 0)]);
    for (a, b) in before.as_flattened().iter().zip(after.as_flattened()) {
        assert!((a - b).abs() < 1e-5);
    }
    assert!((of_after / of_before - 4.0).abs() < 1e-3);
}
