//! Thumbnails: how often, of which ball, and of which pixels.

use super::*;
use crate::observation::{Observation, ObservationState, Observations};
use crate::wire::{MAX_BODY_LEN, encode_body};

/// No two pixels of it are the same: RGB565, high byte first, the column and the row in them.
struct Picture {
    bytes: Vec<u8>,
    size: (u16, u16),
}

impl Picture {
    fn of(width: u16, height: u16, number: u16) -> Self {
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let bytes = places.flat_map(|(x, y)| value(x, y, number).to_be_bytes()).collect();
        Self { bytes, size: (width, height) }
    }

    fn view(&self) -> FrameView<'_> {
        FrameView::packed(&self.bytes, self.size.0, self.size.1, PixelFormat::Rgb565Be).unwrap()
    }
}

const fn value(x: u16, y: u16, number: u16) -> u16 {
    x.wrapping_add(y.wrapping_mul(331)).wrapping_add(number.wrapping_mul(7919))
}

fn ball(state: ObservationState, u: f32, v: f32, diameter: f32) -> Observation {
    Observation { state, centre: ImagePoint::new(u, v), diameter, ..Observation::default() }
}

/// Red and blue are there, green is hidden, yellow is lost.
fn balls() -> Observations {
    use ObservationState::{Lost, Occluded, Predicted, Visible};
    [
        ball(Visible, 60.0, 50.0, 16.0),
        ball(Predicted, 100.0, 60.0, 8.0),
        ball(Occluded, 120.4, 80.0, 20.0),
        ball(Lost, 0.0, 0.0, 20.0),
    ]
}

/// The strips that come with so many pictures, each of which is another.
fn strips(
    preview: &mut Preview,
    balls: &Observations,
    size: (u16, u16),
    pictures: u16,
) -> Vec<Option<PreviewPacket>> {
    let shown = |number: u16| {
        let picture = Picture::of(size.0, size.1, number);
        preview.picture(&picture.view(), balls, (1, 7, number.into()))
    };
    (0..pictures).map(shown).collect()
}

fn every(every: u16) -> Preview {
    let mut preview = Preview::off();
    preview.begin(every);
    preview
}

/// That three strips are one thumbnail, of its picture's pixels.
fn check(strips: &[Option<PreviewPacket>]) -> PreviewPacket {
    let first = strips[0].unwrap();
    let number = u16::try_from(first.sequence).unwrap();
    for (strip, row) in strips.iter().zip([0, 6, 12]) {
        let strip = strip.unwrap();
        assert_eq!(PreviewPacket { row, pixels: strip.pixels, ..first }, strip, "one thumbnail");
        for (pixels, row) in strip.pixels.iter().zip(u16::from(row)..) {
            for (pixel, column) in pixels.chunks(2).zip(0_u16..) {
                let step = u16::from(strip.step);
                let (x, y) = (strip.left + step * column + step / 2, strip.top + step * row + step / 2);
                assert_eq!(pixel, value(x, y, number).to_be_bytes(), "({column}, {row})");
            }
        }
    }
    first
}

#[test]
fn each_ball_with_a_place_has_its_turn_and_a_thumbnail_is_of_one_picture() {
    let came = strips(&mut every(5), &balls(), (160, 120), 20);
    let shown: Vec<_> = came
        .chunks(5)
        .map(|pictures| {
            assert_eq!(pictures[3..], [None, None], "between two of them");
            let first = check(&pictures[..3]);
            (first.sequence, first.ball, first.step, first.left, first.top)
        })
        .collect();
    let expected = [
        (0, Ball::Red, 2, 60 - 16, 50 - 18),
        (5, Ball::Green, 1, 100 - 8, 60 - 9),
        (10, Ball::Blue, 3, 120 - 24, 80 - 27),
        (15, Ball::Red, 2, 60 - 16, 50 - 18),
    ];
    assert_eq!(shown, expected, "yellow is lost");
}

#[test]
fn as_often_as_it_was_asked_for_and_never_before_the_last_strip_went() {
    let began = |preview: &mut Preview, pictures| {
        let came = strips(preview, &balls(), (160, 120), pictures);
        let first =
            |strip: &Option<PreviewPacket>| strip.filter(|strip| strip.row == 0).map(|strip| strip.sequence);
        came.iter().filter_map(first).collect::<Vec<_>>()
    };
    assert_eq!(began(&mut every(0), 50), []);
    assert_eq!(began(&mut Preview::off(), 50), []);
    for often in [1, 2, 3] {
        assert_eq!(began(&mut every(often), 9), [0, 3, 6], "{often}");
    }
    assert_eq!(began(&mut every(30), 65), [0, 30, 60]);
    assert_eq!(began(&mut every(u16::MAX), 300), [0]);
    let mut changed = every(30);
    assert_eq!(began(&mut changed, 2), [0]);
    changed.begin(4);
    assert_eq!(began(&mut changed, 5), [0, 4], "anew, without the rest of the old one");
    changed.begin(0);
    assert_eq!(began(&mut changed, 5), []);
}

