//! Promise: what boards are compared with is worth comparing.

use std::collections::BTreeSet;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::ObservationState;
use tetrad_core::wire::{MotionPacket, Notice, ObservationPacket, Packet};
use tetrad_fixtures::Scene;
use tetrad_qemu::clip::{COVERED, Sequence, others, sequences};
use tetrad_qemu::hand::shown;
use tetrad_qemu::probes::CASE_BYTES;
use tetrad_qemu::tape::{Event, Mode, Tape};
use tetrad_qemu::{arm, desktop, given, recorded};

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

#[test]
fn every_scene_is_compared_once() {
    let shown: Vec<_> = sequences().into_iter().chain(others()).map(|sequence| sequence.scene).collect();
    for (name, _) in Scene::names() {
        let times = shown.iter().filter(|scene| **scene == name).count();
        assert_eq!(times, 1, "{name}");
    }
}

#[test]
fn few_of_the_other_scenes_have_balls_too_small_to_be_tracked() {
    let untracked: Vec<_> = others()
        .iter()
        .filter(|sequence| {
            let packets = desktop::packets(&desktop::line(&Tape::of(sequence)));
            let measured = |seen: &&ObservationPacket| seen.balls.iter().any(|ball| ball.state.is_measured());
            observations(&packets).iter().filter(|seen| measured(seen)).count() <= sequence.frames.len()
        })
        .map(|sequence| sequence.scene)
        .collect();
    assert_eq!(untracked, ["static-5px", "static-side-5px"]);
}

#[test]
fn balls_that_a_camera_is_told_of_are_seen() {
    let tape = given::tape(&Sequence { scene: "demo", frames: (1..6).collect() });
    let packets = desktop::packets(&desktop::line(&tape));
    let count = |is: fn(&Notice) -> bool| {
        let notices = packets.iter().filter_map(|packet| match packet {
            Packet::Notice(told) => Some(told.notice),
            _ => None,
        });
        notices.filter(is).count()
    };
    assert_eq!(count(|notice| matches!(notice, Notice::Untaught { .. })), 4, "windows of unknown balls");
    assert_eq!(count(|notice| *notice == Notice::Done), 8 + 3, "both of each; start, self-test, stop");
    let seen = observations(&packets);
    assert_eq!(seen.len(), 6);
    assert!(seen.iter().flat_map(|seen| &seen.balls).all(|ball| ball.state.is_measured()), "{seen:?}");
}

#[test]
fn balls_of_the_recorded_frames_are_seen() {
    let packets = desktop::packets(&desktop::line(&recorded::tape()));
    let seen = observations(&packets);
    assert_eq!(seen.len(), 6);
    assert!(seen.iter().flat_map(|seen| &seen.balls).all(|ball| ball.state.is_measured()), "{packets:?}");
}

#[test]
fn a_hand_is_measured_carried_on_lost_and_latched_in_what_is_compared() {
    for mode in Mode::ALL {
        let mut states = BTreeSet::new();
        for shown in shown() {
            let motions = motions(&desktop::answers(&shown.tape(mode)));
            assert_eq!(motions.len(), shown.sequence.frames.len() + 1, "each instant is told of");
            states.extend(motions.iter().map(|motion| motion.state));
            let latches = motions.last().map(|motion| motion.engagements);
            assert_eq!(latches, Some(2), "{mode:?}, {}", shown.sequence.scene);
            let moved = motions.iter().filter(|motion| motion.since_engage.translation != [0.0; 3]).count();
            assert!(2 * moved > motions.len(), "{mode:?}, {}: {moved}", shown.sequence.scene);
        }
        let expected: &[PoseState] = match mode {
            // it knows complete frames and others
            Mode::Paper => &[PoseState::Both, PoseState::Held, PoseState::Lost],
            Mode::Refined => &PoseState::ALL,
        };
        assert!(states.iter().eq(expected), "{mode:?}: {states:?}");
    }
}

#[test]
fn the_arm_is_asked_for_what_is_in_reach_and_what_is_not() {
    let tape = arm::tape();
    assert!(tape.events.len() > 80, "{} cases", tape.events.len());
    let mut lengths = BTreeSet::new();
    for event in &tape.events {
        assert!(matches!(event, Event::Case(bytes) if bytes.len() == CASE_BYTES), "{event:?}");
        let alone = Tape { events: vec![event.clone()], ..tape.clone() };
        lengths.insert(desktop::answers(&alone).len());
    }
    // where the joints bring the tool, and for each precision eight solutions or a reason
    assert_eq!(lengths, BTreeSet::from([48 + 2 * 2, 48 + 2 * (1 + 8 * (3 + 1 + 6 * 4))]));
}

fn motions(line: &[u8]) -> Vec<MotionPacket> {
    let motion = |packet| match packet {
        Packet::Motion(motion) => Some(motion),
        _ => None,
    };
    desktop::packets(line).into_iter().filter_map(motion).collect()
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
