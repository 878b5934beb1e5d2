//! Promise: whatever comes on a board's serial line, byte by byte and by interrupts, nothing is lost behind it
//! and nothing begins anew; what cannot be taken is refused with its reason.

use std::io;
use std::time::Duration;
use tetrad_core::wire::{BadPicture, Command, Notice, NoticePacket, Packet};
use tetrad_qemu::board::Target;
use tetrad_qemu::clip::{Clip, Sequence};
use tetrad_qemu::desktop::{self, Camera};
use tetrad_qemu::garbage::Garbage;
use tetrad_qemu::live::Live;
use tetrad_qemu::tape::{Event, Tape, command_frame};

/// What a line of 9,600 baud carries in a minute.
const MINUTE_BYTES: usize = 9_600 / 10 * 60;

/// Any other does as well.
const SEED: u64 = 4;

fn sequence() -> Sequence {
    Sequence { scene: "static-30px", frames: (1..6).collect() }
}

/// A board, and the desktop beside it: both are told the same.
struct Beside {
    board: Live,
    desktop: Camera,
}

impl Beside {
    fn start(target: Target, tape: &Tape) -> io::Result<Self> {
        Ok(Self { board: Live::start(target, tape)?, desktop: Camera::of(tape) })
    }

    /// Puts bytes on the line; `pictures` are those that they ask for. Waits until as much was answered as on
    /// the desktop: so the line never runs over.
    fn tell(&mut self, bytes: Vec<u8>, pictures: &[Event]) -> io::Result<()> {
        self.board.send(&bytes)?;
        self.desktop.take(&Event::Line(bytes));
        pictures.iter().for_each(|picture| self.desktop.take(picture));
        let expected = self.desktop.line();
        self.board.until(|came| came.len() >= expected.len())?;
        Ok(())
    }

    /// Nothing comes that does not come on the desktop, nor in another order.
    fn compare(&mut self) -> io::Result<()> {
        let came = self.board.when_quiet(Duration::from_millis(300))?;
        let expected = self.desktop.line();
        let (theirs, ours) = (desktop::packets(came), desktop::packets(expected));
        for (their, our) in theirs.iter().zip(&ours) {
            assert_eq!(their, our);
        }
        assert_eq!(theirs.len(), ours.len(), "packets");
        assert!(came == expected, "bytes between packets");
        Ok(())
    }
}

#[test]
fn a_minute_of_garbage_costs_no_command_and_no_picture() -> io::Result<()> {
    for target in Target::OWN {
        let tape = Tape::of_pictures(&sequence());
        let mut beside = Beside::start(target, &tape)?;
        let mut garbage = Garbage::new(SEED);
        let mut bytes = 0;
        while bytes < MINUTE_BYTES {
            let piece = garbage.piece();
            bytes += piece.len();
            beside.tell(piece, &[])?;
        }
        let refused = desktop::packets(beside.desktop.line());
        let refused = refused.iter().filter_map(not_understood).max();
        assert!(refused > Some(MINUTE_BYTES as u32 / 1_000), "{refused:?}: that was no garbage");

        let places = Clip::named(sequence().scene, 0).ok_or(io::ErrorKind::NotFound)?.places(0);
        let mut commands = garbage.sequence()..;
        let mut number = || commands.next().unwrap_or_default();
        for (ball, at) in places {
            beside.tell(command_frame(number(), Command::Learn { ball, at }), &tape.events[..1])?;
        }
        beside.tell(command_frame(number(), Command::Start), &tape.events)?;
        beside.tell(command_frame(number(), Command::Stop), &[])?;
        beside.compare()?;
    }
    Ok(())
}

#[test]
fn a_line_that_runs_over_says_so_and_is_heard_again() -> io::Result<()> {
    // frames of two bytes that are no packets, and an answer to each: nobody reads them, so the board cannot go on
    let flood = [1, 0].repeat(8 * 1024);
    let mut board = Live::start(Target::OWN[0], &Tape::of_pictures(&sequence()))?;
    board.send(&flood)?;
    std::thread::sleep(Duration::from_secs(2));
    let quiet = Duration::from_millis(500);
    let came = desktop::packets(board.when_quiet(quiet)?);
    let overruns = came.iter().filter_map(overrun).max();
    assert!(overruns.is_some(), "{} packets, and no overrun among them", came.len());
    let refused = came.iter().filter_map(not_understood).max();
    assert!(refused < Some(flood.len() as u32 / 2), "{refused:?}: nothing was lost");

    // the zero byte ends what was cut
    let ask = [vec![0], command_frame(0, Command::SelfTest)].concat();
    board.send(&ask)?;
    let answers = |packet: &Packet| notice(packet).is_some_and(|notice| notice.answers == Some(0));
    board.until(|came| desktop::packets(came).iter().any(answers))?;
    let came = desktop::packets(board.when_quiet(quiet)?);
    let notices: Vec<&NoticePacket> = came.iter().filter_map(notice).collect();
    let last = notices.last().map(|last| (last.answers, last.notice));
    assert_eq!(last, Some((Some(0), Notice::Done)), "{notices:?}");
    assert_eq!(came.iter().filter_map(overrun).max(), overruns, "it was over");
    let numbers: Vec<u32> = notices.iter().map(|notice| notice.sequence).collect();
    let whole: Vec<u32> = (0..).take(numbers.len()).collect();
    assert_eq!(numbers, whole, "no answer was lost, and the camera did not begin anew");
    Ok(())
}

#[test]
fn pictures_of_a_wrong_length_are_refused_and_the_next_is_looked_at() -> io::Result<()> {
    let mut tape = Tape::of(&sequence());
    let mut pictures = tape.events.iter_mut().filter_map(|event| match event {
        Event::Picture(_, bytes) => Some(bytes),
        Event::Line(_) | Event::Pause(_) | Event::Case(_) => None,
    });
    // one byte short, half, nothing, and more than the buffer has room for
    let whole = pictures.nth(1).ok_or(io::ErrorKind::NotFound)?;
    whole.pop();
    for length in [2, 1, 0] {
        let bytes = pictures.next().ok_or(io::ErrorKind::NotFound)?;
        bytes.resize(bytes.len() * length / 2 + length / 2, 0);
    }
    let expected = desktop::line(&tape);
    let refused = desktop::packets(&expected);
    let refused = refused.iter().filter_map(notice);
    let refused =
        refused.filter(|notice| notice.notice == Notice::PictureRefused { why: BadPicture::Length });
    assert_eq!(refused.count(), 4);
    for target in Target::OWN {
        let (line, _) = target.play(&tape)?;
        assert_eq!(desktop::packets(&line), desktop::packets(&expected), "{target:?}");
        assert!(line == expected, "{target:?}: bytes between packets");
    }
    Ok(())
}

fn notice(packet: &Packet) -> Option<&NoticePacket> {
    match packet {
        Packet::Notice(notice) => Some(notice),
        _ => None,
    }
}

fn not_understood(packet: &Packet) -> Option<u32> {
    match notice(packet)?.notice {
        Notice::NotUnderstood { count } => Some(count),
        _ => None,
    }
}

fn overrun(packet: &Packet) -> Option<u32> {
    match notice(packet)?.notice {
        Notice::LineOverrun { count } => Some(count),
        _ => None,
    }
}
