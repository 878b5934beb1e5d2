//! Promise: nalgebra computes sines, roots and powers with libm wherever it is built into: never with the
//! platform's C library, which gives other bits.
//!
//! Its feature `libm-force` sees to that, and is only as good as the builds it is in. What cargo would build is
//! asked, so that a manifest that leaves the feature out, or a crate that builds another nalgebra, is noticed.

use std::path::Path;
use std::process::Command;
use tetrad_tests::repository;

/// The crates that choose between libm and the platform, and what makes them choose libm.
const FORCED: [(&str, &str); 2] = [("nalgebra", "libm-force"), ("simba", "libm_force")];

/// What is built: name, manifest, and cargo's arguments.
const BUILDS: [(&str, &str, &[&str]); 5] = [
    ("core", "Cargo.toml", &["--package", "tetrad-core", "--edges", "normal"]),
    ("host", "Cargo.toml", &["--package", "tetrad", "--edges", "normal"]),
    ("the workspace with its tests", "Cargo.toml", &["--workspace"]),
    ("firmware", "firmware/Cargo.toml", &["--features", "mps2", "--target", "thumbv7em-none-eabihf"]),
    ("no-panic", "tests/no-panic/Cargo.toml", &["--target", "thumbv7em-none-eabihf"]),
];

/// Every crate of a build a line, as `name vVERSION ...|feature,feature`.
fn crates(manifest: &Path, arguments: &[&str]) -> String {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["tree", "--locked", "--prefix", "none", "--format", "{p}|{f}", "--manifest-path"]);
    let output = cargo.arg(manifest).args(arguments).output().expect("cargo runs");
    assert!(output.status.success(), "{cargo:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Of each of [`FORCED`] whether it is in a build, and never without its feature.
fn are_forced(crates: &str) -> [bool; 2] {
    FORCED.map(|(name, feature)| {
        let lines = crates.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(" v"));
        let mut features =
            lines.map(|line| line.split_once('|').map_or("", |(_, features)| features)).peekable();
        // a crate that was told before has a remark behind its features
        let has = |features: &str| features.split([',', ' ']).any(|has| has == feature);
        features.peek().is_some() && features.all(has)
    })
}

#[test]
fn nalgebra_computes_with_libm_in_every_build() {
    for (name, manifest, arguments) in BUILDS {
        let crates = crates(&repository().join(manifest), arguments);
        assert_eq!(are_forced(&crates), [true; 2], "{name}: {FORCED:?}\n{crates}");
    }
}

#[test]
fn a_build_without_it_is_noticed() {
    let forced = "core v0.1.0 (/core)|\nnalgebra v0.35.0|libm,libm-force\nsimba v0.10.2|libm,libm_force\n";
    assert_eq!(are_forced(forced), [true; 2]);
    let twice = format!("{forced}nalgebra v0.35.0|libm,libm-force (*)\nnalgebra-macros v0.3.0|\n");
    assert_eq!(are_forced(&twice), [true; 2]);
    assert_eq!(are_forced(&forced.replace("libm-force", "std")), [false, true]);
    assert_eq!(are_forced(&format!("{forced}simba v0.9.1|libm,std\n")), [true, false], "a second version");
    assert_eq!(are_forced("core v0.1.0 (/core)|\n"), [false; 2], "what is not there is not checked");
}
