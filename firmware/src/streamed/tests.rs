use super::*;
use crate::handover::Packets;
use crate::track::track;
use core::convert::Infallible;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use std::boxed::Box;
use std::vec::Vec;
use tetrad_core::node::Node;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{
    Command, CommandPacket, MAX_FRAME_LEN, Notice, NoticePacket, STRIP_BYTES, Strip, encode,
};

const SESSION: u32 = 7;
const SIZE: (u16, u16) = (32, 24);
const LENGTH: usize = 32 * 24 * 2;

/// A line on which these bytes come, and then none.
struct Line(Vec<u8>);

impl embedded_io_async::ErrorType for Line {
    type Error = Infallible;
}

impl Read for Line {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Infallible> {
        if self.0.is_empty() {
            return core::future::pending().await;
        }
        let count = bytes.len().min(self.0.len());
        let rest = self.0.split_off(count);
        bytes[..count].copy_from_slice(&self.0);
        self.0 = rest;
        Ok(count)
    }
}

fn frame(packet: &Packet) -> Vec<u8> {
    let mut out = [0; MAX_FRAME_LEN];
    let length = encode(packet, &mut out).unwrap();
    out[..length].to_vec()
}

fn part(picture: u32, shown: Shown) -> Vec<u8> {
    frame(&ShownPacket { session: SESSION, picture, shown }.into())
}

fn told(sequence: u32, command: Command) -> Vec<u8> {
    frame(&CommandPacket { session: 1, sequence, command }.into())
}

fn begin() -> Vec<u8> {
    part(0, Shown::Begin { refined: true })
}

fn strips(picture: u32) -> Vec<Vec<u8>> {
    let bytes = std::vec![0x55; LENGTH];
    let strip = |(at, bytes): (usize, &[u8])| {
        let offset = (at * STRIP_BYTES) as u32;
        part(picture, Shown::Strip { offset, strip: Strip::of(bytes).unwrap() })
    };
    bytes.chunks(STRIP_BYTES).enumerate().map(strip).collect()
}

fn look(picture: u32, length: usize) -> Vec<u8> {
    let (width, height, format) = (SIZE.0, SIZE.1, PixelFormat::Rgb565Be);
    part(picture, Shown::Look { capture_us: 5, length: length as u32, width, height, format })
}

fn picture(number: u32) -> Vec<u8> {
    [strips(number).concat(), look(number, LENGTH)].concat()
}

/// What the camera says to these bytes.
fn said(bytes: &[Vec<u8>]) -> Vec<Packet> {
    let (buffers, inputs, packets) = (Buffers::new(), Inputs::new(), Packets::new());
    for _ in 0..2 {
        assert!(buffers.try_send(Box::leak(Box::new(PictureBuffer::new()))).is_ok());
    }
    let mut receiving = pin!(receive(Line(bytes.concat()), &buffers, &inputs));
    let mut tracking = pin!(async {
        let mut node = Node::new(&config(AT_FIRST)).unwrap();
        while let Some(begin) = track(&mut node, &inputs, &buffers, &packets, || None, || {}).await {
            node = Node::new(&config(begin)).unwrap();
        }
    });
    let context = &mut Context::from_waker(Waker::noop());
    let mut came = Vec::new();
    for _ in 0..200 {
        assert_eq!(receiving.as_mut().poll(context), Poll::Pending);
        assert_eq!(tracking.as_mut().poll(context), Poll::Pending);
        came.extend(core::iter::from_fn(|| packets.try_receive().ok()).flatten());
    }
    came
}

/// Observations as the picture's number among them, notices as they are; all are of this session.
fn summary(packets: &[Packet], session: u32) -> Vec<Result<u32, Notice>> {
    let short = |packet: &Packet| {
        assert_eq!(packet.session(), session, "{packet:?}");
        match packet {
            Packet::Observation(seen) => Ok(seen.sequence),
            Packet::Notice(NoticePacket { notice, .. }) => Err(*notice),
            _ => panic!("{packet:?}"),
        }
    };
    packets.iter().map(short).collect()
}

