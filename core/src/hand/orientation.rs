//! A proper rotation from three measured arms: eq. 4 and the Gram-Schmidt process of section 4.

use crate::config::HandConfig;
use nalgebra::{Matrix3, Vector3};

/// Why three arms give no orientation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum OrientationRefusal {
    /// An arm is not made of finite numbers.
    NotFinite,
    /// An arm has no length: two balls are in one place.
    Coincident,
    /// An arm lies (nearly) in what the arms before it span.
    Collinear,
    /// The arms are a left-handed set: two of the balls are taken for each other.
    LeftHanded,
}

impl core::fmt::Display for OrientationRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "an arm of the feature frame is not made of finite numbers",
            Self::Coincident => "two balls of the feature frame are in one place",
            Self::Collinear => "the arms of the feature frame lie in one line or plane",
            Self::LeftHanded => "the arms of the feature frame are left-handed: two balls are swapped",
        })
    }
}

impl core::error::Error for OrientationRefusal {}

/// The rotation whose columns are the orthonormal axes Z_1, Z_2, Z_3 of the three arms
/// `X_i - X_0` (any unit of length), taken in this order.
///
/// # Errors
/// [`OrientationRefusal`] where the arms are not nearly a right-handed set of right angles.
pub fn gram_schmidt(
    arms: &[Vector3<f32>; 3],
    config: &HandConfig,
) -> Result<Matrix3<f32>, OrientationRefusal> {
    let [x1, x2, x3] = arms;
    let (e1, e2, e3) = (unit(x1)?, unit(x2)?, unit(x3)?);
    // e_i are unit vectors, so what is left of one is the sine of its angle to the plane or line
    let z1 = e1;
    let z2 = axis(e2 - z1 * e2.dot(&z1), config)?;
    let z3 = axis(e3 - z1 * e3.dot(&z1) - z2 * e3.dot(&z2), config)?;
    if z1.cross(&z2).dot(&z3) > 0.0 {
        Ok(nearest_rotation_step(&Matrix3::from_columns(&[z1, z2, z3])))
    } else {
        Err(OrientationRefusal::LeftHanded)
    }
}

/// A nearly orthonormal matrix, nearer: one Newton step towards its polar factor.
///
/// An error of size e becomes one of e^2, and no axis is favoured. Products of rotations go through
/// it so that they stay rotations over hours.
#[must_use]
pub fn nearest_rotation_step(rotation: &Matrix3<f32>) -> Matrix3<f32> {
    let excess = rotation.transpose() * rotation - Matrix3::identity();
    rotation - rotation * excess * 0.5
}

/// Eq. 4; the paper divides by the square root of the norm, which gives no unit vector.
fn unit(arm: &Vector3<f32>) -> Result<Vector3<f32>, OrientationRefusal> {
    let norm = libm::sqrtf(arm.dot(arm));
    if !norm.is_finite() {
        Err(OrientationRefusal::NotFinite)
    } else if norm < f32::MIN_POSITIVE {
        Err(OrientationRefusal::Coincident)
    } else {
        Ok(arm / norm)
    }
}

/// Z_i = Y_i / norm(Y_i), where enough of Y_i is left.
fn axis(rest: Vector3<f32>, config: &HandConfig) -> Result<Vector3<f32>, OrientationRefusal> {
    let sine = libm::sqrtf(rest.dot(&rest));
    if sine > 0.0 && sine >= config.min_arm_sine {
        Ok(rest / sine)
    } else {
        Err(OrientationRefusal::Collinear)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::synthetic::rotation;
    use proptest::prelude::*;

    fn solve(arms: [Vector3<f32>; 3]) -> Result<Matrix3<f32>, OrientationRefusal> {
        gram_schmidt(&arms, &HandConfig::default())
    }

    proptest! {
        #[test]
        fn arms_of_a_rotated_frame_give_the_rotation(r in rotation(3.1), l in prop::array::uniform3(0.01_f32..2.0)) {
            let [l1, l2, l3] = l;
            let solved = solve([r.column(0) * l1, r.column(1) * l2, r.column(2) * l3]).unwrap();
            prop_assert!((solved - r).norm() < 1e-6, "{}", solved - r);
        }

        #[test]
        fn skewed_arms_give_a_proper_rotation(
            r in rotation(3.1),
            skew in prop::array::uniform9(-0.2_f32..0.2),
        ) {
            let arms = r + Matrix3::from_column_slice(&skew);
            let z = solve([arms.column(0).into(), arms.column(1).into(), arms.column(2).into()]).unwrap();
            prop_assert!((z.transpose() * z - Matrix3::identity()).norm() < 1e-6);
            prop_assert!((z.determinant() - 1.0).abs() < 1e-6);
            // the first axis is the first arm's, and the second stays in the plane of the first two
            prop_assert!(z.column(0).cross(&arms.column(0)).norm() < 1e-6);
            prop_assert!(z.column(2).dot(&arms.column(1)).abs() < 1e-6);
        }

        #[test]
        fn a_step_takes_a_worn_rotation_back(r in rotation(3.1), wear in prop::array::uniform9(-1e-3_f32..1e-3)) {
            let worn = r + Matrix3::from_column_slice(&wear);
            let mended = nearest_rotation_step(&worn);
            prop_assert!((mended.transpose() * mended - Matrix3::identity()).norm() < 2e-5);
            prop_assert!((mended - r).norm() <= wear.iter().map(|w| w * w).sum::<f32>().sqrt() + 2e-5);
        }
    }

    #[test]
    fn refusals() {
        use OrientationRefusal::*;
        let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
        assert_eq!(solve([x, y, z]), Ok(Matrix3::identity()));
        assert_eq!(solve([x, z, y]), Err(LeftHanded));
        assert_eq!(solve([x, y, -z]), Err(LeftHanded));
        assert_eq!(solve([x, x + y * 0.1, z]), Err(Collinear));
        assert_eq!(solve([x, -x, z]), Err(Collinear));
        assert_eq!(solve([x, y, x + y + z * 0.1]), Err(Collinear));
        assert_eq!(solve([x, Vector3::zeros(), z]), Err(Coincident));
        assert_eq!(solve([x * f32::NAN, y, z]), Err(NotFinite));
        assert_eq!(solve([x, y, z * f32::INFINITY]), Err(NotFinite));
        assert_eq!(solve([x, y * 1e30, z]), Err(NotFinite), "its square overflows");
    }
}
