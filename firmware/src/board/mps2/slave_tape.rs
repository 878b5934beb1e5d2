//! A recording of what comes to a slave, read by semihosting: what stands for the operator, the drives and the
//! clock, in runs that have to come out the same.
//!
//! A tape is a file: the 8 bytes `TETRADS1`, and then records, all numbers with their lowest byte first: 4
//! bytes kind (1 bytes of the serial line, 2 bytes of a serial line that stands for the bus, 3 a cycle), 4
//! bytes length, 8 bytes time in microseconds, and as many bytes as the length says.

use crate::slave::{Listener, SlaveInput, SlaveInputs};
use core::ffi::CStr;
use semihosting::fs::File;
use semihosting::io::{self, Read as _};

/// The file, in the folder that QEMU runs in.
pub const NAME: &CStr = c"tetrad.tape";

const MAGIC: &[u8; 8] = b"TETRADS1";
const LINE: u32 = 1;
const BUS: u32 = 2;
const CYCLE: u32 = 3;

/// Bytes taken from the tape at a time.
const CHUNK: usize = 256;

/// A tape, at its first record.
pub struct SlaveTape {
    file: File,
    listener: Listener,
}

impl SlaveTape {
    /// Opens the tape; `None` where there is none, or none of this format.
    #[must_use]
    pub fn open() -> Option<Self> {
        let mut tape = Self { file: File::open(NAME).ok()?, listener: Listener::default() };
        let magic: [u8; 8] = tape.array().ok()?;
        (magic == *MAGIC).then_some(tape)
    }

    /// Plays it to its end.
    pub async fn play(mut self, inputs: &SlaveInputs) {
        while self.record(inputs).await.is_ok() {}
        inputs.send(SlaveInput::End).await;
    }

    /// The next record.
    async fn record(&mut self, inputs: &SlaveInputs) -> io::Result<()> {
        let kind = u32::from_le_bytes(self.array()?);
        let mut left = u32::from_le_bytes(self.array()?) as usize;
        let now_us = u64::from_le_bytes(self.array()?);
        if kind == CYCLE {
            inputs.send(SlaveInput::Cycle(now_us)).await;
        }
        let mut bytes = [0; CHUNK];
        while left > 0 {
            let (piece, _) = bytes.split_at_mut(left.min(CHUNK));
            self.file.read_exact(piece)?;
            left -= piece.len();
            match kind {
                LINE => self.listener.line(piece, now_us, inputs).await,
                BUS => self.listener.bus(piece, now_us, inputs).await,
                _ => {}
            }
        }
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}
