//! What stands for the CAN bus, which these boards have not: UART 1, which sends as fast as it is told.
//!
//! QEMU takes a byte at once, so that nobody has to be woken when there is room for the next.

use super::Register;
use core::convert::Infallible;

const BASE: usize = 0x4000_5000;
const DATA: Register = Register(BASE);
const STATE: Register = Register(BASE + 4);
const CONTROL: Register = Register(BASE + 8);
const DIVIDER: Register = Register(BASE + 16);

/// State bit.
const TRANSMIT_FULL: u32 = 1;

/// Control bit: transmit, without interrupts.
const TRANSMIT: u32 = 1;

/// The least divider: the fastest line. QEMU minds it no further.
const FASTEST: u32 = 16;

/// The line's sending half.
pub struct Sender(());

impl Sender {
    /// Starts the line.
    #[must_use]
    pub fn start() -> Self {
        DIVIDER.write(FASTEST);
        CONTROL.write(TRANSMIT);
        Self(())
    }
}

impl embedded_io_async::ErrorType for Sender {
    type Error = Infallible;
}

impl embedded_io_async::Write for Sender {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for byte in bytes {
            while STATE.read() & TRANSMIT_FULL != 0 {}
            DATA.write(u32::from(*byte));
        }
        Ok(bytes.len())
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        while STATE.read() & TRANSMIT_FULL != 0 {}
        Ok(())
    }
}
