//! The hand's pose from all that was measured in one frame: Gauss-Newton steps on the reprojection
//! error, the cameras being as they are known.
//!
//! Every ball of every view gives two equations in units of their standard deviation, whichever view
//! it is from: that weighs the views by their information, and three balls in one view do with four in
//! the other (rigid completion). A ball beyond `huber_sigmas` counts linearly, so that one wrong
//! ball cannot carry the hand away. A weak prior about the start keeps directions that nothing
//! was measured in where they were expected.

use super::camera::{Camera, Sensitivity};
use super::symmetric::add_lower;
use crate::config::{MAX_VIEWS, PoseConfig};
use crate::geometry::Pose;
use crate::hand::affine::Arms;
use crate::hand::orientation::nearest_rotation_step;
use crate::hand::perspective::Sightings;
use crate::hand::so3;
use crate::observation::BALLS;
use nalgebra::{Cholesky, Matrix6, Vector3, Vector6};

/// The most steps; two or three are taken where the prediction is good.
const MAX_STEPS: usize = 10;

/// A step that lowers the sum of squares (in variances) by less is the last one: what it leaves is
/// the square of a thirtieth of a standard deviation at most, and less since the steps shrink quickly.
const LAST_STEP: f32 = 1e-2;

/// What the last of [`MAX_STEPS`] may gain. With a ball that is far off the steps shrink slowly, since
/// it is weighed anew each time; what came of them tells which ball it is.
const POOR_STEP: f32 = 1e3;

/// The cameras by their place in the list.
pub type Cameras = [Option<Camera>; MAX_VIEWS];

/// What was measured, by camera.
pub type Seen = [Sightings; MAX_VIEWS];

/// How the views fit the pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewFit {
    /// Balls that were compared.
    pub balls: u8,
    /// The sum of squares of measured less projected, px^2.
    pub squares_px: f32,
}

impl ViewFit {
    /// The root mean square over the image coordinates, px.
    #[must_use]
    pub fn rms_px(&self) -> f32 {
        libm::sqrtf(self.squares_px / (2.0 * f32::from(self.balls)).max(1.0))
    }
}

/// A pose and how well it fits.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// world_from_hand.
    pub pose: Pose,
    /// The covariance of translation (m) and turn (rad), world axes, from the centres' noise alone.
    pub covariance: Matrix6<f32>,
    /// The sum of squares in variances (Huber's beyond `huber_sigmas`), without the prior.
    pub squares: f32,
    /// Equations less unknowns.
    pub freedom: f32,
    /// How many balls stand too far off to be what they were taken for.
    pub wrong: u32,
    /// The view and the ball that stands farthest off of those.
    pub worst: Option<(usize, usize)>,
    /// Whether the steps came to an end.
    pub settled: bool,
    /// By camera.
    pub views: [ViewFit; MAX_VIEWS],
}

impl Fit {
    /// Squares per degree of freedom: 1 where the centres are as good as they say.
    #[must_use]
    pub fn mean_square(&self) -> f32 {
        self.squares / self.freedom.max(1.0)
    }

    /// The root mean square over all balls and views, px.
    #[must_use]
    pub fn rms_px(&self) -> f32 {
        let squares: f32 = self.views.iter().map(|view| view.squares_px).sum();
        let balls: f32 = self.views.iter().map(|view| f32::from(view.balls)).sum();
        libm::sqrtf(squares / (2.0 * balls).max(1.0))
    }
}

/// Calls `each` with camera, ball and derivatives of all that was measured, at `pose`.
pub fn compare_all(
    pose: &Pose,
    cameras: &Cameras,
    seen: &Seen,
    arms: Arms,
    mut each: impl FnMut(usize, usize, &Camera, &Sensitivity),
) {
    for (view, (camera, sightings)) in cameras.iter().zip(seen).enumerate() {
        if let Some(camera) = camera {
            compare_view(pose, camera, sightings, arms, |ball, at| each(view, ball, camera, at));
        }
    }
}

/// Calls `each` with ball and derivatives of all that one camera measured, at `pose`.
pub(super) fn compare_view(
    pose: &Pose,
    camera: &Camera,
    sightings: &Sightings,
    arms: Arms,
    mut each: impl FnMut(usize, &Sensitivity),
) {
    if sightings.iter().all(Option::is_none) {
        return;
    }
    let balls = arms.balls_in_frame();
    let camera_from_hand = camera.sees(pose);
    for (ball, (x_in_hand, sighting)) in balls.iter().zip(sightings).enumerate() {
        let Some(sighting) = sighting else { continue };
        if let Some(derivatives) = camera.compare(&camera_from_hand, pose, x_in_hand, sighting) {
            each(ball, &derivatives);
        }
    }
}

