//! The packets between a smart camera and its host.

use super::super::body::{COMMAND, NOTICE, PREVIEW};
use super::pinned::{documented, hex};
use super::*;
use crate::observation::Ball;
use crate::vision::appearance::LearntBall;
use crate::vision::colour::{Primary, Reference};
use crate::vision::frame::Rgb;

fn a_ball() -> LearntBall {
    let reference = Reference {
        primary: Primary::Blue,
        reference: Rgb::new(20, 40, 200),
        typical: Rgb::new(24, 44, 190),
        background: Rgb::new(90, 90, 96),
    };
    LearntBall { reference, diameter: 15.5, aspect: 1.0 }
}

/// The second strip of a thumbnail: blue below a row of grey.
fn strip() -> PreviewPacket {
    let mut pixels = [[0x19, 0x4C].repeat(16).try_into().unwrap(); PreviewPacket::STRIP_ROWS];
    pixels[0] = [0x5A, 0xCC].repeat(16).try_into().unwrap();
    PreviewPacket {
        camera: 1,
        session: 700,
        sequence: 300,
        ball: Ball::Blue,
        left: 144,
        top: 103,
        step: 2,
        row: 6,
        pixels,
    }
}

/// The packets of the examples in docs/wire.md.
fn examples() -> [Packet; 3] {
    let command = Command::Learn { ball: Ball::Blue, at: ImagePoint::new(160.0, 120.5) };
    let notice = Notice::Learnt { ball: Ball::Blue, learnt: a_ball() };
    [
        CommandPacket { session: 300, sequence: 4, command }.into(),
        NoticePacket { camera: 1, session: 700, sequence: 2, answers: Some(4), notice }.into(),
        strip().into(),
    ]
}

fn commands() -> [Command; 7] {
    let (ball, at) = (Ball::Yellow, ImagePoint::new(1.0, 2.0));
    [
        Command::Start,
        Command::Stop,
        Command::Learn { ball, at },
        Command::SetReference { ball, learnt: a_ball() },
        Command::SetWindow { ball, at },
        Command::SelfTest,
        Command::Preview { every: 300 },
    ]
}

const WHY_NOT_TAUGHT: [NotTaught; 9] = [
    NotTaught::Outside,
    NotTaught::Background,
    NotTaught::TooSmall,
    NotTaught::TooLarge,
    NotTaught::Saturated,
    NotTaught::NoContrast,
    NotTaught::NotFoundAgain,
    NotTaught::Size,
    NotTaught::Colour,
];

const WHY_REFUSED: [BadPicture; 3] = [BadPicture::Length, BadPicture::Layout, BadPicture::Overrun];

fn notices() -> [Notice; 8] {
    let ball = Ball::Green;
    [
        Notice::Done,
        Notice::Learnt { ball, learnt: a_ball() },
        Notice::NotTaught { ball, why: NotTaught::TooSmall },
        Notice::Untaught { ball },
        Notice::SelfTestFailed,
        Notice::PictureRefused { why: BadPicture::Overrun },
        Notice::NotUnderstood { count: 5 },
        Notice::LineOverrun { count: 6 },
    ]
}

pub(super) fn packet() -> impl Strategy<Value = Packet> {
    let command = (any::<(u32, u32)>(), prop::sample::select(commands().to_vec()))
        .prop_map(|((session, sequence), command)| CommandPacket { session, sequence, command }.into());
    let notice = (any::<(u8, u32, u32, Option<u32>)>(), prop::sample::select(notices().to_vec())).prop_map(
        |((camera, session, sequence, answers), notice)| {
            NoticePacket { camera, session, sequence, answers, notice }.into()
        },
    );
    let place = (any::<(u16, u16)>(), 1..=u8::MAX, 0..3_u8);
    let pixels = prop::array::uniform6(prop::array::uniform32(any::<u8>()));
    let balls = prop::sample::select(Ball::ALL.to_vec());
    let preview = (any::<(u8, u32, u32)>(), balls, place, pixels).prop_map(
        |((camera, session, sequence), ball, ((left, top), step, strip), pixels)| {
            let row = 6 * strip;
            PreviewPacket { camera, session, sequence, ball, left, top, step, row, pixels }.into()
        },
    );
    prop_oneof![command, notice, preview]
}

