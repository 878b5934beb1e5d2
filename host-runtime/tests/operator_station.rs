//! Promise: `tetrad operator` runs cameras, hand and arm in one process from one file, says what it did, and
//! refuses what cannot be meant.

mod common;

use common::console::Operator;
use common::{Ran, command, csv, tetrad};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};
use tetrad::session::{Entry, Reader, Tape, Topic};

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
    // none of them can be the session of a run that writes them
    for file in fs::read_dir(&out).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let again = "operator --config tetrad.toml --hold-to-run always --seconds 1 --out out --record";
        let own = format!("--record out/{name} and the result out/{name} are the same file");
        tetrad(dir.path(), &format!("{again} out/{name}")).refused(2, &[own.as_str()]);
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
    let taught = |entry: &Entry| matches!(entry.topic, Topic::Taught(_) | Topic::HandBegins);
    let session = entries(&dir.path().join("session.mcap"));
    assert!(!session.iter().any(taught), "nobody has taught it anything");
    assert!(["The balls", "The hand", "The arm", "Delays", "/arm/joints"].iter().all(|t| page.contains(t)));
}

/// What is in a session, in order.
fn entries(session: &Path) -> Vec<Entry> {
    let mut reader = Reader::open(session).unwrap();
    std::iter::from_fn(|| reader.next_entry().unwrap())
        .map(|entry| Entry { bytes: Vec::new(), ..entry })
        .collect()
}

/// Every camera sees every ball, and both see where the hand is, in what was known after that time.
fn tracked_after(operator: &Operator, since_us: u64) -> Option<u64> {
    let now = operator.snapshot();
    let states = now["cameras"].as_array().into_iter().flatten();
    let balls = states.flat_map(|camera| camera["balls"].as_array().into_iter().flatten());
    let seen = balls.filter(|ball| ball["state"] == "visible" || ball["state"] == "occluded").count();
    let time_us = now["time_us"].as_u64().filter(|time_us| *time_us > since_us + 1_000_000);
    time_us.filter(|_| seen == 8 && now["hand"]["state"] == "both")
}

/// What is set up is in use, and so much later all is tracked by it.
#[track_caller]
fn sets_up(operator: &Operator, path: &str, asked: &Value) {
    let (status, told) = operator.post(path, asked);
    let stopped = told["said"].as_str().is_some_and(|said| said.contains("the arm is stopped"));
    assert!(status == 200 && stopped, "{path}: {status}, {told}");
    let since_us = operator.snapshot()["time_us"].as_u64().unwrap();
    operator.until("tracking", |operator| tracked_after(operator, since_us));
}

/// The same colours, each reference a tenth darker: another threshold for every ball.
fn darker(colours: &str) -> String {
    let darker = |line: &str| {
        let Some(numbers) = line.strip_prefix("reference = [") else { return line.to_owned() };
        let numbers = numbers.trim_end_matches(']').split(',');
        let darker: Vec<_> =
            numbers.map(|n| (n.trim().parse::<u32>().unwrap() * 9 / 10).to_string()).collect();
        format!("reference = [{}]", darker.join(", "))
    };
    colours.lines().map(darker).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_session_in_which_the_cameras_are_set_up_replays_to_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    let camera = "source = \"sim:demo?format=nv12\"\nfps = 15";
    let file = ALL.replace("source = \"sim:still\"", camera);
    let file = format!("{file}{PATIENT}[console]\nlisten = \"127.0.0.1:0\"\n");
    fs::write(dir.path().join("tetrad.toml"), file).unwrap();
    let operator = Operator::start(dir.path(), "--hold-to-run console --record session.mcap");
    operator.until("tracking", |operator| tracked_after(operator, 0));
    operator.until("balls in both cameras", |operator| {
        let (status, told) = operator.post("/api/setup/find", &json!({}));
        assert_eq!(status, 200, "{told}");
        let said = told["said"].as_str().unwrap_or_default();
        said.contains("found by 2 of 2 cameras").then_some(())
    });
    sets_up(&operator, "/api/setup/use", &json!({}));
    sets_up(&operator, "/api/setup/arm", &json!({ "arm_mm": 82.5 }));
    let colours = operator.get("/api/setup/colours?camera=0");
    let others = darker(&colours);
    assert_ne!(colours, others);
    let (status, told) =
        operator.post("/api/setup/colours", &json!({ "camera": 0, "file": "dark.toml", "text": others }));
    assert_eq!(status, 200, "{told}");
    sets_up(&operator, "/api/setup/use", &json!({ "camera": 0 }));
    let said = operator.end();
    assert!(said.contains("recorded        ") && !said.contains("left out        "), "{said}");

    let ran = tetrad(dir.path(), "replay session.mcap --out out").done();
    for what in ["left observations", "right observations", "instants", "poses"] {
        let line = ran.stdout.lines().find_map(|line| line.strip_prefix(what)).unwrap_or_default();
        let count = line.split_whitespace().next().and_then(|count| count.parse::<u64>().ok());
        assert!(line.contains(" identical, hash ") && count > Some(45), "{what}: {ran:#?}");
    }

    // each stands before the first picture, or instant, that it counts for
    let all = entries(&dir.path().join("session.mcap"));
    let mut counts = [0; 3];
    for (at, entry) in all.iter().enumerate() {
        let (kind, counts_for) = match entry.topic {
            Topic::Taught(camera) => (camera, Topic::Image(camera)),
            Topic::HandBegins => (2, Topic::Hand),
            _ => continue,
        };
        counts[kind] += 1;
        let first = all[at..].iter().find(|later| later.topic == counts_for).unwrap();
        assert_eq!(first.sequence, entry.sequence, "{:?}", entry.topic);
    }
    assert_eq!(counts, [2, 1, 3], "the left camera twice, the right once, the hand each time");

    // and without them it is another session
    let mut reader = Reader::open(&dir.path().join("session.mcap")).unwrap();
    let tape = Tape::start(&dir.path().join("less.mcap"), &reader.beginning().message()).unwrap();
    while let Some(Entry { topic, time_us, sequence, mut bytes, .. }) = reader.next_entry().unwrap() {
        if !matches!(topic, Topic::Taught(_) | Topic::HandBegins) {
            tape.feed().put(topic, time_us, sequence, |into| into.append(&mut bytes));
        }
    }
    tape.finish(BTreeMap::new()).unwrap();
    tetrad(dir.path(), "replay less.mcap --out out").refused(1, &["are not those that were recorded"]);
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
    // nor over a result that is not there yet
    let own = ["--record out/../out/arm_state.csv and the result out/arm_state.csv", "same file"];
    let twice = "--hold-to-run always --out out --record out/../out/arm_state.csv";
    run(dir.path(), ALL, twice).refused(2, &own);
    assert_eq!(fs::read_dir(dir.path().join("out")).unwrap().count(), 0, "nothing was begun");
    let away = ALL
        .replace("sim:still\"\nview", "/dev/video99\"\nview")
        .replace("view = \"right\"", "colours = \"no.toml\"");
    run(dir.path(), &away, "--hold-to-run always").refused(2, &["no.toml"]);
}

