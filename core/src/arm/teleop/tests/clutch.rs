//! Let go, move the hand, engage again; and what cannot be reached.

use super::*;
use crate::config::Turning;

fn thousand_cycles<T: Real>(turning: Turning) {
    let mut rig = Rig::<T>::armed(&TeleopConfig { turning, ..TeleopConfig::default() });
    let mut random = Random::new(1);
    rig.arm.set_point.rotation = random.rotation(1.0).map(T::of);
    rig.arm.set_point.translation = random.vector(0.5).map(T::of);
    let start = rig.arm.set_point;
    let mut cycles = 0;
    for _ in 0..1000 {
        // the hand goes anywhere while nothing is engaged, and keeps still while it is
        rig.sender.hand = Pose { rotation: random.rotation(3.0), translation: random.vector(1.0) };
        // every other time the station's latch is an old one: only the pedal was let go
        if cycles % 2 == 0 {
            rig.press();
        } else {
            rig.sender.engaged = true;
            rig.frame();
            rig.button(true);
        }
        for _ in 0..3 {
            let decision = rig.step();
            assert_eq!((decision.status, decision.order), (Status::Engaged, Order::Follow(start)));
            rig.frame();
        }
        rig.release();
        rig.step();
        cycles += 1;
    }
    assert_eq!((cycles, rig.arm.set_point), (1000, start));
}

#[test]
fn a_thousand_clutch_cycles_with_a_still_hand_end_where_they_began_to_the_bit() {
    thousand_cycles::<f64>(Turning::Scaled(1.0));
    thousand_cycles::<f32>(Turning::Scaled(1.0));
    thousand_cycles::<f64>(Turning::Scaled(0.5));
    thousand_cycles::<f64>(Turning::Locked);
}

#[test]
fn an_arm_that_sags_does_not_creep_from_clutch_to_clutch() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
    let start = rig.arm.set_point;
    for _ in 0..100 {
        rig.arm.measured.translation = rig.arm.set_point.translation - Vector3::new(0.0, 0.0, 0.01);
        rig.press();
        rig.step();
        rig.release();
        rig.step();
    }
    assert_eq!(rig.arm.set_point, start);
}

#[test]
fn reaching_beyond_the_workspace_winds_nothing_up_and_the_way_back_begins_at_once() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    // 0.55 m to the edge, then 1.45 m beyond it
    let mut edge = 0;
    for _ in 0..200 {
        rig.move_hand(Vector3::new(0.01, 0.0, 0.0));
        edge += u32::from(rig.step().notes.contains(Note::WorkspaceEdge));
    }
    assert!((145..=146).contains(&edge), "{edge}");
    assert_eq!(rig.arm.set_point.translation.x, 0.95);
    rig.move_hand(Vector3::new(-0.01, 0.01, 0.0));
    let decision = rig.step();
    assert!(decision.notes.is_empty());
    let place = decision.order.goal().unwrap().translation;
    assert!((place - Vector3::new(0.94, 0.11, 0.8)).norm() < 1e-6, "{place}");
    // cycle after cycle against the edge
    for _ in 0..50 {
        rig.release();
        rig.step();
        rig.press();
        rig.move_hand(Vector3::new(0.03, 0.0, 0.0));
        rig.step();
    }
    assert_eq!(rig.arm.set_point.translation.x, 0.95);
    rig.move_hand(Vector3::new(-0.02, 0.0, 0.0));
    assert!((rig.step().order.goal().unwrap().translation.x - 0.93).abs() < 1e-6);
}

#[test]
fn an_arm_outside_the_workspace_is_not_pulled_in_but_may_come_in() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
    rig.arm.set_point.translation.z = -0.1;
    let start = rig.arm.set_point;
    rig.press();
    assert_eq!(rig.step().order, Order::Follow(start));
    rig.move_hand(Vector3::new(0.0, 0.0, -0.02));
    let decision = rig.step();
    assert!(decision.notes.contains(Note::WorkspaceEdge));
    assert_eq!(decision.order.goal().unwrap().translation.z, -0.1);
    let mut last = -0.1;
    for _ in 0..10 {
        rig.move_hand(Vector3::new(0.0, 0.0, 0.02));
        let z = rig.step().order.goal().unwrap().translation.z;
        assert!((z - last - 0.02).abs() < 1e-6, "{last} {z}");
        last = z;
    }
    // in by now, and not out again
    for _ in 0..10 {
        rig.move_hand(Vector3::new(0.0, 0.0, -0.02));
        last = rig.step().order.goal().unwrap().translation.z;
    }
    assert_eq!(last, 0.0);
}

