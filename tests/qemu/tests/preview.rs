//! Promise: what a board shows of its balls are the pixels of the picture that it names, whatever comes between, and
//! all else that it sends is the same with and without.

use std::io;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::wire::{Command, Packet, PreviewPacket};
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::Sequence;
use tetrad_qemu::desktop;
use tetrad_qemu::tape::{Event, Tape, command_frame};

/// A thumbnail begins every so many pictures: between two of them there is a picture without a strip.
const EVERY: u16 = 4;

/// A number that no other command of a tape has.
const NUMBER: u32 = 1_000;

/// The pictures, with and without the command.
fn tapes() -> [Tape; 2] {
    let without = Tape::of(&Sequence { scene: "demo", frames: (1..20).collect() });
    let mut with = without.clone();
    let is_picture = |event: &Event| matches!(event, Event::Picture(..));
    let first = with.events.iter().position(is_picture).unwrap_or_default();
    // behind what else it is told
    with.events.insert(first, Event::Line(command_frame(NUMBER, Command::Preview { every: EVERY })));
    [with, without]
}

fn strips(packets: &[Packet]) -> Vec<PreviewPacket> {
    let strip = |packet: &Packet| match packet {
        Packet::Preview(strip) => Some(*strip),
        _ => None,
    };
    packets.iter().filter_map(strip).collect()
}

/// That a strip's pixels are those of the picture of its number: on the tape they lie as they are sent.
fn check(strip: &PreviewPacket, tape: &Tape) {
    let mut pictures = tape.events.iter().filter_map(|event| match event {
        Event::Picture(_, bytes) => Some(bytes),
        Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
    });
    let picture = pictures.nth(strip.sequence as usize).expect("it was shown");
    let (left, top) = (usize::from(strip.left), usize::from(strip.top));
    let (step, first) = (usize::from(strip.step), usize::from(strip.row));
    for (pixels, row) in strip.pixels.iter().zip(first..) {
        for (pixel, column) in pixels.chunks(2).zip(0..) {
            let (x, y) = (left + step * column + step / 2, top + step * row + step / 2);
            let at = 2 * (y * usize::from(tape.size.0) + x);
            assert_eq!(pixel, &picture[at..at + 2], "({x}, {y}) of picture {}", strip.sequence);
        }
    }
}

#[test]
fn thumbnails_of_a_board_are_its_pictures() -> io::Result<()> {
    let [with, without] = tapes();
    for target in Target::OWN {
        let (line, _) = target.play(&with)?;
        let expected = desktop::line(&with);
        assert_eq!(desktop::packets(&line), desktop::packets(&expected), "{target:?}");
        assert!(line == expected, "{target:?}: bytes between packets");

        let packets = desktop::packets(&line);
        let strips = strips(&packets);
        for strip in &strips {
            check(strip, &with);
        }
        let thumbnails: Vec<&[PreviewPacket]> = strips.chunks(PreviewPacket::STRIPS).collect();
        assert!(thumbnails.len() > BALLS, "{target:?}: {} thumbnails", thumbnails.len());
        for (thumbnail, ball) in thumbnails.iter().zip(Ball::ALL.into_iter().cycle()) {
            let rows: Vec<u8> = thumbnail.iter().map(|strip| strip.row).collect();
            assert_eq!(rows, [0, 6, 12], "{target:?}: whole");
            let of = (thumbnail[0].sequence, ball);
            assert!(thumbnail.iter().all(|strip| (strip.sequence, strip.ball) == of), "{target:?}: {of:?}");
        }
        let observations = |packets: Vec<Packet>| {
            packets.into_iter().filter(|packet| matches!(packet, Packet::Observation(_))).collect::<Vec<_>>()
        };
        let (line, _) = target.play(&without)?;
        assert_eq!(observations(packets), observations(desktop::packets(&line)), "{target:?}");
    }
    Ok(())
}
