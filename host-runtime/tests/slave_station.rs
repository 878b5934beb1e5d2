//! Promise: `tetrad slave` with a station's file moves its arm by the one operator it names, tells what
//! the arm does, and brings it to rest before it ends.
//!
//! Timeouts are long here: a test's machine may stand still for a while, an arm's must not.
#![cfg(unix)]

mod common;

use common::{command, tetrad};
use std::fs::{self, File};
use std::net::UdpSocket;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tetrad::link::{Carrier as _, Identity, Link, LinkConfig, Peer, PeerConfig};
use tetrad::robot::clock::Clock;
use tetrad::station::SlaveAnnouncement;
use tetrad_core::wire::{ArmState, ArmStatePacket, ButtonsPacket, MotionPacket};
use tetrad_fixtures::packets;

const LONG: Duration = Duration::from_secs(30);

/// A slave's process; dropped, it is killed.
struct Slave(Child);

impl Drop for Slave {
    fn drop(&mut self) {
        // one that has ended is not there to be killed
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn keys(dir: &Path) {
    tetrad(dir, "keys --out keys authority").done();
    for name in ["operator", "slave"] {
        tetrad(dir, &format!("keys --out keys station {name}")).done();
    }
}

/// The slave's file, and where it listens.
fn file(dir: &Path, slave: &str) -> String {
    // a port that nobody has at the moment
    let address = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).unwrap().to_string();
    let text = format!(
        "[station]\nname = \"slave\"\nkeys = \"keys\"\nlisten = \"{address}\"\n[[peer]]\nname = \"operator\"\n\
         [slave]\noperator = \"operator\"\n{slave}\n\
         [teleop]\ncommand_timeout_ms = 4000\nhold_to_run_timeout_ms = 4000\nresume_ms = 5000\n"
    );
    fs::write(dir.join("tetrad.toml"), text).unwrap();
    address
}

fn start(dir: &Path, more: &str) -> Slave {
    let mut command = command(&format!("slave --config tetrad.toml {more}"));
    let log = |name: &str| File::create(dir.join(name)).unwrap();
    command.current_dir(dir).stdin(Stdio::null()).stdout(log("said")).stderr(log("log"));
    Slave(command.spawn().unwrap())
}

/// The operator's end of the link.
struct Operator {
    link: Link,
    slave: Peer,
    motion: MotionPacket,
    buttons: ButtonsPacket,
    state: Option<ArmStatePacket>,
}

impl Operator {
    fn dial(dir: &Path, address: String) -> Self {
        let identity = Identity::load(&dir.join("keys"), &"operator".parse().unwrap()).unwrap();
        let name: tetrad::link::StationName = "slave".parse().unwrap();
        let peers = vec![PeerConfig { name: name.clone(), address: Some(address) }];
        let config = LinkConfig { listen: None, peers, picture_bytes_per_s: 1_000_000 };
        let link = Link::start(&config, &identity, Clock::wall()).unwrap();
        let session = link.session();
        let (motion, buttons) = (packets::motion(session, 0), packets::buttons(session, 0));
        Self { slave: link.peer(&name).unwrap(), link, motion, buttons, state: None }
    }

    /// Sends and listens until the arm's state is as wanted.
    #[track_caller]
    fn until(&mut self, what: &str, wanted: impl Fn(&ArmStatePacket) -> bool) -> ArmStatePacket {
        let began = Instant::now();
        loop {
            self.motion.sequence += 1;
            self.motion.capture_us += 16_667;
            self.buttons.sequence += 1;
            self.slave.send(&self.motion.into()).unwrap();
            self.slave.send(&self.buttons.into()).unwrap();
            std::thread::sleep(Duration::from_millis(16));
            self.state = self.slave.arm_state().map(|state| state.what).or(self.state);
            if let Some(state) = self.state.filter(|state| wanted(state)) {
                return state;
            }
            assert!(began.elapsed() < LONG, "never {what}: {:?}, {:?}", self.state, self.link.events());
        }
    }

