//! The port with its threads, on a bus in memory with our own drives: the contract of
//! `tetrad_core::arm::port`.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tetrad::robot::Robot as _;
use tetrad::robot::canopen::bus::{Bus, in_memory};
use tetrad::robot::canopen::{CanopenError, CanopenPort};
use tetrad_core::arm::port::{PortError, PortFault, PortStatus, RobotPort as _};
use tetrad_core::arm::puma560::{Counts, Drives, Joints};
use tetrad_core::config::{CanopenConfig, DrivesConfig, PumaConfig};
use tetrad_fixtures::drive::{Drive, Status};

const START: Joints<f64> = [0.0, 0.785, -3.1, 0.0, 0.785, 0.0];

/// Waits until `check`, at most a minute: for progress, not for speed.
pub(crate) fn wait_for(what: &str, mut check: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !check() {
        assert!(Instant::now() < end, "waited in vain for {what}");
        thread::sleep(Duration::from_millis(1));
    }
}

/// Writes so many set-points about `start`, each once the one before was sent; gives their counts.
pub(crate) fn set_points(port: &mut CanopenPort, start: &Joints<f64>, count: u64) -> Vec<Counts> {
    let before = port.counters().set_points;
    let mut written = Vec::new();
    for k in 1..=count {
        let mut joints = *start;
        for (joint, angle) in (1u8..).zip(&mut joints) {
            *angle += 0.15 * (k as f64 / 40.0 + f64::from(joint)).sin() - 0.15 * f64::from(joint).sin();
        }
        port.write_set_point(&joints).unwrap_or_else(|error| panic!("{error}: {:?}", port.reason()));
        written.push(port.drives().counts(&joints).unwrap());
        wait_for("the cycle", || {
            port.counters().set_points == before + k || port.status() != PortStatus::Ready
        });
    }
    written
}

/// Six drives on a thread.
struct Fleet {
    drives: Arc<Mutex<Vec<Drive>>>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Fleet {
    /// The drives, and the bus for their master.
    fn start() -> (Self, Bus) {
        let mut buses = in_memory(2);
        let (master, mut bus) = (buses.remove(0), buses.remove(0));
        let counts = Drives::new(&DrivesConfig::default()).unwrap().counts(&START).unwrap();
        let drives = (1u8..).zip(counts).map(|(node, count)| Drive::new(node, count)).collect();
        let drives: Arc<Mutex<Vec<Drive>>> = Arc::new(Mutex::new(drives));
        let ended = Arc::new(AtomicBool::new(false));
        let (all, still) = (Arc::clone(&drives), Arc::clone(&ended));
        let thread = thread::spawn(move || {
            let start = Instant::now();
            while !still.load(Ordering::Relaxed) {
                let frame = bus.receive.receive(Duration::from_millis(5));
                let mut out = Vec::new();
                for drive in all.lock().unwrap().iter_mut() {
                    if let Ok(Some(frame)) = &frame {
                        drive.receive(frame, &mut out);
                    }
                    drive.tick(start.elapsed().as_micros() as u64, &mut out);
                }
                bus.transmit.send(&out).unwrap();
            }
        });
        (Self { drives, ended, thread: Some(thread) }, master)
    }

    fn with<T>(&self, look: impl FnOnce(&mut Vec<Drive>) -> T) -> T {
        look(&mut self.drives.lock().unwrap())
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the drives");
        }
    }
}

/// Patient with a machine that is busy, impatient where that is not the question.
fn config() -> CanopenConfig {
    CanopenConfig {
        listen_ms: 50,
        missing_cycles: 50,
        heartbeat_timeout_ms: 2_000,
        watchdog_cycles: 200,
        enable_timeout_ms: 20_000,
        ..CanopenConfig::default()
    }
}

fn open_once(bus: Bus) -> CanopenPort {
    let bus = Mutex::new(Some(bus));
    let opener = move || bus.lock().unwrap().take().ok_or_else(|| io::Error::other("unplugged"));
    CanopenPort::start(Box::new(opener), &PumaConfig::default(), &config()).unwrap()
}

fn ready() -> (Fleet, CanopenPort) {
    let (fleet, bus) = Fleet::start();
    let mut port = open_once(bus);
    port.enable().unwrap();
    wait_for("the arm", || port.status() == PortStatus::Ready);
    (fleet, port)
}

#[test]
fn set_points_in_radians_arrive_in_counts() {
    let (fleet, mut port) = ready();
    let written = set_points(&mut port, &START, 60);
    let last = *written.last().unwrap();
    wait_for("the drives", || fleet.with(|drives| drives.iter().map(Drive::position).eq(last)));
    let motors = *port.drives();
    wait_for("the positions", || motors.counts(&port.read_joints().unwrap().joints) == Ok(last));
    let report = port.report();
    assert!(report[0].contains("60 set-points sent, late by"), "{report:?}");
}

#[test]
fn a_set_point_that_cannot_be_is_refused_and_not_gone_to() {
    let (fleet, mut port) = ready();
    let refused = |port: &mut CanopenPort, change: &dyn Fn(&mut Joints<f64>)| {
        let mut joints = START;
        change(&mut joints);
        port.write_set_point(&joints).unwrap_err()
    };
    assert_eq!(refused(&mut port, &|q| q[3] = f64::NAN), PortError::NotFinite(4));
    assert_eq!(refused(&mut port, &|q| q[1] = 4.0), PortError::OutOfRange(2));
    assert_eq!(refused(&mut port, &|q| q[0] = 0.2), PortError::TooFar(1));
    port.write_set_point(&START).unwrap();
    let counts = port.drives().counts(&START).unwrap();
    assert!(fleet.with(|drives| drives.iter().map(Drive::position).eq(counts)));
}

