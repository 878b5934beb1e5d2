//! Cameras and hands with known truth, for the tests of this layer.

use crate::config::MAX_VIEWS;
use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::{Arms, Centres};
use crate::observation::{ImageCovariance, Observation, ObservationState, Observations};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;
use std::vec::Vec;

/// 80 mm, the arm of the frames this is built for.
pub(crate) fn arms() -> Arms {
    Arms::equal(0.08).unwrap()
}

/// A camera that looks from a distance at the origin of the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    camera_from_world: Matrix3<f32>,
    /// Pixels per metre at the world's origin.
    scale: f32,
    /// Metres to the world's origin; infinite for an orthographic camera.
    distance: f32,
}

impl Camera {
    /// Turned by `azimuth` about the world's vertical, then by `elevation` (radians).
    pub(crate) fn orthographic(azimuth: f32, elevation: f32, scale: f32) -> Self {
        Self::perspective(azimuth, elevation, scale, f32::INFINITY)
    }

    pub(crate) fn perspective(azimuth: f32, elevation: f32, scale: f32, distance: f32) -> Self {
        let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), elevation)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), azimuth);
        Self { camera_from_world: *turn.matrix(), scale, distance }
    }

    pub(crate) fn project(&self, x_in_world: Vector3<f32>) -> ImagePoint {
        let x = self.camera_from_world * x_in_world;
        let scale = self.scale / (1.0 + x.z / self.distance);
        ImagePoint::new(320.0 + scale * x.x, 240.0 + scale * x.y)
    }

    pub(crate) fn centres(&self, world_from_hand: &Pose) -> Centres {
        arms()
            .balls_in_frame()
            .map(|ball| self.project(world_from_hand.rotation * ball + world_from_hand.translation))
    }

    pub(crate) fn observe(&self, world_from_hand: &Pose) -> Observations {
        self.centres(world_from_hand).map(|centre| Observation {
            state: ObservationState::Visible,
            centre,
            diameter: 16.0,
            covariance: ImageCovariance::isotropic(0.1),
            visible: 1.0,
        })
    }
}

/// Two orthographic cameras 70 degrees apart at about the scale of 640x480 pictures at 1 m.
pub(crate) fn two_cameras() -> [Camera; 2] {
    [Camera::orthographic(-0.6, 0.3, 600.0), Camera::orthographic(0.6, 0.3, 550.0)]
}

/// Two cameras to as many as there may be, at least 25 degrees between neighbours.
pub(crate) fn cameras() -> impl Strategy<Value = Vec<Camera>> {
    prop::collection::vec((0.0_f32..0.1, -0.5_f32..0.5, 300.0_f32..900.0), 2..=MAX_VIEWS).prop_map(|list| {
        list.into_iter()
            .enumerate()
            .map(|(i, (jitter, elevation, scale))| {
                Camera::orthographic(i as f32 * 0.55 + jitter - 0.8, elevation, scale)
            })
            .collect()
    })
}

/// A rotation about any axis by up to `most` radians.
pub(crate) fn rotation(most: f32) -> impl Strategy<Value = Matrix3<f32>> {
    (prop::array::uniform3(-1.0_f32..1.0), 0.0..most).prop_filter_map("no axis", |(axis, angle)| {
        let axis = nalgebra::Unit::try_new(Vector3::from(axis), 1e-2)?;
        Some(*Rotation3::from_axis_angle(&axis, angle).matrix())
    })
}

/// A rigid motion of up to `turn` radians and `shift` metres along each axis.
pub(crate) fn pose(turn: f32, shift: f32) -> impl Strategy<Value = Pose> {
    (rotation(turn), prop::array::uniform3(-shift..shift))
        .prop_map(|(rotation, t)| Pose { rotation, translation: Vector3::from(t) })
}

/// Any number, most often one that could be a coordinate in a picture.
pub(crate) fn number() -> impl Strategy<Value = f32> {
    prop_oneof![20 => -500.0_f32..1500.0, 1 => any::<f32>(), 1 => Just(f32::NAN), 1 => Just(1e30_f32)]
}

/// The larger of the distance in metres and the Frobenius distance of the rotations.
pub(crate) fn difference(a: &Pose, b: &Pose) -> f32 {
    (a.translation - b.translation).norm().max((a.rotation - b.rotation).norm())
}
