//! What the hand's own motion teaches of the cameras: where they stand and their focal lengths.
//!
//! The hand's pose at the last latch is the world, so the balls measured then (the *anchor*) are seen
//! with the pose known: they fix each camera but for its focal length, of which only a nominal value
//! is known. Each later *key* frame, one in which the hand has moved since the last, gives equations
//! in the hand's pose and the cameras together; the pose is taken out and the rest is kept
//! ([`SquareRoot`]). So
//!
//! ```text
//! knowledge = key frames (poses taken out, fading) + anchor + nominal focal lengths
//! ```
//!
//! and its best fit is the cameras. Key frames fade, for two reasons: the centres' errors are not
//! independent from frame to frame (a light from one side pulls all centres one way), and the
//! equations hold about the cameras as they were known then. The anchor and the nominal focal
//! lengths do not fade, and are compared anew each time. A hand at rest adds nothing, so standing
//! still for ten minutes feigns no certainty and moves no pose.

use super::camera::Camera;
use super::equations::OfView;
use super::solve::{Cameras, Fit, Seen, compare_all};
use super::square_root::{CAMERA, CameraUnknowns, Equations, SquareRoot, UNKNOWNS};
use crate::config::{MAX_VIEWS, PoseConfig};
use crate::geometry::Pose;
use crate::hand::affine::Arms;
use crate::observation::BALLS;
use nalgebra::{Matrix6, Vector3, Vector6};

/// How often the cameras are fitted again after a key frame: the anchor's equations bend where a
/// focal length is mended by several percent.
const FITS: usize = 3;

/// A change of an unknown below this (rad or logarithm; px for the place in the picture) is not
/// worth another fit.
const SMALL_CHANGE: f32 = 1e-3;

/// The cameras and how well they are known: about 27 KiB for eight of them, 2 KiB for two.
#[derive(Clone, Debug)]
pub struct Calibration {
    cameras: Cameras,
    views: usize,
    /// What was said of the focal lengths, px; what has been learnt where a camera was moved since.
    nominal_px: [f32; MAX_VIEWS],
    /// What was measured when the hand was at the world's origin.
    anchor: Seen,
    /// From the key frames.
    keys: SquareRoot,
    /// Everything together; its right hand side is spent.
    all: SquareRoot,
    /// The hand's pose in the last key frame.
    key_pose: Pose,
    repeats: u32,
}

impl Calibration {
    /// No camera is known yet; `views` of them are to come.
    #[must_use]
    pub fn new(views: usize) -> Self {
        Self {
            cameras: [None; MAX_VIEWS],
            views,
            nominal_px: [0.0; MAX_VIEWS],
            anchor: [[None; BALLS]; MAX_VIEWS],
            keys: SquareRoot::new(views),
            all: SquareRoot::new(views),
            key_pose: Pose::identity(),
            repeats: 0,
        }
    }

    /// No camera is known any more; none is to come yet.
    pub fn clear(&mut self) {
        let Self { cameras, views, nominal_px, anchor, keys, all, key_pose, repeats } = self;
        *cameras = [None; MAX_VIEWS];
        *views = 0;
        *nominal_px = [0.0; MAX_VIEWS];
        *anchor = [[None; BALLS]; MAX_VIEWS];
        keys.clear(0);
        all.clear(0);
        *key_pose = Pose::identity();
        *repeats = 0;
    }

    /// There are at least so many cameras.
    pub fn expect_views(&mut self, views: usize) {
        if views > self.views {
            self.views = views;
            self.keys.make_room(views);
        }
    }

    /// The cameras as they are known now.
    #[must_use]
    pub const fn cameras(&self) -> &Cameras {
        &self.cameras
    }

    /// One camera of them.
    #[must_use]
    pub fn camera(&self, view: usize) -> Option<&Camera> {
        self.cameras.get(view).and_then(Option::as_ref)
    }

    /// Adds a camera that sees the hand so while the hand is at `pose`. It is known from the next key
    /// frame or anchor on.
    pub fn add_camera(
        &mut self,
        view: usize,
        camera_from_hand: &Pose,
        pose: &Pose,
        focal_px: f32,
        nominal_px: f32,
        arms: Arms,
    ) {
        let [l1, l2, l3] = arms.lengths_m();
        let middle_in_hand = Vector3::new(l1, l2, l3) / 4.0;
        if let (Some(camera), Some(nominal)) = (self.cameras.get_mut(view), self.nominal_px.get_mut(view)) {
            *camera = Some(Camera::new(camera_from_hand, pose, &middle_in_hand, focal_px));
            *nominal = nominal_px;
        }
    }

    /// Forgets a camera that was moved; gives its focal length, px.
    pub fn remove_camera(&mut self, view: usize) -> Option<f32> {
        let focal_px = self.camera(view)?.focal_px();
        if let (Some(camera), Some(anchor)) = (self.cameras.get_mut(view), self.anchor.get_mut(view)) {
            *camera = None;
            *anchor = [None; BALLS];
        }
        self.keys.forget_camera(view);
        Some(focal_px)
    }

    /// The hand at `pose`, where it was measured so, is the world from here on.
    pub fn latch(&mut self, pose: &Pose, seen: &Seen, arms: Arms, noise: f32, config: &PoseConfig) {
        // the old anchor stays as a key frame: what it says of the cameras whatever the pose was
        let old = self.anchor;
        self.add_equations(&Pose::identity(), &old, arms, noise);
        for camera in self.cameras.iter_mut().flatten() {
            camera.change_world(pose);
        }
        self.anchor = *seen;
        self.key_pose = Pose::identity();
        self.repeats = 0;
        self.fit(arms, noise, config);
    }

