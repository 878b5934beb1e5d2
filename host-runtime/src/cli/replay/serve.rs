//! `tetrad replay --serve`: the console's replay page without a station.

use crate::cli::interrupt::Interrupt;
use crate::cli::{note, say};
use crate::console::{Console, Desk};
use crate::exit::{Exit, Failure};
use crate::link::Doorbell;
use crate::robot::clock::Clock;
use crate::settings::station::ConsoleSettings;
use std::path::Path;
use std::time::Duration;

/// Ctrl-C is looked for so often.
const LOOK: Duration = Duration::from_millis(50);

/// Shows the sessions of the folder that `file` lies in, until somebody ends it.
pub(super) fn run(file: &Path) -> Result<(), Failure> {
    let name = file.file_name().and_then(|name| name.to_str()).filter(|name| name.ends_with(".mcap"));
    let Some(name) = name else {
        return Err(Failure::bad_arguments(format!("--serve: {} does not end with .mcap", file.display()))
            .help("the page shows the files of that name: rename it"));
    };
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let interrupt = Interrupt::listen()?;
    let settings = ConsoleSettings { sessions: Some(folder.to_owned()), ..ConsoleSettings::demo() };
    // nobody drives here
    let desk = Desk::new(false, Vec::new(), Clock::wall(), Doorbell::default());
    let console = Console::start(&settings, desk).map_err(|error| Failure::new(Exit::DeviceLost, error))?;
    say(format_args!("session         {}replay?session={}", console.url(), in_address(name)));
    note("open it; Ctrl-C ends");
    while !interrupt.asked() {
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// A name as addresses have it.
fn in_address(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    name.bytes()
        .map(|byte| if plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_no_blanks() {
        assert_eq!(in_address("a b&ü-1.mcap"), "a%20b%26%C3%BC-1.mcap");
    }
}
