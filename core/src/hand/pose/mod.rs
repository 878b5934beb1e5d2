//! The refined pose: latched at engage, with perspective terms, from one to eight uncalibrated views.
//!
//! ```text
//! views --> where the hand is expected ([`course`])
//!       --> Gauss-Newton on the reprojection error ([`solve`]): pose
//!       --> what disagrees is left out: a wrong ball, a camera that was moved
//!       --> what the motion teaches of the cameras ([`calibration`], [`camera`], [`square_root`])
//!       --> pose since engage, covariance, state
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

use crate::config::{HandConfig, MAX_VIEWS, PoseConfig};
use crate::geometry::{ImagePoint, Pose};
use crate::hand::affine::{AffineRefusal, Arms};
use crate::hand::motion::{Motion, MotionRefusal};
use crate::hand::perspective::posit::posit;
use crate::hand::perspective::{Sighting, Sightings, picture};
use crate::hand::report::HandReport;
use crate::hand::state::PoseState;
use crate::hand::view::{CameraModel, HandView};
use crate::observation::{BALLS, Ball, ImageCovariance, Observation, ObservationState};
use calibration::Calibration;
use camera::Camera;
use course::{Course, turned_covariance};
use nalgebra::{Cholesky, Vector3};
use solve::{Cameras, Fit, Seen, solve};

#[cfg(test)]
mod tests;

/// How many of the balls of a frame may be left out as wrong before a whole view is doubted.
const MAX_WRONG: usize = 2;

/// Equations less unknowns from which on a ball that is not where it should be shows: seven balls.
const REDUNDANT: f32 = 8.0;

/// The share of the rim from which on a ball counts as seen whole.
const CLEAR: f32 = 0.75;

/// Frames over which the noise of the centres is judged.
const NOISE_MEMORY: f32 = 32.0;

/// The least that is left of the standard deviations that centres come with, however well they fit:
/// what they have in common does not show in what is left of them.
const MIN_NOISE: f32 = 0.5;

/// The most that centres are taken for worse than they say, in standard deviations.
const MAX_NOISE: f32 = 100.0;

/// The hand's pose since engage, from all views. About 36 KiB, most of it for eight cameras' worth of
/// what is known of them ([`square_root`]).
#[derive(Clone, Debug)]
pub struct PoseTracker {
    arms: Arms,
    config: HandConfig,
    models: [Option<CameraModel>; MAX_VIEWS],
    calibration: Calibration,
    /// `None` until the hand has been latched.
    course: Option<Course>,
    /// The pose since engage of the world's origin: the identity, but for cameras latched anew on
    /// the way.
    engage_from_world: Pose,
    /// Which balls were half hidden in this frame.
    hidden: [[bool; BALLS]; MAX_VIEWS],
    /// How many times worse than they say the centres are, variances.
    noise_square: f32,
    /// What was measured in the last frame, if its pose was.
    last: Option<Seen>,
    refused: u32,
    engagements: u32,
    latch_at_next: bool,
    /// Frames in which one camera alone was ready to be latched.
    waited: u32,
    /// Frames in a row in which a camera contradicted the others; in which nothing fitted.
    contradicted: [u32; MAX_VIEWS],
    unsolved: u32,
}

/// A frame that was solved.
struct Solved {
    fit: Fit,
    /// What of the views it was solved from.
    seen: Seen,
    /// The view that was left out.
    excluded: Option<usize>,
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
            engage_from_world: Pose::identity(),
            hidden: [[false; BALLS]; MAX_VIEWS],
            noise_square: 1.0,
            last: None,
            refused: 0,
            engagements: 0,
            latch_at_next: false,
            waited: 0,
            contradicted: [0; MAX_VIEWS],
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
        *self = Self { engagements: self.engagements, ..Self::new(self.arms, self.config) };
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
        let before = self.course.as_ref().map(|course| *course.pose());
        let solved = match before {
            None => self.latch_first(&seen, t_us),
            Some(_) => self.measure(&seen, t_us),
        };
        let Some(Solved { fit, seen: used, excluded }) = solved else {
            self.last = None;
            self.refused = self.refused.saturating_add(u32::from(self.course.is_some()));
            self.doubt_everything(&seen, t_us);
            return self.unmeasured(views, t_us);
        };
        self.unsolved = 0;
        let spread = self.calibration.spread(&fit, &used, self.arms, self.noise());
        let covariance = fit.covariance + spread;
        let spans = if before.is_some() { self.refused.saturating_add(1) } else { 0 };
        let increment = before.unwrap_or_else(Pose::identity).inverse().compose(&fit.pose);
        let state = state_of(&fit);
        if let Some(course) = &mut self.course {
            course.follow(&fit.pose, &covariance, &fit.covariance, t_us);
        }
        self.refused = 0;
        self.last = Some(used);
        self.noise_follows(&fit);
        self.learn(&fit, &seen, &used, excluded);

