//! The operator's terminal: the space bar as hold-to-run (h for the way home), and a stop that is always there.
//! Letters are those of the console's pages, where both have one.
//!
//! How long a key counts as held, which a terminal hardly tells, is [`held`]'s.
//!
//! What is struck is read on a thread of its own: reading a terminal that has gone away may never return,
//! and an arm's cycles may not wait for it. Whether it has gone is asked of the system beside that.

mod held;

use crate::exit::{Exit, Failure};
use crate::locked::lock;
use crate::precedence::{Duty, step_forward};
use crate::station::operator::SCALES;
use crossterm::event::{
    self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, KeyboardEnhancementFlags,
    PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::{execute, terminal};
use held::Held;
use rustix::event::{PollFd, PollFlags, Timespec};
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, IsTerminal as _};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};
use tetrad_core::wire::{PressFor, ScaleShare};

/// What has been struck waits in a queue of so many keys. Nobody strikes as many between two looks; what
/// does is no hand on the keys, and stops the arm.
const STRUCK: usize = 64;

/// The thread that reads looks so often whether it is to end.
const LOOK: Duration = Duration::from_millis(50);

/// What the operator did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Key {
    /// Stop the arm.
    Stop,
    /// End a stop or a fault.
    Reset,
    /// The joints are homed.
    Homed,
    /// The hand shall lead less far, or farther again.
    Finer,
    Coarser,
    /// End the program.
    Quit,
}

/// The next smaller share of the scale, or the next larger one; the last stays.
pub(in crate::cli) fn next_scale(scale: ScaleShare, key: Key) -> ScaleShare {
    let percent = scale.percent();
    let next = match key {
        Key::Finer => SCALES.iter().rev().find(|step| **step < percent),
        _ => SCALES.iter().find(|step| **step > percent),
    };
    next.and_then(|percent| ScaleShare::from_percent(*percent)).unwrap_or(scale)
}

/// What the operator is told of it.
pub(in crate::cli) fn scale_words(scale: ScaleShare) -> String {
    format!("the next press follows by {} % of the slave's scale", scale.percent())
}

/// A terminal in raw mode; it is itself again when this is dropped.
#[derive(Debug)]
pub(in crate::cli) struct Keyboard {
    held: Held,
    /// What the key that is held is for.
    held_for: PressFor,
    /// The bar was struck and nobody has asked yet.
    struck: bool,
    reader: Arc<Reader>,
    /// The terminal, to ask whether it is still there.
    terminal: OwnedFd,
}

/// What the thread that reads the terminal has read.
#[derive(Debug, Default)]
struct Reader {
    desk: Mutex<Struck>,
    end: AtomicBool,
}

#[derive(Debug, Default)]
struct Struck {
    keys: VecDeque<(KeyEvent, Instant)>,
    /// There was no room for another key.
    too_many: bool,
    failed: Option<io::Error>,
}

impl Reader {
    fn desk(&self) -> MutexGuard<'_, Struck> {
        lock(&self.desk)
    }

    fn read(&self) {
        step_forward(Duty::Join);
        while !self.end.load(Ordering::Relaxed) {
            match event::poll(LOOK).and_then(|is_there| is_there.then(event::read).transpose()) {
                Ok(Some(Event::Key(event))) => self.desk().strike(event, Instant::now()),
                Ok(_) => {}
                Err(error) => {
                    self.desk().failed = Some(error);
                    return;
                }
            }
        }
    }
}

impl Struck {
    fn strike(&mut self, event: KeyEvent, at: Instant) {
        if self.keys.len() < STRUCK {
            self.keys.push_back((event, at));
        } else {
            self.too_many = true;
        }
    }
}

impl Keyboard {
    /// Takes the terminal.
    ///
    /// # Errors
    /// Where there is none, or it cannot be switched to raw mode.
    pub(in crate::cli) fn open() -> io::Result<Self> {
        terminal::enable_raw_mode()?;
        // the one that keys are read from
        let terminal = match io::stdin() {
            stdin if stdin.is_terminal() => stdin.as_fd().try_clone_to_owned()?,
            _ => File::open("/dev/tty")?.into(),
        };
        // whoever does not answer does not tell
        let tells_releases = terminal::supports_keyboard_enhancement().unwrap_or(false);
        let keyboard = Self::of(terminal, tells_releases);
        if tells_releases {
            let flags = KeyboardEnhancementFlags::REPORT_EVENT_TYPES
                | KeyboardEnhancementFlags::REPORT_ALL_KEYS_AS_ESCAPE_CODES;
            execute!(io::stderr(), PushKeyboardEnhancementFlags(flags))?;
        }
        let reader = Arc::clone(&keyboard.reader);
        std::thread::Builder::new().name("keys".to_owned()).spawn(move || reader.read())?;
        Ok(keyboard)
    }