#[test]
fn a_stop_is_obeyed_at_once_and_what_was_written_is_forgotten() {
    let (fleet, mut port) = ready();
    set_points(&mut port, &START, 20);
    port.stop().unwrap();
    assert_eq!(port.write_set_point(&START), Err(PortError::NotReady(PortStatus::Stopped)));
    wait_for("the drives", || {
        fleet.with(|drives| drives.iter().all(|drive| drive.rests() && drive.targets.len() > 1))
    });
    wait_for("the reason", || port.reason().is_some_and(|reason| reason.starts_with("stopped as asked")));
    let stands = fleet.with(|drives| drives.iter().map(Drive::position).collect::<Vec<_>>());
    port.enable().unwrap();
    assert_eq!(port.status(), PortStatus::Enabling);
    wait_for("the arm", || port.status() == PortStatus::Ready);
    assert_eq!(fleet.with(|drives| drives.iter().map(Drive::position).collect::<Vec<_>>()), stands);
}

/// Who drives by the port's beat gives no cycle two set-points: none is overwritten before it was sent,
/// and the drives get each of them in its order.
#[test]
fn by_the_beat_every_set_point_reaches_the_drives() {
    let (fleet, mut port) = ready();
    let before = port.counters().set_points;
    let mut wanted = Vec::new();
    port.pace(Instant::now());
    for k in 1..=200 {
        let mut joints = START;
        joints[0] += 0.002 * f64::from(k);
        port.write_set_point(&joints).unwrap_or_else(|error| panic!("{error}: {:?}", port.reason()));
        wanted.push(port.drives().counts(&joints).unwrap()[0]);
        port.pace(Instant::now() + Duration::from_secs(5));
    }
    assert_eq!(port.counters().set_points - before, 200);
    wait_for("the last", || fleet.with(|drives| drives[0].targets.last() == wanted.last()));
    let mut got = fleet.with(|drives| drives[0].targets.clone());
    // a cycle without one repeats the last: that is a test's machine that stood still
    got.dedup();
    assert!(got.ends_with(&wanted), "{got:?}");
}

#[test]
fn a_closed_port_leaves_the_arm_at_rest() {
    let (fleet, mut port) = ready();
    set_points(&mut port, &START, 20);
    drop(port);
    let braked = |drive: &Drive| drive.history.contains(&Status::QuickStop) && drive.rests();
    wait_for("the drives", || fleet.with(|drives| drives.iter().all(braked)));
}

/// A program that enables in a loop does not reset what nobody has seen.
#[test]
fn a_new_fault_is_not_reset_before_it_can_have_been_read() {
    let (fleet, bus) = Fleet::start();
    fleet.with(|drives| drives[5].fail(0x7305, &mut Vec::new()));
    let mut port = open_once(bus);
    let fault = PortFault { joint: Some(6), code: 0x7305 };
    wait_for("the fault", || port.status() == PortStatus::Fault(fault));
    assert_eq!(port.enable(), Err(PortError::Refused(fault)));
    assert_eq!(port.status(), PortStatus::Fault(fault));
    assert_eq!(fleet.with(|drives| drives[5].status), Status::Fault);
    wait_for("the reset", || port.enable() == Ok(()));
    wait_for("the arm", || port.status() == PortStatus::Ready);
}

/// One drive is gone, not the controller: the others are read and told to stop.
#[test]
fn with_one_drive_silent_the_others_are_stopped_and_it_says_which() {
    let (fleet, mut port) = ready();
    set_points(&mut port, &START, 5);
    fleet.with(|drives| drives[2].faults.dead = true);
    wait_for("the loss", || {
        // without set-points it would stop for that
        let _ = port.read_joints().and_then(|reading| port.write_set_point(&reading.joints));
        port.status() == PortStatus::Lost
    });
    assert_eq!(port.stop(), Ok(()));
    assert!(port.read_joints().is_ok());
    wait_for("who obeyed", || {
        port.reason().is_some_and(|reason| {
            reason.contains("stopped: joints 1, 2, 4, 5, 6; not known to have stopped: joint 3,")
        })
    });
}

#[test]
fn an_adapter_that_is_pulled_is_a_loss_and_enabling_tries_to_open_it_again() {
    let (fleet, mut port) = ready();
    set_points(&mut port, &START, 5);
    // the other end of a bus in memory is gone
    drop(fleet);
    wait_for("the loss", || port.status() == PortStatus::Lost);
    assert_eq!(port.read_joints(), Err(PortError::Lost));
    wait_for("the bus", || {
        // refused until somebody can have read it
        let _ = port.enable();
        port.reason().is_some_and(|reason| reason.starts_with("the CAN bus is gone: unplugged"))
    });
    wait_for("the status", || port.status() == PortStatus::Lost);
}

#[test]
fn a_bus_that_cannot_be_opened_says_what_to_do() {
    let opener = || Err(io::Error::from(io::ErrorKind::NotFound));
    let opened = CanopenPort::start(Box::new(opener), &PumaConfig::default(), &CanopenConfig::default());
    let error = opened.unwrap_err();
    assert!(
        matches!(error, CanopenError::Open(_)) && error.to_string().contains("ip link set can0 up"),
        "{error}"
    );
}
