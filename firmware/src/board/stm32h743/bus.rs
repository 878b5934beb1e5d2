//! Packets on the CAN bus: the bytes of the line, cut into payloads of CAN FD.

use crate::can_fd::Payload;
use core::convert::Infallible;
use embassy_stm32::can::config::TxBufferMode;
use embassy_stm32::can::frame::{FdFrame, Header};
use embassy_stm32::can::{CanConfigurator, CanTx};
use embedded_can::StandardId;

/// Bits a second: of a frame's head, and of its payload.
const HEAD: u32 = 500_000;
const PAYLOAD: u32 = 2_000_000;

/// The first camera's identifier; the others follow. CANopen leaves it free.
const FIRST: u16 = 0x680;

/// The bus, to send.
pub struct Bus {
    sender: CanTx<'static>,
    identifier: StandardId,
}

impl Bus {
    pub(super) fn new(mut settings: CanConfigurator<'static>, camera: u8) -> Self {
        settings.set_bitrate(HEAD);
        settings.set_fd_data_bitrate(PAYLOAD, true);
        // all frames have one identifier: by priority they would overtake each other
        let mut order = settings.config();
        order.tx_buffer_mode = TxBufferMode::Fifo;
        settings.set_config(order);
        let (sender, _, _) = settings.into_normal_mode().split();
        let identifier = StandardId::new(FIRST + u16::from(camera)).unwrap_or(StandardId::MAX);
        Self { sender, identifier }
    }
}

impl embedded_io_async::ErrorType for Bus {
    type Error = Infallible;
}

impl embedded_io_async::Write for Bus {
    /// Waits for room, for ever where nobody is on the bus.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        let (payload, taken) = Payload::of(bytes);
        let bytes = payload.bytes();
        // (there is no payload longer than 64 bytes)
        let length = u8::try_from(bytes.len()).unwrap_or(0);
        let head = Header::new_fd(self.identifier.into(), length, false, true);
        if let Ok(frame) = FdFrame::new(head, bytes) {
            self.sender.write_fd(&frame).await;
        }
        Ok(taken)
    }

    async fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}
