//! Promise: what is wrong with a station's file is said by `tetrad check`, and by the station before it
//! does anything: with the key, what would mend it, and the same exit code whichever station it is.

mod common;

use common::{Ran, tetrad};
use std::fs;
use std::io::{Read as _, Seek as _};
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
            let words = ["tetrad.toml: [station] listen", address, "a port that is free", cause];
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
            for word in
                ["error: tetrad.toml: [station] keys", "keys/one.pem", "`tetrad keys --out keys station one`"]
            {
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
        (
            OPERATOR.replace("sim:still", "node:serial:/dev/ttyX?baud=0"),
            "[[operator.camera]] 1 source",
            "a number from 300 to 12000000 bits a second",
        ),
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
    // on a station the authority's key has nothing to do, and its own is nobody else's to read
    let told = checked(CAMERA).done().stdout;
    assert!(told.contains("note            [station] keys: keys/authority.key is here"), "{told}");
    fs::remove_file(dir.path().join("keys/authority.key")).unwrap();
    let told = checked(CAMERA).done().stdout;
    // not everybody who runs this may have real-time priorities
    let mut notes =
        told.lines().filter(|line| line.starts_with("note ") && !line.contains("real-time priorities"));
    assert_eq!(notes.next(), None, "{told}");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let key = dir.path().join("keys/one.key");
        fs::set_permissions(&key, fs::Permissions::from_mode(0o644)).unwrap();
        let told = checked(CAMERA).done().stdout;
        assert!(told.contains("everybody on this computer may read keys/one.key"), "{told}");
        fs::set_permissions(&key, fs::Permissions::from_mode(0o640)).unwrap();
    }
    station(dir.path(), "127.0.0.1:0", CAMERA);
    let told = check(dir.path()).done().stdout;
    assert!(told.contains("note            [station] listen: 127.0.0.1:0 is another port at each"), "{told}");
}

/// A name may be that of a pipe that nobody writes to, or of a file without an end.
#[cfg(target_os = "linux")]
#[test]
fn files_that_never_end_are_refused_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let made = std::process::Command::new("mkfifo").arg(dir.path().join("pipe")).status().unwrap();
    assert!(made.success());
    for (config, tables) in [
        ("pipe", String::new()),
        ("/dev/zero", String::new()),
        ("tetrad.toml", format!("{CAMERA}scene = \"pipe\"\n")),
        ("tetrad.toml", format!("{CAMERA}colours = \"/dev/zero\"\n")),
    ] {
        station(dir.path(), "127.0.0.1:7420", &tables);
        let ran = ended_soon(dir.path(), &format!("check --config {config}"));
        ran.refused(2, &[config, "it is a pipe or a device"]);
    }
    // what the console is served with, by `check` and by the station itself
    let console = |files: &str| format!("{OPERATOR}[console]\nlisten = \"127.0.0.1:0\"\n{files}");
    for (files, words) in [
        ("token_file = \"/dev/zero\"\n", ["[console] token_file", "/dev/zero", "it is a pipe or a device"]),
        ("token_file = \"pipe\"\n", ["[console] token_file", "pipe", "it is a pipe or a device"]),
        (
            "certificate = \"pipe\"\nkey = \"pipe\"\n",
            ["[console] certificate", "pipe", "it is a pipe or a device"],
        ),
        ("sessions = \"tetrad.toml\"\n", ["[console] sessions", "tetrad.toml", "is no folder"]),
    ] {
        fs::write(dir.path().join("tetrad.toml"), console(files)).unwrap();
        for command in ["check --config tetrad.toml", "operator --config tetrad.toml --seconds 1"] {
            ended_soon(dir.path(), command).refused(2, &words);
        }
    }
}

/// Runs the program; one that hangs is ended, and has no exit code.
fn ended_soon(dir: &Path, arguments: &str) -> Ran {
    let text = || tempfile::tempfile().unwrap();
    let (mut stdout, mut stderr) = (text(), text());
    let mut command = common::command(arguments);
    command.current_dir(dir).stdout(stdout.try_clone().unwrap()).stderr(stderr.try_clone().unwrap());
    let mut program = command.spawn().unwrap();
    let mut looks = 0;
    while program.try_wait().unwrap().is_none() && looks < 1_000 {
        std::thread::sleep(std::time::Duration::from_millis(20));
        looks += 1;
    }
    // one that ended is not there to be killed
    let _ = program.kill();
    let code = program.wait().unwrap().code();
    let read = |file: &mut fs::File| {
        let mut text = String::new();
        file.rewind().and_then(|()| file.read_to_string(&mut text)).unwrap();
        text
    };
    Ran { code, stdout: read(&mut stdout), stderr: read(&mut stderr) }
}
