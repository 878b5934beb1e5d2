//! One command as it came: what a motion packet says, and when it came on this receiver's clock.

use crate::geometry::Pose;
use crate::hand::state::{PoseCovariance, PoseState};
use crate::real::Real;
use crate::wire::MotionPacket;
use core::fmt;
use nalgebra::Matrix3;

/// The farthest place that is taken, metres: beyond it single precision is coarser than any use.
const MAX_PLACE_M: f32 = 1000.0;

/// How far R^T R of what is taken for a rotation may be from the identity, as on the wire; within,
/// the nearest rotation is meant.
const MAX_SKEW: f32 = 1e-3;

/// Steps of Newton's iteration to that rotation: the skew is squared in each, 1e-3 is 1e-12 after
/// two and 1e-16 after three.
const SQUARING_STEPS: usize = 3;

/// A command. Nothing in it has been believed yet: that is done where it is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Who sends: chosen anew each time the sender starts.
    pub session: u32,
    /// Counts the sender's commands, and wraps.
    pub sequence: u32,
    /// When the pictures were taken, on the sender's clock, microseconds. Only its differences are
    /// used; the age of a command is told by `received_us`.
    pub capture_us: u64,
    /// When it came, on this receiver's clock, microseconds.
    pub received_us: u64,
    /// Whether the operator moves the arm, as the sender knows it.
    pub engaged: bool,
    /// Counts the latches of the hand, and wraps.
    pub engagements: u32,
    /// How the pose is known.
    pub state: PoseState,
    /// The paper's alpha and Phi: R(t)_from_R(t+1).
    pub increment: Pose,
    /// engage_from_now.
    pub since_engage: Pose,
    /// How well `since_engage` is known.
    pub covariance: Option<PoseCovariance>,
}

impl Command {
    /// What a packet says, and when it came on this receiver's clock, microseconds.
    #[must_use]
    pub fn new(packet: &MotionPacket, received_us: u64) -> Self {
        Self {
            session: packet.session,
            sequence: packet.sequence,
            capture_us: packet.capture_us,
            received_us,
            engaged: packet.engaged,
            engagements: packet.engagements,
            state: packet.state,
            increment: packet.increment.into(),
            since_engage: packet.since_engage.into(),
            covariance: packet.covariance.map(Into::into),
        }
    }
}

/// What is wrong with the numbers of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BadCommand {
    /// A number is not finite, or a place is over a kilometre away.
    NotFinite,
    /// Nine numbers are not a rotation's.
    NotARotation,
}

impl fmt::Display for BadCommand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFinite => {
                "the operator station sends numbers that are not finite or beyond 1 km; restart it"
            }
            Self::NotARotation => "the operator station sends a rotation that is none; restart it",
        })
    }
}

impl core::error::Error for BadCommand {}

/// Why a command was dropped. All but [`CommandRefusal::Bad`] leave the law as it was; two senders
/// stop the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandRefusal {
    /// It is no newer than one that was taken before: reordered, repeated or replayed.
    Old,
    /// Its sender has been followed by another one since.
    OldSession,
    /// It is of another sender than the one that is being listened to.
    AnotherSender,
    /// Its numbers cannot be used; the arm holds until better ones come.
    Bad(BadCommand),
}

impl fmt::Display for CommandRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Old => "a command no newer than one taken before was dropped",
            Self::OldSession => "a command of a session that has ended was dropped",
            Self::AnotherSender => "a command of a second operator station was dropped; end one of the two",
            Self::Bad(bad) => return bad.fmt(f),
        })
    }
}

impl core::error::Error for CommandRefusal {}

/// The rotation nearest to a pose's, with the pose, or what is wrong with it.
pub(super) fn checked<T: Real>(pose: &Pose) -> Result<Pose<T>, BadCommand> {
    // comparisons written so that NaN fails them
    if !pose.translation.iter().all(|x| x.abs() <= MAX_PLACE_M)
        || !pose.rotation.iter().all(|x| x.is_finite())
    {
        return Err(BadCommand::NotFinite);
    }
    let of = |x: f32| T::of(f64::from(x));
    let rotation = pose.rotation.map(of);
    if !is_rotation(&rotation) {
        return Err(BadCommand::NotARotation);
    }
    Ok(Pose { rotation: nearest_rotation(&rotation), translation: pose.translation.map(of) })
}

/// Whether these are a rotation's nine numbers, to a thousandth.
pub(super) fn is_rotation<T: Real>(rotation: &Matrix3<T>) -> bool {
    let skew = rotation.transpose() * rotation - Matrix3::identity();
    let most = T::of(f64::from(MAX_SKEW));
    skew.iter().all(|x| x.abs() <= most) && rotation.determinant() > T::zero()
}

/// The rotation nearest to what is nearly one: R (3 I - R^T R) / 2, repeated. A matrix whose columns
/// are units of the axes comes back to the bit.
pub(super) fn nearest_rotation<T: Real>(rotation: &Matrix3<T>) -> Matrix3<T> {
    let (half, three) = (T::of(0.5), T::of(3.0));
    (0..SQUARING_STEPS).fold(*rotation, |r, _| r * ((Matrix3::identity() * three - r.transpose() * r) * half))
}