/// A file of colours that can be meant.
fn colours() -> String {
    let ball = |(name, colour): (&str, &str)| {
        let colours = format!("reference = [{colour}]\ntypical = [{colour}]\nbackground = [120, 118, 110]");
        format!("[{name}]\n{colours}\ndiameter_px = 16.5\n")
    };
    let balls = [("red", "203, 41, 52"), ("green", "41, 203, 52"), ("blue", "41, 52, 203")];
    balls.into_iter().chain([("yellow", "203, 203, 52")]).map(ball).collect()
}

/// The station's file names its files from its own folder, --record from where the program is run.
#[test]
fn nothing_that_the_run_reads_is_recorded_over() {
    let dir = tempfile::tempdir().unwrap();
    let camera = "[[operator.camera]]\nsource = ";
    let station = format!(
        "[station]\nname = \"operator\"\nkeys = \"keys\"\n\
         [camera]\nsource = \"sim:still\"\ncolours = \"own.toml\"\n\
         [operator]\narm_mm = 80\nslave = \"here\"\n\
         {camera}\"clip.mcap\"\nscene = \"scene.json\"\n\
         {camera}\"frames\"\ncolours = \"frames.toml\"\n\
         [console]\nlisten = \"127.0.0.1:0\"\ntoken_file = \"token\"\n\
         certificate = \"console.pem\"\nkey = \"console.key\"\n\
         [slave]\nport = \"dry-run:station/points.csv\"\n\
         [[slave.camera]]\nsource = \"eye.y4m\"\n"
    );
    let balls = json!({ "red": [9, 9], "green": [19, 9], "blue": [29, 9], "yellow": [39, 9] });
    let (scene, own) = (json!({ "seeds": { "left": balls } }).to_string(), colours());
    let keys = "and [station] keys station/keys/";
    let files = [
        ("tetrad.toml", station.as_str(), "and --config station/tetrad.toml"),
        ("own.toml", own.as_str(), "and the colours station/own.toml"),
        ("clip.mcap", "a session", "and [[operator.camera]] source station/clip.mcap"),
        ("scene.json", scene.as_str(), "and the scene station/scene.json"),
        ("frames/0001.png", "a picture", "is read with [[operator.camera]] source station/frames"),
        ("frames.toml", own.as_str(), "and the colours station/frames.toml"),
        ("token", "a secret", "and [console] token_file station/token"),
        ("console.pem", "a certificate", "and [console] certificate station/console.pem"),
        ("console.key", "a key", "and [console] key station/console.key"),
        ("keys/operator.pem", "a certificate", keys),
        ("keys/operator.key", "a key", keys),
        ("keys/authority.pem", "a certificate", keys),
        ("keys/authority.key", "a key", keys),
        ("points.csv", "t,q1,q2,q3,q4,q5,q6\n", "and [slave] port station/points.csv"),
        ("eye.y4m", "a film", "and [[slave.camera]] source station/eye.y4m"),
    ];
    for folder in ["station/keys", "station/frames"] {
        fs::create_dir_all(dir.path().join(folder)).unwrap();
    }
    for (name, text, _) in files {
        fs::write(dir.path().join("station").join(name), text).unwrap();
    }
    let run = "operator --config station/tetrad.toml --hold-to-run always --record";
    for (name, text, why) in files {
        let said = format!("--record station/{name} {why}");
        tetrad(dir.path(), &format!("{run} station/{name}")).refused(2, &[said.as_str(), "would be lost"]);
        let file = dir.path().join("station").join(name);
        assert_eq!(fs::read_to_string(&file).unwrap(), text, "{name} is as it was");
    }
}
