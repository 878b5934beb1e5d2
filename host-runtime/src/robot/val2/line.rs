//! The serial line: 8 data bits, no parity, one stop bit, no flow control, for one program alone.

use std::fs::{File, OpenOptions};
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::robot::serial;
use serialport::{ClearBuffer, SerialPort};

/// How long a read waits for the first byte: what a set-point may wait before it is sent.
const PATIENCE: Duration = Duration::from_millis(5);

/// An open line.
pub(super) struct Line {
    port: Box<dyn SerialPort>,
}

impl Line {
    /// Opens `device` at `baud`, locked against other programs.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn open(device: &str, baud: u32) -> Result<Self, serialport::Error> {
        Ok(Self { port: serial::open(device, baud, PATIENCE)? })
    }

    /// Drops what came while nobody listened.
    ///
    /// # Errors
    /// What the system says: the device is gone.
    pub(super) fn clear(&mut self) -> Result<(), serialport::Error> {
        self.port.clear(ClearBuffer::Input)
    }

    /// What has come, after a short wait; nothing is no error.
    ///
    /// # Errors
    /// The device is gone.
    pub(super) fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.port.read(buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => Ok(count),
            Err(error) if is_passing(error.kind()) => Ok(0),
            Err(error) => Err(error),
        }
    }

    /// Sends all of it.
    ///
    /// # Errors
    /// The device is gone, or takes nothing.
    pub(super) fn write(&mut self, text: &str) -> io::Result<()> {
        let mut rest = text.as_bytes();
        let given_up = Instant::now() + Duration::from_secs(1);
        while !rest.is_empty() {
            let written = match self.port.write(rest) {
                Ok(0) => Err(ErrorKind::TimedOut.into()),
                written => written,
            };
            match written {
                Ok(count) => rest = rest.get(count..).unwrap_or_default(),
                Err(error) if is_passing(error.kind()) && Instant::now() < given_up => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Whether it may be tried again: the line has nothing, takes nothing now, or a signal came.
const fn is_passing(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

/// What was sent and received, one line a piece: seconds, `>` sent or `<` received, the bytes.
pub(super) struct Log {
    file: File,
    began: Instant,
}

impl Log {
    /// Opens a file to add to.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().create(true).append(true).open(path)?;
        Ok(Self { file, began: Instant::now() })
    }

    /// Adds what was sent.
    ///
    /// # Errors
    /// What the system says, a full disk for one.
    pub(super) fn sent(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.add('>', bytes)
    }

    /// Adds what was received.
    ///
    /// # Errors
    /// What the system says.
    pub(super) fn received(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.add('<', bytes)
    }

    fn add(&mut self, way: char, bytes: &[u8]) -> io::Result<()> {
        let line = format!("{:12.6} {way} {}\n", self.began.elapsed().as_secs_f64(), bytes.escape_ascii());
        self.file.write_all(line.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_shows_every_byte() -> io::Result<()> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("val2.log");
        let mut log = Log::open(&path)?;
        log.sent(b"WHERE\r")?;
        log.received(b"\n.\xff\"")?;
        let text = std::fs::read_to_string(&path)?;
        let lines: Vec<&str> = text.lines().filter_map(|line| line.get(13..)).collect();
        assert_eq!(lines, [r"> WHERE\r", r#"< \n.\xff\""#]);
        Ok(())
    }
}
