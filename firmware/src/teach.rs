//! Learning by a button, without a host: held, the light goes through the balls' colours, one a second; let
//! go, the ball in the middle of the next picture is learnt as the one that was shown.

use crate::handover::{Input, Inputs};
use embassy_time::{Instant, Timer};
use embedded_hal::digital::InputPin;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::wire::{Command, CommandPacket};

/// How long each colour is shown, and nothing before the first: a tap does nothing, milliseconds.
const TURN_MS: u64 = 1000;

/// How often the button is looked at: more seldom than its contact bounces, milliseconds.
const LOOK_MS: u64 = 20;

/// The button's commands are of a session of its own.
const SESSION: u32 = u32::MAX;

/// Hosts count their commands up from 0, and notices answer by that number alone: the button counts down.
const FIRST: u32 = u32::MAX;

/// What a look at the button says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Look {
    /// The ball whose colour the light shows.
    pub shown: Option<Ball>,
    /// The ball that is to be learnt now.
    pub let_go: Option<Ball>,
}

/// The button.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Button {
    held_since_ms: Option<u64>,
}

impl Button {
    /// Looks at it.
    pub fn look(&mut self, is_held: bool, now_ms: u64) -> Look {
        let ball = self.held_since_ms.and_then(|since| ball_after(now_ms.saturating_sub(since)));
        if is_held {
            self.held_since_ms.get_or_insert(now_ms);
            Look { shown: ball, let_go: None }
        } else {
            self.held_since_ms = None;
            Look { shown: None, let_go: ball }
        }
    }
}

/// The ball that is shown after the button was held for so long. Behind the last there is a turn of none,
/// which is the way out.
fn ball_after(held_ms: u64) -> Option<Ball> {
    let turn = held_ms / TURN_MS % (BALLS as u64 + 1);
    Ball::ALL.into_iter().zip(1..).find(|(_, of)| *of == turn).map(|(ball, _)| ball)
}

/// Watches a button that pulls its pin low, for ever. `show` is called at each look. The camera is started
/// too, for nobody else may be there to do so.
pub async fn teach(
    mut pin: impl InputPin,
    mut show: impl FnMut(Option<Ball>),
    inputs: &Inputs,
    middle: ImagePoint,
) -> ! {
    let mut button = Button::default();
    let mut sequence = FIRST;
    loop {
        Timer::after_millis(LOOK_MS).await;
        // (a pin of a microcontroller can always be read)
        let look = button.look(pin.is_low().unwrap_or(false), Instant::now().as_millis());
        show(look.shown);
        let Some(ball) = look.let_go else { continue };
        for command in [Command::Learn { ball, at: middle }, Command::Start] {
            inputs.send(Input::Command(CommandPacket { session: SESSION, sequence, command })).await;
            sequence = sequence.wrapping_sub(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Holds the button for so long, looking as often as [`teach`] does; what was shown, and learnt.
    fn held(button: &mut Button, for_ms: u64) -> (std::vec::Vec<Option<Ball>>, Option<Ball>) {
        let mut shown = std::vec::Vec::new();
        for now in (0..for_ms).step_by(LOOK_MS as usize) {
            let look = button.look(true, 5_000 + now);
            assert_eq!(look.let_go, None);
            shown.push(look.shown);
        }
        let look = button.look(false, 5_000 + for_ms);
        assert_eq!(look.shown, None);
        shown.dedup();
        (shown, look.let_go)
    }

    #[test]
    fn a_tap_does_nothing() {
        let mut button = Button::default();
        assert_eq!(button.look(false, 0), Look::default());
        assert_eq!(held(&mut button, 900), (std::vec![None], None));
        assert_eq!(button.look(false, 9_000), Look::default());
    }

    #[test]
    fn held_it_offers_each_ball_and_then_none() {
        let mut button = Button::default();
        for (ball, seconds) in Ball::ALL.into_iter().zip(1..) {
            let (shown, let_go) = held(&mut button, 1000 * seconds + 500);
            assert_eq!(shown.last(), Some(&Some(ball)));
            assert_eq!(let_go, Some(ball), "what was shown last");
        }
        let (shown, let_go) = held(&mut button, 5_500);
        let [red, green, blue, yellow] = Ball::ALL.map(Some);
        assert_eq!(shown, [None, red, green, blue, yellow, None]);
        assert_eq!(let_go, None);
        assert_eq!(held(&mut button, 6_500).1, red, "and begins again");
    }

    #[test]
    fn a_contact_that_bounces_learns_once() {
        let mut button = Button::default();
        let mut learnt = std::vec::Vec::new();
        let bouncing = [
            (true, 0),
            (false, 20),
            (true, 40),
            (true, 2_000),
            (false, 2_020),
            (true, 2_040),
            (false, 2_060),
        ];
        for (is_held, now) in bouncing {
            learnt.extend(button.look(is_held, now).let_go);
        }
        assert_eq!(learnt, [Ball::Red]);
    }
}
