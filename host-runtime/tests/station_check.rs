//! Promise: what is wrong with a station's file is said by `tetrad check`, and by the station before it
//! does anything: with the key, what would mend it, and the same exit code whichever station it is.

mod common;

use common::{Ran, tetrad};
use std::fs;
use std::net::UdpSocket;
use std::path::Path;

const CAMERA: &str = "[camera]\nsource = \"sim:still\"\n";
const OPERATOR: &str =
    "[operator]\narm_mm = 80\nslave = \"here\"\n[[operator.camera]]\nsource = \"sim:still\"\n";
const SLAVE: &str = "[slave]\noperator = \"boss\"\nport = \"sim:\"\n";

/// The commands, each with the tables it needs and flags without which it would not come so far.
const STATIONS: [(&str, &str, &str); 3] = [
    ("camera", CAMERA, "--seconds 1"),
    ("operator", OPERATOR, "--seconds 1 --hold-to-run always"),
    ("slave", SLAVE, "--seconds 1"),
];

fn station(dir: &Path, listen: &str, tables: &str) {
    let text = format!(
        "[station]\nname = \"one\"\nkeys = \"keys\"\nlisten = \"{listen}\"\n[[peer]]\nname = \"boss\"\n{tables}"
    );
    fs::write(dir.join("tetrad.toml"), text).unwrap();
}

fn keys(dir: &Path) {
    tetrad(dir, "keys --out keys authority").done();
    tetrad(dir, "keys --out keys station one").done();
}

fn check(dir: &Path) -> Ran {
    tetrad(dir, "check --config tetrad.toml")
}

#[test]
fn an_address_that_cannot_be_listened_on_ends_every_station_alike() {
    let dir = tempfile::tempdir().unwrap();
    keys(dir.path());
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let taken = taken.local_addr().unwrap().to_string();
    // documentation's own network (RFC 5737): nobody has it
    for (address, cause) in [(taken.as_str(), "in use"), ("192.0.2.1:7420", "assign requested address")] {
        for (command, tables, flags) in STATIONS {
            station(dir.path(), address, tables);
            let ran = tetrad(dir.path(), &format!("{command} --config tetrad.toml {flags}"));
            let words = ["[station] listen", address, "a port that is free", cause];
            ran.refused(3, &words);
        }
    }
}

#[test]
fn a_missing_certificate_is_named_with_the_command_that_makes_it() {
    let dir = tempfile::tempdir().unwrap();
    for (command, tables, flags) in STATIONS {
        station(dir.path(), "127.0.0.1:7420", tables);
        for ran in [check(dir.path()), tetrad(dir.path(), &format!("{command} --config tetrad.toml {flags}"))]
        {
            assert_eq!(ran.code, Some(2), "{ran:#?}");
            for word in ["error: [station] keys", "keys/one.pem", "`tetrad keys --out keys station one`"] {
                assert!(ran.stderr.contains(word), "no {word:?} in {ran:#?}");
            }
        }
    }
    // what it says to do is enough
    keys(dir.path());
    check(dir.path()).done();
}

#[test]
fn what_check_can_know_it_says() {
    let dir = tempfile::tempdir().unwrap();
    keys(dir.path());
    let checked = |tables: &str| {
        station(dir.path(), "127.0.0.1:7420", tables);
        check(dir.path())
    };
    for (tables, key, mend) in [
        (CAMERA.replace("still", "stil"), "[camera] source", "there are still"),
        (format!("{CAMERA}colours = \"no.toml\"\n"), "[camera] colours", "cannot read"),
        (CAMERA.replace("sim:still", "rtsp://10.0.0.9/1"), "[camera] source", "/dev/videoN"),
        (OPERATOR.replace("sim:still", "node:left"), "[[operator.camera]] 1 source", "name = \"left\""),
        (SLAVE.replace("\"sim:\"", "\"puma:\""), "[slave] port", "canopen:can0"),
        (SLAVE.replace("boss", "bos"), "[slave] operator", "[[peer]]"),
    ] {
        checked(&tables).refused(2, &["tetrad.toml", key, mend]);
    }
    // what is only not there now is a note
    let away = SLAVE.replace("\"sim:\"", "\"val2:/dev/ttyNONE\"");
    let ran = checked(&format!("{away}[[slave.camera]]\nsource = \"/dev/videoNONE\"\n")).done();
    for words in [
        "note            [slave] port: /dev/ttyNONE is not there now; `tetrad devices` lists the serial ports",
        "note            [[slave.camera]] 1 source: /dev/videoNONE is not there now",
        "ready for       tetrad slave",
    ] {
        assert!(ran.stdout.contains(words), "no {words:?} in {ran:#?}");
    }
    assert!(!checked(CAMERA).done().stdout.contains("note "));
}
