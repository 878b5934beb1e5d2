//! A packet's body: version, kind, and the fields in postcard's encoding.

use super::packet::{MotionPacket, ObservationPacket, Packet};
use super::{
    ArmStatePacket, ButtonsPacket, CommandPacket, DecodeError, EncodeError, NoticePacket, PreviewPacket,
    ShownPacket,
};
use postcard::ser_flavors::{Flavor, Slice};
use serde::de::DeserializeOwned;

/// The version of every packet's layout. docs/wire.md says when it is raised.
pub const VERSION: u8 = 5;

/// The kinds' numbers; a number once used is never given to another kind.
pub(super) const OBSERVATION: u8 = 1;
pub(super) const MOTION: u8 = 2;
pub(super) const ARM_STATE: u8 = 3;
pub(super) const BUTTONS: u8 = 4;
pub(super) const COMMAND: u8 = 5;
pub(super) const NOTICE: u8 = 6;
pub(super) const PREVIEW: u8 = 7;
pub(super) const SHOWN: u8 = 8;

const HEADER_LEN: usize = 2;

/// The most bytes any body takes.
pub const MAX_BODY_LEN: usize = HEADER_LEN
    + longer(
        longer(ObservationPacket::MAX_LEN, MotionPacket::MAX_LEN),
        longer(
            longer(ArmStatePacket::MAX_LEN, ButtonsPacket::MAX_LEN),
            longer(
                longer(CommandPacket::MAX_LEN, NoticePacket::MAX_LEN),
                longer(PreviewPacket::MAX_LEN, ShownPacket::MAX_LEN),
            ),
        ),
    );

const fn longer(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}

/// Writes a packet's body to the start of `out` and returns its length in bytes. For carriers that
/// keep datagrams whole; over a stream use [`super::encode`].
///
/// # Errors
/// [`EncodeError`].
pub fn encode_body(packet: &Packet, out: &mut [u8]) -> Result<usize, EncodeError> {
    // Slice writes through checked pointers; its indexing, which can panic, is not used here
    write_body(packet, Slice::new(out)).map(|written| written.len())
}

/// Reads a packet from a whole body.
///
/// # Errors
/// [`DecodeError`], but none of those about frames.
pub fn decode_body(body: &[u8]) -> Result<Packet, DecodeError> {
    let [version, kind, fields @ ..] = body else {
        return Err(DecodeError::TooShort);
    };
    if *version != VERSION {
        return Err(DecodeError::UnknownVersion(*version));
    }
    match *kind {
        OBSERVATION => {
            // another sender may leave a lost ball's old place in: here it has none
            let packet = read_fields::<ObservationPacket>(fields)?.tidied();
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        MOTION => {
            let packet: MotionPacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        ARM_STATE => {
            let packet: ArmStatePacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        BUTTONS => {
            let packet: ButtonsPacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        COMMAND => {
            let packet: CommandPacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        NOTICE => {
            let packet: NoticePacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        PREVIEW => {
            let packet: PreviewPacket = read_fields(fields)?;
            packet.check().map_err(DecodeError::Value)?;
            Ok(packet.into())
        }
        SHOWN => Ok(read_fields::<ShownPacket>(fields)?.into()),
        unknown => Err(DecodeError::UnknownKind(unknown)),
    }
}

/// Writes a checked packet's body to any sink.
pub(super) fn write_body<F: Flavor>(packet: &Packet, sink: F) -> Result<F::Output, EncodeError> {
    let written = match packet {
        Packet::Observation(packet) => {
            let packet = packet.tidied();
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, OBSERVATION, packet), sink)
        }
        Packet::Motion(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, MOTION, packet), sink)
        }
        Packet::ArmState(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, ARM_STATE, packet), sink)
        }
        Packet::Buttons(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, BUTTONS, packet), sink)
        }
        Packet::Command(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, COMMAND, packet), sink)
        }
        Packet::Notice(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, NOTICE, packet), sink)
        }
        Packet::Preview(packet) => {
            packet.check().map_err(EncodeError::Value)?;
            postcard::serialize_with_flavor(&(VERSION, PREVIEW, packet), sink)
        }
        Packet::Shown(packet) => postcard::serialize_with_flavor(&(VERSION, SHOWN, packet), sink),
    };
    // no packet holds anything that postcard cannot write, so only room can be wanting
    written.map_err(|_| EncodeError::BufferTooSmall)
}

fn read_fields<P: DeserializeOwned>(fields: &[u8]) -> Result<P, DecodeError> {
    match postcard::take_from_bytes(fields) {
        Ok((packet, [])) => Ok(packet),
        Ok(_) => Err(DecodeError::TrailingBytes),
        Err(_) => Err(DecodeError::MalformedBody),
    }
}
