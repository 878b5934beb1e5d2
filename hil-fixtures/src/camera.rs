//! A pinhole camera.

use nalgebra::{Matrix3, Vector3};

/// A pinhole camera with square pixels and no distortion.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Where the optical axis meets the picture, in pixels.
    pub principal_px: (f64, f64),
    /// Rotation from world to camera axes (x right, y down, z forward).
    pub camera_from_world: Matrix3<f64>,
    /// The optical centre in the world, metres.
    pub position_m: Vector3<f64>,
}

impl Camera {
    /// A camera at `position` whose optical axis, in the middle of a `width` x `height` picture,
    /// passes through `target`; the picture's columns are parallel to the world's vertical.
    #[must_use]
    pub fn looking_at(
        position: Vector3<f64>,
        target: Vector3<f64>,
        focal_px: f64,
        width: u16,
        height: u16,
    ) -> Self {
        let forward = (target - position).normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        let down = forward.cross(&right);
        Self {
            focal_px,
            principal_px: ((f64::from(width) - 1.0) / 2.0, (f64::from(height) - 1.0) / 2.0),
            camera_from_world: Matrix3::from_rows(&[
                right.transpose(),
                down.transpose(),
                forward.transpose(),
            ]),
            position_m: position,
        }
    }

    /// A point of the world in camera axes, metres.
    #[must_use]
    pub fn in_camera(&self, x_in_world: &Vector3<f64>) -> Vector3<f64> {
        self.camera_from_world * (x_in_world - self.position_m)
    }

    /// Where a point given in camera axes appears, in pixels; the point must be in front.
    #[must_use]
    pub fn picture_of(&self, x_in_camera: &Vector3<f64>) -> (f64, f64) {
        (
            self.principal_px.0 + self.focal_px * x_in_camera.x / x_in_camera.z,
            self.principal_px.1 + self.focal_px * x_in_camera.y / x_in_camera.z,
        )
    }

    /// The unit vector, in camera axes, of all that appears at (`u`, `v`).
    #[must_use]
    pub fn ray_through(&self, u: f64, v: f64) -> Vector3<f64> {
        let (cu, cv) = self.principal_px;
        Vector3::new((u - cu) / self.focal_px, (v - cv) / self.focal_px, 1.0).normalize()
    }

    /// Where a point of the world appears, in pixels, or `None` when it is not in front.
    #[must_use]
    pub fn project(&self, x_in_world: &Vector3<f64>) -> Option<(f64, f64)> {
        let x_in_camera = self.in_camera(x_in_world);
        (x_in_camera.z > 0.0).then(|| self.picture_of(&x_in_camera))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_is_right_and_up_is_up() {
        let camera = Camera::looking_at(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros(), 800.0, 640, 480);
        assert_eq!(camera.project(&Vector3::zeros()), Some((319.5, 239.5)));
        let (u, v) = camera.project(&Vector3::new(0.0, 0.1, 0.05)).expect("in front");
        assert!((u - 399.5).abs() < 1e-9 && (v - 199.5).abs() < 1e-9, "{u} {v}");
        let ray = camera.ray_through(u, v);
        assert!((camera.in_camera(&Vector3::new(0.0, 0.1, 0.05)).normalize() - ray).amax() < 1e-12);
        assert_eq!(camera.project(&Vector3::new(1.5, 0.0, 0.0)), None);
        assert!((camera.camera_from_world.determinant() - 1.0).abs() < 1e-12);
    }
}
