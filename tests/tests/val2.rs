//! Promise: a VAL II controller is driven through its terminal as it wants to be, and what goes wrong
//! on the line stops the arm and says why.
//!
//! The controller at the other end of the pseudo-terminal (`val2/controller.rs`) was written from the
//! notes on the terminal, not from the driver. No arm was ever at the end of this line.

#![cfg(unix)]

#[path = "val2/controller.rs"]
mod controller;
#[path = "val2/pty.rs"]
mod pty;
#[path = "val2/script.rs"]
mod script;

use controller::{Controller, Degrees, READY};
use pty::Emulator;
use std::fs;
use std::time::{Duration, Instant};
use tetrad::robot::val2::{Convention, Val2Config, Val2Port, open};
use tetrad_core::arm::port::{PortError, PortStatus, RobotPort};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::PumaConfig;
use tetrad_tests::repository;

/// What no step of a test takes, however busy the machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// A loaded machine is no reason to stop, a silent controller is found soon.
fn patient() -> Val2Config {
    let (watchdog, timeout) = (Duration::from_secs(10), Duration::from_secs(1));
    Val2Config { watchdog, timeout, ..Val2Config::default() }
}

#[test]
fn golden_scripts_are_said_byte_for_byte() {
    let folder = repository().join("hil-fixtures/data/val2");
    let files = fs::read_dir(&folder).expect("the scripts").flatten().map(|entry| entry.path());
    let mut played = 0;
    for path in files.filter(|path| path.extension().is_some_and(|extension| extension == "txt")) {
        let said = script::play(&path);
        if std::env::var_os("TETRAD_BLESS").is_some() {
            fs::write(&path, &said).expect("the script");
        }
        assert_eq!(said, fs::read_to_string(&path).expect("the script"), "{}", path.display());
        played += 1;
    }
    assert!(played >= 8, "{played} scripts in {}", folder.display());
}

fn opened(emulator: &Emulator, settings: &str) -> Val2Port {
    open(&emulator.address(settings), &PumaConfig::default(), &patient()).expect("a port")
}

/// Waits until the port stands otherwise than `from`.
fn left(port: &Val2Port, from: PortStatus) -> PortStatus {
    let given_up = Instant::now() + PATIENCE;
    while port.status() == from {
        assert!(Instant::now() < given_up, "still {from:?}: {:?}", port.reason());
        std::thread::sleep(Duration::from_millis(2));
    }
    port.status()
}

fn enabled(port: &mut Val2Port) -> PortStatus {
    port.enable().expect("to begin");
    left(port, PortStatus::Enabling)
}

fn reason(port: &Val2Port) -> String {
    port.reason().unwrap_or_default()
}

/// A port at an arm that is ready.
fn ready(emulator: &Emulator, settings: &str) -> Val2Port {
    let mut port = opened(emulator, settings);
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    port
}

