//! The measured balls of the views, in the form in which they are compared with a pose.

use super::PoseTracker;
use super::solve::Seen;
use crate::config::{MAX_VIEWS, PoseConfig};
use crate::geometry::ImagePoint;
use crate::hand::perspective::{Sighting, Sightings};
use crate::hand::view::{CameraModel, HandView};
use crate::observation::{BALLS, ImageCovariance, Observation, ObservationState};
use nalgebra::Vector2;

/// The share of the rim from which on a ball counts as seen whole.
const CLEAR: f32 = 0.75;

impl PoseTracker {
    /// The measured balls of the views, in the form they are compared in.
    pub(super) fn take(&mut self, views: &[HandView]) -> Seen {
        let mut seen: Seen = [[None; BALLS]; MAX_VIEWS];
        let views = views.iter().take(MAX_VIEWS);
        self.calibration.expect_views(views.len());
        let places = views.zip(&mut seen).zip(&mut self.models).zip(&mut self.hidden);
        for (((view, sightings), model), hidden) in places {
            *model = Some(view.camera);
            for ((ball, hidden), of_ball) in view.balls.iter().zip(hidden).zip(sightings) {
                *hidden = ball.state == ObservationState::Occluded || ball.visible < CLEAR;
                *of_ball = sighting(ball, &view.camera, &self.config.pose);
            }
        }
        seen
    }
}

/// The middle of a camera's pictures, px.
pub(super) fn middle(model: &CameraModel) -> ImagePoint {
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
pub(super) fn complete(sightings: &Sightings) -> Option<[Vector2<f32>; BALLS]> {
    let [red, green, blue, yellow] = sightings;
    Some([red.as_ref()?.x_px, green.as_ref()?.x_px, blue.as_ref()?.x_px, yellow.as_ref()?.x_px])
}
