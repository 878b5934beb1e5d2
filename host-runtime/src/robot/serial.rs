//! Serial lines: 8 data bits, no parity, one stop bit, no flow control, for one program alone.

use serialport::{DataBits, FlowControl, Parity, SerialPort, StopBits};
use std::time::Duration;

/// Opens the line. A read or a write waits `within` at most, and a write takes what there is room for.
///
/// # Errors
/// What the system says.
pub(super) fn open(
    path: &str,
    baud: u32,
    within: Duration,
) -> Result<Box<dyn SerialPort>, serialport::Error> {
    let line = serialport::new(path, baud)
        .data_bits(DataBits::Eight)
        .parity(Parity::None)
        .stop_bits(StopBits::One)
        .flow_control(FlowControl::None)
        .timeout(within);
    #[cfg(target_os = "linux")]
    {
        let port = line.open_native()?;
        take_what_fits(&port)?;
        Ok(Box::new(port))
    }
    #[cfg(not(target_os = "linux"))]
    line.open()
}

/// Without this a write waits for as long as it takes until the line has taken all of it, which a device
/// that has stopped reading never does.
#[cfg(target_os = "linux")]
fn take_what_fits(port: &serialport::TTYPort) -> std::io::Result<()> {
    use std::os::fd::AsRawFd as _;
    // SAFETY: the descriptor belongs to `port` and is open for as long as that lives; F_SETFL takes an int
    // and touches no memory of ours.
    let set = unsafe { libc::fcntl(port.as_raw_fd(), libc::F_SETFL, libc::O_NONBLOCK) };
    if set == -1 { Err(std::io::Error::last_os_error()) } else { Ok(()) }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use std::io::{ErrorKind, Write as _};
    use std::sync::mpsc::channel;

    #[test]
    fn a_device_that_reads_nothing_does_not_hold_a_writer() {
        let (_device, computer) = serialport::TTYPort::pair().unwrap();
        let path = computer.name().unwrap();
        drop(computer);
        let mut line = open(&path, 115_200, Duration::from_millis(20)).unwrap();
        let (done, ended) = channel();
        std::thread::spawn(move || {
            // more than any pseudo terminal keeps
            let error = line.write_all(&[b'x'; 1 << 20]).unwrap_err();
            done.send(error.kind())
        });
        let kind = ended.recv_timeout(Duration::from_secs(60)).expect("the write gave up");
        assert!(matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock), "{kind:?}");
    }
}
