//! Latching: the hand's frame, and where each camera stands to it, at first, at an engage, for a camera
//! that joins or was moved, and anew for all when nothing fits any more.

use super::PoseTracker;
use super::camera::Camera;
use super::consistency::Solved;
use super::course::Course;
use super::noise::MAX_NOISE;
use super::sightings::complete;
use super::solve::{Cameras, Fit, Seen, solve};
use crate::config::{MAX_VIEWS, PoseConfig};
use crate::geometry::Pose;
use crate::hand::perspective::Sightings;
use crate::hand::perspective::posit::posit;
use crate::observation::BALLS;
use nalgebra::Vector3;

impl PoseTracker {
    /// The first frame: every camera that sees all four balls is latched where it sees the hand.
    #[cold]
    #[inline(never)]
    pub(super) fn latch_first(&mut self, seen: &Seen, t_us: u64) -> Option<Solved> {
        let listed = self.models.iter().flatten().count();
        let mut single = [None; MAX_VIEWS];
        for (view, ((found, sightings), model)) in single.iter_mut().zip(seen).zip(&self.models).enumerate() {
            *found = model
                .filter(|_| !self.is_stale(view))
                .and_then(|model| self.single_view(sightings, model.focal_px));
        }
        let ready = single.iter().flatten().count();
        if ready == 0 {
            return None;
        }
        if ready < listed.min(2) && self.waited < self.config.pose.latch_wait_frames {
            self.waited = self.waited.saturating_add(1);
            return None;
        }
        let mut anchor: Seen = [[None; BALLS]; MAX_VIEWS];
        let views = single.iter().zip(seen).zip(&mut anchor).zip(&self.models).enumerate();
        for (view, (((found, sightings), anchor), model)) in views {
            if let (Some((camera_from_hand, mean_square)), Some(model)) = (found, model) {
                self.noise = self.noise.max(libm::sqrtf(*mean_square).min(MAX_NOISE));
                *anchor = *sightings;
                let nominal = model.focal_px;
                let origin = Pose::identity();
                self.calibration.add_camera(view, camera_from_hand, &origin, nominal, nominal, self.arms);
            }
        }
        for trust in &mut self.trust {
            *trust = trust.begin_anew();
        }
        let noise = self.noise;
        self.calibration.latch(&Pose::identity(), &anchor, self.arms, noise, &self.config.pose);
        let mut fit = self.fit(&Pose::identity(), &anchor)?;
        fit.pose = Pose::identity();
        self.waited = 0;
        if let Some(course) = self.doubted.take() {
            let config = &self.config.pose;
            self.engage_from_world =
                Some(self.since_engage(&course.pose_at(t_us, config), &course.covariance_at(t_us, config)));
        }
        self.course = Some(Course::new(fit.pose, fit.covariance, t_us));
        Some(Solved { fit, seen: anchor, excluded: None })
    }

    /// camera_from_hand from one view alone, and how many times worse than they say its centres are;
    /// `None` unless it shows all four balls about as such a hand would.
    fn single_view(&self, sightings: &Sightings, focal_px: f32) -> Option<(Pose, f32)> {
        let start = posit(&complete(sightings)?, focal_px, self.arms)?;
        let camera = Camera::new(&start, &Pose::identity(), &Vector3::zeros(), focal_px);
        let mut cameras: Cameras = [None; MAX_VIEWS];
        let mut seen: Seen = [[None; BALLS]; MAX_VIEWS];
        if let (Some(first), Some(its)) = (cameras.first_mut(), seen.first_mut()) {
            (*first, *its) = (Some(camera), *sightings);
        }
        // nothing to lean on but the four balls, all alike
        let alone = PoseConfig { huber_sigmas: 1e6, prior_m: 10.0, prior_rad: 10.0, ..self.config.pose };
        let fit = solve(&Pose::identity(), &cameras, &seen, self.arms, 1.0, &alone)?;
        let fits = fit.settled && fit.rms_px() < self.config.pose.latch_px;
        // two equations too many say little about small errors, and enough about those of pixels
        let noise = if fit.rms_px() > self.config.pose.wrong_px { fit.mean_square() } else { 1.0 };
        fits.then(|| (camera.sees(&fit.pose), noise))
    }

    /// What a solved frame tells of the cameras.
    #[inline(never)]
    pub(super) fn learn(&mut self, fit: &Fit, seen: &Seen, used: &Seen, excluded: Option<usize>) {
        self.trust_follows(fit, seen, used, excluded);
        let noise = self.noise;
        let contributing = fit.views.iter().filter(|view| view.balls > 0).count();
        let listed = self.models.iter().flatten().count();
        if contributing >= listed.min(2) && excluded.is_none() {
            self.calibration.learn(&fit.pose, used, self.arms, noise, &self.config.pose);
        }
        // a camera that was moved, and one that has not seen the hand before, are latched from the pose
        // that the others give
        let moved = self.take_moved();
        let mut focal_px = None;
        if let Some(view) = moved {
            focal_px = self.calibration.remove_camera(view);
        }
        let mut joined = false;
        let mut with_joined = *used;
        for view in 0..MAX_VIEWS {
            let (Some(model), Some(sightings)) = (self.models.get(view).copied().flatten(), seen.get(view))
            else {
                continue;
            };
            if self.calibration.camera(view).is_some() || self.is_stale(view) {
                continue;
            }
            let focal_px = focal_px.filter(|_| moved == Some(view)).unwrap_or(model.focal_px);
            let Some((camera_from_hand, _)) = self.single_view(sightings, focal_px) else { continue };
            self.calibration.add_camera(view, &camera_from_hand, &fit.pose, focal_px, focal_px, self.arms);
            if let Some(with) = with_joined.get_mut(view) {
                *with = *sightings;
            }
            joined = true;
        }
        if joined {
            self.calibration.relearn(&fit.pose, &with_joined, self.arms, noise, &self.config.pose);
        }
    }

    /// All cameras are latched anew, the pose going on from where it stands, when views that show the
    /// whole hand have contradicted each other for too long.
    #[cold]
    #[inline(never)]
    pub(super) fn doubt_everything(&mut self, seen: &Seen) {
        let shown = seen
            .iter()
            .enumerate()
            .any(|(view, sightings)| !self.is_stale(view) && sightings.iter().all(Option::is_some));
        if self.course.is_none() || !shown {
            return;
        }
        self.unsolved = self.unsolved.saturating_add(1);
        if self.unsolved > self.config.pose.relatch_frames {
            let doubted = self.course.take();
            self.forget_cameras();
            self.doubted = doubted;
            for trust in &mut self.trust {
                *trust = trust.begin_anew();
            }
        }
    }

    /// From here on the pose is told from `pose`, at which the balls were `seen`.
    #[cold]
    #[inline(never)]
    pub(super) fn latch(&mut self, pose: &Pose, seen: &Seen) {
        let noise = self.noise;
        self.calibration.latch(pose, seen, self.arms, noise, &self.config.pose);
        if let Some(course) = &mut self.course {
            course.change_world(pose);
        }
        // what was not known of the old world does not matter in the new one
        if let Some(fit) = self.fit(&Pose::identity(), seen) {
            let covariance = fit.covariance + self.calibration.spread(&fit, seen, self.arms, noise);
            if let Some(course) = &mut self.course {
                course.is_known_to(covariance);
            }
        }
        for trust in &mut self.trust {
            trust.change_world();
        }
        self.engage_from_world = None;
        self.engagements = self.engagements.wrapping_add(1);
        self.latch_at_next = false;
    }
}