const REFUSED: Notice = Notice::PictureRefused { why: BadPicture::Overrun };
const TOO_LONG: Notice = Notice::PictureRefused { why: BadPicture::Length };

#[test]
fn a_picture_is_looked_at_once_it_is_whole() {
    let came = said(&[begin(), told(0, Command::Start), picture(0), picture(1)]);
    assert_eq!(summary(&came, SESSION), [Err(Notice::Done), Ok(0), Ok(1)]);
    let Packet::Observation(seen) = came[1] else { panic!("{came:?}") };
    assert_eq!((seen.capture_us, seen.width, seen.height, seen.observed_us), (5, SIZE.0, SIZE.1, 0));
}

#[test]
fn a_strip_that_is_missing_or_astray_costs_that_picture_alone() {
    let damaged = |damage: fn(&mut Vec<Vec<u8>>)| {
        let mut strips = strips(3);
        damage(&mut strips);
        [begin(), told(0, Command::Start), strips.concat(), look(3, LENGTH), picture(4)]
    };
    let cases: [fn(&mut Vec<Vec<u8>>); 6] = [
        |strips| drop(strips.remove(0)),
        |strips| drop(strips.remove(3)),
        |strips| drop(strips.pop()),
        |strips| strips.swap(1, 2),
        |strips| strips.insert(2, strips[1].clone()),
        |strips| strips.clear(),
    ];
    for (case, damage) in cases.into_iter().enumerate() {
        let came = said(&damaged(damage));
        assert_eq!(summary(&came, SESSION), [Err(Notice::Done), Err(REFUSED), Ok(0)], "case {case}");
    }
}

#[test]
fn garbage_between_strips_is_told_and_costs_no_picture() {
    let mut strips = strips(0);
    strips.insert(2, std::vec![9, 9, 9, 0]);
    let came = said(&[begin(), told(0, Command::Start), strips.concat(), look(0, LENGTH)]);
    assert_eq!(summary(&came, SESSION), [Err(Notice::Done), Err(Notice::NotUnderstood { count: 1 }), Ok(0)]);
}

#[test]
fn a_look_that_is_asked_for_again_is_done_once() {
    let came = said(&[begin(), told(0, Command::Start), picture(0), look(0, LENGTH), look(0, LENGTH)]);
    assert_eq!(summary(&came, SESSION), [Err(Notice::Done), Ok(0)]);
}

#[test]
fn lengths_that_are_none_are_refused() {
    let too_long: Vec<Vec<u8>> = (0..=PICTURE_BYTES / STRIP_BYTES)
        .map(|at| {
            let strip = Strip::of(&[1; STRIP_BYTES]).unwrap();
            part(1, Shown::Strip { offset: (at * STRIP_BYTES) as u32, strip })
        })
        .collect();
    let came = said(&[
        begin(),
        told(0, Command::Start),
        strips(0).concat(),
        look(0, LENGTH - 2),
        too_long.concat(),
        look(1, PICTURE_BYTES + STRIP_BYTES),
        // as many as it says, and not as many as its size takes
        strips(2)[..2].concat(),
        look(2, 2 * STRIP_BYTES),
        picture(3),
    ]);
    assert_eq!(
        summary(&came, SESSION),
        [Err(Notice::Done), Err(REFUSED), Err(TOO_LONG), Err(TOO_LONG), Ok(0)]
    );
}

#[test]
fn who_has_not_begun_shows_nothing_and_who_begins_finds_a_new_camera() {
    let came = said(&[look(0, LENGTH), told(0, Command::Start)]);
    assert_eq!(summary(&came, NOT_BEGUN), [Err(Notice::NotUnderstood { count: 1 }), Err(Notice::Done)]);
    let once = said(&[begin(), told(0, Command::Start), picture(0)]);
    let twice =
        said(&[begin(), told(0, Command::Start), picture(0), begin(), told(0, Command::Start), picture(0)]);
    assert_eq!(twice, [&once[..], &once[..]].concat());
}
