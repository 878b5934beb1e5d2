//! A press that is for going home.

use super::*;

fn home(rig: &mut Rig<f64>, pressed: bool) {
    rig.teleop.press_is_for(PressFor::Home, ScaleShare::FULL);
    rig.button(pressed);
}

fn follow(rig: &mut Rig<f64>, pressed: bool) {
    rig.teleop.press_is_for(PressFor::Follow, ScaleShare::FULL);
    rig.button(pressed);
}

fn rig() -> Rig<f64> {
    Rig::armed(&TeleopConfig::default())
}

#[test]
fn the_arm_goes_home_while_it_is_asked_to_and_the_hand_plays_no_part() {
    let mut rig = rig();
    rig.sender.engage();
    rig.sender.state = PoseState::Lost;
    home(&mut rig, true);
    rig.frame();
    for _ in 0..30 {
        rig.sender.hand.translation.x += 0.01;
        rig.frame();
        home(&mut rig, true);
        let decision = rig.step();
        assert_eq!((decision.order, decision.status), (Order::Home, Status::Engaged));
        assert!(decision.notes.contains(Note::GoesHome) && decision.uncertainty.is_none());
    }
    home(&mut rig, false);
    let decision = rig.step();
    assert_eq!((decision.order, decision.status), (Order::Stop, Status::Armed(ArmedReason::Press)));
    assert!(decision.notes.is_empty());
}

#[test]
fn it_takes_no_command_but_a_button_that_is_as_fresh_as_one() {
    let mut rig = rig();
    // no camera sees anything: no command at all
    rig.wait(10_000_000);
    home(&mut rig, false);
    rig.wait(20_000);
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Home);
    rig.wait(100_000);
    assert_eq!(rig.step().order, Order::Home);
    rig.wait(1);
    let decision = rig.step();
    assert_eq!((decision.order, decision.status), (Order::Stop, Status::Hold(HoldReason::NoHoldToRun)));
    // it goes on where that was a hiccup, and not after a silence
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Home);
    rig.wait(600_000);
    rig.step();
    home(&mut rig, true);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::LetGo(HoldReason::NoHoldToRun)));
}

#[test]
fn a_press_that_goes_on_for_something_else_has_ended() {
    for first in PressFor::ALL {
        let mut rig = rig();
        let (one, other) = match first {
            PressFor::Home => (home as fn(&mut Rig<f64>, bool), follow as fn(&mut Rig<f64>, bool)),
            PressFor::Follow => (follow as fn(&mut Rig<f64>, bool), home as fn(&mut Rig<f64>, bool)),
        };
        rig.sender.engage();
        rig.frame();
        one(&mut rig, true);
        assert_eq!(rig.step().status, Status::Engaged, "{first:?}");
        other(&mut rig, true);
        for _ in 0..20 {
            let decision = rig.step();
            assert_eq!(decision.order, Order::Stop);
            assert_eq!(decision.status, Status::Armed(ArmedReason::PressChanged), "{first:?}");
            rig.frame();
            other(&mut rig, true);
        }
        // nor does it come back as what it was
        one(&mut rig, true);
        assert_eq!(rig.step().order, Order::Stop);
        one(&mut rig, false);
        one(&mut rig, true);
        assert_eq!(rig.step().status, Status::Engaged, "{first:?}");
    }
}

#[test]
fn a_press_that_waits_for_the_hand_does_not_become_one_for_home() {
    let mut rig = rig();
    // the commands say that the hand is not engaged
    follow(&mut rig, true);
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::Engage));
    home(&mut rig, true);
    rig.sender.engage();
    rig.frame();
    assert_eq!(rig.step().status, Status::Armed(ArmedReason::PressChanged));
}

#[test]
fn after_the_way_home_the_hand_leads_from_there_without_a_jump() {
    let mut rig = rig();
    rig.sender.engage();
    rig.frame();
    home(&mut rig, true);
    rig.step();
    // the arm is on its way
    rig.arm.set_point.translation.z -= 0.2;
    rig.sender.hand.translation.x += 0.3;
    rig.release();
    rig.step();
    let there = rig.arm.set_point;
    rig.teleop.press_is_for(PressFor::Follow, ScaleShare::FULL);
    rig.press();
    assert_eq!(rig.step().order, Order::Follow(there));
}

#[test]
fn a_stop_ends_the_way_home_and_it_takes_a_reset() {
    let mut rig = rig();
    rig.sender.engage();
    rig.frame();
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Home);
    rig.teleop.stop();
    assert_eq!(rig.step().status, Status::Stopped(StopReason::Asked));
    home(&mut rig, false);
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Stop);
}

#[test]
fn a_sender_that_is_not_engaged_neither_bars_the_way_home_nor_begins_it_again() {
    let mut rig = rig();
    // nobody has engaged the hand
    for _ in 0..5 {
        rig.frame();
        rig.step();
    }
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Home);
    // it is engaged, and let go, on the way
    for engaged in [true, false, true] {
        if engaged {
            rig.sender.engage();
        } else {
            rig.sender.engaged = false;
        }
        rig.frame();
        home(&mut rig, true);
        assert_eq!(rig.step().order, Order::Home, "engaged: {engaged}");
    }
    // a press that has ended stays ended, whatever the sender does
    rig.wait(600_000);
    rig.step();
    for engaged in [true, false, true, false] {
        rig.sender.engaged = engaged;
        rig.frame();
        home(&mut rig, true);
        assert_eq!(rig.step().order, Order::Stop, "engaged: {engaged}");
    }
    home(&mut rig, false);
    home(&mut rig, true);
    assert_eq!(rig.step().order, Order::Home);
}
