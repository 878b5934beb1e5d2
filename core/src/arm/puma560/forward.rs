//! Joints -> pose of the tool.
//!
//! The product of the link table, multiplied out. The arm (joints 1 to 3) places the wrist centre,
//! the wrist (joints 4 to 6) turns about it.

use super::model::{Geometry, Joints, Puma560};
use crate::geometry::Pose;
use crate::real::Real;
use nalgebra::{Matrix3, Vector3};

/// Sine and cosine of an angle.
#[derive(Clone, Copy)]
pub(super) struct Turn<T> {
    pub(super) sin: T,
    pub(super) cos: T,
}

impl<T: Real> Turn<T> {
    pub(super) fn by(angle: T) -> Self {
        let (sin, cos) = angle.sin_cos();
        Self { sin, cos }
    }
}

impl<T: Real> Puma560<T> {
    /// `base_from_tool` at these joints. Joints that are not finite give a pose that is not.
    #[must_use]
    pub fn forward(&self, joints: &Joints<T>) -> Pose<T> {
        self.geometry.wrist(joints).compose(&self.geometry.tool)
    }
}

impl<T: Real> Geometry<T> {
    /// `base_from_wrist`: the last link's frame, at the wrist centre.
    fn wrist(&self, joints: &Joints<T>) -> Pose<T> {
        let [q1, q2, q3, q4, q5, q6] = *joints;
        let arm = self.arm(Turn::by(q1), Turn::by(q2), Turn::by(q2 + q3));
        let wrist = wrist_rotation(Turn::by(q4), Turn::by(q5), Turn::by(q6));
        Pose { rotation: arm.rotation * wrist, translation: arm.translation }
    }

    /// The third link's axes, at the wrist centre. `q23` is the sum of both angles.
    #[inline]
    pub(super) fn arm(&self, q1: Turn<T>, q2: Turn<T>, q23: Turn<T>) -> Pose<T> {
        let (s1, c1, s23, c23) = (q1.sin, q1.cos, q23.sin, q23.cos);
        let out = self.upper_arm * q2.cos + self.elbow * c23 - self.forearm * s23;
        let up = self.upper_arm * q2.sin + self.elbow * s23 + self.forearm * c23;
        #[rustfmt::skip]
        let rotation = Matrix3::new(
            c1 * c23, -s1,       -c1 * s23,
            s1 * c23, c1,        -s1 * s23,
            s23,      T::zero(), c23,
        );
        let (x, y) = (c1 * out + s1 * self.offset, s1 * out - c1 * self.offset);
        Pose { rotation, translation: Vector3::new(x, y, self.base + up) }
    }
}

/// The last link's axes seen in the third's: `Rz(q4) Ry(-q5) Rz(q6)`.
#[inline]
pub(super) fn wrist_rotation<T: Real>(q4: Turn<T>, q5: Turn<T>, q6: Turn<T>) -> Matrix3<T> {
    let (s4, c4, s5, c5, s6, c6) = (q4.sin, q4.cos, q5.sin, q5.cos, q6.sin, q6.cos);
    let (x, y) = (c4 * c5, s4 * c5);
    #[rustfmt::skip]
    let rotation = Matrix3::new(
        x * c6 - s4 * s6, -x * s6 - s4 * c6, -c4 * s5,
        y * c6 + c4 * s6, -y * s6 + c4 * c6, -s4 * s5,
        s5 * c6,          -s5 * s6,          c5,
    );
    rotation
}
