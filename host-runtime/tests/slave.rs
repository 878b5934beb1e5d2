//! Promise: `tetrad slave` brings the arm to where the packets say, and says why where it does not.
//!
//! Timeouts are long here: a test's machine may stand still for a while, an arm's must not.

mod common;

use common::{Clip, Ran, tetrad};
use nalgebra::{Matrix3, Vector3};
use std::fs;
use std::path::Path;
use tetrad_core::geometry::Pose;
use tetrad_core::wire::{MAX_BODY_LEN, MAX_FRAME_LEN, MotionPacket, Packet, Transform, encode, encode_body};
use tetrad_fixtures::packets;

const FRAME_US: u64 = 33_333;

/// Where the hand is at a frame, in the axes it was latched in: a second's way, then at rest.
fn hand(frame: u32) -> Vector3<f32> {
    let share = (frame as f32 / 30.0).min(1.0);
    Vector3::new(0.04, -0.03, 0.02) * share
}

fn packet(frame: u32) -> MotionPacket {
    let pose = |translation| Transform::from(Pose { rotation: Matrix3::identity(), translation });
    MotionPacket {
        capture_us: 5_000_000 + u64::from(frame) * FRAME_US,
        increment: pose(hand(frame) - hand(frame.saturating_sub(1))),
        since_engage: pose(hand(frame)),
        ..packets::motion(9, frame)
    }
}

/// A recording of so many frames; every `damaged`-th has a byte changed.
fn record(file: &Path, frames: u32, damaged: Option<u32>) {
    let mut bytes = Vec::new();
    let mut frame = [0; MAX_FRAME_LEN];
    for number in 0..frames {
        let length = encode(&Packet::Motion(packet(number)), &mut frame).unwrap();
        if damaged.is_some_and(|every| number % every == every - 1) {
            frame[length / 2] ^= 0x10;
        }
        bytes.extend_from_slice(&frame[..length]);
    }
    fs::write(file, bytes).unwrap();
}

/// A frame around any bytes, whole by its check: CRC-16/IBM-3740 behind the body, both stuffed (COBS).
fn sealed(mut body: Vec<u8>) -> Vec<u8> {
    let check = body.iter().fold(u16::MAX, |check, byte| {
        (0..8).fold(check ^ (u16::from(*byte) << 8), |check, _| {
            (check << 1) ^ if check & 0x8000 == 0 { 0 } else { 0x1021 }
        })
    });
    body.extend(check.to_le_bytes());
    let blocks = body.split(|byte| *byte == 0);
    let mut frame = Vec::new();
    for block in blocks {
        frame.push(u8::try_from(block.len() + 1).unwrap());
        frame.extend(block);
    }
    frame.push(0);
    frame
}

const PATIENT: &str = "[teleop]
command_timeout_ms = 4000
hold_to_run_timeout_ms = 4000
resume_ms = 5000
";

fn run(dir: &Path, arguments: &str) -> Ran {
    fs::write(dir.join("tetrad.toml"), PATIENT).unwrap();
    tetrad(dir, &format!("slave --config tetrad.toml --hold-to-run sender {arguments}"))
}

/// The last row of arm.csv by column names.
fn last(dir: &Path) -> impl Fn(&str) -> f64 {
    let text = fs::read_to_string(dir.join("out/arm.csv")).unwrap();
    let header: Vec<String> = text.lines().next().unwrap().split(',').map(str::to_owned).collect();
    let row: Vec<String> = text.lines().last().unwrap().split(',').map(str::to_owned).collect();
    assert_eq!(header.len(), row.len());
    move |name| row[header.iter().position(|column| column == name).unwrap()].parse().unwrap()
}

