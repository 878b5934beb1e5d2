//! The packets: what one camera saw, and how the hand moved. Plain arrays, no matrix types, so that
//! what is sent is what is written here, field by field in this order.

use super::{
    ArmStatePacket, BadValue, ButtonsPacket, CommandPacket, NoticePacket, PreviewPacket, ShownPacket,
};
use crate::geometry::{ImagePoint, Pose};
use crate::hand::state::{PoseCovariance, PoseState};
use crate::observation::{BALLS, ImageCovariance, Observation, ObservationState, Observations};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// The most bytes postcard takes for an unsigned integer: seven bits a byte.
pub(super) const MAX_U16: usize = 3;
pub(super) const MAX_U32: usize = 5;
pub(super) const MAX_U64: usize = 10;
/// A byte, a bool, or an enum of fewer than 128 variants.
pub(super) const BYTE: usize = 1;
pub(super) const F32: usize = 4;

/// The largest element of R^T R - I that passes as a rotation. Rotations are kept to 1e-6 by
/// [`crate::hand::orientation`]; this is for senders that do worse, and 1e-3 is 0.03 degrees.
const MAX_SKEW: f32 = 1e-3;

/// How far rounding may carry the square of a covariance above the product of its variances.
const COVARIANCE_SLACK: f32 = 1.0001;

/// What one camera saw in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObservationPacket {
    /// The camera's place in the list of views.
    pub camera: u8,
    /// Chosen anew each time the sender starts, so that old packets are not taken for new ones.
    pub session: u32,
    /// Counts the camera's packets from 0, and wraps.
    pub sequence: u32,
    /// When the picture was taken, on the sender's clock, microseconds.
    pub capture_us: u64,
    /// When the whole picture was in the sender's memory, microseconds after `capture_us`.
    pub ready_us: u32,
    /// When these observations were made of it, microseconds after `capture_us`.
    pub observed_us: u32,
    /// The picture's width, px.
    pub width: u16,
    /// The picture's height, px.
    pub height: u16,
    /// Pixels looked at to find the balls.
    pub pixels_tested: u32,
    /// The four balls. The centre of a lost ball is sent as (0, 0).
    pub balls: Observations,
}

impl ObservationPacket {
    /// The most bytes the fields take.
    pub const MAX_LEN: usize =
        BYTE + 2 * MAX_U32 + MAX_U64 + 2 * MAX_U32 + 2 * MAX_U16 + MAX_U32 + BALLS * (BYTE + 7 * F32);

    /// The same without what has no meaning: a lost ball has no place.
    pub(super) fn tidied(mut self) -> Self {
        for ball in self.balls.iter_mut().filter(|ball| ball.state == ObservationState::Lost) {
            ball.centre = ImagePoint::default();
            ball.covariance = ImageCovariance::default();
            ball.visible = 0.0;
        }
        self
    }

    pub(super) fn check(&self) -> Result<(), BadValue> {
        let numbers = |ball: &Observation| {
            let (c, k) = (ball.centre, ball.covariance);
            [c.u, c.v, ball.diameter, k.uu, k.uv, k.vv, ball.visible]
        };
        if !self.balls.iter().flat_map(numbers).all(f32::is_finite) {
            return Err(BadValue::NotFinite);
        }
        if !self.balls.iter().all(|ball| ball.covariance.is_valid()) {
            return Err(BadValue::NotACovariance);
        }
        if !self.balls.iter().all(|ball| (0.0..=1.0).contains(&ball.visible)) {
            return Err(BadValue::NotAShare);
        }
        Ok(())
    }
}

/// A rigid motion `a_from_b` as twelve numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transform {
    /// b's origin in a, metres.
    pub translation: [f32; 3],
    /// The rotation matrix row by row: r11, r12, r13, r21, ...
    pub rotation: [f32; 9],
}

impl Transform {
    pub(super) const MAX_LEN: usize = 12 * F32;

