//! Programs in Python, written by others, that tests talk to: where they are installed.

use std::fs;
use std::path::{Path, PathBuf};

/// Names the virtual environment with what tests/peers/requirements.txt asks for, where it is not the one
/// that `cargo verify` makes.
pub const PEERS: &str = "TETRAD_PEERS";

/// What the peers need, as pip reads it.
pub const REQUIREMENTS: &str = include_str!("../peers/requirements.txt");

/// Why a test that needs them is skipped.
pub const MISSING: &str =
    "what tests/peers/requirements.txt names is not installed: run `cargo verify --only peers`";

/// The environment under cargo's target directory.
#[must_use]
pub fn environment(target: &Path) -> PathBuf {
    target.join("verify/peers")
}

/// Its Python.
#[must_use]
pub fn python_in(environment: &Path) -> PathBuf {
    environment.join("bin/python")
}

/// The file in it that says what was installed, once all of it was.
#[must_use]
pub fn installed(environment: &Path) -> PathBuf {
    environment.join("installed.txt")
}

/// The Python that has everything, or `None`: then skip by [`MISSING`].
#[must_use]
pub fn python() -> Option<PathBuf> {
    if let Some(environment) = std::env::var_os(PEERS) {
        return Some(python_in(Path::new(&environment))).filter(|python| python.is_file());
    }
    let environment = environment(&crate::repository().join("target"));
    let complete = fs::read_to_string(installed(&environment)).is_ok_and(|text| text == REQUIREMENTS);
    complete.then(|| python_in(&environment))
}
