//! A line between a board and whoever shows it pictures, that loses bytes on their way to the board, or brings others.

use crate::sender::{is_a_wait, put};
use serialport::{SerialPort as _, TTYPort};
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// How long a read waits at a time.
const PATIENCE: Duration = Duration::from_millis(20);

/// No pseudo terminal minds it.
const BAUD: u32 = 921_600;

/// What is done to the line, once, behind so many bytes.
#[derive(Clone, Debug)]
pub enum Harm {
    /// So many bytes are lost.
    Lose(usize),
    /// These come behind the next zero byte: between two frames.
    Bring(Vec<u8>),
}

/// The line.
#[derive(Debug)]
pub struct Relay {
    device: PathBuf,
    ended: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    /// It stays open: the terminal lives while no program is at it.
    _slave: TTYPort,
}

impl Relay {
    /// A line to the board at this device, harmed behind `after` bytes.
    ///
    /// # Errors
    /// The device cannot be opened, or there is no pseudo terminal.
    pub fn start(board: &Path, after: usize, harm: Harm) -> io::Result<Self> {
        let board = serialport::new(board.to_string_lossy(), BAUD).timeout(PATIENCE);
        let mut board = TTYPort::open(&board)?;
        let (mut master, slave) = TTYPort::pair()?;
        master.set_timeout(PATIENCE)?;
        let device = PathBuf::from(slave.name().ok_or(io::ErrorKind::NotFound)?);
        let (mut from_board, mut to_sender) = (board.try_clone_native()?, master.try_clone_native()?);
        let ended = Arc::new(AtomicBool::new(false));
        let [there, back] = [Arc::clone(&ended), Arc::clone(&ended)];
        let mut harmed = Harmed { left: after, harm: Some(harm), lost: 0 };
        let threads = vec![
            thread::spawn(move || {
                carry(&there, &mut master, |bytes| put(&mut board, &harmed.pass(bytes)));
            }),
            thread::spawn(move || carry(&back, &mut from_board, |bytes| put(&mut to_sender, bytes))),
        ];
        Ok(Self { device, ended, threads, _slave: slave })
    }

    /// The end for whoever shows pictures.
    #[must_use]
    pub fn device(&self) -> &Path {
        &self.device
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            // one that has panicked carries nothing, which the test sees
            let _ = thread.join();
        }
    }
}

/// Carries bytes until the end is told, or an end is gone.
fn carry(ended: &AtomicBool, from: &mut TTYPort, mut to: impl FnMut(&[u8]) -> io::Result<()>) {
    let mut bytes = [0; 1024];
    while !ended.load(Ordering::Relaxed) {
        match from.read(&mut bytes) {
            Ok(count) if count > 0 => {
                if to(bytes.get(..count).unwrap_or_default()).is_err() {
                    return;
                }
            }
            Err(error) if is_a_wait(&error) => {}
            _ => return,
        }
    }
}

/// A line on which something is done once.
struct Harmed {
    /// Bytes until then.
    left: usize,
    harm: Option<Harm>,
    /// Bytes that are still to be lost.
    lost: usize,
}

impl Harmed {
    fn pass(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut passed = Vec::new();
        for byte in bytes {
            if self.left == 0 {
                self.lost += match self.harm {
                    Some(Harm::Lose(count)) => count,
                    _ => 0,
                };
                self.harm = self.harm.take().filter(|harm| matches!(harm, Harm::Bring(_)));
            }
            if self.lost > 0 {
                self.lost -= 1;
                continue;
            }
            passed.push(*byte);
            if self.left == 0
                && *byte == 0
                && let Some(Harm::Bring(noise)) = self.harm.take()
            {
                passed.extend(noise);
            }
            self.left = self.left.saturating_sub(1);
        }
        passed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passed(left: usize, harm: Harm, pieces: &[&[u8]]) -> Vec<u8> {
        let mut harmed = Harmed { left, harm: Some(harm), lost: 0 };
        pieces.iter().flat_map(|piece| harmed.pass(piece)).collect()
    }

    #[test]
    fn a_line_is_harmed_once_and_where_it_is_to_be() {
        let pieces: [&[u8]; 3] = [&[1, 2, 0], &[3, 0, 4], &[5, 0, 6, 0]];
        assert_eq!(passed(2, Harm::Lose(3), &pieces), [1, 2, 4, 5, 0, 6, 0]);
        assert_eq!(passed(3, Harm::Bring(vec![9, 0]), &pieces), [1, 2, 0, 3, 0, 9, 0, 4, 5, 0, 6, 0]);
        assert_eq!(passed(99, Harm::Lose(1), &pieces), pieces.concat());
    }
}
