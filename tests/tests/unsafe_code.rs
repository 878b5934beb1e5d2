//! Promise: core holds no unsafe code, and elsewhere each use says why it is sound.

use std::fs;
use std::path::{Path, PathBuf};
use tetrad_tests::repository;
use tetrad_tests::source::code_only;

/// How many lines above an `unsafe` its SAFETY comment may start.
const REACH: usize = 6;

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() && name != "target" && name != ".git" {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Whether `line` of code starts something unsafe that needs a reason. Attributes, declarations and
/// function pointer types promise nothing themselves.
fn is_unsafe(line: &str) -> bool {
    let mut rest = line;
    while let Some((before, after)) = rest.split_once("unsafe") {
        let word = |c: char| c.is_alphanumeric() || c == '_';
        if !before.ends_with(word) && (after.starts_with(" {") || after.starts_with(" impl")) {
            return true;
        }
        rest = after;
    }
    false
}

/// The numbers of the lines of `text` that are unsafe and have no reason above them.
fn without_reason(text: &str) -> Vec<usize> {
    let lines: Vec<&str> = text.lines().collect();
    let code = code_only(text);
    let bare = |at: usize| {
        let first = at.saturating_sub(REACH);
        !lines[first..=at].iter().any(|line| line.contains("SAFETY:"))
    };
    code.lines().enumerate().filter(|(at, line)| is_unsafe(line) && bare(*at)).map(|(at, _)| at + 1).collect()
}

#[test]
fn core_forbids_unsafe_code() -> std::io::Result<()> {
    let lib = fs::read_to_string(repository().join("core/src/lib.rs"))?;
    assert!(code_only(&lib).contains("#![forbid(unsafe_code)]"));
    assert!(code_only(&lib).contains("#![no_std]"));
    Ok(())
}

#[test]
fn every_unsafe_block_says_why_it_is_sound() -> std::io::Result<()> {
    let mut files = Vec::new();
    rust_files(repository(), &mut files);
    assert!(files.len() > 20, "the checkout is not there: {files:?}");
    for file in files {
        let bare = without_reason(&fs::read_to_string(&file)?);
        assert!(bare.is_empty(), "{}: lines {bare:?} need a SAFETY comment", file.display());
    }
    Ok(())
}

#[test]
fn a_missing_reason_is_seen() {
    assert_eq!(without_reason("fn f() {\n    unsafe { g() }\n}\n"), [2]);
    assert_eq!(without_reason("unsafe impl Send for X {}\n"), [1]);
    assert_eq!(without_reason("// SAFETY: g has no conditions\nunsafe { g() }\n"), []);
    assert_eq!(without_reason("// unsafe { }\nlet unsafe_code = \"unsafe { }\";\n"), []);
}
