//! The repository's recorded frames as a tape: smaller than a sensor's, low byte first.

use crate::tape::{Event, Mode, Tape};
use std::fs;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_core::wire::{Command, CommandPacket};
use tetrad_fixtures::golden::data;

/// How often each is shown.
const TIMES: usize = 3;

/// Both frames of `still`: the balls are taught in each anew.
///
/// # Panics
/// When the files are not what the fixtures' README says.
#[must_use]
pub fn tape() -> Tape {
    let places = fs::read_to_string(data("still_160x120.txt")).expect("where the balls are");
    let mut commands = 0..;
    let mut told = |command| {
        let sequence = commands.next().unwrap_or(0);
        Event::packet(&CommandPacket { session: 9, sequence, command }.into())
    };
    let mut events = vec![told(Command::Start)];
    for (side, first) in [("left", 0), ("right", TIMES)] {
        let learn = |(ball, at)| Command::Learn { ball, at };
        events.extend(places_of(&places, side).into_iter().map(learn).map(&mut told));
        let bytes = fs::read(data(&format!("still_{side}_160x120.rgb565"))).expect("a recorded frame");
        let picture = |number| Event::Picture(33_333 * number as u64, bytes.clone());
        events.extend((first..first + TIMES).map(picture));
    }
    Tape { size: (160, 120), format: PixelFormat::Rgb565Le, mode: Mode::Refined, events }
}

/// `side ball u v diameter`, a ball a line.
fn places_of(text: &str, side: &str) -> Vec<(Ball, ImagePoint)> {
    let place = |line: &str| {
        let mut words = line.split(' ').filter(|_| line.starts_with(side)).skip(1);
        let name = words.next()?;
        let ball = Ball::ALL.into_iter().find(|ball| ball.name() == name)?;
        let mut number = || words.next()?.parse().ok();
        Some((ball, ImagePoint::new(number()?, number()?)))
    };
    text.lines().filter_map(place).collect()
}
