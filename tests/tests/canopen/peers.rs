//! Against PyPI `canopen`, which nobody here wrote: as six drives, and as the master of one of ours.
//! Over CAN adapters at pseudo terminals, in real time.

use super::hub::Hub;
use super::port::{set_points, wait_for};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use tetrad::robot::Robot as _;
use tetrad::robot::canopen::bus::open_slcan;
use tetrad::robot::canopen::{CanopenPort, open};
use tetrad_core::arm::port::{PortFault, PortStatus, RobotPort as _};
use tetrad_core::arm::puma560::{Counts, Drives, Joints};
use tetrad_core::config::{CanopenConfig, DrivesConfig, PumaConfig};
use tetrad_fixtures::drive::{Drive, Status};
use tetrad_tests::{peers, repository, skip};

/// Away from zero, so that wrong signs and places show.
const START: Joints<f64> = [0.2, 0.9, -2.9, -0.3, 0.7, 0.4];

/// A machine that does something else as well may hold a thread up for a long time.
fn patient() -> CanopenConfig {
    CanopenConfig {
        heartbeat_ms: 100,
        heartbeat_timeout_ms: 1_500,
        missing_cycles: 60,
        watchdog_cycles: 1_000,
        sdo_timeout_ms: 3_000,
        enable_timeout_ms: 20_000,
        ..CanopenConfig::default()
    }
}

fn start_counts() -> Counts {
    Drives::new(&DrivesConfig::default()).unwrap().counts(&START).unwrap()
}

