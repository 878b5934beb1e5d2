//! What is known of many unknowns, as a triangle: the square root of their information matrix.
//!
//! The knowledge is the least squares problem `min |R x - d|^2` with R upper triangular, so that
//! `(R^t R)^-1` is the covariance of x. A new equation `a x = b`, in units of its standard deviation,
//! is rotated into the triangle (Givens). Information matrices themselves would need f64: here those
//! of a focal length and of a direction differ by 10^7, and f32 would lose the smaller one in the
//! subtraction that takes an unknown out. The triangle holds their roots, and taking out the first
//! unknowns is leaving out the first rows.
//!
//! Unknowns that nobody told anything about have a row of zeros.

use crate::config::MAX_VIEWS;
use nalgebra::{Matrix6, Vector6};

/// Unknowns of a pose: they come first.
pub const POSE: usize = 6;

/// Unknowns of a camera: turn (3), place in the picture (2), scale, focal length.
pub const CAMERA: usize = 7;

/// The most unknowns.
pub const UNKNOWNS: usize = POSE + CAMERA * MAX_VIEWS;

/// One equation: its right hand side, then the unknowns' factors.
pub type Row = [f32; UNKNOWNS + 1];

/// Factors smaller than this are none: a camera that was not told of.
const MIN_DIAGONAL: f32 = 1e-6;

/// Values of the cameras' unknowns, one array a camera.
pub type CameraUnknowns = [[f32; CAMERA]; MAX_VIEWS];

/// The triangle R with its right hand side d, for the pose and `cameras` cameras: about 15 KiB, of
/// which 1.3 KiB are touched with two cameras.
#[derive(Clone, Debug)]
pub struct SquareRoot {
    rows: [Row; UNKNOWNS],
    /// How many unknowns are in use.
    unknowns: usize,
}

