//! The pose of the known frame from one view: POSIT (DeMenthon and Davis 1995).
//!
//! The arms are at right angles, so the pseudo-inverse that POSIT multiplies with is the constant
//! `diag(1 / l_k)`: with w_k = 1 + e_k the corrected depth ratio of ball k,
//!
//! ```text
//! I_k = (w_k u_k - u_0) / l_k      J_k = (w_k v_k - v_0) / l_k      px per metre
//! s = sqrt(|I| |J|) = f / z_0      r_1 = I / |I|, r_2 = J / |J|, r_3 = r_1 x r_2
//! e_k = l_k r_3k / z_0             and again
//! ```
//!
//! The three arms are not in one plane, so there is one solution and no mirrored one.

use crate::geometry::Pose;
use crate::hand::affine::Arms;
use crate::hand::orientation::nearest_rotation_step;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Rounds of the iteration; each takes the error times the hand's depth over its distance, 0.1 for an
/// arm of 80 mm at 1 m, and Gauss-Newton steps follow it.
const ROUNDS: usize = 6;

/// The least length of I and J, px per metre: an arm of 80 mm that is seen 0.1 px long.
const MIN_SCALE: f32 = 1.0;

/// The least sine of the angle between I and J, which are at right angles but for noise.
const MIN_SINE: f32 = 0.1;

/// camera_from_hand of the four balls seen at `x_px` (px from the picture's middle), for a focal
/// length in px; `None` where the balls coincide or the iteration leaves the numbers.
#[must_use]
pub fn posit(x_px: &[Vector2<f32>; 4], focal_px: f32, arms: Arms) -> Option<Pose> {
    let [x0, x1, x2, x3] = x_px;
    let [l1, l2, l3] = arms.lengths_m();
    let mut w = Vector3::repeat(1.0);
    let mut solved = None;
    for _ in 0..ROUNDS {
        let row = |u: [f32; 4]| {
            let [u0, u1, u2, u3] = u;
            Vector3::new((w.x * u1 - u0) / l1, (w.y * u2 - u0) / l2, (w.z * u3 - u0) / l3)
        };
        let i = row([x0.x, x1.x, x2.x, x3.x]);
        let j = row([x0.y, x1.y, x2.y, x3.y]);
        let (i_norm, j_norm) = (libm::sqrtf(i.dot(&i)), libm::sqrtf(j.dot(&j)));
        let is_seen = i_norm > MIN_SCALE && j_norm > MIN_SCALE;
        if !is_seen {
            return None;
        }
        let (r1, r2) = (i / i_norm, j / j_norm);
        let normal = r1.cross(&r2);
        let sine = libm::sqrtf(normal.dot(&normal));
        // NaN is not above either
        let is_solid = sine > MIN_SINE;
        if !is_solid {
            return None;
        }
        let r3 = normal / sine;
        // r_1 and r_2 turned apart or together by equal parts until they are at right angles
        let (sum, difference) = (r1 + r2, r1 - r2);
        let half = core::f32::consts::FRAC_1_SQRT_2;
        let sum = sum * (half / libm::sqrtf(sum.dot(&sum)));
        let difference = difference * (half / libm::sqrtf(difference.dot(&difference)));
        let (r1, r2) = (sum + difference, sum - difference);
        let z0 = focal_px / libm::sqrtf(i_norm * j_norm);
        w = Vector3::new(1.0 + l1 * r3.x / z0, 1.0 + l2 * r3.y / z0, 1.0 + l3 * r3.z / z0);
        let rotation = Matrix3::from_rows(&[r1.transpose(), r2.transpose(), r3.transpose()]);
        let translation = Vector3::new(x0.x * z0 / focal_px, x0.y * z0 / focal_px, z0);
        solved = Some(Pose { rotation: nearest_rotation_step(&rotation), translation });
    }
    solved.filter(|pose| pose.translation.iter().chain(pose.rotation.iter()).all(|x| x.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hand::perspective::picture;
    use crate::hand::synthetic::{arms, difference, number, rotation};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_view_gives_the_pose_it_was_made_from(
            rotation in rotation(3.1),
            place in prop::array::uniform2(-0.2_f32..0.2),
            distance in 0.6_f32..2.0,
            focal_px in 500.0_f32..1200.0,
        ) {
            let [x, y] = place;
            let pose = Pose { rotation, translation: Vector3::new(x, y, distance) };
            let [Some(a), Some(b), Some(c), Some(d)] = picture(&pose, focal_px, arms()) else {
                return Err(TestCaseError::fail("behind the camera"));
            };
            // two arms in one line of sight leave nothing to start from
            let (u, v, w) = (b - a, c - a, d - a);
            let area = |p: &Vector2<f32>, q: &Vector2<f32>| (p.x * q.y - p.y * q.x).abs();
            prop_assume!(area(&u, &v).max(area(&v, &w)).max(area(&w, &u)) > 500.0);
            let found = posit(&[a, b, c, d], focal_px, arms()).unwrap();
            // good enough to start Gauss-Newton from
            prop_assert!(difference(&found, &pose) < 0.02, "{}", difference(&found, &pose));
        }

        #[test]
        fn any_numbers_give_a_finite_pose_or_none(
            numbers in prop::array::uniform8(number()),
            focal_px in number(),
        ) {
            let [a, b, c, d, e, f, g, h] = numbers;
            let points = [Vector2::new(a, b), Vector2::new(c, d), Vector2::new(e, f), Vector2::new(g, h)];
            if let Some(pose) = posit(&points, focal_px, arms()) {
                prop_assert!(pose.translation.iter().chain(pose.rotation.iter()).all(|x| x.is_finite()));
            }
        }
    }

    #[test]
    fn balls_in_one_place_or_on_one_line_give_none() {
        let at = Vector2::new(10.0, 20.0);
        assert_eq!(posit(&[at; 4], 800.0, arms()), None);
        let along = |k: f32| at + Vector2::new(30.0, 10.0) * k;
        assert_eq!(posit(&[along(0.0), along(1.0), along(-0.5), along(2.0)], 800.0, arms()), None);
    }
}
