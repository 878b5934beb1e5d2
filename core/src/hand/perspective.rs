//! A pinhole camera that looks at the known frame: projection, its derivatives, and the pose one
//! view gives by itself ([`posit`]).
//!
//! Section 4 of the paper takes the view for affine (weak perspective), which at 1 m costs 5 to 40
//! mm over a movement of 0.3 m. Here a ball b of the hand, in metres in the axes of the feature
//! frame, is seen by camera i at
//!
//! ```text
//! p = R_i (R b + t) + t_i        camera_i_from_world (world_from_hand b), metres
//! x = f_i (p_x, p_y) / p_z       px from the picture's middle: square pixels, no distortion
//! ```
//!
//! What is measured is not x but the centre of the sphere's outline, which perspective puts farther
//! out: for a sphere of radius r it is `x / (1 - (r / p_z)^2)` to within a thousandth of the shift,
//! and 2 f r / p_z is the diameter D in the picture. So a measured centre, told from the middle, is
//! taken times `1 - (D / 2 f)^2` ([`Sighting::new`]): 0.02 px at 200 px from the middle for D = 16.

use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::Arms;
use crate::observation::BALLS;
use nalgebra::{Vector2, Vector3};

pub mod posit;

/// Nearer than this to the camera's plane nothing is projected, metres.
const MIN_DEPTH_M: f32 = 0.02;

/// A measured ball in one view, ready to be compared with a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Where the sphere's centre is seen, px from the picture's middle.
    pub x_px: Vector2<f32>,
    /// The lower triangle of L^-1, where L L^t is the covariance: 1 / l_11, l_21, 1 / l_22.
    whitening: [f32; 3],
}

/// What of a view was measured, ordered as [`crate::observation::Ball::ALL`].
pub type Sightings = [Option<Sighting>; BALLS];

impl Sighting {
    /// A ball whose outline's centre was measured at `centre` with the covariance `uu, uv, vv` (px^2)
    /// and the diameter `diameter_px`, by a camera whose optical axis meets the picture at `middle`.
    ///
    /// `None` where a number is not finite, or the ball is larger than half the focal length.
    #[must_use]
    pub fn new(
        centre: ImagePoint,
        middle: ImagePoint,
        diameter_px: f32,
        focal_px: f32,
        [uu, uv, vv]: [f32; 3],
    ) -> Option<Self> {
        let offset = centre - middle;
        let ratio = if diameter_px > 0.0 { 0.5 * diameter_px / focal_px } else { 0.0 };
        let inward = 1.0 - ratio * ratio;
        let l11 = libm::sqrtf(uu);
        let l21 = uv / l11;
        let l22 = libm::sqrtf(vv - l21 * l21);
        let whitening = [1.0 / l11, l21, 1.0 / l22];
        let x_px = Vector2::new(offset.u, offset.v) * inward;
        let usable = x_px.iter().chain(&whitening).all(|x| x.is_finite()) && ratio < 0.25;
        usable.then_some(Self { x_px, whitening })
    }

    /// A vector in px, in units of this sighting's standard deviation.
    #[must_use]
    pub fn whiten(&self, px: Vector2<f32>) -> Vector2<f32> {
        let [over_l11, l21, over_l22] = self.whitening;
        let first = px.x * over_l11;
        Vector2::new(first, (px.y - l21 * first) * over_l22)
    }
}

/// Where a point is seen, and how that changes with the point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Px from the picture's middle.
    pub x_px: Vector2<f32>,
    /// The gradients of both coordinates with the point in camera axes, px per metre.
    pub rows: [Vector3<f32>; 2],
}

/// Where a camera of this focal length (px) sees a point given in its axes; `None` when the point is
/// not in front of it.
#[must_use]
pub fn project(x_in_camera: &Vector3<f32>, focal_px: f32) -> Option<Projection> {
    if x_in_camera.z.is_nan() || x_in_camera.z <= MIN_DEPTH_M {
        return None;
    }
    let scale = focal_px / x_in_camera.z;
    let (u, v) = (scale * x_in_camera.x, scale * x_in_camera.y);
    let over_z = 1.0 / x_in_camera.z;
    Some(Projection {
        x_px: Vector2::new(u, v),
        rows: [Vector3::new(scale, 0.0, -u * over_z), Vector3::new(0.0, scale, -v * over_z)],
    })
}

