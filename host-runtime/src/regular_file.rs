//! Opening a file, and nothing else that a name can be that of: a pipe that nobody writes to never ends an
//! `open`, `/dev/zero` never ends a `read`.

use std::fs::{self, File, Metadata};
use std::io;
use std::path::Path;

/// Opens a regular file to be read.
///
/// # Errors
/// What the system says, or that it is something else.
pub(crate) fn open(path: &Path) -> io::Result<File> {
    // a device is not even opened: that alone can set it going
    check(&fs::metadata(path)?)?;
    let file = open_at_once(path)?;
    // by now the name may be that of something else
    check(&file.metadata()?)?;
    Ok(file)
}

fn check(found: &Metadata) -> io::Result<()> {
    let wrong = |problem| Err(io::Error::new(io::ErrorKind::InvalidData, problem));
    if found.is_dir() {
        return wrong("it is a folder: name the file in it");
    }
    if !found.is_file() {
        return wrong("it is a pipe or a device, and a regular file is needed: copy it to one");
    }
    Ok(())
}

/// Opens it without waiting for whoever writes to a pipe; regular files are read as ever.
#[cfg(target_os = "linux")]
fn open_at_once(path: &Path) -> io::Result<File> {
    use std::os::unix::fs::OpenOptionsExt as _;
    fs::OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path)
}

/// Elsewhere a name that becomes a pipe's after it was looked at is waited for.
#[cfg(not(target_os = "linux"))]
fn open_at_once(path: &Path) -> io::Result<File> {
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
        // nor where it takes a file's place between the look and the opening
        let opened = open_at_once(&pipe).unwrap();
        assert!(check(&opened.metadata().unwrap()).is_err());
    }
}