    /// Learns from a frame in which the hand is at `pose`, where it has moved far enough since the
    /// last one that taught something.
    pub fn learn(&mut self, pose: &Pose, seen: &Seen, arms: Arms, noise: f32, config: &PoseConfig) {
        if self.has_moved(pose, arms, config) {
            let remembered = 1.0 - 1.0 / config.key_frames.max(2.0);
            self.keys.fade(libm::sqrtf(remembered));
            self.add_equations(pose, seen, arms, noise);
            self.key_pose = *pose;
            self.repeats = 0;
            self.fit(arms, noise, config);
        } else if self.repeats < config.key_repeats {
            self.add_equations(pose, seen, arms, noise);
            self.repeats += 1;
            self.fit(arms, noise, config);
        }
    }

    /// Learns from this frame in any case, as when a camera has just been added.
    pub fn relearn(&mut self, pose: &Pose, seen: &Seen, arms: Arms, noise: f32, config: &PoseConfig) {
        self.add_equations(pose, seen, arms, noise);
        self.key_pose = *pose;
        self.fit(arms, noise, config);
    }

    /// The covariance that not knowing the cameras gives to a pose (order as in [`Fit`]).
    #[must_use]
    pub fn spread(&self, fit: &Fit, seen: &Seen, arms: Arms, noise: f32) -> Matrix6<f32> {
        let mut columns = [Vector6::zeros(); CAMERA * MAX_VIEWS];
        let weight = 1.0 / (noise * noise);
        compare_all(&fit.pose, &self.cameras, seen, arms, |view, _, camera, at| {
            let of_view = columns.iter_mut().skip(CAMERA * view).take(CAMERA);
            let [first, second] = camera.sensitivity(at);
            let [row_1, row_2] = at.pose.map(|row| Vector6::from(row) * weight);
            for (column, (a, b)) in of_view.zip(first.iter().zip(&second)) {
                for (sum, (of_1, of_2)) in column.iter_mut().zip(row_1.iter().zip(&row_2)) {
                    *sum += of_1 * a;
                    *sum += of_2 * b;
                }
            }
        });
        for column in columns.iter_mut().take(CAMERA * self.views) {
            if *column != Vector6::zeros() {
                *column = fit.covariance * *column;
            }
        }
        self.all.spread(&mut columns)
    }

    /// Whether a ball has moved by `key_arms` of an arm since the last key frame.
    fn has_moved(&self, pose: &Pose, arms: Arms, config: &PoseConfig) -> bool {
        let lengths = Vector3::from(arms.lengths_m());
        let least = config.key_arms * (lengths.x + lengths.y + lengths.z) / 3.0;
        arms.balls_in_frame().iter().any(|ball| {
            let moved = (pose.rotation - self.key_pose.rotation) * ball + pose.translation
                - self.key_pose.translation;
            moved.norm_squared() > least * least
        })
    }

    /// Adds a frame's equations to the key frames', its pose taken out.
    fn add_equations(&mut self, pose: &Pose, seen: &Seen, arms: Arms, noise: f32) {
        let mut gathered = OfView::EMPTY;
        let mut is_first = true;
        let views = self.cameras.iter().zip(seen).enumerate();
        for (view, (camera, sightings)) in views {
            let Some(camera) = camera else { continue };
            if sightings.iter().all(Option::is_none) {
                continue;
            }
            if is_first {
                gathered.write((view, camera), pose, sightings, arms, noise);
                self.keys.insert(&mut gathered.gather_pose(view));
                is_first = false;
            } else {
                let mut equations = OfView::EMPTY;
                equations.write((view, camera), pose, sightings, arms, noise);
                equations.take_pose_out(&mut gathered, CAMERA * self.views);
                self.keys.insert(&mut equations.cameras);
            }
        }
    }

    /// The cameras that fit best all that is known.
    fn fit(&mut self, arms: Arms, noise: f32, config: &PoseConfig) {
        for _ in 0..FITS {
            let all = &mut self.all;
            all.copy_from(&self.keys);
            let cameras = self.cameras.iter().zip(&self.nominal_px).zip(&self.anchor).enumerate();
            for (view, ((camera, nominal_px), sightings)) in cameras {
                let Some(camera) = camera else { continue };
                all.insert(&mut nominal_focal(view, camera, *nominal_px, config));
                if sightings.iter().any(Option::is_some) {
                    let mut anchor = OfView::EMPTY;
                    anchor.write((view, camera), &Pose::identity(), sightings, arms, noise);
                    all.insert(&mut anchor.cameras);
                }
            }
            let by = self.all.solve_cameras();
            if !self.step(&by) {
                // nothing sensible: what the keys say is not believed, the anchor is
                self.keys.clear(self.views);
                return;
            }
            if by.as_flattened().iter().all(|x| x.abs() < SMALL_CHANGE) {
                return;
            }
        }
    }

    /// Moves the cameras' unknowns; false where one would move too far.
    fn step(&mut self, by: &CameraUnknowns) -> bool {
        let mut stepped = self.cameras;
        let all_small = stepped
            .iter_mut()
            .zip(by)
            .all(|(camera, by)| camera.as_mut().is_none_or(|camera| camera.step(by)));
        if all_small {
            self.cameras = stepped;
            self.keys.shift_cameras(by);
        }
        all_small
    }
}

/// What was said of a camera's focal length.
fn nominal_focal(view: usize, camera: &Camera, nominal_px: f32, config: &PoseConfig) -> Equations<1> {
    let mut equation = [[0.0]; UNKNOWNS + 1];
    let off = libm::logf(nominal_px / camera.focal_px());
    if let ([[right], ..], true) = (&mut equation, off.is_finite()) {
        *right = off / config.focal_sigma;
    }
    if let Some([focal]) = equation.get_mut(CAMERA * (view + 1)) {
        *focal = 1.0 / config.focal_sigma;
    }
    equation
}
