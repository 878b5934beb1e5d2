//! Joints -> how the tool moves with each of them.

use super::forward::{Turn, wrist_rotation};
use super::model::{Joints, Puma560};
use crate::real::Real;
use nalgebra::{SMatrix, Vector3, Vector6};

/// The geometric Jacobian: the tool's velocity (rows 1 to 3, m/s) and angular velocity (rows 4 to 6,
/// rad/s), both in the base's axes, out of the joints' speeds (rad/s).
pub type Jacobian<T> = SMatrix<T, 6, 6>;

impl<T: Real> Puma560<T> {
    /// The geometric Jacobian at the tool.
    #[must_use]
    pub fn jacobian(&self, joints: &Joints<T>) -> Jacobian<T> {
        let [q1, q2, q3, q4, q5, q6] = *joints;
        let (q1, q2, q23) = (Turn::by(q1), Turn::by(q2), Turn::by(q2 + q3));
        let q4 = Turn::by(q4);
        let of = &self.geometry;
        let arm = of.arm(q1, q2, q23);
        let wrist = arm.rotation * wrist_rotation(q4, Turn::by(q5), Turn::by(q6));
        let tool = arm.translation + wrist * of.tool.translation;

        // each joint turns about an axis through a point
        let zero = T::zero();
        let shoulder = Vector3::new(zero, zero, of.base);
        let out = of.upper_arm * q2.cos;
        let elbow = Vector3::new(q1.cos * out, q1.sin * out, of.base + of.upper_arm * q2.sin);
        let across = Vector3::new(q1.sin, -q1.cos, zero);
        let bend = arm.rotation * Vector3::new(q4.sin, -q4.cos, zero);
        let column = |axis: Vector3<T>, point: Vector3<T>| {
            let v = axis.cross(&(tool - point));
            Vector6::new(v.x, v.y, v.z, axis.x, axis.y, axis.z)
        };
        Jacobian::from_columns(&[
            column(Vector3::z(), shoulder),
            column(across, shoulder),
            column(across, elbow),
            column(arm.rotation * Vector3::z(), arm.translation),
            column(bend, arm.translation),
            column(wrist * Vector3::z(), arm.translation),
        ])
    }
}