/// The pose that fits best, sought from `start`; `noise` is how many times worse than they say
/// the centres have turned out to be. `None` where too little was measured to fix a pose, or the
/// steps go nowhere.
#[must_use]
pub fn solve(
    start: &Pose,
    cameras: &Cameras,
    seen: &Seen,
    arms: Arms,
    noise: f32,
    config: &PoseConfig,
) -> Option<Fit> {
    if !is_enough(cameras, seen) {
        return None;
    }
    let weight = 1.0 / (noise * noise);
    let (prior_t, prior_w) = (config.prior_m, config.prior_rad);
    let prior = Vector6::new(prior_t, prior_t, prior_t, prior_w, prior_w, prior_w)
        .map(|sigma: f32| 1.0 / (sigma * sigma));
    let mut pose = *start;
    for step in 0..MAX_STEPS {
        let mut information = Matrix6::from_diagonal(&prior);
        // at the start nothing draws back to it
        let mut gradient = Vector6::zeros();
        if step > 0 {
            gradient = prior.component_mul(&difference(start, &pose));
        }
        let mut squares = 0.0;
        let mut equations = 0.0;
        let mut views = [ViewFit::default(); MAX_VIEWS];
        let (mut wrong, mut worst, mut farthest) = (0, None, 0.0);
        let bound = config.huber_sigmas;
        compare_all(&pose, cameras, seen, arms, |view, ball, _, at| {
            let square = at.residual.norm_squared() * weight;
            let mut trust = weight;
            if square > bound * bound {
                let distance = libm::sqrtf(square);
                squares += bound * (2.0 * distance - bound);
                // where a first step starts everything may be off together
                if step > 0 {
                    trust = weight * bound / distance;
                }
            } else {
                squares += square;
            }
            equations += 2.0;
            for (row, residual) in at.pose.iter().zip(&at.residual) {
                let row = Vector6::from(*row);
                gradient += row * (trust * residual);
                add_lower(&mut information, &(row * trust), &row);
            }
            let square_px = at.residual_px.norm_squared();
            let is_far = square > config.wrong_sigmas * config.wrong_sigmas;
            if is_far && square_px > config.wrong_px * config.wrong_px {
                wrong += 1;
                if square > farthest {
                    (farthest, worst) = (square, Some((view, ball)));
                }
            }
            if let Some(fit) = views.get_mut(view) {
                fit.balls += 1;
                fit.squares_px += square_px;
            }
        });
        let factor = Cholesky::new(information)?;
        let by = factor.solve(&gradient);
        let gain = gradient.dot(&by);
        if !gain.is_finite() {
            return None;
        }
        let [x, y, z, wx, wy, wz] = by.into();
        pose.translation += Vector3::new(x, y, z);
        pose.rotation = nearest_rotation_step(&(so3::exp(&Vector3::new(wx, wy, wz)) * pose.rotation));
        let settled = step > 0 && gain < LAST_STEP;
        let last = step + 1 == MAX_STEPS && gain < POOR_STEP;
        if settled || last {
            let settled = settled || gain < 1.0;
            let covariance = factor.inverse();
            let finite = covariance.iter().chain(pose.translation.iter()).all(|x| x.is_finite());
            let fit =
                Fit { pose, covariance, squares, freedom: equations - 6.0, wrong, worst, settled, views };
            return finite.then_some(fit);
        }
    }
    None
}

/// What a turn and a shift, in world axes and about the hand's own origin, take `from` to `to`:
/// translation in metres, then the rotation vector.
#[must_use]
pub fn difference(to: &Pose, from: &Pose) -> Vector6<f32> {
    let t = to.translation - from.translation;
    let w = so3::log(&(to.rotation * from.rotation.transpose()));
    Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z)
}

/// Three balls at least, and more equations than the six unknowns. Three balls in one view give just
/// six, which up to four poses satisfy: where the plane of the three comes to face the camera two of
/// them become one, and when they part again nothing in the picture tells which is true. The wrong one
/// fits to a hundredth of a pixel and is off by 10 degrees.
fn is_enough(cameras: &Cameras, seen: &Seen) -> bool {
    let mut equations = 0;
    let mut any = [false; BALLS];
    for (camera, sightings) in cameras.iter().zip(seen) {
        if camera.is_some() {
            for (any, sighting) in any.iter_mut().zip(sightings) {
                *any |= sighting.is_some();
                equations += if sighting.is_some() { 2 } else { 0 };
            }
        }
    }
    equations > 6 && any.iter().filter(|any| **any).count() >= 3
}
