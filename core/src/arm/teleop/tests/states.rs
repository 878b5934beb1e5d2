//! When the arm may move, one transition after the other.

use super::*;
use std::string::ToString;

fn rig() -> Rig<f64> {
    Rig::engaged(&TeleopConfig::default())
}

#[test]
fn nothing_moves_before_a_reset_a_release_and_a_fresh_press() {
    let mut rig = Rig::<f64>::new(&TeleopConfig::default());
    rig.sender.engage();
    rig.frame();
    assert_eq!(rig.step().status, Status::Stopped(StopReason::Started));
    assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Err(ResetRefusal::NoHoldToRun));
    rig.button(true);
    assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Err(ResetRefusal::Pressed));
    rig.button(false);
    rig.arm.condition = ArmCondition::NotReady;
    let refused = rig.teleop.reset(rig.now_us, &rig.arm);
    assert_eq!(refused, Err(ResetRefusal::Arm(FaultReason::ArmNotReady)));
    rig.arm.condition = ArmCondition::Ready;
    assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Ok(()));
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Press));
    rig.button(true);
    rig.frame();
    let before = rig.arm.set_point;
    let decision = rig.step();
    assert_eq!((decision.status, decision.order), (Status::Engaged, Order::Follow(before)));
    assert!(decision.notes.contains(Note::Latched));
}

#[test]
fn the_goal_is_the_set_point_moved_by_the_hand_in_the_robots_axes() {
    let config = TeleopConfig {
        scale: 0.5,
        // the hand's x is the robot's y, its y the robot's -x
        robot_from_hand: Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0),
        ..TeleopConfig::default()
    };
    let mut rig = Rig::<f64>::armed(&config);
    rig.arm.set_point.rotation = so3::exp(&Vector3::new(0.3, -0.4, 0.5));
    rig.arm.measured.translation += Vector3::new(0.0, 0.0, -0.01);
    rig.sender.hand.rotation = so3::exp(&Vector3::new(-1.0, 0.2, 0.7));
    let start = rig.arm.set_point;
    rig.press();
    assert_eq!(rig.step().order, Order::Follow(start), "the measured place plays no part");
    rig.sender.hand.rotation *= so3::exp(&Vector3::new(0.2, 0.0, 0.0));
    rig.move_hand(Vector3::new(0.08, 0.0, 0.02));
    let goal = *rig.step().order.goal().unwrap();
    let expected = Pose {
        translation: start.translation + Vector3::new(0.0, 0.04, 0.01),
        rotation: so3::exp(&Vector3::new(0.0, 0.2, 0.0)) * start.rotation,
    };
    let (metres, radians) = apart(&goal, &expected);
    assert!(metres < 1e-7 && radians < 1e-6, "{metres} m, {radians} rad");
}

#[test]
fn a_release_ends_it_at_once_and_a_press_between_two_steps_latches_anew() {
    let mut rig = rig();
    rig.move_hand(Vector3::new(0.05, 0.0, 0.0));
    rig.step();
    rig.button(false);
    let decision = rig.step();
    assert_eq!((decision.status, decision.order), (Status::Armed(ArmedReason::Press), Order::Stop));
    rig.button(true);
    rig.frame();
    rig.step();
    // let go, hand away, pressed again: no step was made in between
    let before = rig.arm.set_point;
    rig.button(false);
    rig.move_hand(Vector3::new(0.05, 0.0, 0.0));
    rig.button(true);
    assert_eq!(rig.step().order, Order::Follow(before));
}

#[test]
fn a_clutch_at_the_station_needs_no_release_of_the_pedal() {
    let mut rig = rig();
    rig.sender.engaged = false;
    rig.frame();
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Engage));
    rig.button(true);
    rig.sender.hand.translation.x += 0.3;
    rig.sender.engage();
    rig.frame();
    let before = rig.arm.set_point;
    assert_eq!(rig.step().order, Order::Follow(before));
}

