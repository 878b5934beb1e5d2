//! What is reported of a frame: the state of a measured pose, and pose and reason where none was
//! measured.

use super::PoseTracker;
use super::course::turned_covariance;
use super::solve::Fit;
use crate::geometry::Pose;
use crate::hand::affine::AffineRefusal;
use crate::hand::motion::MotionRefusal;
use crate::hand::report::HandReport;
use crate::hand::state::PoseState;
use crate::hand::view::HandView;
use crate::observation::{BALLS, Ball};
use nalgebra::Matrix6;

impl PoseTracker {
    /// The report of a frame whose pose was not measured.
    pub(super) fn unmeasured(&self, views: &[HandView], t_us: u64) -> HandReport {
        let motion = Err(refusal(views));
        let lost = HandReport { motion, pose: None, covariance: None, state: PoseState::Lost };
        let Some(course) = self.course.as_ref() else { return lost };
        let age_us = course.age_us(t_us);
        if age_us > self.longest_us() {
            return lost;
        }
        let config = self.pose_config();
        let carried_on = course.pose_at(t_us, config);
        let (pose, covariance) = self.since_engage(&carried_on, &course.covariance_at(t_us, config));
        HandReport {
            pose: Some(pose),
            covariance: Some(covariance),
            state: if age_us > config.predict_us { PoseState::Held } else { PoseState::Predicted },
            ..lost
        }
    }

    /// A pose in the world, and its covariance, as since engage: with what is not known of where the
    /// world stands, were the cameras latched anew on the way.
    #[inline]
    pub(super) fn since_engage(&self, pose: &Pose, covariance: &Matrix6<f32>) -> (Pose, Matrix6<f32>) {
        let Some((engage_from_world, engage_covariance)) = &self.engage_from_world else {
            return (*pose, *covariance);
        };
        let turn = &engage_from_world.rotation;
        // a turn of the world carries the hand along
        let lever = turn * pose.translation;
        let mut carry = Matrix6::identity();
        carry.fixed_view_mut::<3, 3>(0, 3).copy_from(&(-lever.cross_matrix()));
        let of_world = carry * engage_covariance * carry.transpose();
        (engage_from_world.compose(pose), turned_covariance(turn, covariance) + of_world)
    }
}

/// Which views and balls a pose was measured from.
pub(super) fn state_of(fit: &Fit) -> PoseState {
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
