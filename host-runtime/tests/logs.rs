//! Promise: logs stand on standard error beside what people are told, and only where they are asked for.

mod common;

use common::{command, tetrad};
use std::fs;
use std::path::Path;
use std::process::Stdio;

const STATION: &str = "[operator]\narm_mm = 80\nslave = \"here\"\n[[operator.camera]]\nsource = \"sim:still\"\n\
                       [[operator.camera]]\nsource = \"sim:still\"\nview = \"right\"\n[slave]\nport = \"sim:\"\n";

/// What a short run of an operator with a simulated arm has on standard error.
fn told(dir: &Path, flag: &str, variable: Option<&str>) -> String {
    let mut run = command(&format!("{flag} operator --config tetrad.toml --hold-to-run always --seconds 2"));
    run.current_dir(dir).stdin(Stdio::null()).env_remove("RUST_LOG");
    run.envs(variable.map(|filter| ("RUST_LOG", filter)));
    let output = run.output().expect("the program starts");
    let stdout = String::from_utf8(output.stdout).unwrap();
    assert!(!stdout.contains(" INFO tetrad::"), "{stdout}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn what_happens_is_logged_where_that_is_asked_for() {
    const ARM: &str =
        " INFO tetrad::cli::operator::run: the slave is there port=\"sim\" cameras=0 scale=1.0\n";
    const TOLD: &str = "the slave's arm is at sim, 0 cameras";
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("tetrad.toml"), STATION).unwrap();
    let plain = told(dir.path(), "", None);
    assert!(plain.contains(TOLD) && !plain.contains("tetrad::"), "{plain}");
    for (flag, variable) in [("", Some("tetrad=info")), ("--log info", Some("off"))] {
        let logged = told(dir.path(), flag, variable);
        assert!(logged.contains(ARM) && logged.contains(TOLD), "{flag} {variable:?}: {logged}");
        let line = logged.lines().find(|line| line.contains(" INFO ")).unwrap();
        assert!(line.starts_with("20") && line.contains('Z'), "{line}");
    }
}

#[test]
fn a_level_that_is_none_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    for place in ["--log loud devices", "devices --log loud"] {
        tetrad(dir.path(), place).refused(2, &["--log loud", "error, warn, info, debug, trace or off"]);
    }
}
