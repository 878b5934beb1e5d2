//! What two smart cameras saw of a hand, and an operator's presses, as a tape.

use crate::clip::{COVERED, FORMAT, Sequence};
use crate::desktop;
use crate::tape::{Event, Mode, Tape};
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::wire::{ButtonsPacket, ObservationPacket, Packet};
use tetrad_fixtures::packets;

/// What is shown, and what happens at which of its instants. Each sequence is pressed for at its third.
#[derive(Clone, Debug)]
pub struct Shown {
    /// What both cameras are shown.
    pub sequence: Sequence,
    /// Where the operator presses anew: the hand is latched, or will be when it is seen.
    pub pressed_at: usize,
    /// Where the second camera sees nothing.
    pub blind: std::ops::Range<usize>,
    /// An instant that comes behind the one after it.
    pub late: usize,
}

/// A hand that moves about; that is covered, lost and found, and latched while it is away; that turns until
/// one ball hides another; and that leaves the picture in part.
#[must_use]
pub fn shown() -> [Shown; 4] {
    let shown = |scene, frames, pressed_at, blind, late| Shown {
        sequence: Sequence { scene, frames },
        pressed_at,
        blind,
        late,
    };
    [
        shown("demo", (1..60).collect(), 30, 20..26, 45),
        shown(COVERED, (41..56).step_by(2).chain([75, 101]).chain(102..125).collect(), 9, 25..27, 30),
        shown("crossing", (80..150).step_by(2).collect(), 25, 30..32, 10),
        shown("edge", (30..60).collect(), 20, 0..0, 5),
    ]
}

impl Shown {
    /// What the hand's follower is told.
    ///
    /// # Panics
    /// When there is no such scene.
    #[must_use]
    pub fn tape(&self, mode: Mode) -> Tape {
        let [left, right] = [0, 1].map(|camera| self.seen(camera, mode));
        let mut instants: Vec<_> = left.into_iter().zip(right).collect();
        for (_, right) in instants.get_mut(self.blind.clone()).into_iter().flatten() {
            right.balls = [Observation::default(); BALLS];
        }
        instants.swap(self.late, self.late + 1);
        let mut events = Vec::new();
        let mut buttons = 0..;
        for (at, (left, right)) in instants.into_iter().enumerate() {
            if at == 2 || at == self.pressed_at {
                for pressed in [false, true] {
                    let told = packets::buttons(9, buttons.next().unwrap_or(0));
                    events.push(Event::packet(&ButtonsPacket { pressed, ..told }.into()));
                }
            }
            events.extend([left, right].map(|seen| Event::packet(&seen.into())));
        }
        Tape { size: (0, 0), format: FORMAT, mode, events }
    }

    /// What a smart camera tells of its pictures.
    fn seen(&self, camera: u8, mode: Mode) -> Vec<ObservationPacket> {
        let pictures = Tape { mode, ..Tape::of_camera(&self.sequence, usize::from(camera)) };
        let observation = |packet| match packet {
            Packet::Observation(seen) => Some(ObservationPacket { camera, ..seen }),
            _ => None,
        };
        desktop::packets(&desktop::line(&pictures)).into_iter().filter_map(observation).collect()
    }
}