impl SquareRoot {
    /// Nothing known of a pose and so many cameras.
    #[must_use]
    pub fn new(cameras: usize) -> Self {
        Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns: POSE + CAMERA * cameras.min(MAX_VIEWS) }
    }

    /// So many cameras can be told of from now on.
    pub fn make_room(&mut self, cameras: usize) {
        self.unknowns = self.unknowns.max(POSE + CAMERA * cameras.min(MAX_VIEWS));
    }

    /// Takes over what another one of as many cameras knows.
    pub fn copy_from(&mut self, other: &Self) {
        self.unknowns = other.unknowns;
        let width = self.unknowns + 1;
        for (row, from) in self.rows.iter_mut().zip(&other.rows).take(self.unknowns) {
            for (a, b) in row.iter_mut().zip(from).take(width) {
                *a = *b;
            }
        }
    }

    /// Adds one equation; the row is used up.
    pub fn insert(&mut self, row: &mut Row) {
        let unknowns = self.unknowns;
        let Some((right, factors)) = row.split_first_mut() else { return };
        let Some(mut rest) = factors.get_mut(..unknowns) else { return };
        for (place, own) in self.rows.iter_mut().enumerate() {
            let Some((head, tail)) = rest.split_first_mut() else { return };
            if *head != 0.0 {
                let Some((own_right, own_factors)) = own.split_first_mut() else { return };
                let Some(own_factors) = own_factors.get_mut(place..unknowns) else { return };
                let Some((diagonal, own_tail)) = own_factors.split_first_mut() else { return };
                let length = libm::sqrtf(*diagonal * *diagonal + *head * *head);
                let (cosine, sine) = (*diagonal / length, *head / length);
                *diagonal = length;
                let rotate = |a: &mut f32, b: &mut f32| {
                    let turned = cosine * *a + sine * *b;
                    *b = cosine * *b - sine * *a;
                    *a = turned;
                };
                rotate(own_right, right);
                for (a, b) in own_tail.iter_mut().zip(tail.iter_mut()) {
                    rotate(a, b);
                }
            }
            rest = tail;
        }
    }

    /// Takes the pose out: what is left is what the equations tell of the cameras whatever it was.
    pub fn forget_pose(&mut self) {
        for row in self.rows.iter_mut().take(POSE) {
            *row = [0.0; UNKNOWNS + 1];
        }
    }

    /// Everything known becomes less certain: standard deviations times 1 / `share`.
    pub fn fade(&mut self, share: f32) {
        for value in self.rows.iter_mut().take(self.unknowns).flatten() {
            *value *= share;
        }
    }

    /// Takes one camera out, keeping what the equations tell of the others whatever it was. The pose
    /// must have been taken out before.
    pub fn forget_camera(&mut self, camera: usize) {
        let empty = [0.0; UNKNOWNS + 1];
        let unknowns = self.unknowns;
        let first = 1 + POSE + CAMERA * camera;
        // with this camera's unknowns in front, leaving out the first rows takes it out
        let mut turned = Self { rows: [empty; UNKNOWNS], unknowns };
        for from in self.rows.iter().take(unknowns) {
            let own = from.iter().skip(first).take(CAMERA);
            let before = from.iter().take(first).skip(1 + POSE);
            let after = from.iter().take(unknowns + 1).skip(first + CAMERA);
            let mut row = empty;
            for (to, value) in row.iter_mut().zip(from.iter().take(1).chain(own).chain(before).chain(after)) {
                *to = *value;
            }
            turned.insert(&mut row);
        }
        *self = Self { rows: [empty; UNKNOWNS], unknowns };
        for from in turned.rows.iter().take(unknowns).skip(CAMERA) {
            let mut row = empty;
            let places = (0..1).chain(1 + POSE..first).chain(first + CAMERA..unknowns + 1);
            let values = from.iter().take(1).chain(from.iter().skip(1 + CAMERA));
            for (place, value) in places.zip(values) {
                if let Some(to) = row.get_mut(place) {
                    *to = *value;
                }
            }
            self.insert(&mut row);
        }
    }

    /// The cameras' unknowns that fit best, 0 for those that nothing is known of.
    #[must_use]
    pub fn solve_cameras(&self) -> CameraUnknowns {
        let mut solution = [[0.0; CAMERA]; MAX_VIEWS];
        for (place, row) in self.rows.iter().enumerate().take(self.unknowns).skip(POSE).rev() {
            let known = row.iter().skip(1 + POSE).zip(solution.as_flattened());
            let diagonal = row.get(1 + place).copied().unwrap_or(0.0);
            // the unknowns up to this one are still zero
            let rest: f32 = known.map(|(factor, value)| factor * value).sum();
            let right = row.first().copied().unwrap_or(0.0);
            if let Some(value) = solution.as_flattened_mut().get_mut(place - POSE) {
                *value = if diagonal.abs() > MIN_DIAGONAL { (right - rest) / diagonal } else { 0.0 };
            }
        }
        solution
    }

    /// The unknowns of the cameras are told from elsewhere from now on: from `step` further on.
    pub fn shift_cameras(&mut self, step: &CameraUnknowns) {
        for row in self.rows.iter_mut().take(self.unknowns).skip(POSE) {
            let Some((right, factors)) = row.split_first_mut() else { return };
            let moved: f32 = factors.iter().skip(POSE).zip(step.as_flattened()).map(|(a, b)| a * b).sum();
            *right -= moved;
        }
    }

    /// `K^t (R^t R)^-1 K` for the six columns K (one Vector6 for each unknown of the cameras, in
    /// order): the covariance that the cameras' uncertainty gives to what depends on them by K.
    #[must_use]
    pub fn spread(&self, columns: &mut [Vector6<f32>; CAMERA * MAX_VIEWS]) -> Matrix6<f32> {
        let mut covariance = Matrix6::zeros();
        let Some(mut rest) = columns.get_mut(..self.unknowns.saturating_sub(POSE)) else { return covariance };
        for (place, row) in self.rows.iter().enumerate().skip(POSE) {
            let Some((head, tail)) = rest.split_first_mut() else { break };
            let mut factors = row.iter().skip(1 + place);
            let diagonal = factors.next().copied().unwrap_or(0.0);
            if diagonal.abs() > MIN_DIAGONAL {
                let y = *head / diagonal;
                for (column, factor) in tail.iter_mut().zip(factors) {
                    *column -= y * *factor;
                }
                covariance += y * y.transpose();
            }
            rest = tail;
        }
        covariance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{SMatrix, SVector};
    use std::vec::Vec;

    /// Two cameras: 6 + 14 unknowns.
    const N: usize = POSE + 2 * CAMERA;

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
            let mut row: Row = [0.0; UNKNOWNS + 1];
            row[0] = *right as f32;
            for (to, factor) in row[1..].iter_mut().zip(factors.iter()) {
                *to = *factor as f32;
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
        for (value, expected) in known.solve_cameras().as_flattened().iter().zip(solution.iter().skip(POSE)) {
            assert!((f64::from(*value) - expected).abs() < 1e-4, "{value} {expected}");
        }
        // six quantities that depend on the cameras
        let factors = equations(6, 2);
        let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
        for (k, (of, _)) in factors.iter().enumerate() {
            for (column, factor) in columns.iter_mut().zip(of.iter().skip(POSE)) {
                column[k] = *factor as f32;
            }
        }
        let spread = known.spread(&mut columns);
        for (a, (left, _)) in factors.iter().enumerate() {
            for (b, (right, _)) in factors.iter().enumerate() {
                let (mut left, mut right) = (*left, *right);
                left.fixed_rows_mut::<POSE>(0).fill(0.0);
                right.fixed_rows_mut::<POSE>(0).fill(0.0);
                let expected = (left.transpose() * covariance * right)[0];
                assert!((f64::from(spread[(a, b)]) - expected).abs() < 1e-4, "{a} {b}");
            }
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
        known.forget_pose();
        known.forget_camera(0);
        let after = known.solve_cameras();
        assert_eq!(after[0], [0.0; CAMERA]);
        for (value, expected) in after[1].iter().zip(solution.iter().skip(POSE + CAMERA)) {
            assert!((f64::from(*value) - expected).abs() < 1e-4, "{value} {expected}");
        }
        let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
        for (k, column) in columns.iter_mut().skip(CAMERA).take(6).enumerate() {
            column[k] = 1.0;
        }
        let spread = known.spread(&mut columns);
        let block = covariance.fixed_view::<6, 6>(POSE + CAMERA, POSE + CAMERA);
        assert!((spread.cast::<f64>() - block).amax() < 1e-4);

        // the other one, from a fresh start: its place is in the middle of the row
        let mut known = SquareRoot::new(2);
        insert(&mut known, &told);
        known.forget_pose();
        known.forget_camera(1);
        let after = known.solve_cameras();
        assert_eq!(after[1], [0.0; CAMERA]);
        for (value, expected) in after[0].iter().zip(solution.iter().skip(POSE)) {
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
}
