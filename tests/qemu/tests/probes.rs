//! Promise: what two cameras saw gives the same motion packets, and a pose the same joints, to the byte, on the
//! desktop, on a Cortex-M4F and on a Cortex-M7; of the hand built for size and for speed.

use std::io;
use tetrad_core::wire::{ObservationPacket, Packet};
use tetrad_qemu::board::Target;
use tetrad_qemu::hand::shown;
use tetrad_qemu::tape::{Event, Mode, Tape};
use tetrad_qemu::{arm, desktop};

/// Each sequence in both modes.
fn hand(index: usize) -> io::Result<()> {
    let shown = &shown()[index];
    for mode in Mode::ALL {
        let tape = shown.tape(mode);
        let expected = desktop::answers(&tape);
        for target in Target::OWN {
            let answers = target.answers(&tape)?;
            let (theirs, ours) = (desktop::packets(&answers), desktop::packets(&expected));
            for (their, our) in theirs.iter().zip(&ours) {
                assert_eq!(their, our, "{target:?}, {mode:?}, {}", shown.sequence.scene);
            }
            assert!(answers == expected, "{target:?}, {mode:?}, {}: bytes", shown.sequence.scene);
        }
    }
    Ok(())
}

macro_rules! hands {
    ($($test:ident $index:literal)*) => { $(
        #[test]
        fn $test() -> io::Result<()> {
            hand($index)
        }
    )* };
}

hands! {
    hand_that_moves_about 0
    hand_that_is_lost_and_latched_anew 1
    hand_with_a_hidden_ball 2
    hand_at_the_picture_edge 3
}

#[test]
fn arm() -> io::Result<()> {
    let tape = arm::tape();
    let expected = desktop::answers(&tape);
    for target in [Target::OWN[0], Target::OWN[1], Target::FOREIGN] {
        let answers = target.answers(&tape)?;
        let differs = answers.iter().zip(&expected).position(|(their, our)| their != our);
        assert_eq!((differs, answers.len()), (None, expected.len()), "{target:?}");
    }
    Ok(())
}

/// Plays a tape as it is, and with a bit of it flipped.
fn is_noticed(tape: &Tape, flip: impl FnOnce(&mut [Event])) -> io::Result<bool> {
    let expected = desktop::answers(tape);
    assert!(Target::OWN[0].answers(tape)? == expected, "as on the desktop");
    let mut flipped = tape.clone();
    flip(&mut flipped.events);
    Ok(Target::OWN[0].answers(&flipped)? != expected)
}

#[test]
fn a_flipped_bit_of_an_observation_is_noticed() -> io::Result<()> {
    for mode in Mode::ALL {
        let tape = shown()[0].tape(mode);
        let noticed = is_noticed(&tape, |events| {
            let event = &mut events[40];
            let Event::Line(frame) = &*event else { panic!("{event:?}: no frame") };
            let [Packet::Observation(seen)] = desktop::packets(frame)[..] else { panic!("no observation") };
            let mut balls = seen.balls;
            let u = &mut balls[0].centre.u;
            // a thousandth of a pixel
            *u = f32::from_bits(u.to_bits() ^ 1 << 6);
            *event = Event::packet(&ObservationPacket { balls, ..seen }.into());
        })?;
        assert!(noticed, "{mode:?}: the comparison is blind");
    }
    Ok(())
}

#[test]
fn a_flipped_bit_of_a_pose_is_noticed() -> io::Result<()> {
    let noticed = is_noticed(&arm::tape(), |events| {
        let Event::Case(case) = &mut events[10] else { panic!("no case") };
        // the lowest bit of the place's first number that single precision keeps
        case[24 + 9 * 8 + 3] ^= 1 << 5;
    })?;
    assert!(noticed, "the comparison is blind");
    Ok(())
}
