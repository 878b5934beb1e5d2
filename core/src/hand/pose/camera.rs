//! One camera as the hand has taught it: where it stands in the world, its focal length, and what a
//! small change of either does to the picture.
//!
//! Nobody calibrates a camera. The world is the hand at the last latch, so the pose that a view gives
//! of the hand then is the camera's. Its seven unknowns are told about a *pivot*, a point that does
//! not move: where the hand was when the camera was first latched,
//!
//! ```text
//! p = R (x - pivot) + c            c = z (a / f, b / f, 1)     z = f exp(-scale)
//! ```
//!
//! - turn (3): R becomes exp(turn) R; radians, about the pivot, in camera axes
//! - place (2): a, b, where the pivot is seen; px from the picture's middle
//! - scale: logarithm of f / z, the picture's scale at the pivot
//! - focal: logarithm of f; scale and place stay as they are, so the camera moves away (dolly zoom),
//!   and R turns with the line of sight to the pivot
//!
//! In these terms one picture fixes six of the unknowns and leaves the focal length nearly free
//! whatever its value: what was learnt with a focal length 10 % off stays true when it is mended. And
//! since all of them are told in camera axes, a new latch (a new world) changes none.

use super::square_root::CAMERA;
use crate::geometry::Pose;
use crate::hand::orientation::nearest_rotation_step;
use crate::hand::perspective::{Sighting, project};
use crate::hand::so3;
use nalgebra::{Matrix3, Vector2, Vector3};

/// What a camera is known to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// camera_from_world.
    rotation: Matrix3<f32>,
    /// The pivot in camera axes, metres.
    pivot_in_camera: Vector3<f32>,
    /// The pivot in the world, metres.
    pivot_in_world: Vector3<f32>,
    focal_px: f32,
}

/// The derivatives of one ball's picture, in units of its standard deviation: one row for each of
/// two image coordinates, turned so that their errors are unrelated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// Measured less projected.
    pub residual: Vector2<f32>,
    /// The same, px.
    pub residual_px: Vector2<f32>,
    /// With the hand's translation (metres) and turn about its own origin (radians), world axes.
    pub pose: [[f32; 6]; 2],
    /// The gradient with the ball's place in camera axes.
    point: [Vector3<f32>; 2],
    /// Where the ball is in camera axes.
    x_in_camera: Vector3<f32>,
    /// The projection itself, whitened: its derivative with the logarithm of the focal length.
    projected: Vector2<f32>,
}

impl Camera {
    /// The camera that sees the hand so, when the hand is at `world_from_hand`; the pivot is a point
    /// of the hand.
    #[must_use]
    pub fn new(
        camera_from_hand: &Pose,
        world_from_hand: &Pose,
        pivot_in_hand: &Vector3<f32>,
        focal_px: f32,
    ) -> Self {
        Self {
            rotation: camera_from_hand.rotation * world_from_hand.rotation.transpose(),
            pivot_in_camera: camera_from_hand.rotation * pivot_in_hand + camera_from_hand.translation,
            pivot_in_world: world_from_hand.rotation * pivot_in_hand + world_from_hand.translation,
            focal_px,
        }
    }

    /// Its focal length, px.
    #[must_use]
    pub const fn focal_px(&self) -> f32 {
        self.focal_px
    }

    /// camera_from_hand of a hand at `world_from_hand`.
    #[must_use]
    pub fn sees(&self, world_from_hand: &Pose) -> Pose {
        Pose {
            rotation: self.rotation * world_from_hand.rotation,
            translation: self.rotation * (world_from_hand.translation - self.pivot_in_world)
                + self.pivot_in_camera,
        }
    }

    /// world_from_hand of a hand that this camera sees so.
    #[must_use]
    pub fn places(&self, camera_from_hand: &Pose) -> Pose {
        let back = self.rotation.transpose();
        Pose {
            rotation: back * camera_from_hand.rotation,
            translation: back * (camera_from_hand.translation - self.pivot_in_camera) + self.pivot_in_world,
        }
    }

