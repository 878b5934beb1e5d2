//! Results that are written on a thread of their own: an arm's cycles do not wait for a disk.

use super::csv::OutputError;
use std::io;
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

/// A writer on a thread of its own. Where it is dropped, what waits is still written.
#[derive(Debug)]
pub struct Aside<T> {
    rows: Option<SyncSender<T>>,
    /// Rows for which there was no room.
    lost: u64,
    thread: Option<JoinHandle<Result<(), OutputError>>>,
}

impl<T: Send + 'static> Aside<T> {
    /// Starts the thread; it calls `write` for each row until one fails.
    ///
    /// # Errors
    /// The system has no thread left.
    pub fn start(
        waiting: usize,
        mut write: impl FnMut(&T) -> Result<(), OutputError> + Send + 'static,
    ) -> io::Result<Self> {
        let (rows, waits) = sync_channel(waiting);
        let work = move || waits.iter().try_for_each(|row| write(&row));
        let thread = std::thread::Builder::new().name("results".to_owned()).spawn(work)?;
        Ok(Self { rows: Some(rows), lost: 0, thread: Some(thread) })
    }

    /// Hands a row over; never waits. Where too many wait, it is lost and counted.
    ///
    /// # Errors
    /// A row before could not be written; there will be no more.
    pub fn put(&mut self, row: T) -> Result<(), OutputError> {
        let Some(rows) = &self.rows else { return Ok(()) };
        match rows.try_send(row) {
            Ok(()) => Ok(()),
            Err(TrySendError::Full(_)) => {
                self.lost += 1;
                Ok(())
            }
            Err(TrySendError::Disconnected(_)) => self.end().map(drop),
        }
    }

    /// Waits until all is written; how many rows were lost.
    ///
    /// # Errors
    /// A row could not be written.
    pub fn end(&mut self) -> Result<u64, OutputError> {
        self.rows = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(written)) => written.map(|()| self.lost),
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(self.lost),
        }
    }
}

impl<T> Drop for Aside<T> {
    fn drop(&mut self) {
        self.rows = None;
        if let Some(thread) = self.thread.take() {
            // whoever wants to know how it ended asks before
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;
    use std::sync::{Arc, Mutex, mpsc};

    #[test]
    fn a_disk_that_hangs_makes_nobody_wait_and_what_was_lost_is_counted() {
        let (go_on, wait) = mpsc::channel::<()>();
        let written = Arc::<Mutex<Vec<u32>>>::default();
        let theirs = Arc::clone(&written);
        let mut aside = Aside::start(4, move |row| {
            wait.recv().unwrap();
            theirs.lock().unwrap().push(*row);
            Ok(())
        })
        .unwrap();
        for row in 0..20 {
            aside.put(row).unwrap();
        }
        assert!(written.lock().unwrap().is_empty());
        (0..20).for_each(|_| go_on.send(()).unwrap());
        let lost = aside.end().unwrap();
        // four wait and, where the thread was quick, one is being written
        assert!(lost == 15 || lost == 16, "{lost}");
        let written = written.lock().unwrap();
        assert_eq!(*written, (0..20 - lost as u32).collect::<Vec<_>>());
    }

    #[test]
    fn a_row_that_cannot_be_written_is_told_once() {
        let mut aside = Aside::start(4, |_: &u32| {
            Err(OutputError { path: PathBuf::from("full.csv"), cause: io::Error::other("no space") })
        })
        .unwrap();
        let error = loop {
            if let Err(error) = aside.put(1) {
                break error;
            }
            std::thread::yield_now();
        };
        assert_eq!(error.to_string(), "cannot write full.csv");
        assert!(aside.put(2).is_ok() && aside.end().is_ok());
    }
}