/// The four balls seen by one camera: px from the picture's middle, `None` for one that is not in
/// front of it.
#[must_use]
pub fn picture(camera_from_hand: &Pose, focal_px: f32, arms: Arms) -> [Option<Vector2<f32>>; BALLS] {
    arms.balls_in_frame().map(|ball| {
        let p = camera_from_hand.rotation * ball + camera_from_hand.translation;
        project(&p, focal_px).map(|seen| seen.x_px)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gradients_are_those_of_the_projection(
            sideways in prop::array::uniform2(-0.3_f32..0.3),
            depth in 0.5_f32..2.0,
            direction in prop::array::uniform3(-1.0_f32..1.0),
        ) {
            let x = Vector3::new(sideways[0], sideways[1], depth);
            let step = Vector3::from(direction) * 1e-3;
            let (before, after) = (project(&(x - step), 800.0).unwrap(), project(&(x + step), 800.0).unwrap());
            let change = (after.x_px - before.x_px) / 2.0;
            let rows = project(&x, 800.0).unwrap().rows;
            prop_assert!((rows[0].dot(&step) - change.x).abs() < 2e-3, "{change}");
            prop_assert!((rows[1].dot(&step) - change.y).abs() < 2e-3, "{change}");
        }

        #[test]
        fn whitened_errors_have_the_size_of_their_covariance(
            uu in 0.01_f32..1.0, vv in 0.01_f32..1.0, correlation in -0.9_f32..0.9,
            error in prop::array::uniform2(-2.0_f32..2.0),
        ) {
            let uv = correlation * libm::sqrtf(uu * vv);
            let origin = ImagePoint::new(0.0, 0.0);
            let sighting = Sighting::new(origin, origin, 0.0, 800.0, [uu, uv, vv]).unwrap();
            let e = Vector2::from(error);
            let covariance = nalgebra::Matrix2::new(uu, uv, uv, vv);
            let expected = (e.transpose() * covariance.try_inverse().unwrap() * e).x;
            prop_assert!((sighting.whiten(e).norm_squared() - expected).abs() < 1e-3 * expected + 1e-5);
        }
    }

    #[test]
    fn the_outline_of_a_sphere_is_taken_back_to_its_centre() {
        // a ball of 20 mm at (0.25, -0.15, 0.9) m, f = 800 px: its outline is an ellipse whose long
        // axis points at the picture's middle, from f tan(angle - half width) to f tan(angle + it)
        let (x, y, z) = (0.25_f64, -0.15_f64, 0.9_f64);
        let sideways = x.hypot(y);
        let angle = sideways.atan2(z);
        let half_width = (0.01 / z.hypot(sideways)).asin();
        let outline = 800.0 * ((angle - half_width).tan() + (angle + half_width).tan()) / 2.0;
        let centre = 800.0 * sideways / z;
        assert!(outline - centre > 0.03, "there is something to take back");
        let scale = outline / sideways;
        let at = ImagePoint::new((319.5 + x * scale) as f32, (239.5 + y * scale) as f32);
        let diameter = (800.0 * 0.02 / z) as f32;
        let sighting =
            Sighting::new(at, ImagePoint::new(319.5, 239.5), diameter, 800.0, [0.01, 0.0, 0.01]).unwrap();
        assert!((f64::from(sighting.x_px.norm()) - centre).abs() < 1e-3, "{} {centre}", sighting.x_px.norm());
    }

    #[test]
    fn what_cannot_be_seen_is_none() {
        assert_eq!(project(&Vector3::new(0.1, 0.1, 0.0), 800.0), None);
        assert_eq!(project(&Vector3::new(0.1, 0.1, -1.0), 800.0), None);
        assert_eq!(project(&Vector3::new(0.1, 0.1, f32::NAN), 800.0), None);
        let origin = ImagePoint::new(0.0, 0.0);
        let at = ImagePoint::new(f32::NAN, 0.0);
        assert_eq!(Sighting::new(at, origin, 16.0, 800.0, [0.01, 0.0, 0.01]), None);
        assert_eq!(Sighting::new(origin, origin, 16.0, 0.0, [0.01, 0.0, 0.01]), None);
        assert_eq!(Sighting::new(origin, origin, 16.0, 800.0, [0.01, 0.02, 0.01]), None, "no covariance");
    }
}
