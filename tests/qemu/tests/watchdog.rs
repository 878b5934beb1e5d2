//! Promise: a camera whose pictures cannot be looked at, or that gets none, does not go on as if nothing were
//! wrong: its watchdog ends the run. One with a good picture from time to time goes on.

use std::io;
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::Sequence;
use tetrad_qemu::desktop;
use tetrad_qemu::tape::{Event, Tape};

const SECOND_US: u64 = 1_000_000;

/// What the firmware ends QEMU with, and says.
const NOT_FED: &str = "exit status: 103\nwatchdog: no picture was looked at for 120 s\n";

/// A camera at work, and then these, again and again, for virtual seconds that add up to 300.
fn then_always(events: &[Event]) -> Tape {
    let mut tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..3).collect() });
    let length_us: u64 = events.iter().map(|event| if let Event::Pause(us) = event { *us } else { 0 }).sum();
    for _ in 0..(300 * SECOND_US).div_ceil(length_us) {
        tape.events.extend(events.iter().cloned());
    }
    tape
}

/// A picture that lacks so many bytes.
fn picture(missing: usize) -> io::Result<Event> {
    let mut tape = Tape::of(&Sequence { scene: "static-30px", frames: vec![1] });
    let picture = tape.events.iter_mut().rev().find_map(|event| match event {
        Event::Picture(_, bytes) => {
            bytes.truncate(bytes.len() - missing);
            Some(event.clone())
        }
        Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
    });
    picture.ok_or(io::ErrorKind::NotFound.into())
}

fn check_that_it_ends(tape: &Tape) {
    for target in Target::OWN {
        let error = target.play(tape).expect_err("the watchdog ends it").to_string();
        assert!(error.ends_with(NOT_FED), "{target:?}: {error}");
    }
}

#[test]
fn good_pictures_feed_it() -> io::Result<()> {
    let tape = then_always(&[picture(0)?, Event::Pause(90 * SECOND_US)]);
    for target in Target::OWN {
        assert!(target.play(&tape)?.0 == desktop::line(&tape), "{target:?}");
    }
    Ok(())
}

#[test]
fn pictures_that_cannot_be_looked_at_do_not() -> io::Result<()> {
    check_that_it_ends(&then_always(&[picture(2)?, Event::Pause(30 * SECOND_US)]));
    Ok(())
}

#[test]
fn the_hosts_commands_do_not() -> io::Result<()> {
    let tape = Tape::of(&Sequence { scene: "static-30px", frames: vec![1] });
    let command = tape.events.into_iter().find(|event| matches!(event, Event::Line(_)));
    let command = command.ok_or(io::ErrorKind::NotFound)?;
    check_that_it_ends(&then_always(&[command, Event::Pause(30 * SECOND_US)]));
    Ok(())
}

#[test]
fn silence_does_not() {
    check_that_it_ends(&then_always(&[Event::Pause(30 * SECOND_US)]));
}
