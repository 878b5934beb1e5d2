//! Image points, rotations and poses, and the conventions they share.
//!
//! Image: x right, y down, pixel centres at integers, (0, 0) the centre of the top-left pixel.
//! Poses are named `a_from_b`, points `x_in_a`; rotation matrices act on column vectors.
//! Metres, radians, seconds.

use crate::real::Real;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// A point in a picture, in pixels: `u` right, `v` down, (0, 0) the centre of the top-left pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ImagePoint {
    /// Pixels to the right of the first column's centre.
    pub u: f32,
    /// Pixels below the first row's centre.
    pub v: f32,
}

impl ImagePoint {
    /// A point from its two coordinates in pixels.
    #[must_use]
    pub const fn new(u: f32, v: f32) -> Self {
        Self { u, v }
    }

    /// The distance to another point, in pixels.
    #[must_use]
    pub fn distance(self, other: Self) -> f32 {
        let (du, dv) = (self.u - other.u, self.v - other.v);
        libm::sqrtf(du * du + dv * dv)
    }

    /// Whether both coordinates are finite numbers.
    #[must_use]
    pub fn is_finite(self) -> bool {
        self.u.is_finite() && self.v.is_finite()
    }
}

impl core::ops::Add for ImagePoint {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self::new(self.u + o.u, self.v + o.v)
    }
}

impl core::ops::Sub for ImagePoint {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self::new(self.u - o.u, self.v - o.v)
    }
}

impl core::ops::Mul<f32> for ImagePoint {
    type Output = Self;
    fn mul(self, k: f32) -> Self {
        Self::new(self.u * k, self.v * k)
    }
}

/// The whole number nearest to `value`, halves upwards; the ends of `i32` beyond it, 0 for NaN. Many
/// times cheaper than rounding in floating point.
#[inline]
#[must_use]
pub fn round_to_i32(value: f32) -> i32 {
    let up = value + 0.5;
    // `as` cuts towards zero and saturates
    let whole = up as i32;
    if (whole as f32) > up { whole.saturating_sub(1) } else { whole }
}

/// Sixteen directions, unit vectors, a quarter of a quarter turn apart.
pub(crate) const DIRECTIONS: [(f32, f32); 16] = {
    const C: f32 = 0.923_879_5;
    const S: f32 = 0.382_683_43;
    const H: f32 = core::f32::consts::FRAC_1_SQRT_2;
    [
        (1.0, 0.0),
        (C, S),
        (H, H),
        (S, C),
        (0.0, 1.0),
        (-S, C),
        (-H, H),
        (-C, S),
        (-1.0, 0.0),
        (-C, -S),
        (-H, -H),
        (-S, -C),
        (0.0, -1.0),
        (S, -C),
        (H, -H),
        (C, -S),
    ]
};

/// A rigid motion `a_from_b`: `x_in_a = rotation * x_in_b + translation`. In single precision
/// wherever nothing else is said; arms are computed in both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<T = f32> {
    /// A proper rotation (determinant +1), columns are b's axes seen in a.
    pub rotation: Matrix3<T>,
    /// b's origin seen in a, metres.
    pub translation: Vector3<T>,
}

impl<T: Real> Pose<T> {
    /// No motion at all.
    #[must_use]
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// `a_from_c` out of `a_from_b` (self) and `b_from_c`.
    #[must_use]
    pub fn compose(&self, b_from_c: &Self) -> Self {
        Self {
            rotation: self.rotation * b_from_c.rotation,
            translation: self.rotation * b_from_c.translation + self.translation,
        }
    }

    /// `b_from_a` out of `a_from_b`.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }
}

impl<T: Real> Default for Pose<T> {
    fn default() -> Self {
        Self::identity()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_to_the_nearest_with_halves_upwards() {
        for i in -4000..4000 {
            let value = i as f32 / 16.0;
            assert_eq!(round_to_i32(value), libm::floorf(value + 0.5) as i32, "{value}");
        }
        assert_eq!(round_to_i32(f32::NAN), 0);
        assert_eq!(round_to_i32(1e30), i32::MAX);
        assert_eq!(round_to_i32(-1e30), i32::MIN);
    }
}
