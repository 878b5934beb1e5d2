//! Stops of the console, wherever the buttons are: what is told to the slave, and until when.

use crate::console::Desk;
use crate::station::operator::Buttons;

/// Nobody resets what they have not seen: a reset that comes sooner after a stop was struck before it.
const SEEN_US: u64 = 250_000;

/// Which stops of the console the loop has told, and the resets it has told of whoever holds the buttons.
#[derive(Debug, Default)]
pub(super) struct Stops {
    told: u64,
    told_us: u64,
    resets: u32,
}

impl Stops {
    /// The buttons with the console's stop, to be told in this turn. They are those of the terminal, or of nobody: a
    /// reset there ends the stops that were told some time before it was read. One that came since stays: whoever asked
    /// for the reset cannot have known of it, and whoever stopped was answered that the arm is stopped.
    pub(super) fn with_buttons_elsewhere(&mut self, buttons: Buttons, desk: &Desk, now_us: u64) -> Buttons {
        let mut control = desk.control();
        let is_reset = std::mem::replace(&mut self.resets, buttons.resets) != buttons.resets;
        if is_reset && now_us.saturating_sub(self.told_us) >= SEEN_US {
            control.reset_elsewhere(self.told);
        }
        if std::mem::replace(&mut self.told, control.stops()) != self.told {
            self.told_us = now_us;
        }
        if control.is_stopped() { Buttons { pressed: false, stop: true, ..buttons } } else { buttons }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::Doorbell;
    use crate::robot::clock::Clock;

    fn released(resets: u32) -> Buttons {
        Buttons { resets, ..Buttons::default() }
    }

    fn stopped(resets: u32) -> Buttons {
        Buttons { stop: true, ..released(resets) }
    }

    fn desk() -> Desk {
        Desk::new(false, Vec::new(), Clock::given(), Doorbell::default())
    }

    /// When that was seen which was told at the start.
    const SEEN: u64 = SEEN_US;

    #[test]
    fn a_reset_ends_the_stops_that_were_seen_before_it() {
        let (desk, mut stops) = (desk(), Stops::default());
        let held = Buttons { pressed: true, ..released(0) };
        assert_eq!(stops.with_buttons_elsewhere(held, &desk, 0), held);
        desk.stop();
        assert_eq!(stops.with_buttons_elsewhere(held, &desk, 0), stopped(0), "a stop lets go");
        assert_eq!(stops.with_buttons_elsewhere(released(0), &desk, 1), stopped(0), "it latches");
        assert_eq!(stops.with_buttons_elsewhere(released(1), &desk, SEEN), released(1));
        assert!(!desk.buttons().stop);
    }

    #[test]
    fn a_stop_that_was_not_seen_yet_outlasts_a_reset() {
        let (desk, mut stops) = (desk(), Stops::default());
        stops.with_buttons_elsewhere(released(0), &desk, 0);
        // whichever came first, the loop hears of both at once
        desk.stop();
        assert_eq!(stops.with_buttons_elsewhere(released(1), &desk, SEEN), stopped(1));
        assert!(desk.buttons().stop, "whoever stopped was told so");
        // or of a key that was struck before it a moment later
        assert_eq!(stops.with_buttons_elsewhere(released(2), &desk, 2 * SEEN - 1), stopped(2));
        assert_eq!(
            stops.with_buttons_elsewhere(released(3), &desk, 2 * SEEN),
            released(3),
            "the next one ends it"
        );
        // and one that comes after the reset
        assert_eq!(stops.with_buttons_elsewhere(released(4), &desk, 3 * SEEN), released(4));
        desk.stop();
        assert_eq!(stops.with_buttons_elsewhere(released(4), &desk, 3 * SEEN), stopped(4));
    }

    #[test]
    fn a_second_stop_outlasts_the_reset_of_the_first() {
        let (desk, mut stops) = (desk(), Stops::default());
        desk.stop();
        assert_eq!(stops.with_buttons_elsewhere(released(0), &desk, 0), stopped(0));
        desk.stop();
        assert_eq!(stops.with_buttons_elsewhere(released(1), &desk, SEEN), stopped(1));
        assert!(desk.buttons().stop);
    }
}