#[test]
fn the_arm_ends_where_the_packets_lead_whatever_was_damaged() {
    let dir = tempfile::tempdir().unwrap();
    record(&dir.path().join("motion.bin"), 75, Some(5));
    let arguments = "--packets motion.bin --port sim:?noise=off&watchdog_ms=5000 --out out";
    let ran = run(dir.path(), arguments).done();
    assert!(ran.stdout.contains("60 taken, 14 never came"), "{ran:#?}");
    assert!(ran.stdout.contains("15 damaged"), "{ran:#?}");
    assert!(ran.stderr.contains("\nengaged"), "{ran:#?}");
    // from where the arm stands at first, by what the hand moved since the first packet
    let text = fs::read_to_string(dir.path().join("out/arm.csv")).unwrap();
    let header = text.lines().next().unwrap();
    let place = |name: &str| header.split(',').position(|column| column == name).unwrap();
    let first = text.lines().find(|line| line.contains(",engaged,")).unwrap();
    let first = |name: &str| first.split(',').nth(place(name)).unwrap().parse::<f64>().unwrap();
    let last = last(dir.path());
    for (name, measured, moved) in [("x", "mx", 0.04), ("y", "my", -0.03), ("z", "mz", 0.02)] {
        let off = last(name) - first(name) - moved;
        assert!(off.abs() < 1e-6, "{name}: {off}");
        // an encoder's count is a tenth of a millimetre at the tool
        assert!((last(measured) - last(name)).abs() < 1e-3, "{measured}");
    }
}

#[test]
fn what_is_whole_and_yet_of_no_use_is_told_from_what_was_damaged() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("motion.bin");
    let body = |number| {
        let mut body = [0; MAX_BODY_LEN];
        let length = encode_body(&Packet::Motion(packet(number)), &mut body).unwrap();
        body[..length].to_vec()
    };
    let mut of_another_version = body(75);
    of_another_version[0] += 1;
    let mut impossible = body(30);
    let moved = 0.04_f32.to_le_bytes();
    let at = impossible.windows(4).position(|bytes| bytes == moved).expect("the hand's way");
    impossible[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    record(&file, 75, None);
    let mut bytes = fs::read(&file).unwrap();
    assert!(bytes.ends_with(&sealed(body(74))), "sealed as the program does it");
    bytes.extend([sealed(of_another_version), sealed(impossible.clone()), sealed(impossible)].concat());
    fs::write(&file, bytes).unwrap();
    let ran = run(dir.path(), "--packets motion.bin --port sim:?watchdog_ms=5000").done();
    assert!(ran.stdout.contains("75 taken, 0 never came"), "{ran:#?}");
    assert!(ran.stdout.contains("2 with impossible numbers"), "{ran:#?}");
    assert!(ran.stdout.contains("1 not understood"), "{ran:#?}");
    assert!(ran.stdout.contains("update the older one"), "{ran:#?}");
    assert!(!ran.stdout.contains("damaged"), "{ran:#?}");
}

#[test]
fn a_drive_that_faults_ends_it_by_a_safety_rule_with_its_joint() {
    let dir = tempfile::tempdir().unwrap();
    record(&dir.path().join("motion.bin"), 300, None);
    let arguments = "--packets motion.bin --port sim:?fault=3@1500ms&watchdog_ms=5000";
    run(dir.path(), arguments).refused(4, &["fault", "joint 3"]);
}

#[test]
fn a_controller_that_falls_silent_is_a_lost_device() {
    let dir = tempfile::tempdir().unwrap();
    record(&dir.path().join("motion.bin"), 300, None);
    let arguments = "--packets motion.bin --port sim:?silence=1500ms&watchdog_ms=5000";
    run(dir.path(), arguments).refused(3, &["does not answer"]);
}

#[test]
fn what_cannot_be_driven_by_is_refused_before_anything_moves() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), "--packets none.bin").refused(2, &["none.bin", "tetrad track --packets"]);
    record(&dir.path().join("motion.bin"), 3, None);
    run(dir.path(), "--packets motion.bin --port puma").refused(2, &["puma"]);
    run(dir.path(), "--packets motion.bin --seconds 0").refused(2, &["--seconds"]);
    run(dir.path(), "--packets motion.bin --port val2:/dev/ttyUSB0")
        .refused(2, &["somebody has to hold the button"]);
    fs::write(dir.path().join("bad.toml"), "[teleop]\nscael = 1.0\n").unwrap();
    tetrad(dir.path(), "slave --config bad.toml --hold-to-run sender").refused(2, &["bad.toml", "scael"]);
    // a joint far outside its range
    let outside = "--packets motion.bin --port sim:?start_deg=0,45,120,0,45,0";
    run(dir.path(), outside).refused(2, &["start_deg: joint 3 can be from -225.0 to 45.0 degrees"]);
}

