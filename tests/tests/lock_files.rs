//! Promise: every program of the repository is built from the same numeric crates.
//!
//! Packages outside the workspace have lock files of their own. Where two of them disagree on a crate
//! that computes, the same frames may give other bits on another target.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use tetrad_tests::repository;

/// The crates whose version decides bits.
const NUMERIC: [&str; 4] = ["libm", "nalgebra", "num-traits", "simba"];

/// Crate name to its versions, of the numeric crates in a lock file.
fn numeric_versions(lock: &str) -> BTreeMap<String, Vec<String>> {
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in lock.split("[[package]]") {
        let field = |key: &str| {
            let line = package.lines().find_map(|line| line.strip_prefix(key))?;
            Some(line.trim_start_matches(" = ").trim_matches('"').to_owned())
        };
        if let (Some(name), Some(version)) = (field("name"), field("version"))
            && NUMERIC.contains(&name.as_str())
        {
            versions.entry(name).or_default().push(version);
        }
    }
    versions
}

/// Every lock file of the checkout.
fn lock_files(folder: &Path, found: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if name == "Cargo.lock" {
            found.push(path);
        } else if path.is_dir() && name != "target" && name != ".git" {
            lock_files(&path, found);
        }
    }
}

#[test]
fn lock_files_agree_on_the_crates_that_compute() {
    let mut files = Vec::new();
    lock_files(repository(), &mut files);
    let workspace = repository().join("Cargo.lock");
    assert!(files.len() >= 3 && files.contains(&workspace), "{files:?}");

    let read = |path: &Path| numeric_versions(&fs::read_to_string(path).unwrap_or_default());
    let expected = read(&workspace);
    assert_eq!(expected.keys().collect::<Vec<_>>(), NUMERIC.iter().collect::<Vec<_>>());
    for file in &files {
        for (name, versions) in read(file) {
            assert_eq!(
                Some(&versions),
                expected.get(&name),
                "{name} in {}: cargo update --manifest-path there, --precise to the workspace's version",
                file.display()
            );
        }
    }
}

#[test]
fn a_second_version_is_seen() {
    let one = "[[package]]\nname = \"libm\"\nversion = \"0.2.16\"\n\n[[package]]\nname = \"other\"\nversion = \"1.0.0\"\n";
    assert_eq!(numeric_versions(one)["libm"], ["0.2.16"]);
    let two = format!("{one}\n[[package]]\nname = \"libm\"\nversion = \"0.1.4\"\n");
    assert_eq!(numeric_versions(&two)["libm"], ["0.2.16", "0.1.4"]);
}
