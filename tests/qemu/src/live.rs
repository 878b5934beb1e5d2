//! A board whose serial line somebody is at, while it runs.

use crate::board::Target;
use crate::tape::Tape;
use std::io::{self, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::process::Child;
use std::time::{Duration, Instant};
use std::{fs, thread};
use tempfile::TempDir;

/// One instruction counts as 2^6 ns; a board that waits, waits: somebody is at its line.
const WAITING: &str = "shift=6,sleep=on";

/// The longest that anything is waited for.
const LIMIT: Duration = Duration::from_secs(120);

/// How long a read waits before it looks whether the board still runs.
const PATIENCE: Duration = Duration::from_millis(20);

/// QEMU, ended when this is dropped.
#[derive(Debug)]
struct Machine {
    child: Child,
    folder: TempDir,
}

impl Machine {
    fn start(target: Target, tape: &Tape, serial: &str) -> io::Result<Self> {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("tetrad.tape"), tape.live_bytes())?;
        Self::run(target, "mps2-camera", folder, serial)
    }

    fn run(target: Target, program: &str, folder: TempDir, serial: &str) -> io::Result<Self> {
        let child = target.qemu(program, folder.path(), WAITING, serial)?.spawn()?;
        Ok(Self { child, folder })
    }

    fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join("said")).unwrap_or_default()
    }

    /// A smart camera at a live line never ends by itself: a panic or a fault has ended it.
    fn check(&mut self) -> io::Result<()> {
        match self.child.try_wait()? {
            None => Ok(()),
            Some(status) => Err(io::Error::other(format!("the board ended: {status}\n{}", self.said()))),
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        // it may have ended
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A smart camera, and the other end of its line.
#[derive(Debug)]
pub struct Live {
    machine: Machine,
    line: UnixStream,
    received: Vec<u8>,
}

impl Live {
    /// A camera whose sensor shows this tape's pictures as they are asked for.
    ///
    /// # Errors
    /// There is no such program or no QEMU.
    pub fn start(target: Target, tape: &Tape) -> io::Result<Self> {
        let mut machine = Machine::start(target, tape, "unix:line,server=on,wait=on")?;
        let path = machine.folder.path().join("line");
        let started = Instant::now();
        let line = loop {
            match UnixStream::connect(&path) {
                Ok(line) => break line,
                Err(error) if started.elapsed() > LIMIT => return Err(error),
                Err(_) => {
                    machine.check()?;
                    thread::sleep(Duration::from_millis(5));
                }
            }
        };
        line.set_read_timeout(Some(PATIENCE))?;
        Ok(Self { machine, line, received: Vec::new() })
    }

    /// Puts bytes on the line.
    ///
    /// # Errors
    /// The line was closed.
    pub fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.line.write_all(bytes)
    }

    /// All that came so far, once `enough` says so.
    ///
    /// # Errors
    /// It never does, or the board has ended.
    pub fn until(&mut self, enough: impl Fn(&[u8]) -> bool) -> io::Result<&[u8]> {
        let started = Instant::now();
        while !enough(&self.received) {
            self.take()?;
            if started.elapsed() > LIMIT {
                let came = self.received.len();
                return Err(io::Error::other(format!(
                    "{came} bytes came, and no more: {}",
                    self.machine.said()
                )));
            }
        }
        Ok(&self.received)
    }

    /// All that came so far, once nothing has come for `quiet`.
    ///
    /// # Errors
    /// The board has ended.
    pub fn when_quiet(&mut self, quiet: Duration) -> io::Result<&[u8]> {
        let mut since = Instant::now();
        while since.elapsed() < quiet {
            if self.take()? > 0 {
                since = Instant::now();
            }
        }
        Ok(&self.received)
    }

    /// Reads what there is, or waits a little for it.
    fn take(&mut self) -> io::Result<usize> {
        self.machine.check()?;
        let mut bytes = [0; 4096];
        match self.line.read(&mut bytes) {
            Ok(count) => {
                self.received.extend(&bytes[..count]);
                Ok(count)
            }
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                Ok(0)
            }
            Err(error) => Err(error),
        }
    }
}

/// A smart camera on a pseudo terminal, for a program that opens devices.
#[derive(Debug)]
pub struct Plugged {
    machine: Machine,
    device: PathBuf,
}

impl Plugged {
    /// A camera whose sensor shows this tape's pictures as they are asked for.
    ///
    /// # Errors
    /// There is no such program or no QEMU.
    pub fn start(target: Target, tape: &Tape) -> io::Result<Self> {
        Self::of(Machine::start(target, tape, "pty")?)
    }

    /// A camera that is shown its pictures over its line.
    ///
    /// # Errors
    /// As [`Plugged::start`].
    pub fn streamed(target: Target) -> io::Result<Self> {
        Self::of(Machine::run(target, "mps2-streamed", tempfile::tempdir()?, "pty")?)
    }

    fn of(mut machine: Machine) -> io::Result<Self> {
        let started = Instant::now();
        loop {
            if let Some(device) = device(&machine.said()) {
                return Ok(Self { machine, device });
            }
            machine.check()?;
            if started.elapsed() > LIMIT {
                return Err(io::Error::other(format!("no device is named: {}", machine.said())));
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// The device.
    #[must_use]
    pub fn device(&self) -> &Path {
        &self.device
    }

    /// That it still runs.
    ///
    /// # Errors
    /// A panic or a fault has ended it, with what it said.
    pub fn check(&mut self) -> io::Result<()> {
        self.machine.check()
    }
}

/// `char device redirected to /dev/pts/3 (label serial0)`
fn device(said: &str) -> Option<PathBuf> {
    let (_, behind) = said.split_once("redirected to ")?;
    behind.split_once(" (label").map(|(device, _)| device.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_is_what_qemu_names_once_the_line_is_whole() {
        let said = "char device redirected to /dev/pts/3 (label serial0)\n";
        assert_eq!(device(said), Some("/dev/pts/3".into()));
        assert_eq!(device(&said[..34]), None);
    }
}
