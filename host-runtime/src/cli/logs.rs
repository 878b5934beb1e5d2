//! Logs on standard error, for stations that nobody sits at: `--log LEVEL`, or RUST_LOG.
//!
//! A line an event: when (UTC), its level, the module, what, and what about it as `key=value`. They stand beside
//! what a command tells people (`note`), and change nothing of it. Without the flag and the variable there are
//! none, and an event costs a comparison.

use super::notes::note;
use crate::exit::Failure;
use std::io::{self, IsTerminal as _, Write};
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::{Layer as _, SubscriberExt as _};
use tracing_subscriber::util::SubscriberInitExt as _;

/// What names the filter where the flag does not.
const VARIABLE: &str = "RUST_LOG";

/// Begins to log, where that is asked for; once a process.
pub(super) fn start(flag: Option<&str>) -> Result<(), Failure> {
    let variable = std::env::var(VARIABLE).ok();
    let asked = flag.map(|text| ("--log", text)).or(variable.as_deref().map(|text| (VARIABLE, text)));
    let Some((name, text)) = asked.filter(|(_, text)| !text.trim().is_empty()) else { return Ok(()) };
    let targets = targets(text).map_err(|()| {
        Failure::bad_arguments(format!("{name} {text}: this is no level"))
            .help("error, warn, info, debug, trace or off; or TARGET=LEVEL,..., as tetrad::console=debug,quinn=warn")
    })?;
    let margin = if io::stderr().is_terminal() { "\r" } else { "" };
    let lines = tracing_subscriber::fmt::layer()
        .with_ansi(false)
        .with_writer(move || Line { bytes: Vec::new(), margin })
        .with_filter(targets);
    // only the first logs
    let _ = tracing_subscriber::registry().with(lines).try_init();
    Ok(())
}

/// What is logged: a level alone is that of this program, and others warn.
fn targets(text: &str) -> Result<Targets, ()> {
    match text.trim().parse::<LevelFilter>() {
        Ok(level) => {
            let others = level.min(LevelFilter::WARN);
            Ok(Targets::new().with_default(others).with_target("tetrad", level))
        }
        // a target without a level would be all of it, and a level that is misspelt a target
        Err(_) if !text.split(',').all(|part| part.contains('=')) => Err(()),
        Err(_) => text.parse().map_err(|_| ()),
    }
}

/// One event's line. Nobody waits for standard error: it goes the way of what is told aside.
struct Line {
    bytes: Vec<u8>,
    /// A terminal in raw mode goes back to its margin where it is told to.
    margin: &'static str,
}

impl Write for Line {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        let text = String::from_utf8_lossy(&self.bytes);
        let text = text.trim_end();
        if !text.is_empty() {
            note(format_args!("{text}{}", self.margin));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracing::Level;

    #[test]
    fn a_level_is_that_of_this_program() {
        let told = targets("debug").unwrap();
        assert!(told.would_enable("tetrad::console", &Level::DEBUG));
        assert!(!told.would_enable("tetrad::console", &Level::TRACE));
        assert!(told.would_enable("quinn", &Level::WARN) && !told.would_enable("quinn", &Level::INFO));
        let told = targets("error").unwrap();
        assert!(!told.would_enable("quinn", &Level::WARN) && !told.would_enable("tetrad", &Level::WARN));
        assert!(!targets("off").unwrap().would_enable("tetrad", &Level::ERROR));
    }

    #[test]
    fn targets_have_levels_of_their_own() {
        let told = targets("tetrad::link=trace,quinn=info").unwrap();
        assert!(told.would_enable("tetrad::link::inbox", &Level::TRACE));
        assert!(!told.would_enable("tetrad::console", &Level::ERROR));
        for nonsense in ["loud", "tetrad=loud", "tetrad", "tetrad=info,", "info,quinn=warn"] {
            assert!(targets(nonsense).is_err(), "{nonsense}");
        }
    }
}
