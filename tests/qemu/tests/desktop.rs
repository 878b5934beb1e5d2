//! Promise: what boards are compared with is worth comparing.

use tetrad_core::observation::ObservationState;
use tetrad_core::wire::{Notice, ObservationPacket, Packet};
use tetrad_qemu::clip::{COVERED, Sequence, sequences};
use tetrad_qemu::desktop;
use tetrad_qemu::tape::{Event, Mode, Tape};

#[test]
fn what_is_compared_is_of_balls_that_are_seen() {
    let tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..4).collect() });
    let packets = desktop::packets(&desktop::line(&tape));
    let learnt = |packet: &&Packet| matches!(packet, Packet::Notice(notice) if matches!(notice.notice, Notice::Learnt { .. }));
    assert_eq!(packets.iter().filter(learnt).count(), 4, "{packets:?}");
    let seen = observations(&packets);
    assert_eq!(seen.len(), 4);
    assert!(seen.iter().flat_map(|seen| &seen.balls).all(|ball| ball.state.is_measured()), "{seen:?}");
    let done = |packet: &&Packet| matches!(packet, Packet::Notice(notice) if notice.notice == Notice::Done);
    assert_eq!(packets.iter().filter(done).count(), 3, "start, self-test, stop");
}

#[test]
fn a_wrong_length_is_refused_and_the_next_picture_is_looked_at() {
    let mut tape = Tape::of(&Sequence { scene: "static-30px", frames: (1..4).collect() });
    let whole = desktop::packets(&desktop::line(&tape));
    let place = tape.events.iter().position(|event| matches!(event, Event::Picture(..))).map(|at| at + 2);
    if let Some(Event::Picture(_, bytes)) = place.and_then(|at| tape.events.get_mut(at)) {
        bytes.pop();
    }
    let damaged = desktop::packets(&desktop::line(&tape));
    assert_eq!(damaged.len(), whole.len(), "a notice instead of an observation");
}

#[test]
fn balls_are_hidden_lost_and_found_in_what_is_compared() {
    let sequences = sequences();
    let covered = sequences.iter().find(|sequence| sequence.scene == COVERED);
    let mut tape = Tape::of(covered.expect("it is one of them"));
    for mode in Mode::ALL {
        tape.mode = mode;
        let packets = desktop::packets(&desktop::line(&tape));
        let seen = observations(&packets);
        let first = |state| seen.iter().position(|seen| seen.balls.iter().any(|ball| ball.state == state));
        let lost = first(ObservationState::Lost).unwrap_or_else(|| panic!("{mode:?}: never lost: {seen:?}"));
        let hidden = first(ObservationState::Predicted);
        assert!(hidden.is_some_and(|hidden| hidden < lost), "{mode:?}: {seen:?}");
        let last = seen.last().map(|seen| seen.balls);
        assert!(last.iter().flatten().all(|ball| ball.state.is_measured()), "{mode:?}: {last:?}");
    }
}

fn observations(packets: &[Packet]) -> Vec<&ObservationPacket> {
    packets
        .iter()
        .filter_map(|packet| match packet {
            Packet::Observation(seen) => Some(seen),
            _ => None,
        })
        .collect()
}
