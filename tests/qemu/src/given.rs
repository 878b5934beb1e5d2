//! A tape on which a camera is told what the balls look like and where they are, instead of learning it.

use crate::clip::{Clip, Sequence};
use crate::desktop;
use crate::tape::{Event, Tape};
use tetrad_core::wire::{Command, CommandPacket, Notice, Packet};

/// As [`Tape::of`] the sequence, but for how the camera comes to know the balls. Of each ball it is first told a
/// window, which it refuses: it knows no such ball yet.
///
/// # Panics
/// When there is no such scene, or one of its balls is not learnt.
#[must_use]
pub fn tape(sequence: &Sequence) -> Tape {
    let mut tape = Tape::of(sequence);
    let notices = desktop::packets(&desktop::line(&tape));
    let places = Clip::named(sequence.scene, 0).map(|clip| clip.places(0)).expect("such a scene");
    let commands = places.into_iter().flat_map(|(ball, at)| {
        let learnt = notices.iter().find_map(|packet| match packet {
            Packet::Notice(told) => match told.notice {
                Notice::Learnt { ball: of, learnt } if of == ball => Some(learnt),
                _ => None,
            },
            _ => None,
        });
        let reference = Command::SetReference { ball, learnt: learnt.expect("every ball is learnt") };
        let window = Command::SetWindow { ball, at };
        [window, reference, window]
    });
    // another session than that of the commands that stay
    let told = |(sequence, command)| Event::packet(&CommandPacket { session: 8, sequence, command }.into());
    let given: Vec<_> = (0..).zip(commands).map(told).collect();
    tape.events.splice(..places.len(), given);
    tape
}