/// Leads the arm as a slave station does, by small steps, to `goal` (degrees at the controller), until
/// the controller has it there or the port is no longer ready.
fn lead(
    port: &mut Val2Port,
    emulator: &Emulator,
    at: &mut Joints<f64>,
    goal: &Degrees,
) -> Result<(), PortError> {
    let arm = PumaConfig::default();
    // every session here begins with joint 6 at 0
    let goal_in_model = Convention::at(&READY, &arm).to_model(goal);
    // the first set-point is where the arm is
    port.write_set_point(at)?;
    let given_up = Instant::now() + PATIENCE;
    let near = |joints: &Degrees| joints.iter().zip(goal).all(|(a, b)| (a - b).abs() < 0.0051);
    while !near(&emulator.controller().joints()) {
        assert!(Instant::now() < given_up, "at {:?}: {}", emulator.controller().joints(), reason(port));
        let mut next = *at;
        for ((angle, goal), joint) in next.iter_mut().zip(&goal_in_model).zip(&arm.joints) {
            let step = joint.max_speed_rad_s * 0.01;
            *angle += (goal - *angle).clamp(-step, step);
        }
        match port.write_set_point(&next) {
            Ok(()) => *at = next,
            // further ahead than the arm follows: it has to catch up
            Err(PortError::TooFar(_)) => {}
            Err(error) => return Err(error),
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

/// A walk through the middle of the ranges, never twice the same place.
fn places() -> impl Iterator<Item = Degrees> {
    (1..=50).map(|step| {
        let wave =
            |period: f64, amount: f64| ((f64::from(step) * period).sin() * amount * 100.0).round() / 100.0;
        [
            wave(0.7, 8.0),
            -90.0 + wave(0.5, 9.0),
            90.0 + wave(0.9, 7.0),
            wave(1.1, 12.0),
            20.0 + wave(0.6, 9.0),
            wave(0.3, 20.0),
        ]
    })
}

fn fifty_moves(controller: Controller, settings: &str) {
    let emulator = Emulator::start(controller);
    let mut port = ready(&emulator, settings);
    assert_eq!(emulator.controller().speed(), 30.0);
    let mut at = port.read_joints().expect("a reading").joints;
    for goal in places() {
        lead(&mut port, &emulator, &mut at, &goal)
            .unwrap_or_else(|error| panic!("{error}: {}", reason(&port)));
        let arrived = emulator.controller().visited.last().copied().expect("a move");
        assert!(arrived.iter().zip(&goal).all(|(a, b)| (a - b).abs() < 0.0051), "{arrived:?} {goal:?}");
    }
    // every move on the way was a short one, and went through the controller's own point
    let visited = emulator.controller().visited.clone();
    assert!(visited.len() >= 50 && visited.len() as u64 == port.moves().count(), "{}", visited.len());
    let mut last = READY;
    for place in &visited {
        for ((a, b), joint) in place.iter().zip(&last).zip(&PumaConfig::default().joints) {
            let most = (joint.max_speed_rad_s * 0.3 * 0.25).to_degrees() + 0.011;
            assert!((a - b).abs() <= most, "{last:?} {place:?}");
        }
        last = *place;
    }
    assert_eq!(port.status(), PortStatus::Ready, "{}", reason(&port));
}

#[test]
fn fifty_places_are_moved_to_by_point() {
    fifty_moves(Controller::running(), "where=500");
}

#[test]
fn fifty_places_are_moved_to_by_ppoint() {
    fifty_moves(Controller::plus(), "where=500&dialect=ppoint");
}

#[test]
fn what_where_says_is_what_is_read() {
    let mut controller = Controller::running();
    controller.put([30.0, -120.0, 60.0, -20.0, 45.0, 100.0]);
    let emulator = Emulator::start(controller);
    let mut port = ready(&emulator, "where=100");
    let q = port.read_joints().expect("a reading").joints.map(f64::to_degrees);
    let expected = [30.0, 60.0, -120.0, -20.0, 45.0, -80.0];
    assert!(q.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-9), "{q:?}");
    // and it is asked again
    emulator.controller().put([31.0, -120.0, 60.0, -20.0, 45.0, 100.0]);
    let given_up = Instant::now() + PATIENCE;
    while (port.read_joints().expect("a reading").joints[0].to_degrees() - 31.0).abs() > 1e-9 {
        assert!(Instant::now() < given_up, "never read again");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Where the arm is led to in what follows, and a place beyond.
const NEAR: Degrees = [5.0, -90.0, 90.0, 0.0, 10.0, 0.0];
const FAR: Degrees = [20.0, -80.0, 90.0, 0.0, 20.0, 0.0];

#[test]
fn an_error_text_is_quoted_and_stops_the_arm_until_it_is_enabled() {
    let emulator = Emulator::start(Controller::running());
    let mut port = ready(&emulator, "");
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &NEAR).expect("to get there");
    emulator.controller().refuse = Some("*Robot power is off*".to_owned());
    let refused = lead(&mut port, &emulator, &mut at, &FAR).expect_err("refused");
    assert!(matches!(refused, PortError::NotReady(PortStatus::Fault(_))), "{refused:?}");
    assert!(reason(&port).contains("*Robot power is off*"), "{}", reason(&port));
    let before = emulator.so_far();
    emulator.with(|controller| controller.print("\r\n.\r\n."));
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(emulator.so_far(), before);
    // enabled, it stands where it is and goes on from there
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    assert_eq!(emulator.so_far().0, before.0);
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &FAR).expect("to get there");
}

#[test]
fn silence_is_a_loss_and_nothing_is_gone_to_when_it_ends() {
    let emulator = Emulator::start(Controller::running());
    let mut port = ready(&emulator, "");
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &NEAR).expect("to get there");
    emulator.controller().silent = true;
    let lost = lead(&mut port, &emulator, &mut at, &FAR).expect_err("lost");
    assert_eq!(lost, PortError::NotReady(PortStatus::Lost));
    assert!(reason(&port).contains("did not answer"), "{}", reason(&port));
    assert_eq!(port.read_joints(), Err(PortError::Lost));
    let visited = emulator.controller().visited.len();
    emulator.controller().silent = false;
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(port.status(), PortStatus::Lost, "it does not come back by itself");
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    assert_eq!(emulator.controller().visited.len(), visited);
    // also where nobody ever answers
    emulator.controller().silent = true;
    assert_eq!(enabled(&mut port), PortStatus::Lost);
}

#[test]
fn a_pulled_cable_is_a_loss_and_enabling_opens_the_line_again() {
    let mut emulator = Emulator::start(Controller::running());
    let mut port = ready(&emulator, "");
    emulator.unplug();
    assert_eq!(left(&port, PortStatus::Ready), PortStatus::Lost);
    assert!(reason(&port).contains("ttyVAL"), "{}", reason(&port));
    assert_eq!(enabled(&mut port), PortStatus::Lost, "there is no line");
    assert!(reason(&port).contains("cannot be opened"), "{}", reason(&port));
    emulator.plug();
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &NEAR).expect("to get there");
}

