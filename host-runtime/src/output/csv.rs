//! A CSV file that grows row by row. Fields are numbers and plain words: nothing needs quoting.

use std::fmt::{Display, Write as _};
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A result that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}", path.display())]
pub struct OutputError {
    /// The file.
    pub path: PathBuf,
    /// What the operating system said.
    #[source]
    pub cause: io::Error,
}

/// A CSV file with its header written.
#[derive(Debug)]
pub struct CsvFile {
    file: File,
    path: PathBuf,
    line: String,
}

impl CsvFile {
    /// Creates (or empties) `dir/name` and writes the header.
    ///
    /// # Errors
    /// [`OutputError`] when the file cannot be created or written.
    pub fn create(dir: &Path, name: impl AsRef<Path>, header: &str) -> Result<Self, OutputError> {
        let path = dir.join(name);
        let created = File::create(&path).and_then(|mut file| {
            file.write_all(header.as_bytes())?;
            file.write_all(b"\n")?;
            Ok(file)
        });
        match created {
            Ok(file) => Ok(Self { file, path, line: String::new() }),
            Err(cause) => Err(OutputError { path, cause }),
        }
    }

    /// Adds a row: fill it field by field, it is written in one piece.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn row(&mut self, fill: impl FnOnce(&mut Row<'_>)) -> Result<(), OutputError> {
        self.line.clear();
        fill(&mut Row { line: &mut self.line, first: true });
        self.line.push('\n');
        self.file
            .write_all(self.line.as_bytes())
            .map_err(|cause| OutputError { path: self.path.clone(), cause })
    }
}

/// One row while it is filled.
#[derive(Debug)]
pub struct Row<'a> {
    line: &'a mut String,
    first: bool,
}

impl Row<'_> {
    /// The next field as it displays: whole numbers and words without commas.
    pub fn field(&mut self, value: impl Display) -> &mut Self {
        if !std::mem::replace(&mut self.first, false) {
            self.line.push(',');
        }
        let _ = write!(self.line, "{value}"); // writing to a String does not fail
        self
    }

    /// The next field, empty.
    pub fn empty(&mut self) -> &mut Self {
        self.field("")
    }

    /// A measured number with the digits it needs to read back the same; one that is not finite is
    /// not known and left empty.
    pub fn number(&mut self, value: f32) -> &mut Self {
        // -0 is written as 0
        if value.is_finite() { self.field(value + 0.0) } else { self.empty() }
    }

    /// A time in seconds, to the microsecond.
    pub fn time(&mut self, t_s: f64) -> &mut Self {
        self.field(format_args!("{t_s:.6}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_on_disk_before_the_file_is_closed() {
        let dir = tempfile::tempdir().unwrap();
        let mut csv = CsvFile::create(dir.path(), "a.csv", "frame,t,u,v,w").unwrap();
        csv.row(|row| {
            row.field(3u64).time(0.1).number(-0.0).number(1.0 / 3.0).number(f32::NAN);
        })
        .unwrap();
        let text = std::fs::read_to_string(dir.path().join("a.csv")).unwrap();
        assert_eq!(text, "frame,t,u,v,w\n3,0.100000,0,0.33333334,\n");
    }

    #[test]
    fn a_file_that_cannot_be_made_is_named() {
        let error = CsvFile::create(Path::new("/nowhere/at/all"), "pose.csv", "frame").unwrap_err();
        assert_eq!(error.to_string(), "cannot write /nowhere/at/all/pose.csv");
    }
}
