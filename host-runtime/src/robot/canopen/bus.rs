//! A CAN bus, whatever it hangs on. None of these gives back the frames that it sent itself: a frame
//! that comes in was sent by somebody else.

mod memory;

mod slcan;

#[cfg(target_os = "linux")]
mod socket;

pub use memory::in_memory;
pub use slcan::open as open_slcan;
#[cfg(target_os = "linux")]
pub use socket::open as open_socket;

use std::io;
use std::time::Duration;
use tetrad_core::arm::canopen::Frame;

/// The half that sends.
pub trait Transmit: Send {
    /// Hands the frames over in their order; how many were taken. Those that were not are lost: the
    /// next cycle has newer ones.
    ///
    /// # Errors
    /// What makes the bus unusable: an adapter that was pulled, an interface that went down. That the
    /// bus takes no more frames now is none.
    fn send(&mut self, frames: &[Frame]) -> io::Result<usize>;
}

/// The half that receives.
pub trait Receive: Send {
    /// The next frame, waiting at most about `within` whatever else comes; `None` when no frame came.
    ///
    /// # Errors
    /// What makes the bus unusable.
    fn receive(&mut self, within: Duration) -> io::Result<Option<Frame>>;

    /// How many bytes came so far that belong to no frame: of a serial line at the wrong speed, for one.
    fn garbage(&self) -> u64 {
        0
    }
}

/// Both halves.
pub struct Bus {
    /// Sends.
    pub transmit: Box<dyn Transmit>,
    /// Receives.
    pub receive: Box<dyn Receive>,
}
