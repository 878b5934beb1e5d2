//! The refined pose: latched at engage, with perspective terms, from one to eight uncalibrated views.
//!
//! ```text
//! views --> what is measured (`sightings`)
//!       --> where the hand is expected ([`course`])
//!       --> Gauss-Newton on the reprojection error ([`solve`]): pose
//!       --> what disagrees is left out: a wrong ball, a camera that was moved (`consistency`)
//!       --> whom to believe again, and whom not (`trust`)
//!       --> how good the centres are (`noise`)
//!       --> what the motion teaches of the cameras ([`calibration`], [`camera`], `equations`, [`square_root`])
//!       --> cameras that join or were moved, and the hand at an engage (`latching`)
//!       --> pose since engage, covariance, state (`report`)
//! ```
//!
//! The paper adds up increments (section 4), each an affine approximation; here every pose is told
//! from the latched one at once, so nothing adds up and a lost frame loses nothing. What a camera is
//! follows from the hand itself: the pose in which it sees the hand at the latch, and a nominal focal
//! length that the motion mends.
//!
//! The covariance is the sum of the centres' noise (scaled by what the residuals have shown it to
//! be), and of what is not known of the cameras, the latched frame's noise included.

pub mod calibration;
pub mod camera;
pub mod course;
pub mod solve;
pub mod square_root;

mod consistency;
mod equations;
mod latching;
mod noise;
mod report;
mod sightings;
mod symmetric;
mod trust;

use crate::config::{HandConfig, MAX_VIEWS, PoseConfig};
use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::Arms;
use crate::hand::motion::Motion;
use crate::hand::perspective::picture;
use crate::hand::report::HandReport;
use crate::hand::view::{CameraModel, HandView};
use crate::observation::BALLS;
use calibration::Calibration;
use camera::Camera;
use consistency::Solved;
use course::Course;
use nalgebra::Matrix6;
use report::state_of;
use sightings::middle;
use solve::Seen;
use trust::Trust;

#[cfg(test)]
mod tests;

/// The hand's pose since engage, from all views. About 30 KiB for eight cameras and 4 KiB for two, most of
/// it what is known of them ([`square_root`]).
#[derive(Clone, Debug)]
pub struct PoseTracker {
    arms: Arms,
    config: HandConfig,
    models: [Option<CameraModel>; MAX_VIEWS],
    calibration: Calibration,
    /// `None` until the hand has been latched.
    course: Option<Course>,
    /// The movement before all cameras were doubted: where it goes on at the next latch.
    doubted: Option<Course>,
    /// The pose since engage of the world's origin, and how well that is known, where it is not there: cameras
    /// were latched anew on the way.
    engage_from_world: Option<(Pose, Matrix6<f32>)>,
    /// Which balls were half hidden in this frame.
    hidden: [[bool; BALLS]; MAX_VIEWS],
    /// How many times worse than they say the centres are, standard deviations.
    noise: f32,
    /// What was measured in the last frame, if its pose was.
    last: Option<Seen>,
    refused: u32,
    engagements: u32,
    latch_at_next: bool,
    /// Frames in which one camera alone was ready to be latched.
    waited: u32,
    /// Whom to believe.
    trust: [Trust; MAX_VIEWS],
    /// Frames in a row in which nothing fitted.
    unsolved: u32,
}

impl PoseTracker {
    /// A tracker of a feature frame with these arms, which has seen nothing yet.
    #[must_use]
    pub fn new(arms: Arms, config: HandConfig) -> Self {
        Self {
            arms,
            config,
            models: [None; MAX_VIEWS],
            calibration: Calibration::new(0),
            course: None,
            doubted: None,
            engage_from_world: None,
            hidden: [[false; BALLS]; MAX_VIEWS],
            noise: 1.0,
            last: None,
            refused: 0,
            engagements: 0,
            latch_at_next: false,
            waited: 0,
            trust: [Trust::default(); MAX_VIEWS],
            unsolved: 0,
        }
    }

    /// Latches the hand: from here on the pose is told from where the hand is now.
    ///
    /// Where the hand is not seen now, the latch waits for the next measured frame, so that motion
    /// made unseen before it cannot move the arm.
    pub fn engage(&mut self) {
        match (&self.course, self.last) {
            (Some(course), Some(seen)) => {
                let pose = *course.pose();
                self.latch(&pose, &seen);
            }
            _ => self.latch_at_next = true,
        }
    }

    /// Forgets the hand and the cameras; `engagements` counts on.
    pub fn restart(&mut self) {
        self.forget_cameras();
        self.models = [None; MAX_VIEWS];
        self.engage_from_world = None;
        self.refused = 0;
        self.latch_at_next = false;
        self.trust = [Trust::default(); MAX_VIEWS];
    }

