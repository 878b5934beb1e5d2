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

use super::symmetric::add_lower;
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

/// Two equations, column by column.
pub type Pair = [[f32; 2]; UNKNOWNS + 1];

/// Factors smaller than this are none: a camera that was not told of.
const MIN_DIAGONAL: f32 = 1e-6;

/// Values of the cameras' unknowns, one array a camera.
pub type CameraUnknowns = [[f32; CAMERA]; MAX_VIEWS];

/// The triangle R with its right hand side d, for the pose and `cameras` cameras: about 15 KiB for eight
/// cameras, of which 1.3 KiB are touched with two.
#[derive(Clone, Debug)]
pub struct SquareRoot {
    rows: [Row; UNKNOWNS],
    /// How many unknowns are in use.
    unknowns: usize,
}

/// The rotation that takes a factor of an equation into the diagonal.
#[derive(Clone, Copy)]
struct Givens {
    cosine: f32,
    sine: f32,
}

impl Givens {
    /// `head` goes into `diagonal`; it is spent.
    fn into_diagonal(diagonal: &mut f32, head: f32) -> Self {
        if head == 0.0 {
            return Self { cosine: 1.0, sine: 0.0 };
        }
        let length = libm::sqrtf(*diagonal * *diagonal + head * head);
        let (cosine, sine) = (*diagonal / length, head / length);
        *diagonal = length;
        Self { cosine, sine }
    }

    /// Turns what stands in one column of the triangle's row and of the equation.
    fn turn(self, own: &mut f32, other: &mut f32) {
        let turned = self.cosine * *own + self.sine * *other;
        *other = self.cosine * *other - self.sine * *own;
        *own = turned;
    }
}

impl SquareRoot {
    /// Nothing known of a pose and so many cameras.
    #[must_use]
    pub fn new(cameras: usize) -> Self {
        Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns: POSE + CAMERA * cameras.min(MAX_VIEWS) }
    }

    /// Nothing is known any more, of a pose and so many cameras.
    pub fn clear(&mut self, cameras: usize) {
        self.rows.as_flattened_mut().fill(0.0);
        self.unknowns = POSE + CAMERA * cameras.min(MAX_VIEWS);
    }

    /// So many cameras can be told of from now on.
    pub fn make_room(&mut self, cameras: usize) {
        self.unknowns = self.unknowns.max(POSE + CAMERA * cameras.min(MAX_VIEWS));
    }

    /// Takes over what another one of as many cameras knows of them; the poses must have been taken out.
    pub fn copy_from(&mut self, other: &Self) {
        self.unknowns = other.unknowns;
        let rows = self.rows.iter_mut().zip(&other.rows).enumerate();
        for (place, (row, from)) in rows.take(self.unknowns).skip(POSE) {
            let behind = other.unknowns.saturating_sub(1 + place);
            let Some((right, diagonal, tail)) = parts(row, place, behind) else { return };
            let Some((from_right, from_factors)) = from.split_first() else { return };
            let mut from_factors = from_factors.iter().skip(place);
            *right = *from_right;
            *diagonal = from_factors.next().copied().unwrap_or(0.0);
            for (to, from) in tail.iter_mut().zip(from_factors) {
                *to = *from;
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
                let Some((own_right, diagonal, own_tail)) = parts(own, place, tail.len()) else { return };
                let rotation = Givens::into_diagonal(diagonal, *head);
                rotation.turn(own_right, right);
                for (own, other) in own_tail.iter_mut().zip(tail.iter_mut()) {
                    rotation.turn(own, other);
                }
            }
            rest = tail;
        }
    }

    /// Adds two equations, one after the other, as [`Self::insert`] does, in one pass over the triangle;
    /// they are used up.
    #[inline(never)]
    pub fn insert_both(&mut self, pair: &mut Pair) {
        let unknowns = self.unknowns;
        let Some((right, factors)) = pair.split_first_mut() else { return };
        let Some(mut rest) = factors.get_mut(..unknowns) else { return };
        for (place, own) in self.rows.iter_mut().enumerate() {
            let Some((head, tail)) = rest.split_first_mut() else { return };
            if *head != [0.0; 2] {
                let Some((own_right, diagonal, own_tail)) = parts(own, place, tail.len()) else { return };
                let rotations = head.map(|head| Givens::into_diagonal(diagonal, head));
                turn_both(&rotations, own_right, right);
                for (own, others) in own_tail.iter_mut().zip(tail.iter_mut()) {
                    turn_both(&rotations, own, others);
                }
            }
            rest = tail;
        }
    }

    /// Takes the pose out: what is left is what the equations tell of the cameras whatever it was.
    pub fn forget_pose(&mut self) {
        let width = self.unknowns + 1;
        for row in self.rows.iter_mut().take(POSE) {
            row.iter_mut().take(width).for_each(|value| *value = 0.0);
        }
    }

    /// Everything known becomes less certain: standard deviations times 1 / `share`.
    pub fn fade(&mut self, share: f32) {
        let width = self.unknowns + 1;
        for row in self.rows.iter_mut().take(self.unknowns) {
            row.iter_mut().take(width).for_each(|value| *value *= share);
        }
    }

    /// Takes one camera out, keeping what the equations tell of the others whatever it was. The pose
    /// must have been taken out before.
    #[cold]
    #[inline(never)]
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
        self.rows.as_flattened_mut().fill(0.0);
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
            let diagonal = row.get(1 + place).copied().unwrap_or(0.0);
            let known = row.iter().take(1 + self.unknowns).skip(2 + place);
            let solved = solution.as_flattened().iter().skip(1 + place - POSE);
            let rest: f32 = known.zip(solved).map(|(factor, value)| factor * value).sum();
            let right = row.first().copied().unwrap_or(0.0);
            if let Some(value) = solution.as_flattened_mut().get_mut(place - POSE) {
                *value = if diagonal.abs() > MIN_DIAGONAL { (right - rest) / diagonal } else { 0.0 };
            }
        }
        solution
    }

    /// The unknowns of the cameras are told from elsewhere from now on: from `step` further on.
    pub fn shift_cameras(&mut self, step: &CameraUnknowns) {
        let unknowns = self.unknowns;
        for (place, row) in self.rows.iter_mut().enumerate().take(unknowns).skip(POSE) {
            let Some((right, factors)) = row.split_first_mut() else { return };
            let factors = factors.iter().take(unknowns).skip(place);
            let steps = step.as_flattened().iter().skip(place - POSE);
            let moved: f32 = factors.zip(steps).map(|(factor, step)| factor * step).sum();
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
                add_lower(&mut covariance, &y, &y);
            }
            rest = tail;
        }
        covariance.fill_upper_triangle_with_lower_triangle();
        covariance
    }
}

fn turn_both([first, second]: &[Givens; 2], own: &mut f32, [one, other]: &mut [f32; 2]) {
    first.turn(own, one);
    second.turn(own, other);
}

/// Right hand side, diagonal and so many factors behind it of the row of an unknown.
fn parts(row: &mut Row, place: usize, behind: usize) -> Option<(&mut f32, &mut f32, &mut [f32])> {
    let (right, factors) = row.split_first_mut()?;
    let (diagonal, tail) = factors.get_mut(place..)?.split_first_mut()?;
    Some((right, diagonal, tail.get_mut(..behind)?))
}

#[cfg(test)]
mod tests;