#[test]
fn what_is_tracked_drives_an_arm() {
    let clip = Clip::of("still", 40);
    let tracked = "track --left left --right right --scene scene.json --out run --packets motion.bin";
    clip.tetrad(tracked).done();
    fs::write(clip.path("tetrad.toml"), PATIENT).unwrap();
    let slave = "slave --config tetrad.toml --hold-to-run sender --packets motion.bin --out out \
                 --port sim:?noise=off&watchdog_ms=5000";
    let ran = clip.tetrad(slave).done();
    assert!(ran.stdout.contains("40 taken, 0 never came"), "{ran:#?}");
    // a hand at rest is seen to move by a fraction of a millimetre, and so does the arm
    let last = last(clip.dir.path());
    let moved = (last("x") - 0.6525).abs().max((last("y") + 0.15005).abs()).max((last("z") - 0.6575).abs());
    assert!(moved < 2e-3, "{moved}");
}

#[cfg(target_os = "linux")]
#[path = "common/terminal.rs"]
mod terminal;

#[cfg(target_os = "linux")]
mod keys {
    use super::terminal::{Kind, Terminal};
    use super::{PATIENT, record};
    use std::fs;
    use std::path::Path;

    /// `tetrad slave` at a terminal, whose keys are struck one after the other, each when what stands
    /// before it has been said: how it ends, and what it said.
    fn at_the_keys(port: &str, keys: &[(&str, &str)]) -> (Option<i32>, String) {
        let dir = tempfile::tempdir().unwrap();
        struck(dir.path(), port, keys).end()
    }

    fn struck(dir: &Path, port: &str, keys: &[(&str, &str)]) -> Terminal {
        record(&dir.join("motion.bin"), 3, None);
        fs::write(dir.join("tetrad.toml"), PATIENT).unwrap();
        let arguments = format!("slave --config tetrad.toml --packets motion.bin --port {port}");
        let mut terminal = Terminal::start(Kind::Plain, dir, &arguments);
        for (before, key) in keys {
            terminal.until(before, |_| {});
            terminal.strike(key);
        }
        terminal
    }

    #[test]
    fn a_terminal_that_is_closed_ends_it_by_a_safety_rule() {
        let dir = tempfile::tempdir().unwrap();
        let mut terminal = struck(dir.path(), "sim:?watchdog_ms=5000", &[("r resets", "r")]);
        terminal.until("armed", |_| {});
        terminal.hang_up();
        assert_eq!(terminal.end().0, Some(4));
    }

    #[test]
    fn an_arm_that_is_left_in_fault_ends_it_as_a_fault_whoever_watched() {
        let keys = [("r resets", "r"), ("reports fault", "q")];
        let (code, said) = at_the_keys("sim:?fault=3@2s&watchdog_ms=5000", &keys);
        assert_eq!(code, Some(4), "{said}");
        assert!(said.contains("error: ") && said.contains("joint 3"), "{said}");
    }

    #[test]
    fn an_arm_that_does_not_answer_any_more_is_a_lost_device() {
        let keys = [("r resets", "r"), ("does not answer", "q")];
        let (code, said) = at_the_keys("sim:?silence=2s&watchdog_ms=5000", &keys);
        assert_eq!(code, Some(3), "{said}");
    }

    #[test]
    fn what_the_operator_stopped_is_done() {
        let keys = [("r resets", "r"), ("armed", "x"), ("stop was pressed", "q")];
        for keys in [&keys[..], &[("r resets", "q")]] {
            let (code, said) = at_the_keys("sim:?watchdog_ms=5000", keys);
            assert_eq!(code, Some(0), "{said}");
        }
    }
}