#[test]
fn a_command_stands_for_a_tenth_of_a_second_on_the_receivers_clock() {
    let mut rig = rig();
    // the sender's clock may say what it likes
    rig.send(|command| command.capture_us = 0).unwrap();
    for (wait_us, status) in [
        (99_999, Status::Engaged),
        (1, Status::Engaged),
        (1, Status::Hold(HoldReason::NoCommand)),
        (499_999, Status::Hold(HoldReason::NoCommand)),
        (1, Status::Armed(ArmedReason::LetGo(HoldReason::NoCommand))),
    ] {
        rig.wait(wait_us);
        rig.button(true);
        let decision = rig.step();
        assert_eq!(decision.status, status, "{:?} us", decision.command_age_us);
        assert_eq!(decision.order.goal().is_some(), status == Status::Engaged);
    }
    // commands alone do not bring it back, nor does the button that was never released
    rig.frame();
    rig.button(true);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::LetGo(HoldReason::NoCommand)));
    rig.button(false);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Press));
    rig.button(true);
    assert_eq!(rig.step().status, Status::Engaged);
}

#[test]
fn a_station_that_did_not_look_for_half_a_second_does_not_go_on_by_itself() {
    let mut rig = rig();
    rig.wait(500_001 - FRAME_US);
    rig.frame();
    rig.button(true);
    let decision = rig.step();
    assert_eq!(decision.status, Status::Armed(ArmedReason::LetGo(HoldReason::NoCommand)));
    assert_eq!(decision.order, Order::Stop);
}

#[test]
fn hold_to_run_has_a_freshness_of_its_own() {
    let mut rig = rig();
    let heard_us = rig.now_us - FRAME_US;
    let mut seen = std::vec::Vec::new();
    while rig.now_us - heard_us < 1_000_000 {
        rig.frame();
        let status = rig.step().status;
        if seen.last().is_none_or(|(last, _)| *last != status) {
            seen.push((status, rig.now_us - heard_us));
        }
    }
    let states: std::vec::Vec<Status> = seen.iter().map(|(status, _)| *status).collect();
    let reason = HoldReason::NoHoldToRun;
    assert_eq!(states, [Status::Engaged, Status::Hold(reason), Status::Armed(ArmedReason::LetGo(reason))]);
    let hold_us = seen[1].1;
    assert!((200_000..200_000 + 2 * FRAME_US).contains(&hold_us), "{hold_us}");
    // heard again, still pressed: that is not a fresh press
    rig.button(true);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::LetGo(reason)));
}

#[test]
fn a_button_pressed_while_it_was_not_heard_is_not_fresh() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
    rig.sender.engage();
    for _ in 0..20 {
        rig.frame();
        rig.step();
    }
    rig.button(true);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::LetGo(HoldReason::NoHoldToRun)));
}

#[test]
fn a_stop_latches_and_nothing_queued_runs_after_it() {
    let mut rig = rig();
    rig.teleop.stop();
    let before = rig.arm.set_point;
    for _ in 0..10 {
        rig.move_hand(Vector3::new(0.02, 0.0, 0.0));
        let decision = rig.step();
        assert_eq!((decision.status, decision.order), (Status::Stopped(StopReason::Asked), Order::Stop));
    }
    rig.release();
    // a new latch and motion since then, all of it while stopped
    rig.sender.engage();
    rig.move_hand(Vector3::new(0.02, 0.0, 0.0));
    assert_eq!(rig.step().status, Status::Stopped(StopReason::Asked));
    assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Ok(()));
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Press));
    rig.button(true);
    assert_eq!(rig.step().status, Status::Hold(HoldReason::NoCommand), "old commands are forgotten");
    rig.move_hand(Vector3::new(0.02, 0.0, 0.0));
    let decision = rig.step();
    assert_eq!((decision.status, decision.order), (Status::Engaged, Order::Follow(before)));
}

#[test]
fn a_fault_of_the_arm_latches_by_name() {
    let nan = Pose { translation: Vector3::new(0.0, f64::NAN, 0.0), ..Pose::identity() };
    let skewed = Pose { rotation: Matrix3::identity() * 1.1, ..Pose::identity() };
    type Change = fn(&mut ArmView<f64>, Pose<f64>);
    let arms: [(Change, Pose<f64>, FaultReason); 5] = [
        (|arm, _| arm.condition = ArmCondition::Fault, Pose::identity(), FaultReason::Arm),
        (|arm, _| arm.condition = ArmCondition::NotReady, Pose::identity(), FaultReason::ArmNotReady),
        (|arm, bad| arm.set_point = bad, nan, FaultReason::ArmPoseNotFinite),
        (|arm, bad| arm.measured = bad, nan, FaultReason::ArmPoseNotFinite),
        (|arm, bad| arm.measured = bad, skewed, FaultReason::ArmPoseNotARotation),
    ];
    for (change, bad, reason) in arms {
        let mut rig = rig();
        let good = rig.arm;
        change(&mut rig.arm, bad);
        let decision = rig.step();
        assert_eq!((decision.status, decision.order), (Status::Fault(reason), Order::Stop));
        rig.release();
        assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Err(ResetRefusal::Arm(reason)));
        rig.arm = good;
        rig.teleop.stop();
        assert_eq!(rig.step().status, Status::Fault(reason), "the arm is well again; that takes a reset");
        assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Ok(()));
        assert_eq!(rig.step().status, Status::Armed(ArmedReason::Press));
    }
}