        let pose = self.engage_from_world.compose(&fit.pose);
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
            covariance: Some(turned_covariance(&self.engage_from_world.rotation, &covariance)),
            state,
        };
        if self.latch_at_next {
            self.latch(&fit.pose, &used);
            report.pose = Some(Pose::identity());
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

    fn noise(&self) -> f32 {
        libm::sqrtf(self.noise_square)
    }

    /// The measured balls of the views, in the form they are compared in.
    fn take(&mut self, views: &[HandView]) -> Seen {
        let mut seen: Seen = [[None; BALLS]; MAX_VIEWS];
        let views = views.iter().take(MAX_VIEWS);
        self.calibration.expect_views(views.len());
        let places = views.zip(&mut seen).zip(&mut self.models).zip(&mut self.hidden);
        for (((view, sightings), model), hidden) in places {
            *model = Some(view.camera);
            *hidden = view.balls.map(|ball| ball.state == ObservationState::Occluded || ball.visible < CLEAR);
            *sightings = view.balls.map(|ball| sighting(&ball, &view.camera, &self.config.pose));
        }
        seen
    }

    /// Solves a frame from the cameras as they are known; what does not fit is left out.
    fn measure(&self, seen: &Seen, t_us: u64) -> Option<Solved> {
        let course = self.course.as_ref()?;
        let expected = course.pose_at(t_us, self.pose_config());
        let cameras = self.calibration.cameras();
        // cameras not latched yet take no part
        let mut known = *seen;
        for (sightings, camera) in known.iter_mut().zip(cameras) {
            if camera.is_none() {
                *sightings = [None; BALLS];
            }
        }
        let solved = self.consistent(&known, &expected, &expected).or_else(|| {
            // the hand is not where it was expected: from where each complete view sees it
            let mut starts = cameras.iter().zip(&known).filter_map(|(camera, sightings)| {
                let camera = camera.as_ref()?;
                let hand = posit(&complete(sightings)?, camera.focal_px(), self.arms)?;
                Some(camera.places(&hand))
            });
            starts.find_map(|start| self.consistent(&known, &start, &expected))
        })?;
        if self.is_likely(&solved.fit, course, t_us) {
            return Some(solved);
        }
        // a leap is believed where balls seen whole show it; those half hidden may have feigned it
        let mut clear = known;
        for ((sightings, hidden), fitted) in clear.iter_mut().zip(&self.hidden).zip(&solved.seen) {
            for ((sighting, hidden), fitted) in sightings.iter_mut().zip(hidden).zip(fitted) {
                if *hidden || fitted.is_none() {
                    *sighting = None;
                }
            }
        }
        if clear == solved.seen { Some(solved) } else { self.consistent(&clear, &expected, &expected) }
    }

    /// Whether a pose may follow from the movement before it. After a while unseen any may, if there
    /// are balls enough for a wrong one to show.
    fn is_likely(&self, fit: &Fit, course: &Course, t_us: u64) -> bool {
        let config = self.pose_config();
        if course.age_us(t_us) > config.predict_us {
            return fit.freedom >= REDUNDANT;
        }
        let leap = solve::difference(&fit.pose, &course.pose_at(t_us, config));
        let covariance = fit.covariance + course.covariance_at(t_us, config);
        let square = Cholesky::new(covariance).map_or(0.0, |factor| leap.dot(&factor.solve(&leap)));
        square < 6.0 * config.leap_sigmas * config.leap_sigmas
    }

    /// The pose from a start, without the balls or the view that contradict the others.
    fn consistent(&self, seen: &Seen, start: &Pose, expected: &Pose) -> Option<Solved> {
        let mut rest = *seen;
        let mut from = *start;
        for _ in 0..=MAX_WRONG {
            let Some(fit) = self.fit(&from, &rest) else { break };
            if is_sound(&fit) {
                return Some(Solved { fit, seen: rest, excluded: None });
            }
            // without the ball that is farthest off: it draws others after it
            let Some((view, ball)) = fit.worst else { break };
            if let Some(sighting) = rest.get_mut(view).and_then(|sightings| sightings.get_mut(ball)) {
                *sighting = None;
            }
            from = fit.pose;
        }
        // one camera contradicts the others: the one without which the hand is nearest to where it
        // was expected
        let mut best: Option<(f32, Solved)> = None;
        for (view, sightings) in seen.iter().enumerate() {
            if sightings.iter().all(Option::is_none) {
                continue;
            }
            let mut rest = *seen;
            if let Some(sightings) = rest.get_mut(view) {
                *sightings = [None; BALLS];
            }
            let Some(fit) = self.fit(start, &rest).filter(is_sound) else { continue };
            let off = self.unlikelihood(&fit.pose, expected);
            if best.as_ref().is_none_or(|(least, _)| off < *least) {
                best = Some((off, Solved { fit, seen: rest, excluded: Some(view) }));
            }
        }
        best.map(|(_, solved)| solved)
    }

    fn fit(&self, start: &Pose, seen: &Seen) -> Option<Fit> {
        let config = self.pose_config();
        solve(start, self.calibration.cameras(), seen, self.arms, self.noise(), config)
    }

    /// How far a pose is from where it was expected, in what a prediction may be off.
    fn unlikelihood(&self, pose: &Pose, expected: &Pose) -> f32 {
        let config = self.pose_config();
        let [x, y, z, wx, wy, wz] = solve::difference(pose, expected).into();
        let shift = (x * x + y * y + z * z) / (config.prior_m * config.prior_m);
        shift + (wx * wx + wy * wy + wz * wz) / (config.prior_rad * config.prior_rad)
    }

    /// The first frame: every camera that sees all four balls is latched where it sees the hand.
    fn latch_first(&mut self, seen: &Seen, t_us: u64) -> Option<Solved> {
        let listed = self.models.iter().flatten().count();
        let mut single = [None; MAX_VIEWS];
        for ((found, sightings), model) in single.iter_mut().zip(seen).zip(&self.models) {
            *found = model.and_then(|model| self.single_view(sightings, model.focal_px));
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
                self.noise_square = self.noise_square.max(mean_square.min(MAX_NOISE * MAX_NOISE));
                *anchor = *sightings;
                let nominal = model.focal_px;
                let origin = Pose::identity();
                self.calibration.add_camera(view, camera_from_hand, &origin, nominal, nominal, self.arms);
            }
        }
        let noise = self.noise();
        self.calibration.latch(&Pose::identity(), &anchor, self.arms, noise, &self.config.pose);
        let mut fit = self.fit(&Pose::identity(), &anchor)?;
        fit.pose = Pose::identity();
        self.waited = 0;
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
    fn learn(&mut self, fit: &Fit, seen: &Seen, used: &Seen, excluded: Option<usize>) {
        for (view, count) in self.contradicted.iter_mut().enumerate() {
            *count = if excluded == Some(view) { count.saturating_add(1) } else { 0 };
        }
        let noise = self.noise();
        let contributing = fit.views.iter().filter(|view| view.balls > 0).count();
        let listed = self.models.iter().flatten().count();
        if contributing >= listed.min(2) && excluded.is_none() {
            self.calibration.learn(&fit.pose, used, self.arms, noise, &self.config.pose);
        }
        // a camera that was moved, and one that has not seen the hand before, are latched from the pose
        // that the others give
        let patience = self.config.pose.relatch_frames;
        let moved = excluded.filter(|view| self.contradicted.get(*view).is_some_and(|n| *n >= patience));
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
            if self.calibration.camera(view).is_some() {
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

    /// Centres that are worse than they say are found out by what is left of them.
    fn noise_follows(&mut self, fit: &Fit) {
        if fit.freedom > 0.0 {
            // few equations say less
            let share = fit.freedom / (fit.freedom + 10.0 * NOISE_MEMORY);
            let next = self.noise_square * (1.0 + share * (fit.mean_square() - 1.0));
            self.noise_square = next.clamp(MIN_NOISE * MIN_NOISE, MAX_NOISE * MAX_NOISE);
        }
    }

    /// All cameras are latched anew, the pose going on from where it stands, when views that show the
    /// whole hand have contradicted each other for too long.
    fn doubt_everything(&mut self, seen: &Seen, t_us: u64) {
        let shown = seen.iter().any(|sightings| sightings.iter().all(Option::is_some));
        let Some(course) = self.course.as_ref().filter(|_| shown) else { return };
        self.unsolved = self.unsolved.saturating_add(1);
        if self.unsolved > self.config.pose.relatch_frames {
            let pose = course.pose_at(t_us, &self.config.pose);
            let held = self.engage_from_world.compose(&pose);
            let fresh = Self::new(self.arms, self.config);
            *self = Self {
                engage_from_world: held,
                engagements: self.engagements,
                latch_at_next: self.latch_at_next,
                refused: self.refused,
                models: self.models,
                ..fresh
            };
        }
    }

    fn latch(&mut self, pose: &Pose, seen: &Seen) {
        let noise = self.noise();
        self.calibration.latch(pose, seen, self.arms, noise, &self.config.pose);
        if let Some(course) = &mut self.course {
            course.change_world(pose);
        }
        self.engage_from_world = Pose::identity();
        self.engagements = self.engagements.wrapping_add(1);
        self.latch_at_next = false;
    }

    /// The report of a frame whose pose was not measured.
    fn unmeasured(&self, views: &[HandView], t_us: u64) -> HandReport {
        let motion = Err(refusal(views));
        let lost = HandReport { motion, pose: None, covariance: None, state: PoseState::Lost };
        let Some(course) = self.course.as_ref() else { return lost };
        let age_us = course.age_us(t_us);
        if age_us > self.longest_us() {
            return lost;
        }
        let config = self.pose_config();
        let pose = self.engage_from_world.compose(&course.pose_at(t_us, config));
        let covariance = course.covariance_at(t_us, config);
        HandReport {
            pose: Some(pose),
            covariance: Some(turned_covariance(&self.engage_from_world.rotation, &covariance)),
            state: if age_us > config.predict_us { PoseState::Held } else { PoseState::Predicted },
            ..lost
        }
    }
}

/// The middle of a camera's pictures, px.
fn middle(model: &CameraModel) -> ImagePoint {
    ImagePoint::new((f32::from(model.width) - 1.0) / 2.0, (f32::from(model.height) - 1.0) / 2.0)
}

/// A measured ball in the form it is compared in.
fn sighting(ball: &Observation, model: &CameraModel, config: &PoseConfig) -> Option<Sighting> {
    if !ball.state.is_measured() {
        return None;
    }
    let given = ball.covariance;
    let known = given.is_valid() && given.uu > 0.0 && given.vv > 0.0;
    let ImageCovariance { uu, uv, vv } =
        if known { given } else { ImageCovariance::isotropic(config.centre_default_px) };
    let floor = config.centre_floor_px * config.centre_floor_px;
    Sighting::new(ball.centre, middle(model), ball.diameter, model.focal_px, [uu + floor, uv, vv + floor])
}

/// The four balls' places, if all were measured.
fn complete(sightings: &Sightings) -> Option<[nalgebra::Vector2<f32>; BALLS]> {
    let [red, green, blue, yellow] = sightings;
    Some([red.as_ref()?.x_px, green.as_ref()?.x_px, blue.as_ref()?.x_px, yellow.as_ref()?.x_px])
}

/// Whether a fit came to an end with every ball near where it should be.
fn is_sound(fit: &Fit) -> bool {
    fit.settled && fit.wrong == 0
}

fn state_of(fit: &Fit) -> PoseState {
    let contributing = fit.views.iter().filter(|view| view.balls > 0);
    let (count, whole) = contributing
        .fold((0, true), |(count, whole), view| (count + 1, whole && usize::from(view.balls) == BALLS));
    match (count, whole) {
        (0 | 1, _) => PoseState::One,
        (_, true) => PoseState::Both,
        (_, false) => PoseState::Three,
    }
}

/// Why there is no pose: the first ball that is missing, or that what is there does not fit.
fn refusal(views: &[HandView]) -> MotionRefusal {
    if views.is_empty() {
        return AffineRefusal::TooFewViews.into();
    }
    let missing = (0_u8..).zip(views).find_map(|(view, seen)| {
        let missing = Ball::ALL.into_iter().zip(&seen.balls).find(|(_, ball)| !ball.state.is_measured());
        missing.map(|(ball, _)| MotionRefusal::BallMissing { view, ball })
    });
    missing.unwrap_or(MotionRefusal::Inconsistent)
}