    /// No motion at all.
    pub const IDENTITY: Self =
        Self { translation: [0.0; 3], rotation: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0] };

    pub(super) fn check(&self) -> Result<(), BadValue> {
        if !self.translation.iter().chain(&self.rotation).all(|x| x.is_finite()) {
            return Err(BadValue::NotFinite);
        }
        let r = Pose::from(*self).rotation;
        let skew = r.transpose() * r - Matrix3::identity();
        // elements near 1 follow from the first, so the determinant is near +1 or -1
        if skew.iter().all(|x| x.abs() <= MAX_SKEW) && r.determinant() > 0.0 {
            Ok(())
        } else {
            Err(BadValue::NotARotation)
        }
    }
}

impl From<Pose> for Transform {
    fn from(pose: Pose) -> Self {
        let (t, r) = (pose.translation, pose.rotation);
        Self {
            translation: [t.x, t.y, t.z],
            rotation: [r.m11, r.m12, r.m13, r.m21, r.m22, r.m23, r.m31, r.m32, r.m33],
        }
    }
}

impl From<Transform> for Pose {
    fn from(transform: Transform) -> Self {
        let [x, y, z] = transform.translation;
        let [m11, m12, m13, m21, m22, m23, m31, m32, m33] = transform.rotation;
        Self {
            rotation: Matrix3::new(m11, m12, m13, m21, m22, m23, m31, m32, m33),
            translation: Vector3::new(x, y, z),
        }
    }
}

/// A [`PoseCovariance`] as the 21 numbers of its upper triangle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariance {
    /// Row by row from the diagonal on: 11 to 16, 22 to 26, ..., 66; m^2, m rad and rad^2.
    pub upper: [f32; 21],
}

impl Covariance {
    const MAX_LEN: usize = 21 * F32;

    /// Finite, no negative variance, and no two that vary together more than each does alone.
    fn check(&self) -> Result<(), BadValue> {
        if !self.upper.iter().all(|x| x.is_finite()) {
            return Err(BadValue::NotFinite);
        }
        let p = PoseCovariance::from(*self);
        let bounded = |i: usize, j: usize| match (p.get((i, i)), p.get((j, j)), p.get((i, j))) {
            (Some(a), Some(b), Some(c)) => *a >= 0.0 && *b >= 0.0 && c * c <= a * b * COVARIANCE_SLACK,
            _ => false,
        };
        let all = (0..6).all(|i| (i..6).all(|j| bounded(i, j)));
        if all { Ok(()) } else { Err(BadValue::NotACovariance) }
    }
}

impl From<PoseCovariance> for Covariance {
    fn from(p: PoseCovariance) -> Self {
        let mut upper = [0.0; 21];
        let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
        for (slot, place) in upper.iter_mut().zip(places) {
            *slot = p.get(place).copied().unwrap_or(0.0);
        }
        Self { upper }
    }
}

impl From<Covariance> for PoseCovariance {
    fn from(covariance: Covariance) -> Self {
        let mut p = Self::zeros();
        let places = (0..6).flat_map(|i| (i..6).map(move |j| (i, j)));
        for (value, (i, j)) in covariance.upper.iter().zip(places) {
            for place in [(i, j), (j, i)] {
                if let Some(slot) = p.get_mut(place) {
                    *slot = *value;
                }
            }
        }
        p
    }
}

/// How the hand moved. One is sent for every frame, also for one that was refused (`state` is then
/// `Held` or `Lost` and the increment the identity), so that silence means a broken link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotionPacket {
    /// Chosen anew each time the sender starts, so that old packets are not taken for new ones.
    pub session: u32,
    /// Counts the packets from 0, and wraps.
    pub sequence: u32,
    /// When the pictures were taken, on the sender's clock, microseconds.
    pub capture_us: u64,
    /// Whether the operator moves the arm.
    pub engaged: bool,
    /// Counts the latches of the hand, and wraps. Where it differs from the last packet's,
    /// `since_engage` is told from a new latch, and so must the set-point be.
    pub engagements: u32,
    /// How the pose is known.
    pub state: PoseState,
    /// How many frames the increment spans.
    pub spans: u32,
    /// How many cameras there are.
    pub views: u8,
    /// In how many of them each ball was measured.
    pub seen_in: [u8; BALLS],
    /// The root mean square of measured minus projected, px.
    pub residual_px: f32,
    /// The paper's alpha and Phi: R(t)_from_R(t+1).
    pub increment: Transform,
    /// engage_from_now. It holds the whole motion, so that a lost packet loses none of it.
    pub since_engage: Transform,
    /// How well `since_engage` is known; `None` where the sender's method does not say.
    pub covariance: Option<Covariance>,
}

