//! Promise: where `hil` cannot compare a board with the desktop it says why, where, and what would mend it.

#![cfg(target_os = "linux")]

use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;
use std::{fs, thread};
use tempfile::TempDir;
use tetrad_core::wire::{MAX_FRAME_LEN, Notice, NoticePacket, encode};
use tetrad_qemu::board_file::BoardFile;
use tetrad_qemu::hil;

/// A notice of the wire's version 3.
const OLD: [u8; 12] = [0x0B, 3, 6, 1, 1, 1, 1, 1, 1, 0x0B, 0xD5, 0];

/// The file of a board.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn of(text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("board.toml"), text).expect("it is written");
        Self { folder }
    }

    fn file(&self) -> PathBuf {
        self.folder.path().join("board.toml")
    }

    /// What is said of it; that it works is a failure.
    fn refused(&self) -> String {
        let mut out = Vec::new();
        let said = hil::run(&self.file(), &mut out).expect_err("there is no such board");
        assert!(said.starts_with(&self.file().display().to_string()), "{said}");
        assert_eq!(String::from_utf8_lossy(&out), "", "nothing was compared");
        said
    }

    /// The same of a board at a pseudo terminal that answers so to whatever it is told.
    fn refused_of(answer: &[u8]) -> String {
        let (mut master, slave) = TTYPort::pair().expect("a pseudo terminal");
        master.set_timeout(Duration::from_millis(20)).expect("it waits");
        let port = slave.name().expect("it has a name");
        let bench = Self::of(&format!("port = \"{port}\"\nsequences = [\"recorded\"]\n"));
        let said = thread::scope(|scope| {
            let said = scope.spawn(|| bench.refused());
            while !said.is_finished() {
                let mut bytes = [0; 256];
                if master.read(&mut bytes).is_ok_and(|count| count > 0) {
                    master.write_all(answer).expect("it is written");
                }
            }
            said.join().expect("it was refused")
        });
        assert!(said.contains(&format!("port = \"{port}\", baud = 921600: recorded, Paper")), "{said}");
        drop(slave);
        said
    }
}

#[test]
fn a_file_that_is_none_is_told_with_what_is_wrong() {
    for (text, words) in [
        ("prot = \"/dev/ttyACM0\"", &["1 | prot", "unknown field `prot`", "`port`"][..]),
        ("baud = 9600", &["missing field `port`"]),
        ("port = 3", &["1 | port = 3", "expected"]),
        ("port = \"/dev/x\"\nbaud = 1", &["baud = 1: from 9600 to 12000000"]),
        ("port = \"/dev/x\"\npictures = 0", &["2 | pictures = 0"]),
        ("port = \"/dev/x\"\nsequences = []", &["sequences is empty"]),
        ("port = \"/dev/x\"\nsequences = [\"dmo\"]", &["no \"dmo\"", "recorded, demo"]),
        ("port = \"/dev/x\"\nprobe = { run = [] }", &["probe.run is empty"]),
        ("port = \"/dev/x\"\nprobe = { start = [\"x\"] }", &["unknown field `start`", "`run`"]),
    ] {
        let said = Bench::of(text).refused();
        for word in words {
            assert!(said.contains(word), "{text}: {word} is not in: {said}");
        }
    }
    let said = hil::run(Path::new("nowhere.toml"), &mut Vec::new()).expect_err("there is none");
    assert!(said.starts_with("nowhere.toml: ") && said.contains("port = "), "{said}");
}

#[test]
fn what_a_file_leaves_out_is_the_usual() {
    let bench = Bench::of("port = \"/dev/ttyACM0\"");
    let board = BoardFile::read(&bench.file()).expect("it is whole");
    assert_eq!((board.port, board.baud, board.probe), ("/dev/ttyACM0".into(), 921_600, None));
    assert_eq!((board.sequences.len(), &*board.sequences[0]), (10, "recorded"));
    let bench = Bench::of("port = \"x\"\nsequences = [\"demo\", \"recorded\", \"still\"]\npictures = 2");
    let board = BoardFile::read(&bench.file()).expect("it is whole");
    for name in &board.sequences {
        let tape = board.tape(name).expect("there is one");
        assert_eq!(tape.pictures().count(), 2, "{name}");
    }
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let said = Bench::of("port = \"/dev/no-such-port\"").refused();
    assert!(said.contains("port = \"/dev/no-such-port\": ") && said.contains("plug the board in"), "{said}");
}

#[test]
fn a_program_that_does_not_get_onto_the_board_is_told_with_what_was_said() {
    let probe = |run: &str| Bench::of(&format!("port = \"/dev/no-such-port\"\nprobe = {{ run = {run} }}"));
    let said = probe(r#"["sh", "-c", "pwd; echo no target found >&2; exit 3"]"#);
    let folder = said.folder.path().display().to_string();
    let said = said.refused();
    for word in ["probe.run = [\"sh\"", "exit status: 3", "no target found", &folder] {
        assert!(said.contains(word), "{word} is not in: {said}");
    }
    let said = probe(r#"["no-such-loader"]"#).refused();
    assert!(said.contains("probe.run = [\"no-such-loader\"]") && said.contains("leave probe out"), "{said}");
    // the port is what is asked for next
    let said = probe(r#"["true"]"#).refused();
    assert!(said.contains("port = \"/dev/no-such-port\": "), "{said}");
}

#[test]
fn a_board_that_says_nothing_is_told() {
    let said = Bench::refused_of(&[]);
    assert!(said.contains("the board does not answer") && said.contains("stm32h743-streamed"), "{said}");
}

#[test]
fn a_board_of_another_version_is_told() {
    let said = Bench::refused_of(&OLD);
    assert!(
        said.contains("speaks version 3 of the wire format") && said.contains("load its program"),
        "{said}"
    );
}

#[test]
fn another_program_of_the_board_is_told() {
    let notice = Notice::NotUnderstood { count: 1 };
    let packet = NoticePacket { camera: 0, session: 1, sequence: 0, answers: None, notice };
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(&packet.into(), &mut frame).expect("there is room");
    let said = Bench::refused_of(&frame[..length]);
    assert!(said.contains("load stm32h743-streamed") && said.contains("NotUnderstood"), "{said}");
}

#[test]
fn a_line_of_another_rate_is_told() {
    let said = Bench::refused_of(&[0xF8, 0x80, 0xFE, 0]);
    assert!(said.contains("is no packet") && said.contains("`baud`"), "{said}");
}
