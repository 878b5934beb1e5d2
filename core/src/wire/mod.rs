//! What crosses a cable: versioned packets and their incremental decoder.
//!
//! | layer | file | bytes |
//! |---|---|---|
//! | packet | [`packet`] | what one camera saw, how the hand moved |
//! | | [`buttons`], [`arm_state`] | the operator's buttons; where the arm is, and why |
//! | | [`command`] | what a smart camera is told, and what it answers |
//! | | [`preview`] | what a smart camera shows of its balls |
//! | | [`shown`] | pictures for a camera without a sensor |
//! | body | [`body`] | version, kind, then the packet's fields in postcard's encoding |
//! | frame | [`frame`] | COBS(body, CRC-16), then a zero byte |
//! | decoder | [`decoder`] | frames out of a stream that is split, joined or damaged anywhere |
//!
//! A carrier that keeps datagrams whole and unharmed (QUIC, UDP) takes bodies; a serial line or
//! anything else that is only a stream of bytes takes frames. Every length is bounded at compile
//! time. The byte tables and the rule for raising [`VERSION`] are in docs/wire.md; tests pin them.
//!
//! Nothing here panics: what cannot be written or read is refused by a value with a reason.

pub mod arm_state;
pub mod body;
pub mod buttons;
pub mod command;
pub mod decoder;
pub mod frame;
pub mod packet;
pub mod preview;
pub mod shown;

pub use arm_state::{
    ArmReason, ArmState, ArmStatePacket, ArmVerdict, CommandEcho, ControllerState, MeasuredJoints, Settled,
};
pub use body::{MAX_BODY_LEN, VERSION, decode_body, encode_body};
pub use buttons::{ButtonsPacket, PressFor, ScaleShare};
pub use command::{BadPicture, Command, CommandPacket, NotTaught, Notice, NoticePacket};
pub use decoder::{Decoder, Feed};
pub use frame::{MAX_FRAME_LEN, encode};
pub use packet::{Covariance, MotionPacket, ObservationPacket, Packet, Transform};
pub use preview::PreviewPacket;
pub use shown::{STRIP_BYTES, Shown, ShownPacket, Strip};

#[cfg(test)]
mod tests;

/// What no packet may hold, sent or received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BadValue {
    /// A number is infinite or not a number.
    NotFinite,
    /// Nine numbers that should be a proper rotation are none.
    NotARotation,
    /// Numbers that should be a covariance are none: a variance is negative, or two numbers vary
    /// together more than each does alone.
    NotACovariance,
    /// A share is not between 0 and 1.
    NotAShare,
    /// Rows of pixels are no part of a thumbnail.
    NotAStrip,
}

impl core::fmt::Display for BadValue {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotFinite => "the packet holds a number that is not finite",
            Self::NotARotation => "the packet holds a rotation that is none",
            Self::NotACovariance => "the packet holds a covariance that is none",
            Self::NotAShare => {
                "the packet holds a share that is not one: between 0 and 1, or 1 to 100 percent"
            }
            Self::NotAStrip => "the packet holds rows of pixels that are no part of a thumbnail",
        })
    }
}

impl core::error::Error for BadValue {}

/// Why a packet was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncodeError {
    /// The slice is too short; [`MAX_BODY_LEN`] or [`MAX_FRAME_LEN`] bytes are always enough.
    BufferTooSmall,
    /// The packet may not be sent.
    Value(BadValue),
}

impl core::fmt::Display for EncodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::BufferTooSmall => f.write_str("the buffer is too short for the packet"),
            Self::Value(bad) => bad.fmt(f),
        }
    }
}

impl core::error::Error for EncodeError {}

/// Why received bytes are no packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DecodeError {
    /// The frame ended inside a COBS block: bytes were lost.
    BadFraming,
    /// More bytes came without a zero byte than the decoder has room for.
    Overlong,
    /// Fewer bytes than a version, a kind and a check take.
    TooShort,
    /// The check does not match: bytes were changed or lost.
    BadCrc,
    /// The sender speaks another version of the format; one of the two must be updated.
    UnknownVersion(u8),
    /// A kind of packet this receiver does not know.
    UnknownKind(u8),
    /// The fields do not follow the format.
    MalformedBody,
    /// Bytes are left over behind the last field.
    TrailingBytes,
    /// The packet was understood but may not be used.
    Value(BadValue),
}

impl core::fmt::Display for DecodeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::BadFraming => f.write_str("the frame ends inside a block: bytes were lost"),
            Self::Overlong => f.write_str("the frame is longer than any packet"),
            Self::TooShort => f.write_str("the frame is too short for a packet"),
            Self::BadCrc => f.write_str("the check does not match: bytes were changed or lost"),
            Self::UnknownVersion(version) => write!(
                f,
                "the sender speaks version {version} of the wire format, this receiver version {VERSION}: update the older one"
            ),
            Self::UnknownKind(kind) => write!(f, "packets of kind {kind} are not known here"),
            Self::MalformedBody => f.write_str("the packet's fields do not follow the wire format"),
            Self::TrailingBytes => f.write_str("bytes are left over behind the packet's last field"),
            Self::Value(bad) => bad.fmt(f),
        }
    }
}

impl core::error::Error for DecodeError {}
