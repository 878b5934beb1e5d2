//! Fingers and palms that come between a camera and the balls.

use crate::camera::Camera;
use crate::light::between_keys;
use crate::outline::{CapsuleOutline, SphereOutline};
use tetrad_core::observation::{BALLS, Ball};

/// How far a finger reaches back from its tip, in ball diameters: beyond any picture's border.
const LENGTH: f64 = 60.0;

/// What an [`Occluder`] moves along with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// One ball.
    Ball(Ball),
    /// The middle of the four.
    Hand,
}

/// A finger in front of everything. It is placed in each picture by itself, as if every camera had
/// a finger of its own before it, so that all cameras lose the ball at the same time.
#[derive(Clone, Debug, PartialEq)]
pub struct Occluder {
    /// What it moves along with.
    pub anchor: Anchor,
    /// Which cameras it stands before.
    pub cameras: Vec<usize>,
    /// The direction it comes from, radians: 0 is from the right, a quarter turn from below.
    pub from_rad: f64,
    /// Half its width, in diameters of the anchor as it appears.
    pub radius: f64,
    /// How far its tip reaches past the anchor's centre over time, (second, ball diameters): 0 is
    /// half the ball covered by a wide finger, negative is not yet there.
    pub reach: Vec<(f64, f64)>,
    /// Grey levels in full light.
    pub albedo: [f64; 3],
}

impl Occluder {
    /// A finger of pale skin before both of two cameras.
    #[must_use]
    pub fn finger(anchor: Anchor, from_rad: f64, radius: f64, reach: Vec<(f64, f64)>) -> Self {
        Self { anchor, cameras: vec![0, 1], from_rad, radius, reach, albedo: [205.0, 160.0, 135.0] }
    }

    /// Its outline in one camera's picture.
    pub(crate) fn outline(
        &self,
        camera: usize,
        time_s: f64,
        balls: &[Option<SphereOutline>; BALLS],
    ) -> Option<CapsuleOutline> {
        if !self.cameras.contains(&camera) {
            return None;
        }
        let reach = between_keys(&self.reach, time_s)?;
        let (centre, diameter) = match self.anchor {
            Anchor::Ball(ball) => balls[ball.index()].map(|ball| (ball.centre, ball.diameter))?,
            Anchor::Hand => middle(balls)?,
        };
        let towards = (libm::cos(self.from_rad), libm::sin(self.from_rad));
        let at = |distance: f64| (centre.0 + towards.0 * distance, centre.1 + towards.1 * distance);
        let tip = diameter * (self.radius - reach);
        let radius = diameter * self.radius;
        Some(CapsuleOutline::new([at(tip), at(tip + diameter * LENGTH)], [radius, radius]))
    }
}

/// Mean centre and diameter of the balls that are in front of the camera.
fn middle(balls: &[Option<SphereOutline>; BALLS]) -> Option<((f64, f64), f64)> {
    let seen = || balls.iter().flatten();
    let count = seen().count() as f64;
    let mean = |value: fn(&SphereOutline) -> f64| seen().map(value).sum::<f64>() / count;
    (count > 0.0).then(|| ((mean(|b| b.centre.0), mean(|b| b.centre.1)), mean(|b| b.diameter)))
}

/// A thin rod between two points given in camera axes; `None` unless both are in front.
pub(crate) fn rod(
    camera: &Camera,
    from_to: [nalgebra::Vector3<f64>; 2],
    radius_m: f64,
) -> Option<CapsuleOutline> {
    if from_to.iter().any(|x| x.z <= radius_m) {
        return None;
    }
    Some(CapsuleOutline::new(
        from_to.map(|x| camera.picture_of(&x)),
        from_to.map(|x| camera.focal_px * radius_m / x.z),
    ))
}
