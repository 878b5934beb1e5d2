//! Rotations and their vectors: exp and log of SO(3), in single precision and without a branch that
//! loses digits.

use nalgebra::{Matrix3, Vector3};

/// The rotation by `|vector|` radians about `vector`.
pub(crate) fn exp(vector: &Vector3<f32>) -> Matrix3<f32> {
    let angle = libm::sqrtf(vector.dot(vector));
    // sin(x)/x and (1 - cos(x))/x^2 = (sin(x/2)/(x/2))^2 / 2, which does not cancel
    let half = sinc(angle * 0.5);
    let (a, b) = (sinc(angle), 0.5 * half * half);
    let k = vector.cross_matrix();
    Matrix3::identity() + k * a + k * k * b
}

/// The rotation's vector: its axis times its angle, 0 to pi radians.
pub(crate) fn log(rotation: &Matrix3<f32>) -> Vector3<f32> {
    let (w, v) = quaternion(rotation);
    let (w, v) = if w < 0.0 { (-w, -v) } else { (w, v) };
    let sine = libm::sqrtf(v.dot(&v));
    if sine > 1e-12 {
        v * (2.0 * libm::atan2f(sine, w) / sine)
    } else if w > 0.0 {
        v * (2.0 / w)
    } else {
        Vector3::zeros()
    }
}

/// A multiple of the quaternion of a rotation, built on its largest component (Shepperd).
fn quaternion(r: &Matrix3<f32>) -> (f32, Vector3<f32>) {
    let trace = r.m11 + r.m22 + r.m33;
    let (x, y, z) = (r.m32 - r.m23, r.m13 - r.m31, r.m21 - r.m12);
    let (xy, xz, yz) = (r.m12 + r.m21, r.m13 + r.m31, r.m23 + r.m32);
    if trace >= r.m11 && trace >= r.m22 && trace >= r.m33 {
        (1.0 + trace, Vector3::new(x, y, z))
    } else if r.m11 >= r.m22 && r.m11 >= r.m33 {
        (x, Vector3::new(1.0 + r.m11 - r.m22 - r.m33, xy, xz))
    } else if r.m22 >= r.m33 {
        (y, Vector3::new(xy, 1.0 + r.m22 - r.m11 - r.m33, yz))
    } else {
        (z, Vector3::new(xz, yz, 1.0 + r.m33 - r.m11 - r.m22))
    }
}

/// sin(x)/x.
fn sinc(x: f32) -> f32 {
    if x < 1e-3 { 1.0 - x * x / 6.0 } else { libm::sinf(x) / x }
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
        assert_eq!(exp(&Vector3::zeros()), Matrix3::identity());
        assert_eq!(log(&Matrix3::identity()), Vector3::zeros());
        let half = log(&Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, -1.0)));
        assert!((half - Vector3::y() * PI).norm() < 1e-6, "{half}");
    }
}
