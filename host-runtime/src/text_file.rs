//! Files that people or `tetrad` wrote: settings, colours, scenes, keys. They are small, and are replaced as a
//! whole. What is no regular file, or too large to be what it is taken for, is refused.

use crate::regular_file;
use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::path::Path;

/// The largest file, bytes: a hundred times the largest there is.
const LARGEST: u64 = 1024 * 1024;

/// The text of a file.
///
/// # Errors
/// What the system says, or why the file is not one of text.
pub(crate) fn read(path: &Path) -> io::Result<String> {
    read_within(path, LARGEST)
}

/// The text of a file that has so many bytes at most: one that grows with what it is about.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_within(path: &Path, largest: u64) -> io::Result<String> {
    let mut bytes = Vec::new();
    regular_file::open(path)?.take(largest + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > largest {
        return Err(wrong(format!("it is larger than {} kB: another file must be meant", largest / 1024)));
    }
    String::from_utf8(bytes).map_err(|_| wrong("it is no text (UTF-8): another file must be meant"))
}

fn wrong(problem: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, problem.into())
}

/// Puts a file in place of the one that is there: whoever reads it finds the old text or the new one, never
/// half of it.
///
/// # Errors
/// What the system says; the old file is there then.
pub(crate) fn replace(path: &Path, text: &str) -> io::Result<()> {
    // where a link leads to; a file that is not there yet is no link
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let name = path.file_name().ok_or_else(|| io::Error::from(io::ErrorKind::InvalidFilename))?;
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(".new");
    let beside = path.with_file_name(beside);
    let written = (|| {
        let mut file = File::create(&beside)?;
        if let Ok(old) = fs::metadata(path) {
            file.set_permissions(old.permissions())?;
        }
        file.write_all(text.as_bytes())?;
        file.sync_all()?;
        fs::rename(&beside, path)
    })();
    if written.is_err() {
        // there is nothing to be done about a rest that cannot be removed
        let _ = fs::remove_file(&beside);
    }
    written
}

/// Whether a file could be [replaced](replace) as far as rights go: its folder takes new ones.
pub(crate) fn may_replace(path: &Path) -> bool {
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    takes_files(folder.unwrap_or_else(|| Path::new(".")))
}

#[cfg(unix)]
fn takes_files(folder: &Path) -> bool {
    use rustix::fs::{Access, access};
    access(folder, Access::WRITE_OK | Access::EXEC_OK).is_ok()
}

/// Elsewhere rights are not told by bits alone, and only the writing itself tells.
#[cfg(not(unix))]
fn takes_files(folder: &Path) -> bool {
    folder.is_dir()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("colours.toml");
        replace(&file, "first").unwrap();
        replace(&file, "second").unwrap();
        assert_eq!(read(&file).unwrap(), "second");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing is left beside it");
        let missing = dir.path().join("nowhere").join("colours.toml");
        assert!(may_replace(&file) && !may_replace(&missing));
        assert!(may_replace(Path::new("colours.toml")), "the folder at hand");
        assert_eq!(replace(&missing, "third").unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_one_and_rights_stay() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let dir = tempfile::tempdir().unwrap();
        let (file, link) = (dir.path().join("a.toml"), dir.path().join("b.toml"));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        replace(&link, "new").unwrap();
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }

    fn refused(path: &Path) -> String {
        read(path).unwrap_err().to_string()
    }

    #[test]
    fn only_small_regular_files_of_text_are_read() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("a.toml");
        fs::write(&file, "a = 1").unwrap();
        assert_eq!(read(&file).unwrap(), "a = 1");
        assert!(refused(dir.path()).starts_with("it is a folder"));
        fs::write(&file, [0xFF, 0xFE]).unwrap();
        assert!(refused(&file).starts_with("it is no text"));
        let whole = " ".repeat(LARGEST as usize);
        fs::write(&file, &whole).unwrap();
        assert_eq!(read(&file).unwrap().len(), whole.len());
        fs::write(&file, whole + " ").unwrap();
        assert!(refused(&file).starts_with("it is larger than 1024 kB"));
        let missing = read(&dir.path().join("b.toml")).unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
    }
}