    /// Has the arm switched on and latched to the hand.
    fn engage(&mut self) -> ArmStatePacket {
        // the first count that is heard asks for nothing
        self.until("heard", |state| state.state == ArmState::Stopped && state.buttons_age_us.is_some());
        self.buttons.resets += 1;
        self.until("armed", |state| state.state == ArmState::Armed);
        self.buttons.pressed = true;
        self.until("engaged", |state| state.state == ArmState::Engaged && state.command.is_some())
    }
}

fn end(slave: &mut Slave) -> i32 {
    let told = Command::new("kill").args(["-TERM", &slave.0.id().to_string()]).status().unwrap();
    assert!(told.success());
    code(slave)
}

fn code(slave: &mut Slave) -> i32 {
    let began = Instant::now();
    loop {
        if let Some(status) = slave.0.try_wait().unwrap() {
            return status.code().expect("it was not killed");
        }
        assert!(began.elapsed() < LONG, "it does not end");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn an_operator_moves_the_arm_and_the_end_brings_it_to_rest() {
    let dir = tempfile::tempdir().unwrap();
    keys(dir.path());
    let address = file(dir.path(), "port = \"sim:?noise=off&watchdog_ms=5000\"\n[governor]\ncycle_ms = 2");
    let mut slave = start(dir.path(), "--out out");
    let mut operator = Operator::dial(dir.path(), address);
    let start = operator.engage();
    let said = operator.slave.configuration().map(|said| SlaveAnnouncement::decode(&said).unwrap());
    let said = said.expect("the slave says what it is before anything moves");
    assert_eq!((said.port.as_str(), said.moves_an_arm, said.cycle_us), ("sim", false, 2_000));

    operator.motion.since_engage.translation = [0.05, 0.0, 0.02];
    let moved = operator.motion.sequence;
    let there = operator.until("there", |state| {
        let [x, _, z] = [0, 1, 2].map(|axis| state.tool.translation[axis] - start.tool.translation[axis]);
        (x - 0.05).abs() < 1e-4 && (z - 0.02).abs() < 1e-4
    });
    let command = there.command.unwrap();
    assert!(command.sequence > moved && command.session == operator.link.session());
    assert!(command.solved_after_us <= command.written_after_us);
    operator.until("settled", |state| state.settled.is_some_and(|settled| settled.sequence > moved));

    // in the middle of the next movement
    operator.motion.since_engage.translation = [-0.3, 0.0, 0.0];
    operator.until("moving", |state| state.speed_share > 0.5);
    assert_eq!(end(&mut slave), 0);
    let log = fs::read_to_string(dir.path().join("log")).unwrap();
    assert!(log.contains("operator is connected") && log.contains("engaged"), "{log}");
    let text = fs::read_to_string(dir.path().join("out/arm.csv")).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|name| name == "s1").unwrap();
    let set_points = |row: &str| -> Vec<f64> {
        row.split(',').skip(column).take(6).map(|field| field.parse().unwrap()).collect()
    };
    let last: Vec<_> = text.lines().rev().take(2).map(set_points).collect();
    let speed = last[0].iter().zip(&last[1]).map(|(a, b)| (a - b).abs() / 0.002).fold(0.0, f64::max);
    assert!(speed < 0.01, "at rest at the end: {speed} rad/s");
}

#[test]
fn an_arm_that_is_lost_ends_the_station_and_the_operator_is_told() {
    let dir = tempfile::tempdir().unwrap();
    keys(dir.path());
    let address = file(dir.path(), "port = \"sim:?silence=8000ms&watchdog_ms=5000\"");
    let mut slave = start(dir.path(), "");
    let mut operator = Operator::dial(dir.path(), address);
    operator.engage();
    operator.until("at fault", |state| state.state == ArmState::Fault);
    assert_eq!(code(&mut slave), 3);
    let log = fs::read_to_string(dir.path().join("log")).unwrap();
    assert!(log.contains("error: the arm is lost"), "{log}");
}

#[test]
fn a_file_that_cannot_be_meant_is_refused_before_anything_moves() {
    let dir = tempfile::tempdir().unwrap();
    file(dir.path(), "");
    let run = |arguments: &str| tetrad(dir.path(), &format!("slave --config tetrad.toml {arguments}"));
    let keyless = run("--seconds 1");
    assert_eq!(keyless.code, Some(2), "{keyless:#?}");
    let words = ["keys/slave.pem", "`tetrad keys --out keys station slave`"];
    assert!(words.iter().all(|word| keyless.stderr.contains(word)), "{keyless:#?}");
    keys(dir.path());
    run("--packets x.bin").refused(2, &["--packets", "the station operator moves the arm"]);
    run("--hold-to-run sender").refused(2, &["--hold-to-run"]);
    run("--seconds 0.3").done();
    let text = fs::read_to_string(dir.path().join("tetrad.toml")).unwrap();
    fs::write(dir.path().join("tetrad.toml"), text.replace("operator = \"operator\"", "operator = \"x\""))
        .unwrap();
    run("--seconds 1").refused(2, &["[slave] operator", "[[peer]]"]);
}
