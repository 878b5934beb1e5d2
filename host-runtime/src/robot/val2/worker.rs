//! The thread that owns the line: it carries bytes between the line and the [`Dialogue`].

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use super::dialogue::Dialogue;
use super::line::{Line, Log};
use crate::precedence::{Duty, step_forward};

/// How long a thread without a line sleeps before it looks again whether one is wanted.
const IDLE: Duration = Duration::from_millis(5);

/// What the thread and the port share.
pub(super) struct Shared {
    dialogue: Mutex<Dialogue>,
    /// Enabling was asked for and not begun.
    wanted: AtomicBool,
    quit: AtomicBool,
    began: Instant,
}

impl Shared {
    pub(super) fn new(dialogue: Dialogue) -> Arc<Self> {
        Arc::new(Self {
            dialogue: Mutex::new(dialogue),
            wanted: AtomicBool::new(false),
            quit: AtomicBool::new(false),
            began: Instant::now(),
        })
    }

    /// The dialogue stays whole whoever panicked: it is changed by whole steps only.
    pub(super) fn dialogue(&self) -> MutexGuard<'_, Dialogue> {
        self.dialogue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn now(&self) -> Duration {
        self.began.elapsed()
    }

    /// Asks for a line and the first words on it.
    pub(super) fn begin(&self) {
        self.wanted.store(true, Ordering::Release);
    }

    /// Ends the thread.
    pub(super) fn quit(&self) {
        self.quit.store(true, Ordering::Release);
    }
}

/// What the thread owns.
pub(super) struct Worker {
    pub(super) shared: Arc<Shared>,
    pub(super) device: String,
    pub(super) baud: u32,
    /// Opened once already, so that what is wrong with it is said at once.
    pub(super) line: Option<Line>,
    pub(super) log: Option<Log>,
}

impl Worker {
    pub(super) fn run(mut self) {
        step_forward(Duty::Drive);
        let mut buffer = [0; 512];
        while !self.shared.quit.load(Ordering::Acquire) {
            if self.shared.wanted.swap(false, Ordering::AcqRel) {
                self.begin();
            }
            match self.carry(&mut buffer) {
                Ok(true) => {}
                Ok(false) => thread::sleep(IDLE),
                Err(error) => {
                    self.line = None;
                    let device = &self.device;
                    let reason = format!("{device} went away ({error}); plug it in, then enable");
                    self.shared.dialogue().line_lost(reason);
                }
            }
        }
    }

    /// Sees that the line is open and empty, and begins the conversation.
    fn begin(&mut self) {
        // a line that was unplugged and is back is another line
        if self.line.as_mut().is_some_and(|line| line.clear().is_err()) {
            self.line = None;
        }
        let opened = match self.line.take() {
            Some(line) => Ok(line),
            None => Line::open(&self.device, self.baud),
        };
        let mut dialogue = self.shared.dialogue();
        match opened {
            Ok(line) => {
                self.line = Some(line);
                dialogue.begin(self.shared.now());
            }
            Err(error) => dialogue.line_lost(format!(
                "{} cannot be opened ({error}); plug it in, or end the program that has it, then enable",
                self.device
            )),
        }
    }

    /// One turn: what came, what time brings, what is to be sent. Whether there is a line at all.
    fn carry(&mut self, buffer: &mut [u8]) -> std::io::Result<bool> {
        let Some(line) = &mut self.line else { return Ok(false) };
        let count = line.read(buffer)?;
        let received = buffer.get(..count).unwrap_or_default();
        let output = {
            let mut dialogue = self.shared.dialogue();
            let now = self.shared.now();
            dialogue.receive(received, now);
            dialogue.tick(now);
            dialogue.take_output()
        };
        line.write(&output)?;
        if let Some(log) = &mut self.log {
            let mut logged = if received.is_empty() { Ok(()) } else { log.received(received) };
            if !output.is_empty() {
                logged = logged.and_then(|()| log.sent(output.as_bytes()));
            }
            if let Err(error) = logged {
                eprintln!("val2: the log cannot be written ({error}); going on without it");
                self.log = None;
            }
        }
        Ok(true)
    }
}
