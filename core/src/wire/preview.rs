//! What a smart camera shows of its balls: thumbnails of the windows around them, in strips.
//!
//! A strip is short enough for a slow line to have room for it beside the observations; three of them are a
//! thumbnail, and all of one picture.

use super::BadValue;
use super::packet::{BYTE, MAX_U16, MAX_U32};
use crate::observation::Ball;
use core::fmt;
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::ser::SerializeTuple as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A part of a thumbnail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PreviewPacket {
    /// The camera's place in the list of views.
    pub camera: u8,
    /// The camera's session: that of its observations.
    pub session: u32,
    /// The number of the observation of the picture that the thumbnail was taken from.
    pub sequence: u32,
    /// The ball in its middle.
    pub ball: Ball,
    /// The first column of the picture that the thumbnail shows, px.
    pub left: u16,
    /// The first row of the picture that it shows, px.
    pub top: u16,
    /// It shows one pixel of so many by so many: the one in the middle of them, px.
    pub step: u8,
    /// The strip's first row in the thumbnail.
    pub row: u8,
    /// Its pixels, RGB565, high byte first.
    #[serde(with = "bytes_of")]
    pub pixels: Strip,
}

/// Rows of a thumbnail.
pub type Strip = [[u8; PreviewPacket::ROW_BYTES]; PreviewPacket::STRIP_ROWS];

impl PreviewPacket {
    /// Pixels of a thumbnail.
    pub const WIDTH: u16 = 16;
    /// Pixels of a thumbnail.
    pub const HEIGHT: u16 = 18;
    /// Strips of a thumbnail.
    pub const STRIPS: usize = 3;
    /// Rows of a strip.
    pub const STRIP_ROWS: usize = Self::HEIGHT as usize / Self::STRIPS;
    /// Two bytes a pixel.
    pub const ROW_BYTES: usize = 2 * Self::WIDTH as usize;

    /// The most bytes the fields take.
    pub const MAX_LEN: usize =
        BYTE + 2 * MAX_U32 + BYTE + 2 * MAX_U16 + 2 * BYTE + Self::STRIP_ROWS * Self::ROW_BYTES;

    /// Which of the thumbnail's strips this is, from 0.
    #[must_use]
    pub const fn strip(&self) -> usize {
        self.row as usize / Self::STRIP_ROWS
    }

    pub(super) fn check(&self) -> Result<(), BadValue> {
        let begins = usize::from(self.row).is_multiple_of(Self::STRIP_ROWS) && self.strip() < Self::STRIPS;
        if begins && self.step > 0 { Ok(()) } else { Err(BadValue::NotAStrip) }
    }
}

/// A strip as its bytes, one after the other. What is derived for an array has code of its own for each element, and
/// takes 0.8 KiB more of a microcontroller's flash.
mod bytes_of {
    use super::*;

    const BYTES: usize = PreviewPacket::STRIP_ROWS * PreviewPacket::ROW_BYTES;

    pub(super) fn serialize<S: Serializer>(strip: &Strip, to: S) -> Result<S::Ok, S::Error> {
        let mut bytes = to.serialize_tuple(BYTES)?;
        strip.iter().flatten().try_for_each(|byte| bytes.serialize_element(byte))?;
        bytes.end()
    }

    pub(super) fn deserialize<'a, D: Deserializer<'a>>(from: D) -> Result<Strip, D::Error> {
        from.deserialize_tuple(BYTES, Bytes)
    }

    struct Bytes;

    impl<'a> Visitor<'a> for Bytes {
        type Value = Strip;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a strip's bytes")
        }

        fn visit_seq<A: SeqAccess<'a>>(self, mut bytes: A) -> Result<Strip, A::Error> {
            let mut strip = [[0; PreviewPacket::ROW_BYTES]; PreviewPacket::STRIP_ROWS];
            for place in strip.iter_mut().flatten() {
                *place = bytes.next_element()?.ok_or_else(|| A::Error::custom("the strip ends early"))?;
            }
            Ok(strip)
        }
    }
}