/// Six drives in Python.
struct PythonDrives {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl PythonDrives {
    fn start(python: &std::path::Path, port: &str) -> Self {
        let mut child = Command::new(python)
            .arg(repository().join("tests/peers/canopen_drives.py"))
            .arg(port)
            .args(start_counts().map(|count| count.to_string()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the drives");
        let (input, output) = (child.stdin.take().unwrap(), BufReader::new(child.stdout.take().unwrap()));
        let mut drives = Self { child, input, output };
        assert_eq!(drives.line(), "ready");
        drives
    }

    fn line(&mut self) -> Value {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("a line");
        serde_json::from_str(&line).expect("JSON")
    }

    fn tell(&mut self, command: &str) -> Value {
        writeln!(self.input, "{command}").expect("a drive that listens");
        self.line()
    }

    fn states(&mut self) -> Vec<String> {
        let told = self.tell("state");
        told.as_array().unwrap().iter().map(|drive| drive["state"].as_str().unwrap().to_owned()).collect()
    }

    /// Waits until all but `except` (a node) have stopped, by a quick stop.
    fn assert_others_stop(&mut self, except: Option<usize>) {
        let stopped = |drives: &mut Self| {
            let states = drives.states();
            let others = states.iter().enumerate().filter(|(place, _)| Some(place + 1) != except);
            others.into_iter().all(|(_, state)| state == "switch on disabled" || state == "quick stop")
        };
        wait_for("the others to stop", || stopped(self));
        for (place, drive) in self.tell("state").as_array().unwrap().iter().enumerate() {
            let history = drive["history"].as_array().unwrap();
            assert!(
                Some(place + 1) == except || history.contains(&Value::from("quick stop")),
                "node {}: {history:?}",
                place + 1
            );
        }
    }
}

impl Drop for PythonDrives {
    fn drop(&mut self) {
        // whether it ended by itself matters to nobody
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A bus with an arm that is ready, or `None` where the peers are missing.
fn ready(test: &str) -> Option<(Hub, PythonDrives, CanopenPort)> {
    let Some(python) = peers::python() else {
        skip(test, peers::MISSING);
        return None;
    };
    let hub = Hub::new(2);
    let drives = PythonDrives::start(&python, hub.name(0));
    let address = format!("canopen+slcan:{}", hub.name(1)).parse().unwrap();
    let mut port = open(&address, &PumaConfig::default(), &patient()).unwrap();
    port.enable().unwrap();
    wait_for("the arm", || {
        assert!(!matches!(port.status(), PortStatus::Fault(_) | PortStatus::Lost), "{:?}", port.reason());
        port.status() == PortStatus::Ready
    });
    Some((hub, drives, port))
}

/// Without what is the same as the one before.
fn changes(values: impl IntoIterator<Item = i32>) -> Vec<i32> {
    let mut changes: Vec<i32> = values.into_iter().collect();
    changes.dedup();
    changes
}

#[test]
fn python_drives_get_a_thousand_set_points_to_the_count() {
    let name = "canopen::peers::python_drives_get_a_thousand_set_points_to_the_count";
    let Some((_hub, mut drives, mut port)) = ready(name) else { return };
    let written = set_points(&mut port, &START, 1_000);
    assert_eq!(port.counters().set_points, 1_000);
    let start = start_counts();
    let last = *written.last().unwrap();
    wait_for("the last set-point", || {
        drives.tell("targets 1").as_array().unwrap().last() == Some(&last[0].into())
    });
    for joint in 0..6 {
        let told = drives.tell(&format!("targets {}", joint + 1));
        let got = told.as_array().unwrap().iter().map(|target| target.as_i64().unwrap() as i32);
        let wanted = std::iter::once(start[joint]).chain(written.iter().map(|counts| counts[joint]));
        assert_eq!(changes(got), changes(wanted), "joint {}", joint + 1);
    }
    let motors = *port.drives();
    wait_for("the arm", || motors.counts(&port.read_joints().unwrap().joints) == Ok(last));
    for line in port.report() {
        println!("{line}");
    }
}

#[test]
fn a_python_drive_in_fault_stops_the_others() {
    let Some((_hub, mut drives, mut port)) =
        ready("canopen::peers::a_python_drive_in_fault_stops_the_others")
    else {
        return;
    };
    set_points(&mut port, &START, 50);
    drives.tell("fault 4 0x8611");
    let fault = PortStatus::Fault(PortFault { joint: Some(4), code: 0x8611 });
    wait_for("the fault", || port.status() == fault);
    drives.assert_others_stop(Some(4));
    let reason = port.reason().unwrap();
    println!("{reason}");
    assert!(
        reason.starts_with("the drive of joint 4 (node 4) is in fault 0x8611 (following error"),
        "{reason}"
    );
    // its cause is gone: back, where the arm is
    wait_for("the reset", || port.enable() == Ok(()));
    wait_for("the arm", || port.status() == PortStatus::Ready);
}

#[test]
fn a_python_drive_that_falls_silent_stops_the_others() {
    let name = "canopen::peers::a_python_drive_that_falls_silent_stops_the_others";
    let Some((_hub, mut drives, mut port)) = ready(name) else { return };
    set_points(&mut port, &START, 50);
    drives.tell("silence 2");
    wait_for("the loss", || port.status() == PortStatus::Lost);
    drives.assert_others_stop(Some(2));
    let reason = port.reason().unwrap();
    println!("{reason}");
    assert!(reason.starts_with("the drive of joint 2 (node 2) does not answer"), "{reason}");
}

#[test]
fn when_the_bus_is_cut_python_drives_stop_by_themselves() {
    let name = "canopen::peers::when_the_bus_is_cut_python_drives_stop_by_themselves";
    let Some((hub, mut drives, mut port)) = ready(name) else { return };
    set_points(&mut port, &START, 50);
    hub.cut();
    wait_for("the loss", || port.status() == PortStatus::Lost);
    let reason = port.reason().unwrap();
    println!("{reason}");
    assert!(reason.starts_with("no drive answers; check the bus cable"), "{reason}");
    drives.assert_others_stop(None);
}

/// Our own drive, judged by somebody else's master: what the tests in simulated time rest on.
#[test]
fn pythons_master_takes_our_drive_for_one() {
    let Some(python) = peers::python() else {
        return skip("canopen::peers::pythons_master_takes_our_drive_for_one", peers::MISSING);
    };
    let hub = Hub::new(2);
    let ended = AtomicBool::new(false);
    let adapter = hub.name(0).to_owned();
    let run = || {
        let mut bus = open_slcan(&adapter, 115_200, 1_000_000).unwrap();
        let mut drive = Drive::new(9, -777);
        let start = Instant::now();
        while !ended.load(Ordering::Relaxed) {
            let mut out = Vec::new();
            if let Some(frame) = bus.receive.receive(Duration::from_millis(5)).unwrap() {
                drive.receive(&frame, &mut out);
            }
            if drive.targets.last() == Some(&4242) && drive.status == Status::OperationEnabled {
                drive.fail(0x8611, &mut out);
            }
            drive.tick(start.elapsed().as_micros() as u64, &mut out);
            bus.transmit.send(&out).unwrap();
        }
        drive
    };
    thread::scope(|scope| {
        let drive = scope.spawn(run);
        let mut referee = Command::new(python);
        referee.arg(repository().join("tests/peers/canopen_referee.py")).args([hub.name(1), "9"]);
        let judged = referee.output().expect("the referee");
        ended.store(true, Ordering::Relaxed);
        let drive = drive.join().unwrap();
        let said = format!(
            "{}{}{:?}",
            String::from_utf8_lossy(&judged.stdout),
            String::from_utf8_lossy(&judged.stderr),
            drive.history
        );
        assert!(judged.status.success() && said.starts_with("passed"), "{said}");
        assert!(drive.history.contains(&Status::Fault) && drive.history.contains(&Status::QuickStop));
    });
}
