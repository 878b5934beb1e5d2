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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ImagePoint;
    use crate::hand::perspective::project;
    use crate::hand::synthetic::{difference, pose, rotation as any_rotation};
    use proptest::prelude::*;

    /// A camera that sees a hand somewhere in front of it.
    fn camera() -> impl Strategy<Value = (Camera, Pose)> {
        (any_rotation(3.1), prop::array::uniform2(-0.2_f32..0.2), 0.7_f32..1.5, pose(1.0, 0.1)).prop_map(
            |(rotation, [x, y], z, world_from_hand)| {
                let camera_from_hand = Pose { rotation, translation: Vector3::new(x, y, z) };
                (
                    Camera::new(&camera_from_hand, &world_from_hand, &Vector3::repeat(0.02), 800.0),
                    world_from_hand,
                )
            },
        )
    }

    /// Where a ball is seen, px.
    fn seen(camera: &Camera, hand: &Pose, ball: &Vector3<f32>) -> Vector2<f32> {
        let hand = camera.sees(hand);
        project(&(hand.rotation * ball + hand.translation), camera.focal_px()).unwrap().x_px
    }

    proptest! {
        #[test]
        fn derivatives_are_those_of_the_picture(
            (camera, hand) in camera(),
            ball in prop::array::uniform3(-0.08_f32..0.08),
            unknown in 0_usize..POSE_AND_CAMERA,
        ) {
            let ball = Vector3::from(ball);
            let origin = ImagePoint::new(0.0, 0.0);
            let sighting = Sighting::new(origin, origin, 0.0, 800.0, [1.0, 0.0, 1.0]).unwrap();
            let at = camera.compare(&camera.sees(&hand), &hand, &ball, &sighting).unwrap();
            let of_camera = camera.sensitivity(&at);
            // a step of about 4 px either way
            let size = if (POSE..POSE + 3).contains(&unknown) { 0.01 } else { [0.005, 4.0][usize::from((9..11).contains(&unknown))] };
            let picture = |sign: f32| {
                let (mut camera, mut hand) = (camera, hand);
                if unknown < POSE {
                    let mut step = [0.0; POSE];
                    step[unknown] = sign * size;
                    let [x, y, z, a, b, c] = step;
                    hand.translation += Vector3::new(x, y, z);
                    hand.rotation = so3::exp(&Vector3::new(a, b, c)) * hand.rotation;
                } else {
                    let mut step = [0.0; CAMERA];
                    step[unknown - POSE] = sign * size;
                    assert!(camera.step(&step));
                }
                seen(&camera, &hand, &ball)
            };
            let change = (picture(1.0) - picture(-1.0)) / (2.0 * size);
            for axis in 0..2 {
                let expected = if unknown < POSE { at.pose[axis][unknown] } else { of_camera[axis][unknown - POSE] };
                let tolerance = 0.01 * expected.abs() + 0.02 / size;
                prop_assert!((change[axis] - expected).abs() < tolerance, "{unknown}: {} {expected}", change[axis]);
            }
        }

        #[test]
        fn a_new_world_changes_no_picture((camera, hand) in camera(), latched in pose(1.0, 0.2)) {
            let mut moved = camera;
            moved.change_world(&latched);
            let in_new = latched.inverse().compose(&hand);
            prop_assert!(difference(&moved.sees(&in_new), &camera.sees(&hand)) < 1e-5);
            prop_assert!(difference(&moved.places(&moved.sees(&in_new)), &in_new) < 1e-5);
        }

        #[test]
        fn another_focal_length_leaves_the_pivot_where_it_is_seen((camera, hand) in camera(), change in -0.2_f32..0.2) {
            let pivot = Vector3::repeat(0.02);
            let mut zoomed = camera;
            prop_assert!(zoomed.step(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, change]));
            prop_assert!((zoomed.focal_px() / 800.0 - libm::expf(change)).abs() < 1e-5);
            prop_assert!((seen(&zoomed, &hand, &pivot) - seen(&camera, &hand, &pivot)).norm() < 0.01);
        }
    }

    const POSE: usize = 6;
    const POSE_AND_CAMERA: usize = POSE + CAMERA;

    #[test]
    fn steps_that_are_not_small_are_refused() {
        let hand = Pose { rotation: Matrix3::identity(), translation: Vector3::new(0.0, 0.0, 1.0) };
        let camera = Camera::new(&hand, &Pose::identity(), &Vector3::zeros(), 800.0);
        for (unknown, size) in [(0, 0.6), (5, -0.6), (6, 0.6), (3, f32::NAN)] {
            let (mut stepped, mut by) = (camera, [0.0; CAMERA]);
            by[unknown] = size;
            assert!(!stepped.step(&by));
            assert_eq!(stepped, camera);
        }
    }
}