#[test]
fn the_document_shows_what_a_camera_is_told_and_says() {
    let [command, notice, preview] = examples();
    assert_eq!(hex(&documented("command body")), hex(&body_of(&command)));
    assert_eq!(hex(&documented("notice body")), hex(&body_of(&notice)));
    assert_eq!(hex(&documented("preview body")), hex(&body_of(&preview)));
    let rows = [
        ("command", CommandPacket::MAX_LEN),
        ("notice", NoticePacket::MAX_LEN),
        ("preview", PreviewPacket::MAX_LEN),
    ];
    for (name, length) in rows {
        let fact = format!("| {name} | {} | {} |", 2 + length, 2 + length + 4);
        assert!(super::pinned::DOCUMENT.contains(&fact), "docs/wire.md lacks: {fact}");
    }
}

#[test]
fn the_lengths_are_reached() {
    let learnt = a_ball();
    let command = Command::SetReference { ball: Ball::Red, learnt };
    let command = CommandPacket { session: u32::MAX, sequence: u32::MAX, command };
    let notice = Notice::Learnt { ball: Ball::Red, learnt };
    let (session, sequence, answers) = (u32::MAX, u32::MAX, Some(u32::MAX));
    let notice = NoticePacket { camera: 1, session, sequence, answers, notice };
    assert_eq!(body_of(&command.into()).len(), 2 + CommandPacket::MAX_LEN);
    assert_eq!(body_of(&notice.into()).len(), 2 + NoticePacket::MAX_LEN);
    let (left, top) = (u16::MAX, u16::MAX);
    let preview = PreviewPacket { session: u32::MAX, sequence: u32::MAX, left, top, ..strip() };
    assert_eq!(body_of(&preview.into()).len(), 2 + PreviewPacket::MAX_LEN);
}

#[test]
fn the_numbers_are_pinned() {
    let command = |command| body_of(&CommandPacket { session: 0, sequence: 0, command }.into());
    let notice =
        |notice| body_of(&NoticePacket { camera: 0, session: 0, sequence: 0, answers: None, notice }.into());
    for (number, what) in (0..).zip(commands()) {
        assert_eq!(command(what)[..5], [VERSION, COMMAND, 0, 0, number], "{what:?}");
    }
    for (number, what) in (0..).zip(notices()) {
        assert_eq!(notice(what)[..7], [VERSION, NOTICE, 0, 0, 0, 0, number], "{what:?}");
    }
    for (number, why) in (0..).zip(WHY_NOT_TAUGHT) {
        assert_eq!(notice(Notice::NotTaught { ball: Ball::Blue, why })[7..], [2, number], "{why:?}");
    }
    for (number, why) in (0..).zip(WHY_REFUSED) {
        assert_eq!(notice(Notice::PictureRefused { why })[7..], [number], "{why:?}");
    }
}

#[test]
fn what_is_not_finite_is_neither_sent_nor_taken() {
    let at = ImagePoint::new(f32::NAN, 0.0);
    let learnt = LearntBall { diameter: f32::INFINITY, ..a_ball() };
    let ball = Ball::Red;
    for command in
        [Command::Learn { ball, at }, Command::SetWindow { ball, at }, Command::SetReference { ball, learnt }]
    {
        let packet = CommandPacket { session: 1, sequence: 2, command }.into();
        let mut out = [0; MAX_BODY_LEN];
        assert_eq!(encode_body(&packet, &mut out), Err(EncodeError::Value(BadValue::NotFinite)));
    }
    let [command, notice, _] = examples().map(|packet| body_of(&packet));
    for mut body in [command, notice] {
        let end = body.len();
        body[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(decode_body(&body), Err(DecodeError::Value(BadValue::NotFinite)));
    }
}

#[test]
fn rows_that_are_no_strip_are_neither_sent_nor_taken() {
    let sound = body_of(&strip().into());
    assert_eq!(sound[..2], [VERSION, PREVIEW]);
    let at = sound.len() - 192;
    assert_eq!(sound[at - 2..at], [2, 6], "step and row");
    let not_a_strip = BadValue::NotAStrip;
    for (step, row) in [(0, 6), (2, 5), (2, 18), (2, 255)] {
        let packet = PreviewPacket { step, row, ..strip() }.into();
        let mut out = [0; MAX_BODY_LEN];
        assert_eq!(encode_body(&packet, &mut out), Err(EncodeError::Value(not_a_strip)));
        let mut body = sound.clone();
        body[at - 2..at].copy_from_slice(&[step, row]);
        assert_eq!(decode_body(&body), Err(DecodeError::Value(not_a_strip)), "{step} {row}");
    }
    assert_eq!(decode_body(&sound), Ok(strip().into()));
}
