//! What the newest command says, once it has been looked at.

use super::command::{BadCommand, Command, checked};
use crate::geometry::Pose;
use crate::hand::state::{PoseCovariance, PoseState};
use crate::real::Real;

/// The newest command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Newest<T> {
    /// On this receiver's clock.
    pub(super) received_us: u64,
    /// On the sender's.
    pub(super) capture_us: u64,
    pub(super) engaged: bool,
    pub(super) engagements: u32,
    pub(super) state: PoseState,
    /// engage_from_now and the increment, or why neither can be used.
    pub(super) motion: Result<HandMotion<T>, BadCommand>,
    pub(super) covariance: Option<PoseCovariance>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HandMotion<T> {
    pub(super) since_engage: Pose<T>,
    pub(super) increment: Pose<T>,
}

/// The sender latched the hand between two commands that came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SenderLatch {
    /// When the hand of the last command before was seen, sender's clock.
    pub(super) before_us: u64,
    /// When the first command after came, receiver's clock.
    pub(super) first_us: u64,
}

impl<T: Real> Newest<T> {
    pub(super) fn read(command: &Command) -> Self {
        let known = command.covariance.is_none_or(|p| p.iter().all(|x| x.is_finite()));
        let motion = checked(&command.since_engage).and_then(|since_engage| {
            let increment = checked(&command.increment)?;
            if known { Ok(HandMotion { since_engage, increment }) } else { Err(BadCommand::NotFinite) }
        });
        Self {
            received_us: command.received_us,
            capture_us: command.capture_us,
            engaged: command.engaged,
            engagements: command.engagements,
            state: command.state,
            motion,
            covariance: command.covariance,
        }
    }
}
