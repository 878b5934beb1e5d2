//! Promise: the same pictures give the same packets, to the byte, on the desktop, on a Cortex-M4F and on
//! a Cortex-M7, each as its processor is built for.

use std::io;
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::{Sequence, others, sequences};
use tetrad_qemu::tape::{Event, Mode, Tape};
use tetrad_qemu::{desktop, given, recorded};

/// Compares boards with the desktop, in both modes.
fn check(sequence: &Sequence, targets: &[Target]) -> io::Result<()> {
    let tape = Tape::of(sequence);
    Mode::ALL
        .into_iter()
        .try_for_each(|mode| compare(sequence.scene, &Tape { mode, ..tape.clone() }, targets))
}

/// Plays a tape on boards, and compares what they send with what the desktop would.
fn compare(name: &str, tape: &Tape, targets: &[Target]) -> io::Result<()> {
    let (mode, expected) = (tape.mode, desktop::line(tape));
    for target in targets {
        let (line, _) = target.play(tape)?;
        // packets first: what differs is then told in words
        let (theirs, ours) = (desktop::packets(&line), desktop::packets(&expected));
        for (their, our) in theirs.iter().zip(&ours) {
            assert_eq!(their, our, "{target:?}, {mode:?}, {name}");
        }
        assert_eq!(theirs.len(), ours.len(), "{target:?}, {mode:?}, {name}: packets");
        assert!(line == expected, "{target:?}, {mode:?}, {name}: bytes between packets");
    }
    Ok(())
}

/// Every second of the other scenes, from the first or the second on.
fn check_others(first: usize) -> io::Result<()> {
    others().iter().skip(first).step_by(2).try_for_each(|sequence| check(sequence, &Target::OWN))
}

#[test]
fn half_of_the_other_scenes() -> io::Result<()> {
    check_others(0)
}

#[test]
fn the_other_half() -> io::Result<()> {
    check_others(1)
}

#[test]
fn balls_that_a_camera_is_told_of() -> io::Result<()> {
    compare("given", &given::tape(&Sequence { scene: "demo", frames: (1..6).collect() }), &Target::OWN)
}

#[test]
fn recorded_frames() -> io::Result<()> {
    compare("recorded", &recorded::tape(), &Target::OWN)
}

macro_rules! sequences {
    ($($test:ident $index:literal)*) => { $(
        #[test]
        fn $test() -> io::Result<()> {
            check(&sequences()[$index], &Target::OWN)
        }
    )* };
}

sequences! {
    demo 0
    resting_balls 1
    small_balls 2
    side_light 3
    fast_and_few_frames 4
    covered_and_found_again 5
    crossing 6
    distractor 7
    picture_edge 8
}

#[test]
fn one_program_runs_on_both_boards() -> io::Result<()> {
    check(&sequences()[0], &[Target::FOREIGN])
}

#[test]
fn a_flipped_bit_of_a_picture_is_noticed() -> io::Result<()> {
    let mut tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..4).collect() });
    let expected = desktop::line(&tape);
    assert_eq!(Target::OWN[0].play(&tape)?.0, expected, "as on the desktop");
    let place = tetrad_qemu::clip::Clip::named("static-30px", 0).map(|clip| clip.places(2)[0].1);
    let place = place.ok_or(io::ErrorKind::NotFound)?;
    let (width, pictures) = (usize::from(tape.size.0), tape.events.iter_mut());
    let mut pictures = pictures.filter_map(|event| match event {
        Event::Picture(_, bytes) => Some(bytes),
        Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
    });
    // the upper bit of red, in the middle of the red ball
    let pixel = place.v.round() as usize * width + place.u.round() as usize;
    let third = pictures.nth(2).ok_or(io::ErrorKind::NotFound)?;
    third[2 * pixel] ^= 0x80;
    assert!(Target::OWN[0].play(&tape)?.0 != expected, "the comparison is blind");
    Ok(())
}
