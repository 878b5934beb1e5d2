//! What is known of many unknowns, as a triangle: the square root of their information matrix.
//!
//! The knowledge is the least squares problem `min |R x - d|^2` with R upper triangular, so that
//! `(R^t R)^-1` is the covariance of x. New equations `a x = b`, in units of their standard deviation,
//! are reflected into the triangle, several at once (Householder). Information matrices themselves would
//! need f64: here those of a focal length and of a direction differ by 10^7, and f32 would lose the smaller
//! one in the subtraction that takes an unknown out. The triangle holds their roots, and taking out the
//! first unknowns is leaving out the first rows.
//!
//! Unknowns that nobody told anything about have a row of zeros.

use super::symmetric::add_lower;
use crate::config::MAX_VIEWS;
use nalgebra::{Matrix6, Vector6};

/// Unknowns of a camera: turn (3), place in the picture (2), scale, focal length.
pub const CAMERA: usize = 7;

/// The most unknowns.
pub const UNKNOWNS: usize = CAMERA * MAX_VIEWS;

/// A row of the triangle: its right hand side, then the unknowns' factors.
type Row = [f32; UNKNOWNS + 1];

/// So many equations, column by column: their right hand sides, then the unknowns' factors.
pub type Equations<const N: usize> = [[f32; N]; UNKNOWNS + 1];

/// Factors smaller than this are none: a camera that was not told of.
const MIN_DIAGONAL: f32 = 1e-6;

/// Values of the cameras' unknowns, one array a camera.
pub type CameraUnknowns = [[f32; CAMERA]; MAX_VIEWS];

/// The triangle R with its right hand side d: about 13 KiB for eight cameras, 0.8 KiB for two.
#[derive(Clone, Debug)]
pub struct SquareRoot {
    rows: [Row; UNKNOWNS],
    /// How many unknowns are in use.
    unknowns: usize,
}

/// The reflection that takes the factors of one unknown in several equations into a row's diagonal, the row's
/// sign turned: `s = share (own + w o)`, `own -> s - own`, `o -> o - w s`. For one equation it is Givens'
/// rotation.
#[derive(Clone, Copy)]
pub(super) struct Reflection<const N: usize> {
    /// w.
    others: [f32; N],
    share: f32,
}

impl<const N: usize> Reflection<N> {
    /// `heads` go into `diagonal`; they are spent. `None` where they are zero.
    pub(super) fn into_diagonal(diagonal: &mut f32, heads: &[f32; N]) -> Option<Self> {
        let squares: f32 = heads.iter().map(|head| head * head).sum();
        if squares == 0.0 {
            return None;
        }
        let length = libm::copysignf(libm::sqrtf(*diagonal * *diagonal + squares), *diagonal);
        let reach = *diagonal + length;
        *diagonal = length;
        let over_reach = 1.0 / reach;
        Some(Self { others: heads.map(|head| head * over_reach), share: reach / length })
    }

    /// Reflects what stands in one column of the row and of the equations.
    pub(super) fn reflect(&self, own: &mut f32, others: &mut [f32; N]) {
        let along: f32 = self.others.iter().zip(others.iter()).map(|(w, other)| w * other).sum();
        let step = self.share * (*own + along);
        *own = step - *own;
        for (other, w) in others.iter_mut().zip(&self.others) {
            *other -= w * step;
        }
    }
}

