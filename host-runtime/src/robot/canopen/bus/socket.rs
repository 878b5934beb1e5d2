//! A CAN interface of the Linux kernel.

use super::{Bus, Receive, Transmit};
use socketcan::{
    CanFrame, CanSocket, EmbeddedFrame as _, Frame as _, Socket as _, SocketOptions as _, StandardId,
};
use std::io;
use std::sync::Arc;
use std::time::Duration;
use tetrad_core::arm::canopen::Frame;

/// CAN_ERR_BUSOFF of linux/can/error.h: the controller has left the bus.
const BUS_OFF: u32 = 0x40;

struct Out(Arc<CanSocket>);

struct In(Arc<CanSocket>);

/// Opens the interface, which must be up: `ip link set can0 up type can bitrate 1000000`.
///
/// # Errors
/// No such interface, or one that is down.
pub fn open(interface: &str) -> io::Result<Bus> {
    let socket = CanSocket::open(interface)?;
    // a full queue is dealt with, not waited for; reading waits by poll
    socket.set_nonblocking(true)?;
    // frames of other sockets on this machine are heard, own ones are not: a second master shows
    socket.set_recv_own_msgs(false)?;
    socket.set_error_filter(BUS_OFF)?;
    let socket = Arc::new(socket);
    Ok(Bus { transmit: Box::new(Out(Arc::clone(&socket))), receive: Box::new(In(socket)) })
}

impl Transmit for Out {
    fn send(&mut self, frames: &[Frame]) -> io::Result<usize> {
        for (sent, frame) in frames.iter().enumerate() {
            let id = StandardId::new(frame.id()).ok_or(io::ErrorKind::InvalidData)?;
            let raw = CanFrame::new(id, frame.data()).ok_or(io::ErrorKind::InvalidData)?;
            match self.0.write_frame(&raw) {
                Ok(()) => {}
                // a bus on which nobody acknowledges fills the queue
                Err(error)
                    if error.kind() == io::ErrorKind::WouldBlock
                        || error.raw_os_error() == Some(libc::ENOBUFS) =>
                {
                    return Ok(sent);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(frames.len())
    }
}

impl Receive for In {
    fn receive(&mut self, within: Duration) -> io::Result<Option<Frame>> {
        match self.0.read_frame_timeout(within) {
            Ok(CanFrame::Data(frame)) if !frame.is_extended() => {
                Ok(Frame::new(frame.raw_id() as u16, frame.data()))
            }
            Ok(CanFrame::Error(_)) => Err(io::Error::new(
                io::ErrorKind::NetworkDown,
                "the CAN controller left the bus (bus-off); check terminators, wiring and bit rate",
            )),
            Ok(_) => Ok(None),
            Err(error) if is_passing(error.kind()) => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// Whether reading may go on: nothing came, or a signal to this program came before any frame.
const fn is_passing(kind: io::ErrorKind) -> bool {
    matches!(kind, io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_does_not_make_the_bus_unusable() {
        assert!(is_passing(io::ErrorKind::Interrupted) && is_passing(io::ErrorKind::TimedOut));
        assert!(!is_passing(io::ErrorKind::NetworkDown));
    }
}
