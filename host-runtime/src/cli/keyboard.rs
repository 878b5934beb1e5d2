//! The operator's terminal: the space bar as hold-to-run, and a stop that is always there.
//!
//! A terminal tells that a key is down only by repeating it, and most tell nothing when it is let go.
//! So the bar counts as held for [`FIRST_REPEAT`] after it was first struck, which is longer than
//! keyboards wait before they repeat, and for [`NEXT_REPEAT`] after each repeat. Terminals that do tell
//! (kitty's protocol) are believed at once.

use crossterm::event::{
    self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, KeyboardEnhancementFlags,
    PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::{execute, terminal};
use std::io;
use std::time::{Duration, Instant};

/// Longer than the slowest usual delay before a key repeats (660 ms under X11).
const FIRST_REPEAT: Duration = Duration::from_millis(700);

/// Two repeats of the slowest usual rate (10.9 a second on a Linux console).
const NEXT_REPEAT: Duration = Duration::from_millis(200);

/// What the operator did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) enum Key {
    /// Stop the arm.
    Stop,
    /// End a stop or a fault.
    Reset,
    /// The joints are homed.
    Homed,
    /// End the program.
    Quit,
}

/// How long the space bar counts as held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Held {
    until: Option<Instant>,
}

impl Held {
    fn strike(&mut self, now: Instant) {
        let repeated = self.is_held(now);
        self.until = Some(now + if repeated { NEXT_REPEAT } else { FIRST_REPEAT });
    }

    const fn let_go(&mut self) {
        self.until = None;
    }

    fn is_held(&self, now: Instant) -> bool {
        self.until.is_some_and(|until| now < until)
    }
}

/// A terminal in raw mode; it is itself again when this is dropped.
#[derive(Debug)]
pub(in crate::cli) struct Keyboard {
    held: Held,
    tells_releases: bool,
}

impl Keyboard {
    /// Takes the terminal.
    ///
    /// # Errors
    /// Where there is none, or it cannot be switched to raw mode.
    pub(in crate::cli) fn open() -> io::Result<Self> {
        terminal::enable_raw_mode()?;
        // whoever does not answer does not tell
        let tells_releases = terminal::supports_keyboard_enhancement().unwrap_or(false);
        let keyboard = Self { held: Held::default(), tells_releases };
        if tells_releases {
            let flags = KeyboardEnhancementFlags::REPORT_EVENT_TYPES
                | KeyboardEnhancementFlags::REPORT_ALL_KEYS_AS_ESCAPE_CODES;
            execute!(io::stderr(), PushKeyboardEnhancementFlags(flags))?;
        }
        Ok(keyboard)
    }

    /// The next thing that the operator did since the last call; `None` when there is nothing left.
    ///
    /// # Errors
    /// Where the terminal went away: the bar is then not held any more.
    pub(in crate::cli) fn next(&mut self, now: Instant) -> io::Result<Option<Key>> {
        while event::poll(Duration::ZERO).inspect_err(|_| self.held.let_go())? {
            if let Event::Key(event) = event::read()?
                && let Some(key) = self.key(event, now)
            {
                return Ok(Some(key));
            }
        }
        Ok(None)
    }

    /// Whether the space bar is held.
    pub(in crate::cli) fn is_held(&self, now: Instant) -> bool {
        self.held.is_held(now)
    }

    fn key(&mut self, event: KeyEvent, now: Instant) -> Option<Key> {
        let control = event.modifiers.contains(KeyModifiers::CONTROL);
        let key = match (event.code, event.kind) {
            (KeyCode::Char(' '), KeyEventKind::Release) => {
                self.held.let_go();
                return None;
            }
            (_, KeyEventKind::Release) => return None,
            (KeyCode::Char(' '), _) => {
                self.held.strike(now);
                return None;
            }
            (KeyCode::Char('c' | 'q'), _) if control => Key::Quit,
            (KeyCode::Char('q'), _) => Key::Quit,
            (KeyCode::Char('r'), _) => Key::Reset,
            (KeyCode::Char('h'), _) => Key::Homed,
            // whatever else is struck in a fright
            _ => Key::Stop,
        };
        self.held.let_go();
        Some(key)
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // the terminal may be gone already; there is nobody left to tell
        if self.tells_releases {
            let _ = execute!(io::stderr(), PopKeyboardEnhancementFlags);
        }
        let _ = terminal::disable_raw_mode();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyboard() -> Keyboard {
        Keyboard { held: Held::default(), tells_releases: false }
    }

    fn press(code: KeyCode) -> KeyEvent {
        KeyEvent::new(code, KeyModifiers::NONE)
    }

    #[test]
    fn the_bar_is_held_until_its_repeats_stay_away() {
        let mut held = Held::default();
        let start = Instant::now();
        assert!(!held.is_held(start));
        held.strike(start);
        assert!(held.is_held(start + Duration::from_millis(690)), "before the first repeat");
        let mut now = start + Duration::from_millis(660);
        for _ in 0..20 {
            held.strike(now);
            now += Duration::from_millis(92);
            assert!(held.is_held(now));
        }
        assert!(!held.is_held(now + NEXT_REPEAT), "let go");
    }

    #[test]
    fn a_release_that_is_told_counts_at_once() {
        let mut keyboard = keyboard();
        let now = Instant::now();
        assert_eq!(keyboard.key(press(KeyCode::Char(' ')), now), None);
        assert!(keyboard.is_held(now));
        let release = KeyEvent::new_with_kind(KeyCode::Char(' '), KeyModifiers::NONE, KeyEventKind::Release);
        assert_eq!(keyboard.key(release, now), None);
        assert!(!keyboard.is_held(now));
    }

    #[test]
    fn any_other_key_stops_and_lets_go() {
        let now = Instant::now();
        for (code, key) in [
            (KeyCode::Char('s'), Key::Stop),
            (KeyCode::Esc, Key::Stop),
            (KeyCode::Enter, Key::Stop),
            (KeyCode::Char('r'), Key::Reset),
            (KeyCode::Char('h'), Key::Homed),
            (KeyCode::Char('q'), Key::Quit),
        ] {
            let mut keyboard = keyboard();
            let _ = keyboard.key(press(KeyCode::Char(' ')), now);
            assert_eq!(keyboard.key(press(code), now), Some(key));
            assert!(!keyboard.is_held(now), "{code:?}");
        }
    }
}
