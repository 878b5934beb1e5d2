//! `tetrad replay --serve`: the console's replay page without a station.

use crate::cli::interrupt::Interrupt;
use crate::cli::{note, say};
use crate::console::{Console, Desk};
use crate::exit::{Exit, Failure};
use crate::link::Doorbell;
use crate::robot::clock::Clock;
use crate::settings::station::ConsoleSettings;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Ctrl-C is looked for so often.
const LOOK: Duration = Duration::from_millis(50);

/// Shows the sessions of the folder that `file` lies in, until somebody ends it.
pub(super) fn run(file: &Path) -> Result<(), Failure> {
    let Shown { folder, name } = shown(file)?;
    let interrupt = Interrupt::listen()?;
    let settings = ConsoleSettings { sessions: Some(folder), ..ConsoleSettings::demo() };
    // nobody drives here
    let desk = Desk::new(false, Vec::new(), Clock::wall(), Doorbell::default());
    let console = Console::start(&settings, desk).map_err(|error| Failure::new(Exit::DeviceLost, error))?;
    say(format_args!("session         {}replay?session={}", console.url(), in_address(&name)));
    note("open it; Ctrl-C ends");
    while !interrupt.asked() {
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// What the page is to show.
#[derive(Debug, PartialEq, Eq)]
struct Shown {
    folder: PathBuf,
    name: String,
}

/// Where the file really lies, and what it is called there: the page lists no links.
fn shown(file: &Path) -> Result<Shown, Failure> {
    let real = file.canonicalize().map_err(|cause| {
        let cause = anyhow::Error::new(cause).context(format!("--serve: cannot find {}", file.display()));
        Failure::new(Exit::BadArguments, cause)
    })?;
    let name = real.file_name().and_then(|name| name.to_str());
    let name = name.filter(|name| name.ends_with(".mcap") && !name.starts_with('.'));
    match (real.parent(), name) {
        (Some(folder), Some(name)) => Ok(Shown { folder: folder.to_owned(), name: name.to_owned() }),
        _ => Err(Failure::bad_arguments(format!(
            "--serve: {} does not end with .mcap, or begins with a dot",
            real.display()
        ))
        .help("the page shows files that end with .mcap, and none that are hidden: rename it")),
    }
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
    #[cfg(unix)]
    fn a_link_shows_what_it_leads_to() {
        let dir = tempfile::tempdir().unwrap();
        let real = dir.path().canonicalize().unwrap();
        std::fs::create_dir(real.join("kept")).unwrap();
        for name in ["kept/one.mcap", "kept/.two.mcap", "kept/three.txt"] {
            std::fs::write(real.join(name), "").unwrap();
        }
        let link = |to: &str| {
            let link = real.join(format!("latest-{}.mcap", to.len()));
            std::os::unix::fs::symlink(real.join(to), &link).unwrap();
            link
        };
        let expected = Shown { folder: real.join("kept"), name: "one.mcap".to_owned() };
        assert_eq!(shown(&link("kept/one.mcap")).unwrap(), expected);
        assert_eq!(shown(&real.join("kept/one.mcap")).unwrap(), expected);
        for (file, why) in [
            (link("kept/.two.mcap"), "begins with a dot"),
            (link("kept/three.txt.nowhere"), "cannot find"),
            (real.join("kept/three.txt"), "does not end with .mcap"),
        ] {
            let told = format!("{:#}", shown(&file).unwrap_err().cause);
            assert!(told.contains(why), "{}: {told}", file.display());
        }
    }

    #[test]
    fn an_address_has_no_blanks() {
        assert_eq!(in_address("a b&ü-1.mcap"), "a%20b%26%C3%BC-1.mcap");
    }
}