#[test]
fn a_controller_that_restarts_has_to_be_calibrated_and_is_only_when_asked() {
    let emulator = Emulator::start(Controller::running());
    let mut port = ready(&emulator, "");
    emulator.with(Controller::restart);
    assert_eq!(left(&port, PortStatus::Ready), PortStatus::Lost);
    assert_eq!(enabled(&mut port), PortStatus::NotHomed);
    assert!(reason(&port).contains("calibrate=yes"), "{}", reason(&port));
    assert!(!emulator.controller().typed.iter().any(|line| line == "CAL"));
    drop(port);
    let port = ready(&emulator, "calibrate=yes");
    // a fresh port cannot know of the restart: the controller has been asked nothing that tells
    assert!(!emulator.controller().typed.iter().any(|line| line == "CAL"));
    drop(port);
    emulator.with(Controller::restart);
    let mut port = ready(&emulator, "calibrate=yes");
    assert!(emulator.controller().typed.iter().any(|line| line == "CAL"));
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &NEAR).expect("to get there");
}

#[test]
fn an_arm_that_is_not_calibrated_says_so_at_the_first_move() {
    let emulator = Emulator::start(Controller::running());
    // its questions were answered by somebody else
    emulator.with(|controller| {
        controller.restart();
        controller.hear(b"n\rn\r");
        Vec::new()
    });
    let mut port = ready(&emulator, "calibrate=yes");
    let mut at = port.read_joints().expect("a reading").joints;
    let refused = lead(&mut port, &emulator, &mut at, &NEAR).expect_err("not calibrated");
    assert_eq!(refused, PortError::NotReady(PortStatus::NotHomed));
    assert!(reason(&port).contains("*Arm not calibrated*"), "{}", reason(&port));
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    assert!(emulator.controller().typed.iter().any(|line| line == "CAL"));
}

#[test]
fn a_character_lost_either_way_never_sends_the_arm_elsewhere() {
    let emulator = Emulator::start(Controller::plus());
    let mut port = opened(&emulator, "dialect=ppoint&where=60000&timeout=600");
    for lost in 0..24 {
        emulator.controller().put(READY);
        assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
        emulator.controller().visited.clear();
        let mut at = port.read_joints().expect("a reading").joints;
        {
            let mut controller = emulator.controller();
            let place = Some(1 + lost / 2 * 5);
            *(if lost % 2 == 0 { &mut controller.lose_in } else { &mut controller.lose_out }) = place;
        }
        let led = lead(&mut port, &emulator, &mut at, &NEAR);
        // on the straight way from READY to NEAR, wherever the character was lost
        for place in &emulator.controller().visited {
            let expected = [place[0], -90.0, 90.0, 0.0, place[4], 0.0];
            assert!(*place == expected && (0.0..=5.0).contains(&place[0]), "{lost}: {place:?}");
            assert!((0.0..=10.0).contains(&place[4]), "{lost}: {place:?}");
        }
        match led {
            Ok(()) => {}
            // told by its echo, by silence, or by the controller, for which it was no command
            Err(PortError::NotReady(PortStatus::Lost | PortStatus::Fault(_))) => {}
            Err(error) => panic!("{lost}: {error}: {}", reason(&port)),
        }
        let mut controller = emulator.controller();
        (controller.lose_in, controller.lose_out) = (None, None);
    }
}