#[test]
fn an_arm_that_does_not_follow_is_not_left_behind_by_more_than_the_lead() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    let (stuck, mut goal) = (rig.arm, *rig.step().order.goal().unwrap());
    let turn = so3::exp(&Vector3::new(0.0, 0.0, 0.05));
    for _ in 0..100 {
        rig.sender.hand.rotation *= turn;
        rig.move_hand(Vector3::new(0.01, 0.0, 0.0));
        let decision = rig.step();
        goal = *decision.order.goal().unwrap();
        rig.arm = stuck;
        let (metres, radians) = apart(&goal, &stuck.set_point);
        assert!(metres < 0.25 + 1e-9 && radians < 1.0 + 1e-9, "{metres} m, {radians} rad");
    }
    let (metres, radians) = apart(&goal, &stuck.set_point);
    assert!(metres > 0.25 - 1e-6 && radians > 1.0 - 1e-6, "{metres} m, {radians} rad");
    // the way back begins at once, for both
    rig.sender.hand.rotation *= turn.transpose();
    rig.move_hand(Vector3::new(-0.01, 0.0, 0.0));
    let decision = rig.step();
    assert!(decision.notes.is_empty());
    let (metres, radians) = apart(decision.order.goal().unwrap(), &goal);
    assert!((metres - 0.01).abs() < 1e-5 && (radians - 0.05).abs() < 1e-5, "{metres} m, {radians} rad");
}

#[test]
fn a_short_dropout_is_made_up_for_and_a_long_way_unseen_is_not() {
    // seen again after 0.3 s: the hand has gone on by a little, or by too much
    for (gone, followed) in [(0.1, 0.1), (0.2, 0.0)] {
        let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
        let before = rig.arm.set_point.translation;
        rig.wait(300_000 - FRAME_US);
        rig.button(true);
        assert_eq!(rig.step().status, Status::Hold(HoldReason::NoCommand));
        rig.move_hand(Vector3::new(gone, 0.0, 0.0));
        let decision = rig.step();
        assert_eq!(decision.status, Status::Engaged);
        assert_eq!(decision.notes.contains(Note::HandJumped), followed == 0.0);
        let moved = decision.order.goal().unwrap().translation - before;
        assert!((moved - Vector3::new(followed, 0.0, 0.0)).norm() < 1e-6, "{moved}");
    }
}

#[test]
fn the_motion_between_the_stations_latch_and_its_first_command_counts_if_it_follows_the_press() {
    // three commands lost, then one that tells of 20 mm since the latch
    for (pedal_late, moved) in [(false, 0.02), (true, 0.0)] {
        let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
        let before = rig.arm.set_point.translation;
        rig.sender.engage();
        if !pedal_late {
            rig.button(true);
        }
        rig.wait(3 * FRAME_US);
        rig.sender.hand.translation.x += 0.02;
        rig.frame();
        rig.wait(1);
        rig.button(true);
        let goal = rig.step().order.goal().unwrap().translation;
        assert!((goal - before - Vector3::new(moved, 0.0, 0.0)).norm() < 1e-6, "{pedal_late}: {goal}");
    }
}

#[test]
fn turns_can_be_scaled_or_locked() {
    let hand_turn = Vector3::new(0.3, -0.1, 0.2);
    for (turning, scale) in [(Turning::Scaled(0.5), 0.5), (Turning::Locked, 0.0), (Turning::Scaled(1.0), 1.0)]
    {
        let mut rig = Rig::<f64>::engaged(&TeleopConfig { turning, ..TeleopConfig::default() });
        let start = rig.arm.set_point.rotation;
        rig.sender.hand.rotation *= so3::exp(&hand_turn);
        rig.frame();
        let goal = rig.step().order.goal().unwrap().rotation;
        let expected = so3::exp(&(hand_turn * scale)) * start;
        assert!(law::angle(&goal, &expected) < 1e-6, "{turning:?}");
    }
}

#[test]
fn a_scaled_turn_beyond_half_a_turn_goes_on_smoothly() {
    let config = TeleopConfig { turning: Turning::Scaled(0.5), ..TeleopConfig::default() };
    let mut rig = Rig::<f64>::engaged(&config);
    let (turn, mut last) = (so3::exp(&Vector3::new(0.0, 0.03, 0.04)), rig.arm.set_point.rotation);
    for _ in 0..300 {
        rig.sender.hand.rotation *= turn;
        rig.move_hand(Vector3::zeros());
        let goal = rig.step().order.goal().unwrap().rotation;
        let step = law::angle(&goal, &last);
        assert!((step - 0.025).abs() < 1e-5, "{step}");
        last = goal;
    }
}