impl MotionPacket {
    /// The most bytes the fields take.
    pub const MAX_LEN: usize = 2 * MAX_U32
        + MAX_U64
        + BYTE
        + MAX_U32
        + BYTE
        + MAX_U32
        + BYTE
        + BALLS * BYTE
        + F32
        + 2 * Transform::MAX_LEN
        + BYTE
        + Covariance::MAX_LEN;

    pub(super) fn check(&self) -> Result<(), BadValue> {
        if !self.residual_px.is_finite() {
            return Err(BadValue::NotFinite);
        }
        self.increment.check()?;
        self.since_engage.check()?;
        self.covariance.map_or(Ok(()), |covariance| covariance.check())
    }
}

/// Any packet.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Packet {
    /// What one camera saw.
    Observation(ObservationPacket),
    /// How the hand moved.
    Motion(MotionPacket),
    /// Where the arm is, and why.
    ArmState(ArmStatePacket),
    /// The operator's buttons.
    Buttons(ButtonsPacket),
    /// What a smart camera is told.
    Command(CommandPacket),
    /// What a smart camera says beside its observations.
    Notice(NoticePacket),
    /// A part of what a smart camera shows of a ball.
    Preview(PreviewPacket),
    /// What a camera without a sensor is shown.
    Shown(ShownPacket),
}

impl From<ObservationPacket> for Packet {
    fn from(packet: ObservationPacket) -> Self {
        Self::Observation(packet)
    }
}

impl From<MotionPacket> for Packet {
    fn from(packet: MotionPacket) -> Self {
        Self::Motion(packet)
    }
}

impl From<ArmStatePacket> for Packet {
    fn from(packet: ArmStatePacket) -> Self {
        Self::ArmState(packet)
    }
}

impl From<ButtonsPacket> for Packet {
    fn from(packet: ButtonsPacket) -> Self {
        Self::Buttons(packet)
    }
}

impl From<CommandPacket> for Packet {
    fn from(packet: CommandPacket) -> Self {
        Self::Command(packet)
    }
}

impl From<NoticePacket> for Packet {
    fn from(packet: NoticePacket) -> Self {
        Self::Notice(packet)
    }
}

impl From<PreviewPacket> for Packet {
    fn from(packet: PreviewPacket) -> Self {
        Self::Preview(packet)
    }
}

impl From<ShownPacket> for Packet {
    fn from(packet: ShownPacket) -> Self {
        Self::Shown(packet)
    }
}

impl Packet {
    /// The sender's session.
    #[must_use]
    pub const fn session(&self) -> u32 {
        match self {
            Self::Observation(packet) => packet.session,
            Self::Motion(packet) => packet.session,
            Self::ArmState(packet) => packet.session,
            Self::Buttons(packet) => packet.session,
            Self::Command(packet) => packet.session,
            Self::Notice(packet) => packet.session,
            Self::Preview(packet) => packet.session,
            Self::Shown(packet) => packet.session,
        }
    }

    /// The packet's place among those of its kind (of an observation: of its camera) in its session; of a preview: the
    /// place of the observation of its picture; of a part of a picture that is shown: the picture's.
    #[must_use]
    pub const fn sequence(&self) -> u32 {
        match self {
            Self::Observation(packet) => packet.sequence,
            Self::Motion(packet) => packet.sequence,
            Self::ArmState(packet) => packet.sequence,
            Self::Buttons(packet) => packet.sequence,
            Self::Command(packet) => packet.sequence,
            Self::Notice(packet) => packet.sequence,
            Self::Preview(packet) => packet.sequence,
            Self::Shown(packet) => packet.picture,
        }
    }
}
