use super::*;
use crate::vision::frame::PixelFormat;
use std::{vec, vec::Vec};

mod preview;

const WIDTH: u16 = 160;
const HEIGHT: u16 = 120;
const AT: ImagePoint = ImagePoint { u: 80.0, v: 60.0 };

/// A red disc of 20 px before grey, `shift` px right of [`AT`].
fn picture(shift: i32) -> Vec<u8> {
    let pixel = |index: i32| {
        let (x, y) = (index % i32::from(WIDTH), index / i32::from(WIDTH));
        let (du, dv) = (x - 80 - shift, y - 60);
        if du * du + dv * dv <= 100 { [200, 36, 40] } else { [70, 72, 74] }
    };
    (0..i32::from(WIDTH) * i32::from(HEIGHT)).flat_map(pixel).collect()
}

fn see(node: &mut Node, shift: i32, t_us: u64) -> Seen {
    let bytes = picture(shift);
    let frame = FrameView::packed(&bytes, WIDTH, HEIGHT, PixelFormat::Rgb888).unwrap();
    node.picture(&frame, t_us, 10)
}

fn node() -> Node {
    let (tracker, learn) = (TrackerConfig::default(), LearnConfig::default());
    Node::new(&NodeConfig { camera: 1, session: 7, tracker, learn, started: false }).unwrap()
}

fn told(node: &mut Node, sequence: u32, command: Command) -> Option<(Option<u32>, Notice)> {
    let answer = node.command(&CommandPacket { session: 3, sequence, command })?;
    Some((answer.answers, answer.notice))
}

#[test]
fn learns_starts_tracks_and_stops() {
    let mut node = node();
    assert_eq!(told(&mut node, 0, Command::Learn { ball: Ball::Red, at: AT }), None, "with the next picture");
    let seen = see(&mut node, 0, 0);
    assert_eq!(seen.observation, None, "not started");
    let [NoticePacket { answers: Some(0), notice: Notice::Learnt { ball: Ball::Red, learnt }, .. }] =
        seen.notices[..]
    else {
        panic!("{seen:?}")
    };
    assert!((learnt.diameter - 20.5).abs() < 1.0, "{learnt:?}");
    assert_eq!(told(&mut node, 1, Command::Start), Some((Some(1), Notice::Done)));
    for (sequence, shift) in (0..4).zip([0, 2, 4, 6]) {
        let observation = see(&mut node, shift, 33_000 * u64::from(sequence)).observation.unwrap();
        let red = observation.balls[0];
        assert!(red.state.is_measured() && (red.centre.u - 80.0 - shift as f32).abs() < 0.2, "{red:?}");
        assert_eq!((observation.sequence, observation.camera, observation.session), (sequence, 1, 7));
        assert_eq!((observation.ready_us, observation.width, observation.height), (10, WIDTH, HEIGHT));
    }
    assert_eq!(told(&mut node, 2, Command::Stop), Some((Some(2), Notice::Done)));
    assert_eq!(see(&mut node, 6, 200_000).observation, None);
}

#[test]
fn a_reference_that_is_given_back_does_what_learning_does() {
    let mut first = node();
    told(&mut first, 0, Command::Learn { ball: Ball::Red, at: AT });
    let [NoticePacket { notice: Notice::Learnt { ball, learnt }, .. }] = see(&mut first, 0, 0).notices[..]
    else {
        panic!("not learnt")
    };
    let mut second = node();
    assert_eq!(
        told(&mut second, 0, Command::SetWindow { ball, at: AT }).unwrap().1,
        Notice::Untaught { ball }
    );
    assert_eq!(told(&mut second, 1, Command::SetReference { ball, learnt }).unwrap().1, Notice::Done);
    assert_eq!(told(&mut second, 2, Command::SetWindow { ball, at: AT }).unwrap().1, Notice::Done);
    for node in [&mut first, &mut second] {
        told(node, 9, Command::Start);
    }
    let seen = [&mut first, &mut second].map(|node| see(node, 1, 33_000).observation.unwrap().balls);
    assert_eq!(seen[0], seen[1]);
}

#[test]
fn a_command_that_comes_again_is_answered_again_and_not_done_again() {
    let mut node = node();
    let learn = Command::Learn { ball: Ball::Red, at: AT };
    assert_eq!(told(&mut node, 4, learn), None);
    assert_eq!(told(&mut node, 4, learn), None, "it has no answer yet");
    let first = see(&mut node, 0, 0).notices;
    assert_eq!(first.len(), 1);
    assert_eq!(told(&mut node, 4, learn), Some((Some(4), first[0].notice)));
    assert!(see(&mut node, 30, 1).notices.is_empty(), "it is not learnt anew");
    let other = node.command(&CommandPacket { session: 4, sequence: 4, command: Command::Stop });
    assert_eq!(other.unwrap().notice, Notice::Done, "another sender's number is another command");
}

#[test]
fn what_cannot_be_done_is_refused_with_a_reason() {
    let mut node = node();
    let ball = Ball::Green;
    told(&mut node, 0, Command::Learn { ball, at: ImagePoint::new(500.0, 3.0) });
    told(&mut node, 1, Command::Learn { ball: Ball::Blue, at: ImagePoint::new(5.0, 5.0) });
    let why: Vec<_> = see(&mut node, 0, 0).notices.iter().map(|n| (n.answers, n.notice)).collect();
    let refused = |ball, why| Notice::NotTaught { ball, why };
    assert_eq!(why[0], (Some(0), refused(ball, NotTaught::Outside)));
    assert!(matches!(why[1], (Some(1), Notice::NotTaught { ball: Ball::Blue, .. })), "{why:?}");

    let learnt_at = |diameter| {
        let reference = crate::vision::colour::Reference {
            primary: Primary::Green,
            reference: crate::vision::frame::Rgb::new(20, 200, 30),
            typical: crate::vision::frame::Rgb::new(20, 200, 30),
            background: crate::vision::frame::Rgb::new(90, 90, 90),
        };
        let learnt = LearntBall { reference, diameter, aspect: 1.0 };
        let mut fresh = node.clone();
        told(&mut fresh, 9, Command::SetReference { ball, learnt }).unwrap().1
    };
    assert_eq!(learnt_at(1.0), refused(ball, NotTaught::Size));
    assert_eq!(learnt_at(15.0), Notice::Done);
    let counted: Vec<_> = vec![node.refuse(BadPicture::Length), node.not_understood(), node.not_understood()]
        .into_iter()
        .chain([node.line_overrun()])
        .map(|notice| (notice.sequence, notice.answers, notice.notice))
        .collect();
    assert_eq!(
        counted,
        [
            (2, None, Notice::PictureRefused { why: BadPicture::Length }),
            (3, None, Notice::NotUnderstood { count: 1 }),
            (4, None, Notice::NotUnderstood { count: 2 }),
            (5, None, Notice::LineOverrun { count: 1 }),
        ]
    );
}

#[test]
fn the_self_test_passes_here_as_everywhere() {
    assert_eq!(told(&mut node(), 0, Command::SelfTest), Some((Some(0), Notice::Done)));
    assert!(self_test::outcome().is_some());
}
