//! Packets out of a stream of bytes that comes in pieces of any size and may be damaged anywhere.

use super::body::decode_body;
use super::frame::{CHECK, DELIMITER, FULL_BLOCK};
use super::{DecodeError, Packet};

/// Room for a frame's content. Larger than any packet of this version, so that a longer one of a
/// later version is refused as such and not as overlong.
pub const ROOM: usize = 256;

/// What feeding a piece of the stream came to.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "short-lived, and there is no heap to box a packet on")]
#[must_use = "a packet may have been received, and bytes may be left to feed"]
pub enum Feed<'a> {
    /// The piece is used up; no frame has ended in it.
    Consumed,
    /// A frame has ended.
    Frame {
        /// The packet, or why there is none. The decoder goes on behind it either way.
        result: Result<Packet, DecodeError>,
        /// The bytes behind the frame: feed them next.
        rest: &'a [u8],
    },
}

/// An incremental decoder with room for a frame of N bytes (body and check).
///
/// It may be started anywhere: what comes before the first zero byte is at worst one refused
/// frame. Zero bytes between frames are idle and report nothing.
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize = ROOM> {
    content: heapless::Vec<u8, N>,
    /// Bytes that the current COBS block still has.
    block_left: u8,
    /// A zero belongs between the current block and the next.
    zero_due: bool,
    overlong: bool,
}

impl Decoder {
    /// A decoder that has seen nothing, with room for any packet.
    #[must_use]
    pub const fn new() -> Self {
        Self::with_room()
    }
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::with_room()
    }
}

impl<const N: usize> Decoder<N> {
    /// A decoder that has seen nothing, with room for N bytes of body and check.
    #[must_use]
    pub const fn with_room() -> Self {
        Self { content: heapless::Vec::new(), block_left: 0, zero_due: false, overlong: false }
    }

    /// Takes bytes up to the end of the first frame in `chunk`.
    pub fn feed<'a>(&mut self, chunk: &'a [u8]) -> Feed<'a> {
        let mut bytes = chunk.iter();
        while let Some(byte) = bytes.next() {
            if let Some(result) = self.push(*byte) {
                return Feed::Frame { result, rest: bytes.as_slice() };
            }
        }
        Feed::Consumed
    }

    /// Every packet or refusal whose frame ends in `chunk`, in order. What is not taken from the
    /// iterator is not fed.
    pub fn packets<'a>(
        &'a mut self,
        chunk: &'a [u8],
    ) -> impl Iterator<Item = Result<Packet, DecodeError>> + 'a {
        let mut rest = chunk;
        core::iter::from_fn(move || match self.feed(rest) {
            Feed::Frame { result, rest: behind } => {
                rest = behind;
                Some(result)
            }
            Feed::Consumed => {
                rest = &[];
                None
            }
        })
    }

    fn push(&mut self, byte: u8) -> Option<Result<Packet, DecodeError>> {
        if byte == DELIMITER {
            let result = self.finish();
            *self = Self::with_room();
            return result;
        }
        if self.block_left > 0 {
            self.store(byte);
            self.block_left -= 1;
        } else {
            if self.zero_due {
                self.store(0);
            }
            self.block_left = byte - 1;
            self.zero_due = byte != FULL_BLOCK;
        }
        None
    }

    fn store(&mut self, byte: u8) {
        self.overlong |= self.content.push(byte).is_err();
    }

    /// What the frame that has just ended holds; None when there was none.
    fn finish(&self) -> Option<Result<Packet, DecodeError>> {
        let begun = self.zero_due || self.block_left > 0 || !self.content.is_empty();
        begun.then(|| {
            if self.overlong {
                return Err(DecodeError::Overlong);
            }
            if self.block_left > 0 {
                return Err(DecodeError::BadFraming);
            }
            let (body, check) = self.content.split_last_chunk().ok_or(DecodeError::TooShort)?;
            if CHECK.checksum(body) != u16::from_le_bytes(*check) {
                return Err(DecodeError::BadCrc);
            }
            decode_body(body)
        })
    }
}
