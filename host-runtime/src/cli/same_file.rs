//! Results do not go where they come from: whether two paths lead to one file, which would be emptied before
//! it is read, or while it is.

use crate::exit::Failure;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::{fmt, fs};

/// So many links are followed, as Linux does.
const MOST_LINKS: usize = 40;

/// What results that go to a folder end with there.
const RESULTS: [&str; 2] = ["csv", "json"];

/// What is read of a folder of pictures: what ends with these, and the times.
const PICTURES: [&str; 3] = ["png", "jpg", "jpeg"];
const TIMES: &str = "timestamps.csv";

/// A file that is read, and what a message calls it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Input<'a> {
    /// As `the session` or `--source`.
    pub(super) what: &'a str,
    pub(super) path: &'a Path,
}

impl<'a> Input<'a> {
    pub(super) const fn new(what: &'a str, path: &'a Path) -> Self {
        Self { what, path }
    }

    /// A SRC, where it is a file.
    pub(super) fn source(what: &'a str, spec: &'a str) -> Option<Self> {
        let elsewhere = spec.starts_with("sim:") || spec.starts_with("node:");
        (!elsewhere).then(|| Self::new(what, Path::new(spec)))
    }
}

/// Refuses an output that is one of the inputs, or is read where one of them is a folder; `flag` names it.
pub(super) fn refuse<'a>(
    flag: &str,
    out: &Path,
    inputs: impl IntoIterator<Item = Input<'a>>,
) -> Result<(), Failure> {
    for input in inputs {
        refuse_one(flag, out, input)?;
        if is_read_in(input.path, out) {
            let (what, folder) = (input.what, input.path.display());
            return Err(refused(flag, out, format_args!("is read with {what} {folder}")));
        }
    }
    Ok(())
}

/// Refuses a folder for results where a name that they may have leads to one of the inputs.
pub(super) fn refuse_in<'a>(
    flag: &str,
    folder: &Path,
    inputs: impl IntoIterator<Item = Input<'a>> + Clone,
) -> Result<(), Failure> {
    // one that is not there yet has nothing in it, and one that cannot be read is refused where it is written to
    let there = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let named =
        |path: &PathBuf| path.extension().is_some_and(|end| RESULTS.iter().any(|known| end == *known));
    // none of them is called as the times of a folder of pictures: results may lie beside those
    there
        .filter(named)
        .try_for_each(|out| inputs.clone().into_iter().try_for_each(|input| refuse_one(flag, &out, input)))
}

fn refuse_one(flag: &str, out: &Path, Input { what, path }: Input<'_>) -> Result<(), Failure> {
    if same_file(out, path) {
        return Err(refused(flag, out, format_args!("and {what} {} are the same file", path.display())));
    }
    Ok(())
}

fn refused(flag: &str, out: &Path, why: fmt::Arguments<'_>) -> Failure {
    Failure::bad_arguments(format!("{flag} {} {why}", out.display()))
        .help(format!("give another file or folder to {flag}: what is there would be lost"))
}

/// Whether a file that is there is one of those that are read where a folder of pictures is an input.
fn is_read_in(folder: &Path, out: &Path) -> bool {
    let Some(known) = identity(out) else { return false };
    let is_read = |path: &PathBuf| {
        let is_picture = |end: &OsStr| PICTURES.iter().any(|read| end.eq_ignore_ascii_case(read));
        path.extension().is_some_and(is_picture) || path.file_name().is_some_and(|name| name == TIMES)
    };
    // what is no folder has nothing in it
    let there = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    there.filter(is_read).any(|path| identity(&path).as_ref() == Some(&known))
}

/// Whether two paths lead to one file, which need not be there yet.
pub(super) fn same_file(a: &Path, b: &Path) -> bool {
    let there = identity(a).zip(identity(b)).is_some_and(|(a, b)| a == b);
    there || resolved(a) == resolved(b)
}

/// What a file is known by whatever its names are: hard links have it in common.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt as _;
    let file = fs::metadata(path).ok()?;
    Some((file.dev(), file.ino()))
}

/// Elsewhere nothing that is stable tells: paths do.
#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// Where a path leads, through every link, also one to a file that is not there yet.
fn resolved(path: &Path) -> PathBuf {
    let mut path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for _ in 0..MOST_LINKS {
        let Ok(target) = fs::read_link(&path) else { break };
        path = path.parent().unwrap_or(Path::new("/")).join(target);
    }
    path.canonicalize().unwrap_or_else(|_| match (path.parent().map(Path::canonicalize), path.file_name()) {
        (Some(Ok(parent)), Some(name)) => parent.join(name),
        _ => path,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_one_file_are_told_from_two_files() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("a"), "same").unwrap();
        fs::write(at("b"), "same").unwrap();
        fs::create_dir(at("d")).unwrap();
        assert!(same_file(&at("a"), &at("d/../a")) && !same_file(&at("a"), &at("b")));
        assert!(same_file(&at("new"), &at("d/../new")) && !same_file(&at("new"), &at("d/new")));
        fs::hard_link(at("a"), at("d/hard")).unwrap();
        assert!(same_file(&at("a"), &at("d/hard")) && !same_file(&at("b"), &at("d/hard")));
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_also_to_what_is_not_there_yet() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("a"), "there").unwrap();
        fs::create_dir(at("d")).unwrap();
        symlink("../a", at("d/soft")).unwrap();
        symlink("soft", at("d/softer")).unwrap();
        symlink("../new", at("d/coming")).unwrap();
        symlink("round", at("round")).unwrap();
        assert!(same_file(&at("a"), &at("d/softer")));
        assert!(same_file(&at("new"), &at("d/coming")) && !same_file(&at("a"), &at("d/coming")));
        assert!(!same_file(&at("a"), &at("round")));
    }

    #[test]
    fn what_is_read_of_a_folder_is_an_input_too() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::create_dir(at("left")).unwrap();
        for name in ["left/1.PNG", "left/2.jpg", "left/timestamps.csv", "left/pose.csv"] {
            fs::write(at(name), "there").unwrap();
        }
        fs::hard_link(at("left/2.jpg"), at("hard.mcap")).unwrap();
        let left = at("left");
        let inputs = [Input::new("--left", &left)];
        for name in ["left/1.PNG", "left/../left/2.jpg", "left/timestamps.csv", "hard.mcap"] {
            let message = refuse("--out", &at(name), inputs).unwrap_err().to_string();
            assert!(message.contains(" is read with --left "), "{message}");
        }
        for name in ["left/pose.csv", "left/3.png", "new.mcap"] {
            refuse("--out", &at(name), inputs).unwrap();
        }
        refuse_in("--out", &left, inputs).unwrap();
    }

    #[test]
    fn a_folder_is_refused_where_a_result_would_be_written_over_an_input() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("session.mcap"), "recorded").unwrap();
        let session = at("session.mcap");
        let inputs = [Input::new("the session", &session)];
        refuse_in("--out", dir.path(), inputs).unwrap();
        refuse_in("--out", &at("not/there/yet"), inputs).unwrap();
        fs::hard_link(&session, at("pose.csv")).unwrap();
        let message = refuse_in("--out", dir.path(), inputs).unwrap_err().to_string();
        assert!(message.contains("pose.csv and the session ") && message.contains("same file"), "{message}");
    }
}
