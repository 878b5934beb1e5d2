//! Files that people or `tetrad` wrote: settings, colours, scenes, keys. They are small, and are replaced as a
//! whole.
//!
//! A name can be that of anything: a pipe that nobody writes to never ends an `open`, `/dev/zero` never
//! ends a `read`. What is no regular file, or too large to be what it is taken for, is refused before that.

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
    let wrong = |problem: String| Err(io::Error::new(io::ErrorKind::InvalidData, problem));
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return wrong("it is a folder: name the file in it".to_owned());
    }
    if !kind.is_file() {
        return wrong("it is a pipe or a device, and a regular file is needed: copy it to one".to_owned());
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(LARGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LARGEST {
        return wrong(format!("it is larger than {} kB: another file must be meant", LARGEST / 1024));
    }
    String::from_utf8(bytes)
        .or_else(|_| wrong("it is no text (UTF-8): another file must be meant".to_owned()))
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

    #[cfg(target_os = "linux")]
    #[test]
    fn what_never_ends_is_not_begun() {
        assert!(refused(Path::new("/dev/zero")).starts_with("it is a pipe or a device"));
    }
}