    /// Forgets where the cameras stand, and so the hand, but not whom to believe nor since when the pose is
    /// told. In place: a second tracker beside this one would be too much for a microcontroller's stack.
    fn forget_cameras(&mut self) {
        let Self {
            arms: _,
            config: _,
            models: _,
            calibration,
            course,
            doubted,
            engage_from_world: _,
            hidden,
            noise,
            last,
            refused: _,
            engagements: _,
            latch_at_next: _,
            waited,
            trust: _,
            unsolved,
        } = self;
        calibration.clear();
        (*course, *doubted, *last) = (None, None, None);
        *hidden = [[false; BALLS]; MAX_VIEWS];
        *noise = 1.0;
        (*waited, *unsolved) = (0, 0);
    }

    /// How many times the hand was latched.
    #[must_use]
    pub const fn engagements(&self) -> u32 {
        self.engagements
    }

    /// Takes one frame: each camera's part, in the same order of cameras every time, taken at `t_us`
    /// microseconds of any clock that goes forward.
    pub fn update(&mut self, views: &[HandView], t_us: u64) -> HandReport {
        let seen = self.take(views);
        self.watch(&seen);
        let before = self.course.as_ref().map(|course| *course.pose());
        let solved = match before {
            None => self.latch_first(&seen, t_us),
            Some(_) => self.measure(&seen, t_us),
        };
        let Some(solved) = solved else {
            self.last = None;
            self.refused = self.refused.saturating_add(u32::from(self.course.is_some()));
            self.doubt_everything(&seen);
            return self.unmeasured(views, t_us);
        };
        self.follow(&solved, &seen, before.as_ref(), t_us)
    }

    /// Goes on from a frame that was solved, the pose having been `before`.
    // Of its own, as the parts of solving are: what one of them puts on the stack is gone before the next.
    #[inline(never)]
    fn follow(&mut self, solved: &Solved, seen: &Seen, before: Option<&Pose>, t_us: u64) -> HandReport {
        let Solved { fit, seen: used, excluded } = solved;
        self.unsolved = 0;
        let spread = self.calibration.spread(fit, used, self.arms, self.noise);
        let covariance = fit.covariance + spread;
        let spans = if before.is_some() { self.refused.saturating_add(1) } else { 0 };
        let increment = before.copied().unwrap_or_else(Pose::identity).inverse().compose(&fit.pose);
        let state = state_of(fit);
        if let Some(course) = &mut self.course {
            course.follow(&fit.pose, &covariance, &fit.covariance, t_us);
        }
        self.refused = 0;
        self.last = Some(*used);
        self.noise_follows(fit);
        self.learn(fit, seen, used, *excluded);

        let (pose, covariance) = self.since_engage(&fit.pose, &covariance);
        let mut report = HandReport {
            motion: Ok(Motion {
                alpha: increment.translation,
                phi: increment.rotation,
                since_engage: pose,
                engagements: self.engagements,
                residual_px: fit.rms_px(),
                spans,
            }),
            pose: Some(pose),
            covariance: Some(covariance),
            state,
        };
        if self.latch_at_next {
            self.latch(&fit.pose, used);
            report.pose = Some(Pose::identity());
            report.covariance = self.course.as_ref().map(|course| *course.covariance());
            if let Ok(motion) = &mut report.motion {
                motion.since_engage = Pose::identity();
                motion.engagements = self.engagements;
            }
        }
        report
    }

    /// Where the camera `view` is expected to see the four balls at `t_us`, px; `None` where nothing
    /// is expected (section 3.5). It needs no ball in that view, nor any, while the pose is carried on.
    #[must_use]
    pub fn predict(&self, view: usize, t_us: u64) -> [Option<ImagePoint>; BALLS] {
        let model = self.models.get(view).and_then(Option::as_ref);
        let (Some(course), Some(model), Some(camera)) = (&self.course, model, self.calibration.camera(view))
        else {
            return [None; BALLS];
        };
        if course.age_us(t_us) > self.longest_us() {
            return [None; BALLS];
        }
        let hand = camera.sees(&course.pose_at(t_us, self.pose_config()));
        let middle = middle(model);
        picture(&hand, camera.focal_px(), self.arms)
            .map(|x| x.map(|x| ImagePoint::new(x.x, x.y) + middle).filter(|point| point.is_finite()))
    }

    /// The focal lengths as the motion has taught them, px; `None` for a camera that is not latched.
    #[must_use]
    pub fn focal_px(&self, view: usize) -> Option<f32> {
        self.calibration.camera(view).map(Camera::focal_px)
    }

    const fn pose_config(&self) -> &PoseConfig {
        &self.config.pose
    }

    const fn longest_us(&self) -> u64 {
        self.config.pose.predict_us.saturating_add(self.config.pose.hold_us)
    }
}
