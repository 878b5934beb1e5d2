//! Rotations and their vectors: exp and log of SO(3), in either precision and without a branch that
//! loses digits.

use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// The rotation by `|vector|` radians about `vector`.
pub(crate) fn exp<T: Real>(vector: &Vector3<T>) -> Matrix3<T> {
    let angle = vector.dot(vector).sqrt();
    // sin(x)/x and (1 - cos(x))/x^2 = (sin(x/2)/(x/2))^2 / 2, which does not cancel
    let half = sinc(angle * T::of(0.5));
    let (a, b) = (sinc(angle), T::of(0.5) * half * half);
    let k = vector.cross_matrix();
    Matrix3::identity() + k * a + k * k * b
}

/// The rotation's vector: its axis times its angle, 0 to pi radians.
pub(crate) fn log<T: Real>(rotation: &Matrix3<T>) -> Vector3<T> {
    let (w, v) = quaternion(rotation);
    let (w, v) = if w < T::zero() { (-w, -v) } else { (w, v) };
    let sine = v.dot(&v).sqrt();
    if sine > T::of(1e-12) {
        v * (T::of(2.0) * sine.atan2(w) / sine)
    } else if w > T::zero() {
        v * (T::of(2.0) / w)
    } else {
        Vector3::zeros()
    }
}

/// A multiple of the quaternion of a rotation, built on its largest component (Shepperd).
fn quaternion<T: Real>(r: &Matrix3<T>) -> (T, Vector3<T>) {
    let one = T::one();
    let trace = r.m11 + r.m22 + r.m33;
    let (x, y, z) = (r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12);
    let (xy, xz, yz) = (r.m12 + r.m21, r.m13 + r.m31, r.m23 + r.m32);
    if trace >= r.m11 && trace >= r.m22 && trace >= r.m33 {
        (one + trace, Vector3::new(x, y, z))
    } else if r.m11 >= r.m22 && r.m11 >= r.m33 {
        (x, Vector3::new(one + r.m11 - r.m22 - r.m33, xy, xz))
    } else if r.m22 >= r.m33 {
        (y, Vector3::new(xy, one + r.m22 - r.m11 - r.m33, yz))
    } else {
        (z, Vector3::new(xz, yz, one + r.m33 - r.m11 - r.m22))
    }
}

/// sin(x)/x.
fn sinc<T: Real>(x: T) -> T {
    // the next term of the series is x^4 / 120: 8e-15
    if x < T::of(1e-3) { T::one() - x * x / T::of(6.0) } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn log_undoes_exp(axis in prop::array::uniform3(-1.0_f32..1.0), angle in 0.0_f32..3.1) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 0.1);
            let vector = axis / axis.norm() * angle;
            let rotation = exp(&vector);
            prop_assert!((rotation.transpose() * rotation - Matrix3::identity()).norm() < 2e-6);
            prop_assert!((log(&rotation) - vector).norm() < 2e-6, "{} {vector}", log(&rotation));
        }

        #[test]
        fn exp_undoes_log_up_to_a_half_turn(
            axis in prop::array::uniform3(-1.0_f32..1.0),
            short in 0.0_f32..1e-3,
        ) {
            let axis = Vector3::from(axis);
            prop_assume!(axis.norm() > 0.1);
            let rotation = exp(&(axis / axis.norm() * (PI - short)));
            prop_assert!((exp(&log(&rotation)) - rotation).norm() < 2e-6);
        }

        #[test]
        fn small_vectors_keep_their_digits(v in prop::array::uniform3(-1.0_f32..1.0), scale in 1e-6_f32..1e-2) {
            let vector = Vector3::from(v) * scale;
            prop_assert!((log(&exp(&vector)) - vector).norm() <= vector.norm() * 1e-3 + 1e-9);
        }
    }

    #[test]
    fn nothing_and_a_half_turn() {
        assert_eq!(exp(&Vector3::<f32>::zeros()), Matrix3::identity());
        assert_eq!(log(&Matrix3::<f32>::identity()), Vector3::zeros());
        let half: Vector3<f32> = log(&Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0)));
        assert!((half - Vector3::y() * PI).norm() < 1e-6, "{half}");
    }
}
