//! A CAN bus, and a serial line that stands for one.

use embedded_io_async::Write;
use tetrad_core::arm::canopen::{Frame, slcan};

/// The half of a CAN bus that sends.
#[allow(async_fn_in_trait, reason = "tasks of one executor: nobody asks whether the future is Send")]
pub trait Can {
    /// Hands a frame over. One that the bus does not take is lost: the next cycle has a newer one, and the
    /// drives stop by themselves where none comes.
    async fn send(&mut self, frame: &Frame);
}

/// An adapter at a serial line that speaks the Lawicel protocol.
pub struct Slcan<W>(pub W);

impl<W: Write> Can for Slcan<W> {
    async fn send(&mut self, frame: &Frame) {
        // a line that fails is a bus that is cut
        let _ = self.0.write_all(&slcan::encode(frame)).await;
    }
}