impl SquareRoot {
    /// Nothing known of so many cameras.
    #[must_use]
    pub fn new(cameras: usize) -> Self {
        Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns: CAMERA * cameras.min(MAX_VIEWS) }
    }

    /// Nothing is known any more, of so many cameras.
    pub fn clear(&mut self, cameras: usize) {
        self.rows.as_flattened_mut().fill(0.0);
        self.unknowns = CAMERA * cameras.min(MAX_VIEWS);
    }

    /// So many cameras can be told of from now on.
    pub fn make_room(&mut self, cameras: usize) {
        self.unknowns = self.unknowns.max(CAMERA * cameras.min(MAX_VIEWS));
    }

    /// Takes over what another one knows, of as many cameras.
    pub fn copy_from(&mut self, other: &Self) {
        self.unknowns = other.unknowns;
        for (row, from) in self.rows.iter_mut().zip(&other.rows).take(self.unknowns) {
            *row = *from;
        }
    }

    /// Adds equations; they are used up.
    #[inline(never)]
    pub fn insert<const N: usize>(&mut self, equations: &mut Equations<N>) {
        let [right, factors @ ..] = equations;
        let Some(mut rest) = factors.get_mut(..self.unknowns) else { return };
        for (place, own) in self.rows.iter_mut().enumerate() {
            let Some((heads, tail)) = rest.split_first_mut() else { return };
            let Some((own_right, diagonal, own_tail)) = parts(own, place, tail.len()) else { return };
            if let Some(reflection) = Reflection::into_diagonal(diagonal, heads) {
                reflection.reflect(own_right, right);
                for (own, others) in own_tail.iter_mut().zip(tail.iter_mut()) {
                    reflection.reflect(own, others);
                }
            }
            rest = tail;
        }
    }

    /// Everything known becomes less certain: standard deviations times 1 / `share`.
    pub fn fade(&mut self, share: f32) {
        let width = self.unknowns + 1;
        for row in self.rows.iter_mut().take(self.unknowns) {
            row.iter_mut().take(width).for_each(|value| *value *= share);
        }
    }

    /// Takes one camera out, keeping what the equations tell of the others whatever it was.
    #[cold]
    #[inline(never)]
    pub fn forget_camera(&mut self, camera: usize) {
        let unknowns = self.unknowns;
        let first = 1 + CAMERA * camera;
        // with this camera's unknowns in front, leaving out the first rows takes it out
        let mut turned = Self { rows: [[0.0; UNKNOWNS + 1]; UNKNOWNS], unknowns };
        for from in self.rows.iter().take(unknowns) {
            let own = from.iter().skip(first).take(CAMERA);
            let before = from.iter().take(first).skip(1);
            let after = from.iter().take(unknowns + 1).skip(first + CAMERA);
            let mut row = NO_EQUATION;
            for ([to], value) in row.iter_mut().zip(from.iter().take(1).chain(own).chain(before).chain(after))
            {
                *to = *value;
            }
            turned.insert(&mut row);
        }
        self.rows.as_flattened_mut().fill(0.0);
        for from in turned.rows.iter().take(unknowns).skip(CAMERA) {
            let mut row = NO_EQUATION;
            let places = (0..first).chain(first + CAMERA..unknowns + 1);
            let values = from.iter().take(1).chain(from.iter().skip(1 + CAMERA));
            for (place, value) in places.zip(values) {
                if let Some(to) = row.get_mut(place) {
                    *to = [*value];
                }
            }
            self.insert(&mut row);
        }
    }

    /// The cameras' unknowns that fit best, 0 for those that nothing is known of.
    #[must_use]
    pub fn solve_cameras(&self) -> CameraUnknowns {
        let mut solution = [[0.0; CAMERA]; MAX_VIEWS];
        let Some(all) = solution.as_flattened_mut().get_mut(..self.unknowns) else { return solution };
        for (place, row) in self.rows.iter().enumerate().take(self.unknowns).rev() {
            let Some((right, factors)) = row.split_first() else { break };
            let (Some([diagonal, known @ ..]), Some([value, solved @ ..])) =
                (factors.get(place..), all.get_mut(place..))
            else {
                break;
            };
            let rest: f32 = known.iter().zip(solved).map(|(factor, value)| factor * *value).sum();
            *value = if diagonal.abs() > MIN_DIAGONAL { (right - rest) / diagonal } else { 0.0 };
        }
        solution
    }

    /// The unknowns of the cameras are told from elsewhere from now on: from `step` further on.
    pub fn shift_cameras(&mut self, step: &CameraUnknowns) {
        let Some(steps) = step.as_flattened().get(..self.unknowns) else { return };
        for (place, row) in self.rows.iter_mut().enumerate().take(self.unknowns) {
            let Some((right, factors)) = row.split_first_mut() else { return };
            let (Some(factors), Some(steps)) = (factors.get(place..), steps.get(place..)) else { return };
            let moved: f32 = factors.iter().zip(steps).map(|(factor, step)| factor * step).sum();
            *right -= moved;
        }
    }

    /// `K^t (R^t R)^-1 K` for the six columns K (one Vector6 for each unknown of the cameras, in
    /// order): the covariance that the cameras' uncertainty gives to what depends on them by K.
    #[must_use]
    pub fn spread(&self, columns: &mut [Vector6<f32>; CAMERA * MAX_VIEWS]) -> Matrix6<f32> {
        let mut covariance = Matrix6::zeros();
        let Some(mut rest) = columns.get_mut(..self.unknowns) else { return covariance };
        for (place, row) in self.rows.iter().enumerate() {
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

/// Room for one equation.
const NO_EQUATION: Equations<1> = [[0.0]; UNKNOWNS + 1];

/// Right hand side, diagonal and so many factors behind it of the row of an unknown.
fn parts(row: &mut Row, place: usize, behind: usize) -> Option<(&mut f32, &mut f32, &mut [f32])> {
    let (right, factors) = row.split_first_mut()?;
    let (diagonal, tail) = factors.get_mut(place..)?.split_first_mut()?;
    Some((right, diagonal, tail.get_mut(..behind)?))
}

#[cfg(test)]
mod tests;
