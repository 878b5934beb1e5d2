//! Frames: a body and its check, stuffed so that the zero byte stands only at the end.
//!
//! COBS (Cheshire and Baker 1999) because a receiver that joins late, or lost bytes, is right again
//! at the next zero; CRC-16/IBM-3740 because it finds every error of up to 16 bits in a row, and
//! every two changed bits, in anything as short as these packets. Both are written straight into
//! the caller's slice: postcard's own COBS and CRC flavours index it, which can panic.

use super::EncodeError;
use super::body::{MAX_BODY_LEN, write_body};
use super::packet::Packet;
use crc::{CRC_16_IBM_3740, Crc, Digest, Table};
use postcard::ser_flavors::Flavor;

/// The check over the body, sent low byte first.
pub(super) static CHECK: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// Bytes of the check.
pub(super) const CHECK_LEN: usize = 2;

/// What ends a frame, and stands nowhere in it.
pub(super) const DELIMITER: u8 = 0;

/// The code of a COBS block of 254 bytes after which no zero follows.
pub(super) const FULL_BLOCK: u8 = 0xFF;

/// The most bytes any frame takes, its zero byte included: COBS adds one for every 254 begun.
pub const MAX_FRAME_LEN: usize = {
    let content = MAX_BODY_LEN + CHECK_LEN;
    content + content / 254 + 1 + 1
};

/// Writes a packet as one frame to the start of `out` and returns its length in bytes, the zero
/// byte that ends it included.
///
/// # Errors
/// [`EncodeError`]; what `out` then holds is of no use.
pub fn encode(packet: &Packet, out: &mut [u8]) -> Result<usize, EncodeError> {
    write_body(packet, Framer::new(out))
}

/// A postcard sink that checks and stuffs as it writes.
pub(super) struct Framer<'a> {
    out: &'a mut [u8],
    /// Where the current block's code will stand.
    code_at: usize,
    /// Where the next byte goes.
    at: usize,
    /// One more than the bytes in the current block.
    code: u8,
    check: Digest<'static, u16, Table<1>>,
}

impl<'a> Framer<'a> {
    pub(super) fn new(out: &'a mut [u8]) -> Self {
        Self { out, code_at: 0, at: 1, code: 1, check: CHECK.digest() }
    }

    fn write(&mut self, at: usize, byte: u8) -> postcard::Result<()> {
        *self.out.get_mut(at).ok_or(postcard::Error::SerializeBufferFull)? = byte;
        Ok(())
    }

    fn stuff(&mut self, byte: u8) -> postcard::Result<()> {
        if byte != DELIMITER {
            self.write(self.at, byte)?;
            self.at += 1;
            self.code += 1;
        }
        if byte == DELIMITER || self.code == FULL_BLOCK {
            self.write(self.code_at, self.code)?;
            self.code_at = self.at;
            self.at += 1;
            self.code = 1;
        }
        Ok(())
    }
}

impl Flavor for Framer<'_> {
    type Output = usize;

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        self.check.update(&[byte]);
        self.stuff(byte)
    }

    fn finalize(mut self) -> postcard::Result<usize> {
        for byte in self.check.clone().finalize().to_le_bytes() {
            self.stuff(byte)?;
        }
        self.write(self.code_at, self.code)?;
        self.write(self.at, DELIMITER)?;
        Ok(self.at + 1)
    }
}
