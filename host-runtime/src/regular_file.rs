//! Opening a file, and nothing else that a name can be that of: a pipe that nobody writes to never ends an
//! `open`, `/dev/zero` never ends a `read`.

use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Opens a regular file to be read.
///
/// # Errors
/// What the system says, or that it is something else.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    let wrong = |problem| Err(io::Error::new(io::ErrorKind::InvalidData, problem));
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return wrong("it is a folder: name the file in it");
    }
    if !kind.is_file() {
        return wrong("it is a pipe or a device, and a regular file is needed: copy it to one");
    }
    File::open(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn what_never_ends_is_not_begun() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [Path::new("/dev/zero"), &pipe] {
            let refused = open(path).unwrap_err().to_string();
            assert!(refused.starts_with("it is a pipe or a device"), "{refused}");
        }
    }
}
