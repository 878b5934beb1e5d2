//! Promise: a board that is shown pictures over its serial line sees what the desktop sees, to the byte; what a line
//! loses of them is shown again; and what differs is seen. The boards are QEMU's, behind pseudo terminals: what asks
//! them opens those as it opens the port of a real one.

#![cfg(target_os = "linux")]

use std::io;
use std::path::Path;
use std::process::Command;
use std::time::Duration;
use tetrad_core::wire::{Command as Told, Packet};
use tetrad_qemu::board::Target;
use tetrad_qemu::live::Plugged;
use tetrad_qemu::relay::{Harm, Relay};
use tetrad_qemu::sender::{Failure, Same, Sender};
use tetrad_qemu::tape::{Event, Tape};
use tetrad_qemu::{desktop, recorded};

/// Within the first picture's strips.
const AMID: usize = 20_000;

/// Runs `hil` on a board of QEMU's.
fn hil(target: Target, wanted: &str) -> io::Result<String> {
    let mut board = Plugged::streamed(target)?;
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("board.toml");
    std::fs::write(&file, format!("port = \"{}\"\n{wanted}", board.device().display()))?;
    let ran = Command::new(env!("CARGO_BIN_EXE_hil")).arg(&file).output()?;
    board.check()?;
    let (out, said) = (String::from_utf8_lossy(&ran.stdout), String::from_utf8_lossy(&ran.stderr));
    assert!(ran.status.success(), "{target:?}: {}\n{out}\n{said}", ran.status);
    println!("{out}");
    Ok(out.into_owned())
}

/// The first pictures of the recorded frames.
fn tape(pictures: usize) -> Tape {
    let mut tape = recorded::tape();
    tape.end_behind(pictures);
    tape
}

fn sender(device: &Path) -> io::Result<Sender<Box<dyn serialport::SerialPort>>> {
    let line = serialport::new(device.to_string_lossy(), 921_600).timeout(Duration::from_millis(20));
    Ok(Sender::new(line.open()?))
}

/// Shows one picture over a line that is harmed amid it.
fn shown_over(harm: Harm) -> io::Result<Same> {
    let mut board = Plugged::streamed(Target::OWN[0])?;
    let relay = Relay::start(board.device(), AMID, harm)?;
    let tape = tape(1);
    let same = sender(relay.device())?.compare(&tape, &tape);
    board.check()?;
    same.map_err(|failure| io::Error::other(failure.to_string()))
}

#[test]
fn recorded_frames_on_a_cortex_m4f() -> io::Result<()> {
    let out = hil(Target::OWN[0], "sequences = [\"recorded\"]\n")?;
    for mode in ["Paper", "Refined"] {
        // what begins, a start, four balls in each of two frames, six pictures
        let line = format!(
            "recorded, {mode}: 6 pictures, 16 packets, the same as on the desktop; shown again 0, noise 0"
        );
        assert!(out.contains(&line), "{out}");
    }
    Ok(())
}

#[test]
fn a_sensors_picture_on_a_cortex_m7() -> io::Result<()> {
    let out = hil(Target::OWN[1], "sequences = [\"demo\"]\npictures = 1\n")?;
    assert_eq!(out.matches("demo").count(), 2, "{out}");
    assert_eq!(out.matches(": 1 pictures, 7 packets, the same").count(), 2, "{out}");
    Ok(())
}

#[test]
fn strips_that_are_lost_are_named_and_shown_again() -> io::Result<()> {
    let same = shown_over(Harm::Lose(300))?;
    assert_eq!((same.pictures, same.again), (1, 1), "{same:?}");
    Ok(())
}

#[test]
fn garbage_between_strips_costs_no_picture() -> io::Result<()> {
    let same = shown_over(Harm::Bring(vec![7, 7, 7, 0, 9, 9, 0]))?;
    assert_eq!(same, Same { pictures: 1, packets: 9, again: 0, noise: 2 });
    Ok(())
}

#[test]
fn a_flipped_bit_of_a_picture_is_noticed_and_told() -> io::Result<()> {
    let same = tape(2);
    let mut shown = same.clone();
    // the upper bit of red, in the middle of the red ball
    let at = same.events.iter().find_map(|event| match event {
        Event::Line(bytes) => desktop::packets(bytes).into_iter().find_map(|packet| match packet {
            Packet::Command(told) => match told.command {
                Told::Learn { at, .. } => Some(at),
                _ => None,
            },
            _ => None,
        }),
        _ => None,
    });
    let at = at.ok_or(io::ErrorKind::NotFound)?;
    let pixel = at.v.round() as usize * usize::from(same.size.0) + at.u.round() as usize;
    let second = shown.events.iter_mut().rev().find_map(|event| match event {
        Event::Picture(_, bytes) => Some(bytes),
        _ => None,
    });
    second.ok_or(io::ErrorKind::NotFound)?[2 * pixel + 1] ^= 0x80;
    let mut board = Plugged::streamed(Target::OWN[0])?;
    let mut sender = sender(board.device())?;
    match sender.compare(&shown, &same) {
        Err(Failure::Differs(what)) => {
            assert!(what.starts_with("picture 2\nthe board says   Observation("), "{what}");
        }
        other => panic!("the comparison is blind: {other:?}"),
    }
    board.check()
}
