use super::*;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{Ball, ObservationState};
use tetrad_fixtures::packets;

const SIZE: (u16, u16) = (160, 120);

/// Taken at 1000 times its number by this station's clock, with every ball as many pixels from the left.
fn observed(sequence: u32) -> Received<ObservationPacket> {
    let mut what = ObservationPacket { width: SIZE.0, height: SIZE.1, ..packets::observation(7, sequence) };
    for ball in &mut what.balls {
        ball.state = ObservationState::Visible;
        ball.centre = ImagePoint::new(sequence as f32, 60.0);
    }
    let at_us = 1_000 * u64::from(sequence);
    Received { what, received_us: at_us + 100, captured_us: Some(at_us) }
}

/// The strips of a thumbnail whose every pixel says which picture and which place in it is its.
fn strips(sequence: u32, ball: Ball, (left, top, step): (u16, u16, u8)) -> [PreviewPacket; 3] {
    [0, 6, 12].map(|row| {
        let pixel = |y: u8, x: u8| [sequence as u8, y.wrapping_mul(16).wrapping_add(x)];
        let pixels =
            std::array::from_fn(|y| std::array::from_fn(|at| pixel(row + y as u8, at as u8 / 2)[at % 2]));
        PreviewPacket { camera: 0, session: 7, sequence, ball, left, top, step, row, pixels }
    })
}

/// A thumbnail that comes as it should: the first strip behind the observations of its picture.
fn show(thumbnails: &mut Thumbnails, sequence: u32, ball: Ball, place: (u16, u16, u8)) -> Option<Pieced> {
    for (strip, after) in strips(sequence, ball, place).iter().zip(0..) {
        thumbnails.take(strip, Some(&observed(sequence + after)));
    }
    thumbnails.take_picture()
}

fn pixel(pieced: &Pieced, x: usize, y: usize) -> [u8; 2] {
    let at = 2 * (y * usize::from(pieced.packet.width) + x);
    [pieced.bytes[at], pieced.bytes[at + 1]]
}

#[test]
fn a_thumbnail_is_where_its_window_was_each_pixel_as_large_as_what_it_stands_for() {
    let mut thumbnails = Thumbnails::default();
    let pieced = show(&mut thumbnails, 9, Ball::Green, (40, 30, 2)).unwrap();
    for y in 0..usize::from(SIZE.1) {
        for x in 0..usize::from(SIZE.0) {
            let inside = (40..72).contains(&x) && (30..66).contains(&y);
            let expected = if inside { [9, (16 * ((y - 30) / 2) + (x - 40) / 2) as u8] } else { DARK };
            assert_eq!(pixel(&pieced, x, y), expected, "({x}, {y})");
        }
    }
    assert_eq!((pieced.packet.capture_us, pieced.packet.sequence), (9_000, 9), "when its picture was taken");
    let states = pieced.packet.balls.map(|ball| (ball.state, ball.centre.u));
    let lost = (ObservationState::Lost, 0.0);
    assert_eq!(states, [lost, (ObservationState::Visible, 9.0), lost, lost]);
    assert!(pieced.view().is_some());
    assert_eq!(thumbnails.take_picture(), None, "it was taken");
}

#[test]
fn a_thumbnail_without_one_of_its_strips_is_not_shown_and_the_next_is() {
    for lost in 0..3 {
        let mut thumbnails = Thumbnails::default();
        for (number, after) in (0..3).zip(0..).filter(|(number, _)| *number != lost) {
            thumbnails.take(&strips(9, Ball::Red, (40, 30, 1))[number], Some(&observed(9 + after)));
        }
        assert_eq!(thumbnails.take_picture(), None, "strip {lost}");
        let pieced = show(&mut thumbnails, 20, Ball::Red, (40, 30, 1)).unwrap();
        for y in 30..48 {
            assert_eq!(pixel(&pieced, 40, y)[0], 20, "of one picture alone");
        }
    }
}

#[test]
fn strips_of_two_thumbnails_are_never_one() {
    let (old, new) = (strips(9, Ball::Red, (40, 30, 1)), strips(15, Ball::Red, (40, 30, 1)));
    let other_ball = strips(9, Ball::Blue, (40, 30, 1));
    let moved = strips(9, Ball::Red, (41, 30, 1));
    for second in [new[1], other_ball[1], moved[1], old[0], old[2]] {
        let mut thumbnails = Thumbnails::default();
        thumbnails.take(&old[0], Some(&observed(9)));
        thumbnails.take(&second, Some(&observed(10)));
        thumbnails.take(&old[2], Some(&observed(11)));
        assert_eq!(thumbnails.take_picture(), None, "{second:?}");
    }
    // its observations did not come: nobody knows when it was taken
    let mut thumbnails = Thumbnails::default();
    for strip in old {
        thumbnails.take(&strip, Some(&observed(8)));
    }
    assert_eq!(thumbnails.take_picture(), None);
    for strip in old {
        thumbnails.take(&strip, None);
    }
    assert_eq!(thumbnails.take_picture(), None);
}

#[test]
fn the_newest_of_each_ball_stays_until_two_turns_have_gone_without_it() {
    let mut thumbnails = Thumbnails::default();
    let places = [(0, 0, 1), (20, 0, 1), (40, 0, 1), (60, 0, 1)];
    let mut pieced = None;
    for ((sequence, ball), place) in (10..).step_by(3).zip(Ball::ALL).zip(places) {
        pieced = show(&mut thumbnails, sequence, ball, place);
    }
    let numbers = |pieced: &Pieced| [0, 20, 40, 60].map(|x| pixel(pieced, x, 5)[0]);
    assert_eq!(numbers(&pieced.unwrap()), [10, 13, 16, 19]);
    // from now on red alone is seen
    let mut shown = Vec::new();
    for sequence in (30..).step_by(3).take(7) {
        shown.push(show(&mut thumbnails, sequence, Ball::Red, (0, 0, 1)).unwrap());
    }
    let dark = DARK[0];
    assert_eq!(numbers(&shown[0]), [30, 13, 16, 19]);
    assert_eq!(numbers(&shown[4]), [42, 13, 16, 19]);
    assert_eq!(numbers(&shown[5]), [45, dark, 16, 19]);
    assert_eq!(numbers(&shown[6]), [48, dark, dark, 19]);
    assert_eq!(shown[6].packet.balls[1].state, ObservationState::Lost);
    // the newest lies over the others
    let over = show(&mut thumbnails, 60, Ball::Green, (8, 0, 1)).unwrap();
    assert_eq!([7, 8].map(|x| pixel(&over, x, 5)[0]), [48, 60]);
}

#[test]
fn what_no_camera_says_is_no_harm() {
    let mut thumbnails = Thumbnails::default();
    for place in [(150, 110, 200), (u16::MAX, u16::MAX, u8::MAX), (0, u16::MAX, 1), (u16::MAX, 0, 1)] {
        let pieced = show(&mut thumbnails, 9, Ball::Red, place).unwrap();
        assert_eq!(pixel(&pieced, 0, 0), DARK);
    }
    for (width, height) in [(0, 0), (0, 9), (9, 0), (u16::MAX, u16::MAX)] {
        let mut last = observed(9);
        (last.what.width, last.what.height) = (width, height);
        for strip in strips(9, Ball::Red, (0, 0, 1)) {
            thumbnails.take(&strip, Some(&last));
        }
        let pieced = thumbnails.take_picture();
        assert!(pieced.is_none_or(|pieced| pieced.view().is_none()), "{width} x {height}");
    }
}
