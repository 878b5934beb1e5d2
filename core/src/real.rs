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
}