    fn of(terminal: OwnedFd, tells_releases: bool) -> Self {
        Self {
            held: Held::new(tells_releases),
            held_for: PressFor::Follow,
            struck: false,
            reader: Arc::default(),
            terminal,
        }
    }

    /// The next thing that the operator did since the last call; `None` when there is nothing left.
    ///
    /// # Errors
    /// Where the terminal went away: the bar is then not held any more.
    pub(in crate::cli) fn next(&mut self) -> io::Result<Option<Key>> {
        loop {
            let mut desk = self.reader.desk();
            let next = desk.keys.pop_front();
            let (too_many, failed) = (std::mem::take(&mut desk.too_many), desk.failed.take());
            drop(desk);
            if too_many {
                self.held.let_go();
                return Ok(Some(Key::Stop));
            }
            match next {
                Some((event, at)) => {
                    if let Some(key) = self.key(event, at) {
                        return Ok(Some(key));
                    }
                }
                None => {
                    return match failed {
                        Some(error) => {
                            self.held.let_go();
                            Err(error)
                        }
                        None => self.still_there().map(|()| None),
                    };
                }
            }
        }
    }

    /// # Errors
    /// Where the terminal went away.
    pub(in crate::cli) fn still_there(&mut self) -> io::Result<()> {
        if is_gone(self.terminal.as_fd()) {
            self.held.let_go();
            return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it was hung up"));
        }
        Ok(())
    }

    /// What the key that is held, or was held last, is for.
    pub(in crate::cli) const fn held_for(&self) -> PressFor {
        self.held_for
    }

    /// Whether the space bar, or h, is held.
    pub(in crate::cli) fn is_held(&self, now: Instant) -> bool {
        self.held.is_held(now)
    }

    /// Whether the space bar was struck since this was last asked, held or not.
    pub(in crate::cli) const fn take_strike(&mut self) -> bool {
        std::mem::replace(&mut self.struck, false)
    }

    fn key(&mut self, event: KeyEvent, now: Instant) -> Option<Key> {
        let control = event.modifiers.contains(KeyModifiers::CONTROL);
        let hold = match event.code {
            KeyCode::Char(' ') => Some(PressFor::Follow),
            KeyCode::Char('h') => Some(PressFor::Home),
            _ => None,
        };
        let key = match (event.code, event.kind) {
            (_, KeyEventKind::Release) => {
                if hold == Some(self.held_for) {
                    self.held.let_go();
                }
                return None;
            }
            _ if hold.is_some_and(|hold| hold == self.held_for || !self.held.is_held(now)) => {
                self.strike(hold.unwrap_or_default(), now);
                return None;
            }
            // one key while the other is held is a fright, like any other
            _ if hold.is_some() => Key::Stop,
            (KeyCode::Char('-'), _) if !self.held.is_held(now) => Key::Finer,
            // kitty's protocol tells of the key, not of what Shift makes of it, and of Shift itself
            (KeyCode::Char('+' | '='), _) if !self.held.is_held(now) => Key::Coarser,
            (KeyCode::Modifier(_), _) if !self.held.is_held(now) => return None,
            (KeyCode::Char('c' | 'q'), _) if control => Key::Quit,
            (KeyCode::Char('q'), _) => Key::Quit,
            (KeyCode::Char('r'), _) => Key::Reset,
            (KeyCode::Char('c'), _) => Key::Homed,
            // whatever else is struck in a fright
            _ => Key::Stop,
        };
        self.held.let_go();
        Some(key)
    }

    fn strike(&mut self, press_for: PressFor, now: Instant) {
        if self.held_for != press_for {
            self.held.let_go();
            self.held_for = press_for;
        }
        self.held.strike(now);
        self.struck = true;
    }
}

/// How a run ends at which nobody can reach the keys any more.
pub(in crate::cli) fn went_away(cause: io::Error) -> Failure {
    let cause = anyhow::Error::new(cause).context("the terminal went away");
    Failure::new(Exit::Safety, cause).help("tmux or screen keep a terminal when the connection to it is lost")
}

/// Whether the other end of a terminal has been closed.
fn is_gone(terminal: BorrowedFd<'_>) -> bool {
    let mut asked = [PollFd::from_borrowed_fd(terminal, PollFlags::empty())];
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    let gone = PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL;
    rustix::event::poll(&mut asked, Some(&at_once)).is_ok() && asked[0].revents().intersects(gone)
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // it is not waited for: at a terminal that has gone it may never return
        self.reader.end.store(true, Ordering::Relaxed);
        // the terminal may be gone already; there is nobody left to tell
        if self.held.tells_releases() {
            let _ = execute!(io::stderr(), PopKeyboardEnhancementFlags);
        }
        let _ = terminal::disable_raw_mode();
    }
}

#[cfg(test)]
mod tests;
