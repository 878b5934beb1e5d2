//! Numbers of either precision: f32 on the microcontroller, f64 on the host.
//!
//! The arm is computed in both from one source. Everything goes through [`nalgebra::RealField`],
//! which this workspace builds on `libm` (feature `libm-force`): the same bits on every target, and
//! no panic path. In generic code no float method of std can be meant by accident.

use nalgebra::RealField;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32` or `f64`.
pub trait Real: RealField + Copy + sealed::Sealed {
    /// The distance from 1 to the next larger number.
    const EPSILON: Self;
    /// What is taken for rounding in a computed length (metres), sine or angle (radians): 1e-10 in
    /// f64, 4e-6 in f32. Some thirty roundings of lengths around a metre, with a hundred times that
    /// in hand in f64, where there is room.
    const SLACK: Self;

    /// The number nearest to `value`.
    fn of(value: f64) -> Self;

    /// The number in double precision, exactly.
    fn to_f64(self) -> f64;

    /// The whole number nearest to this one, the even one of two. Up to 2^22 in f32 and 2^51 in f64;
    /// beyond, and not finite, it stays about what it was. Without a branch and many times cheaper
    /// than `round`.
    fn nearest_whole(self) -> Self;
}

impl Real for f32 {
    const EPSILON: Self = Self::EPSILON;
    const SLACK: Self = 4e-6;

    #[inline]
    fn of(value: f64) -> Self {
        value as Self
    }

    #[inline]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }

    #[inline]
    fn nearest_whole(self) -> Self {
        // among the numbers from 2^23 to 2^24 there are no fractions: adding rounds them off
        const NO_FRACTIONS: f32 = 12_582_912.0;
        (self + NO_FRACTIONS) - NO_FRACTIONS
    }
}

impl Real for f64 {
    const EPSILON: Self = Self::EPSILON;
    const SLACK: Self = 1e-10;

    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self
    }

    #[inline]
    fn nearest_whole(self) -> Self {
        // likewise from 2^52 to 2^53
        const NO_FRACTIONS: f64 = 6_755_399_441_055_744.0;
        (self + NO_FRACTIONS) - NO_FRACTIONS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_to_the_nearest_whole_number() {
        for i in -40_000..40_000 {
            let x = f64::from(i) / 16.0;
            assert_eq!(x.nearest_whole(), x.round_ties_even(), "{x}");
            let x = x as f32;
            assert_eq!(x.nearest_whole(), x.round_ties_even(), "{x}");
        }
        assert!(f64::NAN.nearest_whole().is_nan() && f32::INFINITY.nearest_whole() == f32::INFINITY);
    }
}
