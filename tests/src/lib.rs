//! Whole-system tests live in `tests/`, one file a promise; this library holds what they share.
//!
//! A test that needs something this machine lacks does not pass in silence and does not fail: it
//! calls [`skip`] and returns. `cargo verify` counts it as skipped, by name.

pub mod peers;
pub mod source;
pub mod stations;
pub mod verify;

use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Where skipped tests are noted, one `SKIPPED name: why` a line: libtest hides what a passing test
/// prints, so `cargo verify` names a file here and reads it afterwards.
pub const SKIP_LOG: &str = "TETRAD_SKIP_LOG";

/// Names the folder of shared footage and published data, where it is not beside the checkout.
pub const SHARED: &str = "TETRAD_SHARED";

/// Reports the calling test as skipped: `SKIPPED name: why`, on standard error and in the file that
/// [`SKIP_LOG`] names. Call it once a test, with the test's own name, and return.
///
/// # Panics
/// When the file that [`SKIP_LOG`] names cannot be written: a skip that nobody counts is a lie.
pub fn skip(name: &str, why: impl Display) {
    let line = format!("SKIPPED {name}: {why}");
    eprintln!("{line}");
    if let Some(path) = std::env::var_os(SKIP_LOG) {
        let written = append(Path::new(&path), &line);
        assert!(written.is_ok(), "cannot write {}: {written:?}", path.display());
    }
}

fn append(path: &Path, line: &str) -> io::Result<()> {
    let mut log = OpenOptions::new().create(true).append(true).open(path)?;
    // One write for the whole line: tests of several processes append to the same file.
    log.write_all(format!("{line}\n").as_bytes())
}

/// The folder of shared footage and data ([`SHARED`], or `../shared` beside the checkout), or `None`
/// where this machine has none: then [`skip`].
#[must_use]
pub fn shared() -> Option<PathBuf> {
    let folder = match std::env::var_os(SHARED) {
        Some(folder) => PathBuf::from(folder),
        None => repository().parent()?.join("shared"),
    };
    folder.join("data").is_dir().then_some(folder)
}

/// The top of the checkout these tests were built from.
#[must_use]
pub fn repository() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// Cargo's target directory for it.
#[must_use]
pub fn target() -> PathBuf {
    let named = std::env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    // a relative one is meant from the top
    repository().join(named.unwrap_or_else(|| "target".into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_repository_is_the_folder_of_the_workspace() {
        assert!(repository().join("Cargo.lock").is_file());
        assert!(repository().join("tests/Cargo.toml").is_file());
    }

    #[test]
    fn skips_are_appended_one_a_line() -> io::Result<()> {
        let path = std::env::temp_dir().join(format!("tetrad-skips-{}", std::process::id()));
        append(&path, "SKIPPED a: no data")?;
        append(&path, "SKIPPED b: no data")?;
        let text = std::fs::read_to_string(&path)?;
        std::fs::remove_file(&path)?;
        assert_eq!(text, "SKIPPED a: no data\nSKIPPED b: no data\n");
        Ok(())
    }
}
