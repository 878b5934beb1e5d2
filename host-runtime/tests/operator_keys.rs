//! Promise: at the operator's terminal the space bar moves the arm while it is held, with or without a
//! terminal that tells of releases; any other key stops; and the exit code says how the arm stood.
#![cfg(target_os = "linux")]

#[path = "common/terminal.rs"]
mod terminal;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};
use terminal::{Kind, Terminal};

/// A busy computer's cycles come late; what is tried here is not how late.
const ALL: &str = "\
[operator]
arm_mm = 80
slave = \"here\"
[[operator.camera]]
source = \"sim:still\"
[[operator.camera]]
source = \"sim:still\"
view = \"right\"
[teleop]
command_timeout_ms = 4000
hold_to_run_timeout_ms = 4000
resume_ms = 5000
";

fn start(kind: Kind, dir: &Path, port: &str) -> Terminal {
    fs::write(dir.join("tetrad.toml"), format!("{ALL}[slave]\nport = \"{port}\"\n")).unwrap();
    Terminal::start(kind, dir, "operator --config tetrad.toml --out out")
}

/// Ready for the bar: reset, the arm switched on, the hand seen.
fn armed(terminal: &mut Terminal) {
    terminal.until("arm stopped", |_| {});
    let mut struck: Option<Instant> = None;
    terminal.until("arm armed", |terminal| {
        // the first count that a slave hears asks for nothing
        if struck.is_none_or(|at| at.elapsed() > Duration::from_secs(2)) {
            struck = Some(Instant::now());
            terminal.strike("r");
        }
    });
    terminal.until("hand both", |_| {});
}

#[test]
fn a_bar_that_repeats_moves_the_arm_until_it_does_not() {
    let dir = tempfile::tempdir().unwrap();
    let mut terminal = start(Kind::Plain, dir.path(), "sim:?watchdog_ms=5000");
    armed(&mut terminal);
    // a mere tap moves nothing: had it, the arm would be told to be engaged before the next reset
    terminal.strike(" ");
    std::thread::sleep(Duration::from_millis(900));
    assert!(!terminal.said().contains("arm engaged"), "{}", terminal.said());
    terminal.until("arm engaged", |terminal| terminal.strike(" "));
    terminal.until("hold-to-run", |_| {});
    terminal.strike("cx");
    terminal.until("the arm is told that its joints are homed", |_| {});
    terminal.until("stop was pressed", |_| {});
    terminal.strike("q");
    let (code, said) = terminal.end();
    assert_eq!(code, Some(0), "a stop that was asked for is no failure: {said}");
    assert!(said.contains("set-points") || said.contains("cycles"), "{said}");
}

#[test]
fn a_terminal_that_tells_of_releases_is_believed() {
    let dir = tempfile::tempdir().unwrap();
    let mut terminal = start(Kind::Kitty, dir.path(), "sim:?watchdog_ms=5000");
    armed(&mut terminal);
    // pressed once, and repeated as kitty does
    terminal.strike("\x1b[32;1:1u");
    terminal.until("arm engaged", |terminal| terminal.strike("\x1b[32;1:2u"));
    terminal.strike("\x1b[32;1:3u");
    terminal.until("hold-to-run", |_| {});
    terminal.strike("q");
    assert_eq!(terminal.end().0, Some(0));
}

#[test]
fn a_terminal_that_is_closed_brings_the_arm_to_rest_and_ends_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let mut terminal = start(Kind::Plain, dir.path(), "sim:?watchdog_ms=5000");
    armed(&mut terminal);
    terminal.until("arm engaged", |terminal| terminal.strike(" "));
    terminal.hang_up();
    assert_eq!(terminal.end().0, Some(4));
    let arm = fs::read_to_string(dir.path().join("out/arm.csv")).unwrap();
    let state = arm.lines().last().unwrap().split(',').nth(1).unwrap().to_owned();
    assert!(arm.contains(",engaged,") && state == "stopped", "{state}");
}

#[test]
fn an_arm_that_is_lost_ends_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let terminal = start(Kind::Plain, dir.path(), "sim:?silence=1s");
    let (code, said) = terminal.end();
    assert_eq!(code, Some(3), "{said}");
    assert!(said.contains("the arm does not answer") && said.contains("error: the arm is lost"), "{said}");
}

#[test]
fn an_arm_left_in_fault_is_no_good_end() {
    let dir = tempfile::tempdir().unwrap();
    let mut terminal = start(Kind::Plain, dir.path(), "sim:?watchdog_ms=5000&fault=3:0x2310@9s");
    armed(&mut terminal);
    terminal.until("arm fault", |_| {});
    terminal.strike("q");
    let (code, said) = terminal.end();
    assert_eq!(code, Some(4), "{said}");
    assert!(said.contains("the arm stands at the end of the run: fault"), "{said}");
}
