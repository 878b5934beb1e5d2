//! What a command tells its user beside the results, on standard error.
//!
//! A station tells it on a thread of its own: whoever reads (a stalled ssh, a pager) may not read for a
//! while, and an arm's cycles do not wait for that. What nobody reads in time is lost, and counted.

use crate::exit::{Exit, Failure, OrExit as _};
use anyhow::Context as _;
use std::fmt::Display;
use std::io::{self, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

/// So many lines wait for whoever reads.
const WAITING: usize = 512;

/// The end of a command waits at most so long for whoever reads.
const FLUSH: Duration = Duration::from_secs(1);

/// The thread, once a station has started it.
static ASIDE: OnceLock<Aside> = OnceLock::new();

struct Aside {
    lines: SyncSender<Line>,
    lost: AtomicU64,
    /// The reader was waited for once and did not read.
    stalled: AtomicBool,
}

enum Line {
    Text(String),
    /// All before is written.
    Flush(SyncSender<()>),
}

/// From now on nobody waits for standard error; once a process.
pub(super) fn tell_aside() -> Result<(), Failure> {
    let (lines, told) = sync_channel(WAITING);
    if ASIDE.set(Aside { lines, lost: AtomicU64::new(0), stalled: AtomicBool::new(false) }).is_ok()
        && let Some(aside) = ASIDE.get()
    {
        let tell = move || write_all(&told, &aside.lost, &mut io::stderr());
        let thread = std::thread::Builder::new().name("notes".to_owned()).spawn(tell);
        thread.context("the thread that tells cannot be started").or_exit(Exit::Failed)?;
    }
    Ok(())
}

/// Tells the user something beside the results.
pub(super) fn note(text: impl Display) {
    match ASIDE.get() {
        Some(aside) => put(aside, text.to_string()),
        None => {
            let _ = writeln!(io::stderr(), "{text}");
        }
    }
}

/// Waits until what was told is written, or nobody reads.
pub(super) fn flush() {
    let Some(aside) = ASIDE.get() else { return };
    let (done, written) = sync_channel(1);
    if !aside.stalled.load(Ordering::Relaxed) && aside.lines.try_send(Line::Flush(done)).is_ok() {
        let stalled = written.recv_timeout(FLUSH) == Err(RecvTimeoutError::Timeout);
        aside.stalled.store(stalled, Ordering::Relaxed);
    }
}

fn put(aside: &Aside, text: String) {
    if let Err(TrySendError::Full(_)) = aside.lines.try_send(Line::Text(text)) {
        aside.lost.fetch_add(1, Ordering::Relaxed);
    }
}

fn write_all(lines: &Receiver<Line>, lost: &AtomicU64, to: &mut impl Write) {
    for line in lines {
        match line {
            Line::Text(text) => {
                // a terminal in raw mode goes back to its margin where it is told to
                let margin = if text.ends_with('\r') { "\r" } else { "" };
                let missing = lost.swap(0, Ordering::Relaxed);
                let _ = writeln!(to, "{text}");
                if missing > 0 {
                    let _ = writeln!(to, "({missing} lines are missing: nobody read them){margin}");
                }
            }
            Line::Flush(done) => {
                let _ = done.try_send(());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    /// A reader that takes what is written only when it is let.
    struct Stalled {
        let_go: mpsc::Receiver<()>,
        is_free: bool,
        came: Vec<u8>,
    }

    impl Write for Stalled {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if !self.is_free {
                self.let_go.recv().unwrap();
                self.is_free = true;
            }
            self.came.extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn nobody_waits_for_a_reader_and_what_it_missed_is_told() {
        let (lines, told) = sync_channel(WAITING);
        let aside = Aside { lines, lost: AtomicU64::new(0), stalled: AtomicBool::new(false) };
        let (go_on, let_go) = mpsc::channel();
        let mut reader = Stalled { let_go, is_free: false, came: Vec::new() };
        for number in 0..2 * WAITING {
            put(&aside, format!("line {number}\r"));
        }
        go_on.send(()).unwrap();
        let Aside { lines, lost, .. } = aside;
        drop(lines);
        write_all(&told, &lost, &mut reader);
        let text = String::from_utf8(reader.came).unwrap();
        assert_eq!(text.lines().count(), WAITING + 1);
        assert!(text.contains("line 0\r\n(512 lines are missing: nobody read them)\r\n"), "{text}");
        assert!(text.ends_with("line 511\r\n"));
    }
}
