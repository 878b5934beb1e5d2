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

    /// Adds all that another one knows of the cameras.
    pub fn insert_cameras_of(&mut self, other: &Self) {
        for from in other.rows.iter().take(other.unknowns).skip(POSE) {
            let mut row = *from;
            self.insert(&mut row);
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

    /// Takes one camera out, keeping what the equations tell of the others whatever it was.
    pub fn forget_camera(&mut self, camera: usize) {
        // the unknowns of this camera change places with the pose's and one more that is never told
        // of, are taken out with them, and the rest is put back
        let mut turned = Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns: self.unknowns };
        let first = 1 + POSE + CAMERA * camera;
        for from in self.rows.iter().take(self.unknowns) {
            let mut row = [0.0; UNKNOWNS + 1];
            let own = from.iter().skip(first).take(CAMERA);
            let before = from.iter().take(first).skip(1 + POSE);
            let after = from.iter().take(self.unknowns + 1).skip(first + CAMERA);
            // right hand side, the camera's seven, and the others where they end up one unknown
            // later than the pose's six leave them; the pose is known to be out
            let others = before.chain(after);
            let values = from.iter().take(1).chain(own).chain(others);
            for (to, value) in row.iter_mut().zip(values) {
                *to = *value;
            }
            turned.insert(&mut row);
        }
        let kept = turned;
        *self = Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns: kept.unknowns };
        for from in kept.rows.iter().take(kept.unknowns).skip(CAMERA) {
            let mut row = [0.0; UNKNOWNS + 1];
            let right = from.iter().take(1);
            let others = from.iter().skip(1 + CAMERA);
            for (to, value) in row.iter_mut().zip(right) {
                *to = *value;
            }
            // the camera's own places stay zero
            let places = 1 + POSE..first;
            let places = places.chain(first + CAMERA..kept.unknowns + 1);
            for (place, value) in places.zip(others) {
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