#[test]
fn a_clock_that_goes_back_is_a_fault_and_a_moment_is_none() {
    let mut rig = rig();
    rig.now_us -= 100_000;
    assert_eq!(rig.step().status, Status::Engaged);
    rig.now_us -= 3_600_000_000.min(rig.now_us);
    assert_eq!(rig.step().status, Status::Fault(FaultReason::ClockWentBack));
    rig.release();
    assert_eq!(rig.teleop.reset(rig.now_us, &rig.arm), Ok(()));
    rig.press();
    assert_eq!(rig.step().status, Status::Engaged);
}

#[test]
fn a_hand_that_is_not_measured_is_followed_for_a_bounded_time() {
    let mut rig = rig();
    rig.sender.state = PoseState::Predicted;
    let measured_us = rig.now_us;
    loop {
        rig.move_hand(Vector3::new(0.003, 0.0, 0.0));
        let decision = rig.step();
        if rig.now_us - measured_us > 200_000 {
            assert_eq!(decision.status, Status::Hold(HoldReason::HandNotMeasured));
            break;
        }
        assert_eq!(decision.status, Status::Engaged);
        assert!(decision.notes.contains(Note::Predicted));
    }
    rig.sender.state = PoseState::Held;
    rig.frame();
    assert_eq!(rig.step().status, Status::Hold(HoldReason::HandNotSeen));
    rig.sender.state = PoseState::One;
    rig.frame();
    assert_eq!(rig.step().status, Status::Engaged);
    rig.sender.state = PoseState::Lost;
    for _ in 0..20 {
        rig.frame();
        rig.button(true);
        rig.step();
    }
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::LetGo(HoldReason::HandNotSeen)));
}

#[test]
fn a_hand_is_latched_only_where_it_is_measured() {
    let mut rig = Rig::<f64>::armed(&TeleopConfig::default());
    rig.sender.state = PoseState::Predicted;
    rig.press();
    assert_eq!(rig.step().status, Status::Hold(HoldReason::HandNotMeasured));
    rig.sender.state = PoseState::Three;
    rig.frame();
    assert_eq!(rig.step().status, Status::Engaged);
}

#[test]
fn every_reason_says_what_to_do() {
    let bad = [BadCommand::NotFinite, BadCommand::NotARotation].map(HoldReason::BadCommand);
    let holds = [
        HoldReason::NoCommand,
        HoldReason::NoHoldToRun,
        HoldReason::HandNotSeen,
        HoldReason::HandNotMeasured,
        bad[0],
        bad[1],
    ];
    let stops = [StopReason::Started, StopReason::Asked, StopReason::TwoSenders, StopReason::Ending]
        .map(Status::Stopped);
    let faults = [
        FaultReason::ArmNotReady,
        FaultReason::Arm,
        FaultReason::ArmPoseNotFinite,
        FaultReason::ArmPoseNotARotation,
        FaultReason::ClockWentBack,
    ];
    let mut all: std::vec::Vec<Status> = stops.into_iter().chain(faults.map(Status::Fault)).collect();
    all.extend(holds.map(Status::Hold));
    all.extend(holds.map(|reason| Status::Armed(ArmedReason::LetGo(reason))));
    all.extend([ArmedReason::Press, ArmedReason::Engage, ArmedReason::NewSender].map(Status::Armed));
    let mut texts = std::collections::BTreeSet::new();
    for status in &all {
        let text = status.to_string();
        assert!(text.starts_with(status.state().name()), "{text}");
        let advice = ["reset", "press", "check", "show", "restart", "engage", "end", "let go"];
        assert!(advice.iter().any(|verb| text.contains(verb)), "{text}");
        assert!(texts.insert(text), "{status:?} is told like another one");
    }
    assert_eq!(
        Status::Hold(HoldReason::NoCommand).to_string(),
        "hold: no fresh command; check the link and the operator station"
    );
}
