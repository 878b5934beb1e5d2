//! What the balls of one view say of the hand's pose and of the cameras, as equations, and taking the pose
//! out of those of a frame.
//!
//! The pose is taken out view by view: the equations of the first are turned until six of the eight hold all
//! that they say of the pose ([`OfView::gather_pose`]), and those of each other view are reflected into these
//! six until they say nothing of it ([`OfView::take_pose_out`]). What is left is about the cameras alone; the
//! six are left out.
//!
//! What one view says besides of its own camera is one equation about the focal length: where the camera
//! stands cannot be told from where the hand is, since moving the one looks as moving the other.

use super::camera::Camera;
use super::solve::compare_view;
use super::square_root::{CAMERA, Equations, Reflection, UNKNOWNS};
use crate::geometry::Pose;
use crate::hand::affine::Arms;
use crate::hand::perspective::Sightings;
use crate::observation::BALLS;

/// Unknowns of a pose.
const POSE: usize = 6;

/// Equations of a view: two a ball.
const EQUATIONS: usize = 2 * BALLS;

/// The equations of a view, in units of their standard deviations, column by column; those of a ball that was
/// not measured are zeros.
#[derive(Clone, Debug)]
pub(super) struct OfView {
    pose: [[f32; EQUATIONS]; POSE],
    /// Their right hand sides, then what they say of the cameras.
    pub cameras: Equations<EQUATIONS>,
}

impl OfView {
    pub(super) const EMPTY: Self =
        Self { pose: [[0.0; EQUATIONS]; POSE], cameras: [[0.0; EQUATIONS]; UNKNOWNS + 1] };

    /// Writes what one camera says of a hand at `pose`, where nothing was written yet.
    pub(super) fn write(
        &mut self,
        (view, camera): (usize, &Camera),
        pose: &Pose,
        sightings: &Sightings,
        arms: Arms,
        noise: f32,
    ) {
        let weight = 1.0 / noise;
        let Self { pose: of_pose, cameras: [right, cameras @ ..] } = self;
        compare_view(pose, camera, sightings, arms, |ball, at| {
            let put = |column: &mut [f32; EQUATIONS], first: f32, second: f32| {
                let (pairs, _) = column.as_chunks_mut::<2>();
                if let Some(pair) = pairs.get_mut(ball) {
                    *pair = [first * weight, second * weight];
                }
            };
            put(right, at.residual.x, at.residual.y);
            let [first, second] = &at.pose;
            for ((column, first), second) in of_pose.iter_mut().zip(first).zip(second) {
                put(column, *first, *second);
            }
            let [first, second] = &camera.sensitivity(at);
            let of_camera = cameras.iter_mut().skip(CAMERA * view);
            for ((column, first), second) in of_camera.zip(first).zip(second) {
                put(column, *first, *second);
            }
        });
    }

    /// Turns the equations of `view` until the first says of the whole pose, the second of all but its first
    /// unknown and so on; gives the seventh, which says of the focal length alone.
    pub(super) fn gather_pose(&mut self, view: usize) -> Equations<1> {
        let Self { pose, cameras: [right, cameras @ ..] } = self;
        let mut rest = pose.as_mut_slice();
        let of_camera = || CAMERA * view..CAMERA * (view + 1);
        for place in 0..POSE {
            let Some((heads, tail)) = rest.split_first_mut() else { break };
            if let Some(mirror) = Mirror::new(heads, place) {
                tail.iter_mut().for_each(|column| mirror.reflect(column));
                mirror.reflect(right);
                let of_camera = cameras.get_mut(of_camera()).unwrap_or_default();
                of_camera.iter_mut().for_each(|column| mirror.reflect(column));
            }
            rest = tail;
        }
        let mut left = [[0.0]; UNKNOWNS + 1];
        let mut focal = cameras.get(of_camera()).and_then(<[_]>::last).copied().unwrap_or_default();
        if let Some(mirror) = Mirror::new(&mut focal, POSE) {
            let mut right = *right;
            mirror.reflect(&mut right);
            let ([to_right, ..], [.., said, _], [.., factor, _]) = (&mut left, right, focal);
            *to_right = [said];
            if let Some(to) = left.get_mut(CAMERA * (view + 1)) {
                *to = [factor];
            }
        }
        left
    }

    /// Reflects these equations into the `gathered` ones of another view until they say nothing of the pose;
    /// so many `unknowns` of the cameras are in use.
    pub(super) fn take_pose_out(&mut self, gathered: &mut Self, unknowns: usize) {
        let (mut own, mut rest) = (gathered.pose.as_mut_slice(), self.pose.as_mut_slice());
        for place in 0..POSE {
            let (Some((own_heads, own_tail)), Some((heads, tail))) =
                (own.split_first_mut(), rest.split_first_mut())
            else {
                break;
            };
            let Some(diagonal) = own_heads.get_mut(place) else { break };
            if let Some(reflection) = Reflection::into_diagonal(diagonal, heads) {
                let of_cameras = gathered.cameras.iter_mut().zip(&mut self.cameras).take(1 + unknowns);
                for (own, others) in own_tail.iter_mut().zip(tail.iter_mut()).chain(of_cameras) {
                    if let Some(own) = own.get_mut(place) {
                        reflection.reflect(own, others);
                    }
                }
            }
            (own, rest) = (own_tail, tail);
        }
    }
}

/// The reflection that gathers the factors of one unknown in one of the equations themselves.
struct Mirror {
    /// Across its plane, 1 in the equation that gathers.
    normal: [f32; EQUATIONS],
    /// Two over the normal's square.
    share: f32,
}

impl Mirror {
    /// The factors from the equation `place` on are gathered in it; `None` where they are zero.
    fn new(heads: &mut [f32; EQUATIONS], place: usize) -> Option<Self> {
        let mut normal = *heads;
        for (equation, head) in normal.iter_mut().enumerate() {
            *head = if equation < place { 0.0 } else { *head };
        }
        let squares: f32 = normal.iter().map(|head| head * head).sum();
        if squares == 0.0 {
            return None;
        }
        let own = heads.get_mut(place)?;
        let length = libm::copysignf(libm::sqrtf(squares), *own);
        let reach = *own + length;
        *own = -length;
        let over_reach = 1.0 / reach;
        let mut normal = normal.map(|head| head * over_reach);
        *normal.get_mut(place)? = 1.0;
        Some(Self { normal, share: reach / length })
    }

    fn reflect(&self, column: &mut [f32; EQUATIONS]) {
        let along: f32 = self.normal.iter().zip(column.iter()).map(|(n, value)| n * value).sum();
        let step = self.share * along;
        for (value, n) in column.iter_mut().zip(&self.normal) {
            *value -= n * step;
        }
    }
}

#[cfg(test)]
mod tests;
