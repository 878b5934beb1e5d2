//! What is known of the hand after a frame, in either mode.

use crate::geometry::Pose;
use crate::hand::motion::{Motion, MotionRefusal};
use crate::hand::state::{PoseCovariance, PoseState};

/// What is known of the hand after a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandReport {
    /// The motion since the last measured frame, or why there is none.
    pub motion: Result<Motion, MotionRefusal>,
    /// engage_from_now (before the first engage: in the feature frame of the first complete frame);
    /// `None` before it, and when the hand has been away for too long.
    pub pose: Option<Pose>,
    /// How well the pose is known; `None` without a pose, and in `paper` mode, whose method says
    /// nothing about it.
    pub covariance: Option<PoseCovariance>,
    /// How the pose is known.
    pub state: PoseState,
}