#[test]
fn where_no_ball_has_a_place_the_next_that_has_is_shown_at_once() {
    let mut preview = every(10);
    let lost = [Observation::default(); BALLS];
    assert_eq!(strips(&mut preview, &lost, (160, 120), 30), vec![None; 30]);
    let mut found = lost;
    found[3] = balls()[0];
    let came = strips(&mut preview, &found, (160, 120), 11);
    assert_eq!(check(&came[..3]).ball, Ball::Yellow);
    assert_eq!((came[3], came[10].unwrap().ball), (None, Ball::Yellow), "alone it has each turn");
}

#[test]
fn a_thumbnail_stays_inside_the_picture() {
    use ObservationState::{Predicted, Visible};
    let placed = |seen, size| {
        let came = strips(&mut every(1), &[seen; BALLS], size, 3);
        came[0]?;
        let first = check(&came);
        Some((first.left, first.top, first.step))
    };
    let corner = |u, v| placed(ball(Visible, u, v, 16.0), (160, 120));
    assert_eq!(corner(0.0, 0.0), Some((0, 0, 2)));
    assert_eq!(corner(159.0, 119.0), Some((160 - 32, 120 - 36, 2)));
    assert_eq!(placed(ball(Predicted, -1e9, 1e9, 16.0), (160, 120)), Some((0, 120 - 36, 2)));
    // what core never says is no harm
    assert_eq!(
        placed(ball(Predicted, f32::NAN, f32::INFINITY, f32::NAN), (160, 120)),
        Some((0, 120 - 18, 1))
    );
    // a ball as large as the picture
    assert_eq!(placed(ball(Visible, 80.0, 60.0, 1e9), (160, 120)), Some((32, 6, 6)));
    assert_eq!(placed(ball(Visible, 4000.0, 4000.0, 8000.0), (8192, 64)), Some((3976, 10, 3)));
    assert_eq!(placed(ball(Visible, 8.0, 9.0, 16.0), (16, 18)), Some((0, 0, 1)), "just large enough");
    assert_eq!(placed(ball(Visible, 8.0, 8.0, 16.0), (16, 17)), None);
    assert_eq!(placed(ball(Visible, 8.0, 8.0, 16.0), (15, 64)), None);
    assert_eq!(placed(ball(Visible, 0.0, 0.0, 16.0), (1, 1)), None);
}

#[test]
fn other_formats_give_the_nearest_colours() {
    let mut preview = every(1);
    let bytes = [250, 130, 15].repeat(32 * 32);
    let frame = FrameView::packed(&bytes, 32, 32, PixelFormat::Rgb888).unwrap();
    let strip =
        preview.picture(&frame, &[ball(ObservationState::Visible, 16.0, 16.0, 4.0); BALLS], (0, 0, 0));
    let expected = (31_u16 << 11 | 32 << 5 | 1).to_be_bytes();
    assert!(strip.unwrap().pixels.as_flattened().chunks(2).all(|pixel| pixel == expected));
}

#[test]
fn observations_are_the_same_with_and_without() {
    let mut nodes = [node(), node()];
    let [_, with] = &mut nodes;
    assert_eq!(told(with, 0, Command::Preview { every: 4 }), Some((Some(0), Notice::Done)));
    for node in &mut nodes {
        told(node, 1, Command::Learn { ball: Ball::Red, at: AT });
        see(node, 0, 0);
        told(node, 2, Command::Start);
    }
    let mut thumbnails = 0;
    for (number, shift) in (0..12).zip([0, 2, 4, 6, 8, 10].into_iter().cycle()) {
        let seen = nodes.each_mut().map(|node| see(node, shift, 33_000 * (number + 1)));
        assert_eq!(seen[0].preview, None);
        let bodies = seen.each_ref().map(|seen| {
            let mut body = [0; MAX_BODY_LEN];
            let length = encode_body(&seen.observation.unwrap().into(), &mut body).unwrap();
            (body, length)
        });
        assert_eq!(bodies[0], bodies[1], "to the byte");
        let Some(strip) = seen[1].preview else { continue };
        let observation = seen[1].observation.unwrap();
        assert_eq!((strip.camera, strip.session, strip.ball), (1, 7, Ball::Red), "the others are not taught");
        let after = strip.row as usize / PreviewPacket::STRIP_ROWS;
        assert_eq!(strip.sequence as usize, observation.sequence as usize - after);
        if strip.row == 0 {
            let middle = strip.left + 8 * u16::from(strip.step);
            assert!((f32::from(middle) - observation.balls[0].centre.u).abs() <= 1.0, "{strip:?}");
            thumbnails += 1;
        }
    }
    assert_eq!(thumbnails, 3);
}

#[test]
fn nothing_is_shown_while_it_is_stopped_and_nothing_old_behind_that() {
    let mut node = node();
    told(&mut node, 0, Command::Learn { ball: Ball::Red, at: AT });
    see(&mut node, 0, 0);
    told(&mut node, 1, Command::Preview { every: 100 });
    assert_eq!(see(&mut node, 0, 33_000), Seen::default());
    told(&mut node, 2, Command::Start);
    assert_eq!(see(&mut node, 0, 66_000).preview.unwrap().row, 0);
    told(&mut node, 3, Command::Stop);
    assert_eq!(see(&mut node, 0, 99_000).preview, None);
    told(&mut node, 4, Command::Start);
    let strip = see(&mut node, 0, 132_000).preview.unwrap();
    assert_eq!((strip.row, strip.sequence), (0, 1), "one of now");
}