#[test]
fn half_a_line_that_was_left_does_not_move_the_arm() {
    let emulator = Emulator::start(Controller::running());
    emulator.with(|controller| {
        controller.hear(b"POINT #P\r40,-90,90,0,0,0\r\rDO MOVE #P");
        Vec::new()
    });
    let mut port = opened(&emulator, "");
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    assert_eq!(emulator.controller().visited, Vec::<Degrees>::new());
    assert_eq!(emulator.controller().joints(), READY);
}

#[test]
fn a_stop_lets_the_move_under_way_end_and_sends_no_other() {
    let emulator = Emulator::start(Controller::plus());
    let mut port = ready(&emulator, "dialect=ppoint&timeout=60000");
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &NEAR).expect("to get there");
    emulator.controller().hold = true;
    let held = emulator.controller().visited.len() + 1;
    let given_up = Instant::now() + PATIENCE;
    while emulator.controller().visited.len() < held {
        assert!(Instant::now() < given_up, "never moved");
        at[0] += 0.005;
        port.write_set_point(&at).expect("taken");
        std::thread::sleep(Duration::from_millis(5));
    }
    port.stop().expect("stopped");
    assert_eq!(port.status(), PortStatus::Stopped);
    assert!(reason(&port).contains("finishes the move under way"), "{}", reason(&port));
    assert_eq!(port.write_set_point(&at), Err(PortError::NotReady(PortStatus::Stopped)));
    emulator.with(Controller::release);
    let given_up = Instant::now() + PATIENCE;
    while port.reason().is_some() {
        assert!(Instant::now() < given_up, "the prompt was not seen");
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(50));
    assert_eq!(emulator.controller().visited.len(), held);
    // the first set-point after it is where the arm is, not where it was going
    assert_eq!(enabled(&mut port), PortStatus::Ready, "{}", reason(&port));
    at[0] += 0.2;
    assert!(matches!(port.write_set_point(&at), Err(PortError::TooFar(1))));
}

#[test]
fn what_cannot_be_opened_is_named() {
    let said = |address: &str| match open(address, &PumaConfig::default(), &Val2Config::default()) {
        Ok(_) => panic!("{address} was opened"),
        Err(error) => error.to_string(),
    };
    assert!(said("val2:/dev/no-such-port").contains("/dev/no-such-port"));
    assert!(said("val2:/dev/no-such-port?speed=200").contains("speed"));
    let emulator = Emulator::start(Controller::running());
    let _first = opened(&emulator, "");
    assert!(said(&emulator.address("")).contains("another program"), "the line is for one program");
}

#[test]
fn every_byte_is_in_the_log_and_a_point_is_as_long_as_the_rate_that_is_promised() {
    let emulator = Emulator::start(Controller::plus());
    let log = emulator.folder().join("val2.log");
    let mut port = ready(&emulator, &format!("dialect=ppoint&log={}", log.display()));
    assert!(port.notice().contains("10 points a second at best"), "{}", port.notice());
    let mut at = port.read_joints().expect("a reading").joints;
    lead(&mut port, &emulator, &mut at, &FAR).expect("to get there");
    drop(port);
    let text = fs::read_to_string(&log).expect("the log");
    let sent: String = text.lines().filter_map(|line| line.get(13..)?.strip_prefix("> ")).collect();
    let typed: String = emulator.controller().typed.iter().map(|line| format!("{line}\\r")).collect();
    assert_eq!(sent, typed);
    assert!(text.contains(" < "), "what came is there too");
    // 9600 baud are 960 characters a second
    let longest = typed.split("\\r").map(str::len).max().unwrap_or_default() + "DO MOVE #P".len() + 2;
    assert!((60..=96).contains(&longest), "{longest} characters a point");
}
