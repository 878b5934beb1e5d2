use super::*;
use crate::station::node::board::{AT, Board, WIDTH};
use tetrad_core::geometry::ImagePoint;

fn only_red<T: Copy>(what: T) -> [Option<T>; BALLS] {
    [Some(what), None, None, None]
}

#[test]
fn a_ball_is_learnt_given_back_and_tracked() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    let taught = camera.learn(&only_red(AT)).unwrap();
    assert!((taught[0].unwrap().diameter - 20.5).abs() < 1.0 && taught[1].is_none(), "{taught:?}");
    camera.teach(&taught).unwrap();
    camera.place(&only_red(AT)).unwrap();
    camera.start().unwrap();
    for number in 0..20 {
        let Seen { packet, missed } = camera.next(|| false).unwrap().unwrap();
        assert_eq!((packet.sequence, missed, packet.width), (number, 0, WIDTH), "each, in order");
        assert!(packet.balls[0].state.is_measured(), "{packet:?}");
    }
    camera.stop().unwrap();
    assert_eq!(camera.take_notices(), Vec::<String>::new());
}

#[test]
fn a_line_that_loses_every_third_frame_costs_observations_and_no_command() {
    let board = Board::start(3, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    camera.learn(&only_red(AT)).unwrap();
    camera.start().unwrap();
    let (mut seen, mut missed) = (0, 0);
    while seen < 40 {
        let next = camera.next(|| false).unwrap().unwrap();
        assert!(next.packet.balls[0].state.is_measured(), "{next:?}");
        seen += 1;
        missed += next.missed;
    }
    assert!((10..40).contains(&missed), "{missed} of {}", seen + missed);
    camera.stop().unwrap();
}

#[test]
fn what_cannot_be_learnt_is_told_with_its_reason() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    for (at, why, exit) in [
        (ImagePoint::new(10.0, 10.0), NotTaught::Background, Exit::Failed),
        (ImagePoint::new(1000.0, 10.0), NotTaught::Outside, Exit::BadArguments),
    ] {
        let refused = camera.learn(&only_red(at)).unwrap_err();
        assert!(matches!(refused, SmartCameraError::NotTaught(Ball::Red, told) if told == why), "{refused}");
        assert_eq!(refused.exit(), exit);
        assert!(refused.to_string().contains("red"), "{refused}");
    }
    let placed = camera.place(&only_red(AT)).unwrap_err();
    assert!(
        matches!(placed, SmartCameraError::OtherAnswer(Notice::Untaught { ball: Ball::Red })),
        "{placed}"
    );
}

#[test]
fn a_camera_that_begins_anew_has_forgotten_what_it_was_taught() {
    // one packet alone may be damage
    let board = Board::start(0, |sequence| if sequence == 3 || sequence > 6 { 6 } else { 5 });
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    camera.start().unwrap();
    let numbers: Vec<u32> = (0..6).map(|_| camera.next(|| false).unwrap().unwrap().packet.sequence).collect();
    assert_eq!(numbers, [0, 1, 2, 4, 5, 6]);
    let error = camera.next(|| false).unwrap_err();
    assert!(matches!(error, SmartCameraError::BeganAnew), "{error}");
    assert_eq!(error.exit(), Exit::DeviceLost);
}

#[test]
fn a_port_that_is_not_there_is_named_with_what_mends_it() {
    let Err(error) = SmartCamera::open(Path::new("/no/port"), 115_200, 1) else { panic!("there is none") };
    assert!(error.to_string().contains("tetrad devices"), "{error}");
    assert_eq!(error.exit(), Exit::DeviceLost);
}

#[test]
fn whoever_waits_may_stop_waiting() {
    let board = Board::start(0, |_| 5);
    let mut camera = SmartCamera::open(&board.device, 115_200, 1).unwrap();
    assert_eq!(camera.next(|| true).unwrap(), None, "it was never started");
}
