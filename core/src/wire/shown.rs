//! Pictures that a camera is shown over its serial line, in place of its sensor's.
//!
//! A sender begins, and the camera forgets all that it was taught: so one that has run for days gives the bytes of
//! one that was switched on just now. A picture comes in strips, in order, and is looked at once it is named whole.
//! What comes of it is the camera's own answer, an observation or a notice.

use super::packet::{BYTE, MAX_U16, MAX_U32, MAX_U64};
use crate::vision::frame::PixelFormat;
use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The most bytes of a picture that one packet carries.
pub const STRIP_BYTES: usize = 192;

/// Some bytes of a picture, in the order of its buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Strip {
    /// Zero behind those that count.
    bytes: [u8; STRIP_BYTES],
    length: u8,
}

impl Strip {
    /// These bytes; `None` when they are more than [`STRIP_BYTES`].
    #[must_use]
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let length = u8::try_from(bytes.len()).ok()?;
        let mut strip = Self { bytes: [0; STRIP_BYTES], length };
        let room = strip.bytes.get_mut(..bytes.len())?;
        for (place, byte) in room.iter_mut().zip(bytes) {
            *place = *byte;
        }
        Some(strip)
    }

    /// The bytes.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..usize::from(self.length)).unwrap_or_default()
    }
}

impl Serialize for Strip {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(self.bytes())
    }
}

impl<'de> Deserialize<'de> for Strip {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_bytes(Bytes)
    }
}

struct Bytes;

impl Visitor<'_> for Bytes {
    type Value = Strip;

    fn expecting(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("bytes of a picture")
    }

    fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Strip, E> {
        Strip::of(bytes).ok_or_else(|| E::custom("more than a strip has room for"))
    }
}

/// What a camera is shown.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Shown {
    /// A sender begins: the camera is as if just switched on, with the packet's session for its own.
    Begin {
        /// Whether balls are tracked by the finer methods; else by the paper's.
        refined: bool,
    },
    /// Bytes of the picture.
    Strip {
        /// How many bytes of the picture are before these.
        offset: u32,
        /// They.
        strip: Strip,
    },
    /// That was the whole picture: look at it now.
    Look {
        /// When it was taken, microseconds.
        capture_us: u64,
        /// How many bytes it has.
        length: u32,
        /// Pixels.
        width: u16,
        /// Pixels.
        height: u16,
        /// How pixels lie in it.
        format: PixelFormat,
    },
}

/// Shown to a camera that has no pictures of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShownPacket {
    /// Chosen anew each time a sender begins.
    pub session: u32,
    /// Counts the pictures from 0, and wraps: all strips of one, and the look at it, have its number. One that is
    /// shown again is another one.
    pub picture: u32,
    /// What is shown.
    pub shown: Shown,
}

impl ShownPacket {
    /// The most bytes the fields take: a full strip's.
    pub const MAX_LEN: usize = 2 * MAX_U32 + BYTE + longer(MAX_U32 + STRIP_LEN, LOOK_LEN);
}

/// A strip, and how long it is.
const STRIP_LEN: usize = 2 + STRIP_BYTES;

const LOOK_LEN: usize = MAX_U64 + MAX_U32 + 2 * MAX_U16 + BYTE;

const fn longer(a: usize, b: usize) -> usize {
    if a > b { a } else { b }
}
