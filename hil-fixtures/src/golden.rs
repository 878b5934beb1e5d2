//! Results kept in files, and the one switch that rewrites them.
//!
//! A golden file has one `name hash` a line, sorted by name; lines that start with `#` are kept. A
//! test calls [`check`]; with the environment variable `TETRAD_BLESS=1` the call writes the new
//! value instead of comparing, and the difference shows up in `git diff`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::{env, fs, io};

/// The environment variable that turns comparing into writing when it is `1`.
pub const SWITCH: &str = "TETRAD_BLESS";

/// Why a result is not the golden one.
#[derive(Debug, thiserror::Error)]
pub enum GoldenError {
    /// The file cannot be read or written.
    #[error("{}: {error}; run the test with {SWITCH}=1 to write it", path.display())]
    File {
        /// The golden file.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
    /// The file has no such name.
    #[error("{}: no line for `{name}` (now {found}); run the test with {SWITCH}=1 to add it", path.display())]
    Missing {
        /// The golden file.
        path: PathBuf,
        /// Whose result is missing.
        name: String,
        /// The result now.
        found: String,
    },
    /// The result differs.
    #[error(
        "{}: `{name}` was {expected} and is now {found}; if that is meant, run the test with {SWITCH}=1 and commit the file",
        path.display()
    )]
    Differs {
        /// The golden file.
        path: PathBuf,
        /// Whose result differs.
        name: String,
        /// What the file says.
        expected: String,
        /// The result now.
        found: String,
    },
}

/// The path of a file in `hil-fixtures/data`.
#[must_use]
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

/// Whether results are to be rewritten.
#[must_use]
pub fn blessing() -> bool {
    env::var_os(SWITCH).is_some_and(|value| value == "1")
}

/// Compares `hash` with the line `name` of a golden file, or, with `TETRAD_BLESS=1`, writes it
/// there. `name` must have no white space.
///
/// # Errors
/// [`GoldenError`] says which file and name, and how to accept the new result.
pub fn check(file: &Path, name: &str, hash: u64) -> Result<(), GoldenError> {
    check_as(file, name, hash, blessing())
}

fn check_as(file: &Path, name: &str, hash: u64, bless: bool) -> Result<(), GoldenError> {
    // tests of one program run in threads and share files
    static FILES: Mutex<()> = Mutex::new(());
    let _guard = FILES.lock().unwrap_or_else(PoisonError::into_inner);

    let failed = |error| GoldenError::File { path: file.to_owned(), error };
    let found = format!("{hash:016x}");
    let text = match fs::read_to_string(file) {
        Err(error) if error.kind() == io::ErrorKind::NotFound && bless => String::new(),
        other => other.map_err(failed)?,
    };
    let known = text.lines().filter_map(|line| line.split_once(' ')).find(|(key, _)| *key == name);
    match known {
        Some((_, expected)) if expected == found => Ok(()),
        _ if bless => write_atomically(file, with_line(&text, name, &found).as_bytes()).map_err(failed),
        Some((_, expected)) => Err(GoldenError::Differs {
            path: file.to_owned(),
            name: name.to_owned(),
            expected: expected.to_owned(),
            found,
        }),
        None => Err(GoldenError::Missing { path: file.to_owned(), name: name.to_owned(), found }),
    }
}

/// Compares `bytes` with a recorded file, or, with `TETRAD_BLESS=1`, writes the file.
///
/// # Errors
/// As [`check`]; the results named are the hashes of the contents.
pub fn check_file(file: &Path, bytes: &[u8]) -> Result<(), GoldenError> {
    let failed = |error| GoldenError::File { path: file.to_owned(), error };
    if blessing() {
        return write_atomically(file, bytes).map_err(failed);
    }
    let known = fs::read(file).map_err(failed)?;
    if known == bytes {
        return Ok(());
    }
    Err(GoldenError::Differs {
        path: file.to_owned(),
        name: "contents".to_owned(),
        expected: format!("{:016x}", fnv1a(&known)),
        found: format!("{:016x}", fnv1a(bytes)),
    })
}

/// `text` with the line of `name` replaced or put in its place.
fn with_line(text: &str, name: &str, value: &str) -> String {
    let (comments, lines): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    let line = format!("{name} {value}");
    let mut lines: Vec<&str> =
        lines.into_iter().filter(|l| l.split(' ').next() != Some(name)).chain([line.as_str()]).collect();
    lines.sort_unstable();
    let mut out = String::new();
    for line in comments.iter().chain(&lines) {
        // writing to a string cannot fail
        let _ = writeln!(out, "{line}");
    }
    out
}

fn write_atomically(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let part = file.with_extension("part");
    fs::write(&part, bytes)?;
    fs::rename(&part, file)
}

/// FNV-1a, 64 bits: a checksum for golden files, not a defence.
#[derive(Clone, Copy, Debug)]
pub struct Fnv1a(u64);

impl Default for Fnv1a {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv1a {
    /// Takes more bytes in.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Takes a number in by its bits, every NaN as the same one.
    pub fn write_f32(&mut self, value: f32) {
        let bits = if value.is_nan() { 0x7fc0_0000 } else { value.to_bits() };
        self.write(&bits.to_le_bytes());
    }

    /// The hash of all bytes so far.
    #[must_use]
    pub const fn finish(&self) -> u64 {
        self.0
    }
}

/// The FNV-1a hash of `bytes`.
#[must_use]
pub fn fnv1a(bytes: &[u8]) -> u64 {
    let mut hash = Fnv1a::default();
    hash.write(bytes);
    hash.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv_matches_its_published_vectors() {
        assert_eq!(fnv1a(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv1a(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(fnv1a(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn blessing_writes_what_the_next_check_reads() {
        let dir = env::temp_dir().join(format!("tetrad-golden-{}", std::process::id()));
        fs::create_dir_all(&dir).expect("temporary directory");
        let file = dir.join("hashes.txt");
        assert!(matches!(check_as(&file, "b", 1, false), Err(GoldenError::File { .. })));
        check_as(&file, "b", 1, true).expect("a new file");
        fs::write(&file, format!("# kept\n{}", fs::read_to_string(&file).expect("written")))
            .expect("writable");
        check_as(&file, "a", 2, true).expect("a new line");
        check_as(&file, "b", 3, true).expect("a changed line");
        check_as(&file, "b", 3, false).expect("as blessed");
        assert!(matches!(check_as(&file, "b", 1, false), Err(GoldenError::Differs { .. })));
        assert!(matches!(check_as(&file, "c", 1, false), Err(GoldenError::Missing { .. })));
        assert_eq!(
            fs::read_to_string(&file).expect("written"),
            "# kept\na 0000000000000002\nb 0000000000000003\n"
        );
        fs::remove_dir_all(&dir).expect("removable");
    }
}
