//! Commands that do not count, by name and number.

use super::*;

#[test]
fn numbers_that_cannot_be_used_make_the_arm_hold() {
    type Bend = fn(&mut Command);
    let bends: [(Bend, BadCommand); 7] = [
        (|c| c.since_engage.translation.x = f32::NAN, BadCommand::NotFinite),
        (|c| c.since_engage.translation.y = f32::INFINITY, BadCommand::NotFinite),
        (|c| c.since_engage.translation.z = 2000.0, BadCommand::NotFinite),
        (|c| c.increment.rotation.m23 = f32::NAN, BadCommand::NotFinite),
        (|c| c.covariance = Some(PoseCovariance::from_element(f32::NAN)), BadCommand::NotFinite),
        (|c| c.since_engage.rotation *= 1.01, BadCommand::NotARotation),
        (|c| c.since_engage.rotation.m33 = -1.0, BadCommand::NotARotation),
    ];
    for (bend, bad) in bends {
        let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
        rig.move_hand(Vector3::new(0.01, 0.0, 0.0));
        let goal = rig.step().order;
        assert_eq!(rig.send(bend), Err(CommandRefusal::Bad(bad)));
        let decision = rig.step();
        assert_eq!(
            (decision.status, decision.order),
            (Status::Hold(HoldReason::BadCommand(bad)), Order::Stop)
        );
        assert_eq!(rig.teleop.counts().bad, 1);
        rig.frame();
        assert_eq!(rig.step().order, goal);
    }
}

#[test]
fn a_bad_command_can_still_release() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    rig.sender.engaged = false;
    assert!(rig.send(|c| c.since_engage.translation.x = f32::NAN).is_err());
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Engage));
}

#[test]
fn a_nearly_orthonormal_rotation_is_taken_for_the_nearest_one() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    rig.send(|c| c.since_engage.rotation *= 1.0003).unwrap();
    let goal = *rig.step().order.goal().unwrap();
    let skew = goal.rotation.transpose() * goal.rotation - Matrix3::identity();
    assert!(skew.norm() < 1e-14, "{skew}");
}

#[test]
fn reordered_and_repeated_commands_change_nothing() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    rig.sender.sequence = u32::MAX - 1;
    // half the numbers ahead, so that it is newer
    rig.teleop = {
        let mut fresh = Rig::<f64>::engaged(&TeleopConfig::default());
        fresh.sender.sequence = u32::MAX - 3;
        fresh.teleop.inbox = Inbox::new();
        fresh.teleop
    };
    let mut commands = std::vec::Vec::new();
    for _ in 0..6 {
        rig.sender.hand.translation.x += 0.01;
        rig.wait(FRAME_US);
        commands.push(Command { received_us: rig.now_us, ..rig.sender.command(rig.now_us) });
    }
    for command in &commands {
        assert_eq!(rig.teleop.take(command), Ok(()), "{}", command.sequence);
    }
    let before = rig.teleop;
    for command in &commands {
        assert_eq!(rig.teleop.take(command), Err(CommandRefusal::Old), "{}", command.sequence);
    }
    assert_eq!(rig.teleop.counts().old, 6);
    rig.teleop.inbox = before.inbox;
    assert_eq!(rig.teleop, before);
}

#[test]
fn a_second_station_stops_the_arm() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    assert_eq!(rig.send(|c| c.session = 8), Err(CommandRefusal::AnotherSender));
    let decision = rig.step();
    assert_eq!((decision.status, decision.order), (Status::Stopped(StopReason::TwoSenders), Order::Stop));
    assert_eq!(rig.teleop.counts().another_sender, 1);
}

#[test]
fn a_station_that_starts_anew_takes_a_fresh_press_and_its_past_is_dropped() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    let replayed = Command { received_us: 0, ..rig.sender.command(rig.now_us) };
    rig.wait(600_000);
    rig.button(true);
    // not one step in between: the arm's station was busy
    rig.sender = Sender { session: 8, sequence: 0, ..rig.sender };
    rig.frame();
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::NewSender));
    let late = Command { received_us: rig.now_us, ..replayed };
    assert_eq!(rig.teleop.take(&late), Err(CommandRefusal::OldSession));
    rig.release();
    rig.press();
    assert_eq!(rig.step().status, Status::Engaged);
    assert_eq!(rig.teleop.counts().old_session, 1);
}

#[test]
fn a_station_whose_end_is_known_is_followed_by_another_at_once_and_that_takes_a_fresh_press() {
    for state in [State::Engaged, State::Armed] {
        let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
        if state == State::Armed {
            rig.release();
            rig.step();
        }
        let replayed = Command { received_us: 0, ..rig.sender.command(rig.now_us) };
        rig.teleop.end_sender();
        assert_eq!(rig.step().status, Status::Armed(ArmedReason::NewSender), "{state:?}");
        // the next begins with its button held
        rig.sender = Sender { session: 8, sequence: 0, engaged: true, ..rig.sender };
        for _ in 0..3 {
            rig.button(true);
            rig.frame();
            assert_eq!(rig.step().order, Order::Stop);
        }
        let late = Command { received_us: rig.now_us, ..replayed };
        assert_eq!(rig.teleop.take(&late), Err(CommandRefusal::OldSession));
        assert_eq!(rig.step().status.state(), State::Armed, "what is left of the old one stops nothing");
        rig.release();
        rig.press();
        assert_eq!(rig.step().status, Status::Engaged);
        assert_eq!(rig.teleop.counts().another_sender, 0);
    }
}

#[test]
fn the_end_of_a_sender_ends_no_stop() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    rig.teleop.stop();
    rig.teleop.end_sender();
    assert_eq!(rig.step().status, Status::Stopped(StopReason::Asked));
    rig.teleop.stop_for(StopReason::Ending);
    assert_eq!(rig.step().status, Status::Stopped(StopReason::Ending));
}

#[test]
fn a_hand_that_is_somewhere_else_all_at_once_moves_nothing() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig::default());
    rig.move_hand(Vector3::new(0.05, 0.0, 0.0));
    rig.step();
    let before = rig.arm.set_point;
    // labels swapped for one frame: away and back
    for jump in [0.4, -0.4] {
        rig.move_hand(Vector3::new(0.0, jump, 0.0));
        let decision = rig.step();
        assert_eq!((decision.status, decision.order), (Status::Engaged, Order::Follow(before)));
        assert!(decision.notes.contains(Note::HandJumped));
    }
    rig.move_hand(Vector3::new(0.0, 0.0, 0.02));
    let goal = *rig.step().order.goal().unwrap();
    assert!((goal.translation - before.translation - Vector3::new(0.0, 0.0, 0.02)).norm() < 1e-6);
}

#[test]
fn what_is_known_of_the_hand_is_told_of_the_tool() {
    let mut rig = Rig::<f64>::engaged(&TeleopConfig { scale: 2.0, ..TeleopConfig::default() });
    let mut p = PoseCovariance::zeros();
    p.m11 = 9e-6;
    p.m22 = 16e-6;
    p.m44 = 1e-4;
    rig.send(|c| c.covariance = Some(p)).unwrap();
    let known = rig.step().uncertainty.unwrap();
    assert!((known.place_m - 0.01).abs() < 1e-8 && (known.turn_rad - 0.01).abs() < 1e-8, "{known:?}");
    rig.release();
    assert_eq!(rig.step().uncertainty, None);
}
