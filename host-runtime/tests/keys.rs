//! `tetrad keys` makes what stations need to know each other, and never destroys any of it.

mod common;

use common::tetrad;
use std::fs;

#[test]
fn an_authority_and_two_stations() {
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &str| tetrad(dir.path(), arguments);
    run("keys --out new/keys authority").done();
    let said = run("keys --out new/keys station operator").done().stdout;
    assert!(said.contains("new/keys/operator.pem") && said.contains("authority.pem"), "{said}");
    run("keys --out new/keys station slave").done();
    let mut names: Vec<_> = fs::read_dir(dir.path().join("new/keys"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected =
        ["authority.key", "authority.pem", "operator.key", "operator.pem", "slave.key", "slave.pem"];
    assert_eq!(names, expected);
    for name in names {
        let text = fs::read_to_string(dir.path().join("new/keys").join(&name)).unwrap();
        let kind = if name.ends_with(".key") { "PRIVATE KEY" } else { "CERTIFICATE" };
        assert!(text.starts_with(&format!("-----BEGIN {kind}-----")), "{name}");
    }
}

#[test]
fn what_cannot_be_done_is_refused_with_the_mend() {
    let dir = tempfile::tempdir().unwrap();
    let run = |arguments: &str| tetrad(dir.path(), arguments);
    let mend = ["keys/authority.key is not there", "tetrad keys --out keys authority"];
    run("keys --out keys station slave").refused(2, &mend);
    run("keys --out keys authority").done();
    run("keys --out keys authority").refused(2, &["authority.key is there already and is not overwritten"]);
    run("keys --out keys station slave").done();
    run("keys --out keys station slave").refused(2, &["slave.key is there already"]);
    run("keys --out keys station Slave").refused(2, &["`Slave` is no name for a station", "lower-case"]);
    run("keys --out keys station authority").refused(2, &["`authority` is no name"]);
    run("keys --out keys station ../slave").refused(2, &["`../slave` is no name"]);
    run("keys station slave").refused(2, &["--out"]);
}
