//! Promise: `tetrad operator` runs cameras, hand and arm in one process from one file, says what it did, and
//! refuses what cannot be meant.

mod common;

use common::{Ran, command, csv, tetrad};
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

const ALL: &str = "\
[operator]
arm_mm = 80
slave = \"here\"
[[operator.camera]]
source = \"sim:still\"
[[operator.camera]]
source = \"sim:still\"
view = \"right\"
[slave]
port = \"sim:\"
[[slave.camera]]
source = \"sim:arm\"
[[slave.camera]]
source = \"sim:arm\"
view = \"right\"
";

/// A busy computer's cycles come late; what is tried here is not how late.
const PATIENT: &str =
    "[teleop]\ncommand_timeout_ms = 4000\nhold_to_run_timeout_ms = 4000\nresume_ms = 5000\n";

fn run(dir: &Path, file: &str, arguments: &str) -> Ran {
    fs::write(dir.join("tetrad.toml"), file).unwrap();
    tetrad(dir, &format!("operator --config tetrad.toml {arguments}"))
}

fn column(rows: &[Vec<String>], name: &str) -> Vec<String> {
    let at = rows[0].iter().position(|column| column == name).unwrap();
    rows[1..].iter().map(|row| row[at].clone()).collect()
}

#[test]
fn cameras_hand_and_arm_in_one_process() {
    let dir = tempfile::tempdir().unwrap();
    let ran =
        run(dir.path(), &format!("{ALL}{PATIENT}"), "--hold-to-run always --seconds 8 --out out").done();
    for words in ["total sent to port written", "instants", "sim:still right", "memory"] {
        assert!(ran.stdout.contains(words), "no {words:?} in {ran:#?}");
    }
    assert!(ran.stderr.contains("arm engaged") && ran.stderr.contains("hand both"), "{ran:#?}");
    let out = dir.path().join("out");
    let states = column(&csv(&out.join("pose.csv")), "state");
    assert!(states.iter().filter(|state| *state == "both").count() * 2 > states.len(), "{states:?}");
    let arm = column(&csv(&out.join("arm_state.csv")), "state");
    assert!(arm.contains(&"engaged".to_owned()), "{arm:?}");
    assert!(csv(&out.join("arm.csv")).len() > 100);
    for (eye, row) in ["left", "right"].into_iter().zip(&csv(&out.join("pictures.csv"))[1..]) {
        assert_eq!(row[0], eye);
        let jpeg = fs::read(out.join(format!("{eye}.jpg"))).unwrap();
        assert!(jpeg.starts_with(&[0xFF, 0xD8]) && jpeg.ends_with(&[0xFF, 0xD9]), "{eye} is no JPEG");
    }
    let delays = csv(&out.join("delays.csv"));
    let counts = column(&delays, "count");
    assert_eq!(counts.len(), 15);
    for stage in [0, 1, 3, 4, 5, 6, 7, 8, 10, 11, 12, 13, 14] {
        assert!(counts[stage].parse::<u64>().unwrap() > 10, "{:?}", delays[stage + 1]);
    }
}

#[test]
fn what_an_operator_records_replays_to_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    let file = format!("{ALL}{PATIENT}").replace("sim:still", "sim:demo?format=nv12");
    let ran = run(dir.path(), &file, "--hold-to-run always --seconds 6 --record session.mcap").done();
    assert!(ran.stdout.contains("recorded        "), "{ran:#?}");
    assert!(!ran.stdout.contains("left out        "), "{ran:#?}");
    let ran = tetrad(dir.path(), "replay session.mcap --out out --export-csv --report session.html").done();
    for what in ["left observations", "right observations", "instants", "poses"] {
        let line = ran.stdout.lines().find(|line| line.starts_with(what));
        assert!(line.is_some_and(|line| line.contains(" identical, hash ")), "{what}: {ran:#?}");
    }
    let recorded = dir.path().join("out/recorded");
    let engaged = column(&csv(&recorded.join("command.csv")), "engaged");
    assert!(engaged.contains(&"1".to_owned()), "{engaged:?}");
    let arm = csv(&recorded.join("arm.csv"));
    assert!(column(&arm, "state").contains(&"engaged".to_owned()), "{:?}", arm.last());
    assert!(column(&arm, "q6").iter().all(|joint| joint.parse::<f64>().is_ok()));
    assert!(column(&csv(&recorded.join("buttons.csv")), "pressed").contains(&"1".to_owned()));
    assert!(csv(&recorded.join("delays.csv")).len() > 10);
    assert_eq!(csv(&recorded.join("pose.csv")), csv(&dir.path().join("out/pose.csv")), "as it was, and anew");
    let page = fs::read_to_string(dir.path().join("session.html")).unwrap();
    assert!(["The balls", "The hand", "The arm", "Delays", "/arm/joints"].iter().all(|t| page.contains(t)));
}

/// Ends as it is told to, the button released.
#[cfg(unix)]
#[test]
fn a_termination_lets_go_and_ends_well() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("tetrad.toml"), format!("{ALL}{PATIENT}")).unwrap();
    let mut child = command("operator --config tetrad.toml --hold-to-run always --out out")
        .current_dir(dir.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let record = dir.path().join("out/arm_state.csv");
    let began = Instant::now();
    while !fs::read_to_string(&record).is_ok_and(|text| text.contains(",engaged,")) {
        assert!(began.elapsed() < Duration::from_secs(120), "it never engaged");
        std::thread::sleep(Duration::from_millis(50));
    }
    let told = std::process::Command::new("kill").arg(child.id().to_string()).status().unwrap();
    assert!(told.success());
    assert!(child.wait().unwrap().success());
    assert!(dir.path().join("out/delays.csv").exists());
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let none = "[slave]\nport = \"sim:\"\n";
    run(dir.path(), none, "--hold-to-run always").refused(2, &["tetrad.toml", "[operator]"]);
    let iron = ALL.replace("port = \"sim:\"", "port = \"val2:/dev/ttyUSB9\"");
    run(dir.path(), &iron, "--hold-to-run always").refused(2, &["val2", "hold the button"]);
    run(dir.path(), ALL, "").refused(2, &["terminal", "--hold-to-run always"]);
    run(dir.path(), ALL, "--hold-to-run always --seconds 0").refused(2, &["--seconds"]);
    let own = ["--record tetrad.toml and --config tetrad.toml", "same file", "give another file"];
    run(dir.path(), ALL, "--hold-to-run always --record tetrad.toml").refused(2, &own);
    assert_eq!(fs::read_to_string(dir.path().join("tetrad.toml")).unwrap(), ALL);
    let away = ALL
        .replace("sim:still\"\nview", "/dev/video99\"\nview")
        .replace("view = \"right\"", "colours = \"no.toml\"");
    run(dir.path(), &away, "--hold-to-run always").refused(2, &["no.toml"]);
}