    /// Tells of the same camera in a new world, which stands so in the old one.
    pub fn change_world(&mut self, old_from_new: &Pose) {
        self.rotation *= old_from_new.rotation;
        self.pivot_in_world =
            old_from_new.rotation.transpose() * (self.pivot_in_world - old_from_new.translation);
    }

    /// Adds small changes to its unknowns; false (and no change) where they are not small.
    pub fn step(&mut self, by: &[f32; CAMERA]) -> bool {
        let [turn @ .., a, b, scale, focal] = by;
        let small = by.iter().all(|x| x.is_finite())
            && turn.iter().all(|x| x.abs() < 0.5)
            && scale.abs() < 0.5
            && focal.abs() < 0.5;
        if small {
            let turn = Vector3::from(*turn) + self.sight_turn() * *focal;
            let c = self.pivot_in_camera;
            // z / f shrinks as the scale grows, and a and b move by px
            let per_px = c.z / self.focal_px;
            let shrink = libm::expf(-scale);
            let zoom = libm::expf(*focal);
            self.rotation = nearest_rotation_step(&(so3::exp(&turn) * self.rotation));
            self.pivot_in_camera =
                Vector3::new((c.x + a * per_px) * shrink, (c.y + b * per_px) * shrink, c.z * shrink * zoom);
            self.focal_px *= zoom;
        }
        small
    }

    /// By how much a change of the logarithm of the focal length turns the line of sight to a pivot
    /// that is seen at the same place, radians: d x dd / |d|^2 for d = (a / f, b / f, 1) and
    /// dd = -(a / f, b / f, 0).
    fn sight_turn(&self) -> Vector3<f32> {
        let c = self.pivot_in_camera;
        let square = c.dot(&c);
        Vector3::new(c.y * c.z / square, -c.x * c.z / square, 0.0)
    }

    /// What a ball of the hand at `x_in_hand` says of a hand at `world_from_hand`; `None` where this
    /// camera could not see it.
    #[must_use]
    pub fn compare(
        &self,
        camera_from_hand: &Pose,
        world_from_hand: &Pose,
        x_in_hand: &Vector3<f32>,
        seen: &Sighting,
    ) -> Option<Sensitivity> {
        let x_in_camera = camera_from_hand.rotation * x_in_hand + camera_from_hand.translation;
        let projection = project(&x_in_camera, self.focal_px)?;
        let [u, v] = projection.rows;
        // whitening is linear: it goes over every column
        let whiten = |u: f32, v: f32| seen.whiten(Vector2::new(u, v));
        let columns = [whiten(u.x, v.x), whiten(u.y, v.y), whiten(u.z, v.z)];
        let [cx, cy, cz] = columns;
        let point = [Vector3::new(cx.x, cy.x, cz.x), Vector3::new(cx.y, cy.y, cz.y)];
        let arm = world_from_hand.rotation * x_in_hand;
        let pose = point.map(|row| {
            let g = self.rotation.tr_mul(&row);
            let w = arm.cross(&g);
            [g.x, g.y, g.z, w.x, w.y, w.z]
        });
        let residual_px = seen.x_px - projection.x_px;
        Some(Sensitivity {
            residual: seen.whiten(residual_px),
            residual_px,
            pose,
            point,
            x_in_camera,
            projected: seen.whiten(projection.x_px),
        })
    }

    /// The derivatives with the camera's own unknowns, for what [`Self::compare`] gave.
    #[must_use]
    pub fn sensitivity(&self, of: &Sensitivity) -> [[f32; CAMERA]; 2] {
        let c = self.pivot_in_camera;
        let from_pivot = of.x_in_camera - c;
        let per_px = c.z / self.focal_px;
        let sight_turn = self.sight_turn();
        let row = |point: &Vector3<f32>, projected: f32| {
            let turn = from_pivot.cross(point);
            let focal = projected + point.z * c.z + turn.dot(&sight_turn);
            [turn.x, turn.y, turn.z, point.x * per_px, point.y * per_px, -point.dot(&c), focal]
        };
        let [first, second] = &of.point;
        [row(first, of.projected.x), row(second, of.projected.y)]
    }
}
