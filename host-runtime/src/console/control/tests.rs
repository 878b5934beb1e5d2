use super::*;
use proptest::prelude::*;

const A: Tab = Tab(1);
const B: Tab = Tab(2);

/// A tab in control that has let go, at 1 s.
fn driving() -> Control {
    let mut control = Control::new(true);
    control.take(A, "first", 1_000_000).unwrap();
    control.release(A, 1_000_000);
    control
}

/// A tab in control that has pressed at 1 s.
fn pressed() -> Control {
    let mut control = Control::new(true);
    control.take(A, "a", 900_000).unwrap();
    control.release(A, 900_000);
    control.hold(A, 1, PressFor::Follow, 1_000_000, 1_000_000).unwrap();
    assert!(control.buttons(1_000_000).pressed);
    control
}

#[test]
fn nothing_is_pressed_by_a_tab_that_is_not_in_control() {
    let mut control = Control::new(true);
    assert_eq!(control.hold(A, 1, PressFor::Follow, 0, 0), Err(Refusal::NotInControl));
    assert_eq!(control.buttons(0), Buttons::default());
    control.take(A, "a", 0).unwrap();
    assert_eq!(control.hold(B, 1, PressFor::Follow, 0, 0), Err(Refusal::NotInControl));
    assert_eq!(control.buttons(0), Buttons::default());
}

#[test]
fn a_press_counts_for_sixty_milliseconds() {
    let control = pressed();
    assert!(control.buttons(1_060_000).pressed);
    assert!(!control.buttons(1_060_001).pressed);
}

#[test]
fn a_short_silence_is_a_release_while_it_lasts_and_a_long_one_ends_the_press() {
    let mut control = pressed();
    assert!(!control.buttons(1_200_000).pressed);
    control.hold(A, 1, PressFor::Follow, 1_250_000, 1_300_000).unwrap();
    assert!(control.buttons(1_300_000).pressed, "it goes on");
    let late_us = 1_300_000 + HICCUP_US + 1;
    assert_eq!(control.hold(A, 1, PressFor::Follow, late_us, late_us), Err(Refusal::Ended));
    assert!(!control.buttons(late_us).pressed);
    control.hold(A, 2, PressFor::Follow, late_us, late_us + 1).unwrap();
    assert!(control.buttons(late_us + 1).pressed, "a fresh press counts");
}

#[test]
fn a_page_that_has_not_heard_from_us_does_not_press() {
    let mut control = Control::new(true);
    control.take(A, "a", 5_000_000).unwrap();
    control.release(A, 5_000_000);
    assert_eq!(control.hold(A, 1, PressFor::Follow, 5_000_000 - HEARD_US - 1, 5_000_000), Err(Refusal::Late));
    assert_eq!(
        control.hold(A, 1, PressFor::Follow, 5_000_000, 5_000_000),
        Err(Refusal::Ended),
        "a press that began late"
    );
    assert_eq!(
        control.hold(A, 2, PressFor::Follow, 5_000_001, 5_000_000),
        Err(Refusal::Late),
        "from the future"
    );
    control.hold(A, 3, PressFor::Follow, 5_000_000, 5_000_000).unwrap();
    // what waited in a line for a second comes all at once
    for old in [5_030_000, 5_060_000, 5_090_000] {
        assert!(control.hold(A, 3, PressFor::Follow, old, 6_000_000).is_err());
    }
    assert!(!control.buttons(6_000_000).pressed);
}

#[test]
fn a_release_is_at_once_and_the_same_press_does_not_come_back() {
    let mut control = pressed();
    control.release(A, 1_010_000);
    assert!(!control.buttons(1_010_000).pressed);
    assert_eq!(control.hold(A, 1, PressFor::Follow, 1_020_000, 1_020_000), Err(Refusal::Ended));
    control.hold(A, 2, PressFor::Follow, 1_030_000, 1_030_000).unwrap();
    assert!(control.buttons(1_030_000).pressed);
}

#[test]
fn anybody_stops_and_only_who_drives_resets() {
    let mut control = pressed();
    control.stop();
    let stopped = Buttons { stop: true, ..Buttons::default() };
    assert_eq!(control.buttons(1_000_000), stopped);
    for press in [1, 2] {
        // the one that the stop has ended is told why too
        assert_eq!(control.hold(A, press, PressFor::Follow, 1_010_000, 1_010_000), Err(Refusal::Stopped));
    }
    assert_eq!(control.reset(B, 1_010_000), Err(Refusal::NotInControl));
    assert_eq!(control.buttons(1_010_000), stopped);
    control.reset(A, 1_020_000).unwrap();
    assert_eq!(control.buttons(1_020_000), Buttons { resets: 1, ..Buttons::default() });
    for held in [1, 2] {
        assert_eq!(
            control.hold(A, held, PressFor::Follow, 1_030_000, 1_030_000),
            Err(Refusal::Ended),
            "held all the time"
        );
    }
    control.hold(A, 3, PressFor::Follow, 1_040_000, 1_040_000).unwrap();
    assert!(control.buttons(1_040_000).pressed);
}

#[test]
fn what_was_held_before_control_was_taken_does_not_count() {
    let mut control = Control::new(true);
    control.take(A, "a", 0).unwrap();
    assert_eq!(control.hold(A, 1, PressFor::Follow, 0, 0), Err(Refusal::Ended));
    control.release(A, 0);
    control.hold(A, 2, PressFor::Follow, 0, 0).unwrap();
    control.leave(A);
    control.take(A, "a", 10_000).unwrap();
    assert_eq!(control.hold(A, 3, PressFor::Follow, 10_000, 10_000), Err(Refusal::Ended), "again");
    assert!(!control.buttons(10_000).pressed);
}

#[test]
fn a_press_that_was_begun_without_control_does_not_count_once_it_is_given() {
    let mut control = Control::new(true);
    let hold =
        |control: &mut Control, number, now_us| control.hold(A, number, PressFor::Follow, now_us, now_us);
    assert_eq!(hold(&mut control, 1, 0), Err(Refusal::NotInControl));
    control.take(A, "a", 10_000).unwrap();
    control.release(A, 10_000);
    assert_eq!(hold(&mut control, 1, 20_000), Err(Refusal::Ended), "held all the time");
    assert!(!control.buttons(20_000).pressed);
    hold(&mut control, 2, 30_000).unwrap();
    // nor once control was given up and taken anew, which no press outlasts
    control.leave(A);
    control.take(A, "a", 40_000).unwrap();
    control.release(A, 40_000);
    assert_eq!(hold(&mut control, 2, 50_000), Err(Refusal::Ended));
    hold(&mut control, 3, 60_000).unwrap();
    assert!(control.buttons(60_000).pressed);
    // another tab counts its own presses
    control.leave(A);
    control.take(B, "b", 70_000).unwrap();
    control.release(B, 70_000);
    control.hold(B, 1, PressFor::Follow, 80_000, 80_000).unwrap();
    // of one whose socket is gone nothing is kept
    control.gone(B);
    control.gone(A);
    assert!(control.told.is_empty() && control.view(None, 90_000).holder.is_none());
}

#[test]
fn a_reset_lets_go() {
    let mut control = pressed();
    control.reset(A, 1_010_000).unwrap();
    assert!(!control.buttons(1_010_000).pressed);
    assert_eq!(control.hold(A, 1, PressFor::Follow, 1_020_000, 1_020_000), Err(Refusal::Ended));
}

#[test]
fn when_the_button_was_last_told_is_known_after_its_end_too() {
    let mut control = Control::new(true);
    assert_eq!(control.view(None, 0).held_us, None);
    control = pressed();
    control.hold(A, 1, PressFor::Follow, 1_030_000, 1_030_000).unwrap();
    control.release(A, 1_040_000);
    // what does not count is no such message
    assert_eq!(control.hold(A, 1, PressFor::Follow, 1_050_000, 1_050_000), Err(Refusal::Ended));
    control.leave(A);
    assert_eq!(control.view(None, 1_060_000).held_us, Some(1_030_000));
}

#[test]
fn one_tab_at_a_time() {
    let mut control = pressed();
    assert_eq!(control.take(B, "b", 1_010_000), Err(Refusal::AnotherDrives));
    control.take(A, "a", 1_010_000).unwrap();
    assert!(control.buttons(1_010_000).pressed, "asking again changes nothing");
    let seen = control.view(Some(B), 1_010_000);
    assert_eq!((seen.holder.as_deref(), seen.yours, seen.pressed), (Some("a"), false, true));
    control.leave(B);
    assert!(control.is_holder(A, 1_010_000));
    control.leave(A);
    assert!(!control.buttons(1_010_000).pressed, "the socket is gone");
    control.take(B, "b", 1_020_000).unwrap();
    assert_eq!(control.hold(A, 9, PressFor::Follow, 1_030_000, 1_030_000), Err(Refusal::NotInControl));
}

#[test]
fn who_is_silent_for_long_has_lost_control() {
    let mut control = pressed();
    let gone_us = 1_000_000 + ABSENT_US;
    assert_eq!(control.take(B, "b", gone_us), Err(Refusal::AnotherDrives));
    control.here(A, gone_us);
    assert!(control.is_holder(A, gone_us + ABSENT_US));
    let gone_us = gone_us + ABSENT_US + 1;
    assert_eq!(control.view(None, gone_us).holder, None);
    assert_eq!(control.hold(A, 7, PressFor::Follow, gone_us, gone_us), Err(Refusal::NotInControl));
    control.take(B, "b", gone_us).unwrap();
    control.here(A, gone_us);
    assert!(control.is_holder(B, gone_us));
}

#[test]
fn with_the_buttons_elsewhere_a_stop_is_all_there_is() {
    let mut control = Control::new(false);
    assert_eq!(control.take(A, "a", 0), Err(Refusal::ButtonsElsewhere));
    control.stop();
    assert!(control.buttons(0).stop);
    assert_eq!(control.reset(A, 0), Err(Refusal::ButtonsElsewhere));
    control.reset_elsewhere(control.stops() - 1);
    assert!(control.buttons(0).stop, "a stop that was not known of");
    control.reset_elsewhere(control.stops());
    assert_eq!(control.buttons(0), Buttons::default());
}

/// Whatever pages may do.
#[derive(Clone, Copy, Debug)]
enum Act {
    Take(Tab),
    Leave(Tab),
    Here(Tab),
    Hold(Tab, u64, u64),
    Release(Tab),
    Stop,
    Reset(Tab),
}

fn act() -> impl Strategy<Value = Act> {
    let tab = || prop_oneof![Just(A), Just(B)];
    prop_oneof![
        tab().prop_map(Act::Take),
        tab().prop_map(Act::Leave),
        tab().prop_map(Act::Here),
        (tab(), 1..12_u64, 0..400_000_u64).prop_map(|(tab, press, ago)| Act::Hold(tab, press, ago)),
        (tab(), 1..12_u64, Just(0)).prop_map(|(tab, press, ago)| Act::Hold(tab, press, ago)),
        tab().prop_map(Act::Release),
        Just(Act::Stop),
        tab().prop_map(Act::Reset),
    ]
}

proptest! {
    /// Whatever comes in whatever order: pressed means that the tab in control has said so within the
    /// last 60 ms, with a page that was up to date, since the last stop, reset, release and loss of
    /// control, and in a press that none of these had ended, nor was begun before control was taken.
    #[test]
    fn pressed_is_always_a_fresh_press_of_the_tab_in_control(
        acts in prop::collection::vec((act(), 0..120_000_u64), 1..60)
    ) {
        let mut control = Control::new(true);
        let mut now_us = 1_000_000;
        // the last hold that could count: who, when, which press
        let mut told: Option<(Tab, u64, u64)> = None;
        let mut over: Vec<(Tab, u64)> = Vec::new();
        // whatever was said, counted or not
        let mut said: Vec<(Tab, u64)> = Vec::new();
        let mut stopped = false;
        for (act, later_us) in acts {
            now_us += later_us;
            let end = |told: &mut Option<(Tab, u64, u64)>, over: &mut Vec<(Tab, u64)>, who: Option<Tab>| {
                if let Some((tab, _, press)) = told.take_if(|(tab, ..)| who.is_none_or(|who| who == *tab)) {
                    over.push((tab, press));
                }
            };
            match act {
                Act::Take(tab) => {
                    let before = control.is_holder(tab, now_us);
                    if control.take(tab, "x", now_us).is_ok() && !before {
                        over.extend(said.iter().filter(|(of, _)| *of == tab));
                    }
                }
                Act::Leave(tab) => {
                    control.leave(tab);
                    end(&mut told, &mut over, Some(tab));
                }
                Act::Here(tab) => control.here(tab, now_us),
                Act::Hold(tab, press, ago_us) => {
                    said.push((tab, press));
                    if control.hold(tab, press, PressFor::Follow, now_us - ago_us, now_us).is_ok() {
                        prop_assert!(control.is_holder(tab, now_us));
                        prop_assert!(!stopped, "a stop latches");
                        prop_assert!(ago_us <= HEARD_US);
                        prop_assert!(!over.contains(&(tab, press)), "an ended press came back");
                        if told.is_some_and(|(of, _, number)| of == tab && number != press) {
                            end(&mut told, &mut over, Some(tab));
                        }
                        told = Some((tab, now_us, press));
                    }
                }
                Act::Release(tab) => {
                    control.release(tab, now_us);
                    end(&mut told, &mut over, Some(tab));
                }
                Act::Stop => {
                    control.stop();
                    stopped = true;
                    end(&mut told, &mut over, None);
                }
                Act::Reset(tab) => {
                    if control.reset(tab, now_us).is_ok() {
                        stopped = false;
                        end(&mut told, &mut over, None);
                    }
                }
            }
            let buttons = control.buttons(now_us);
            prop_assert_eq!(buttons.stop, stopped);
            if buttons.pressed {
                let (tab, told_us, _) = told.expect("somebody has said so");
                prop_assert!(control.is_holder(tab, now_us));
                prop_assert!(now_us - told_us <= FRESH_US);
            }
            // and silence is a release, whatever went before
            prop_assert!(!control.buttons(now_us + FRESH_US + 1).pressed);
        }
    }
}

#[test]
fn a_press_for_the_way_home_is_one_of_its_own() {
    let mut control = driving();
    control.hold(A, 1, PressFor::Home, 1_000_000, 1_000_000).unwrap();
    let buttons = control.buttons(1_000_000);
    assert_eq!((buttons.pressed, buttons.press_for), (true, PressFor::Home));
    // the same press for something else
    let other = control.hold(A, 1, PressFor::Follow, 1_010_000, 1_010_000);
    assert_eq!(other, Err(Refusal::Ended));
    assert!(!control.buttons(1_010_000).pressed);
    assert_eq!(control.hold(A, 1, PressFor::Home, 1_020_000, 1_020_000), Err(Refusal::Ended));
    control.release(A, 1_030_000);
    assert_eq!(control.buttons(1_030_000).press_for, PressFor::Home, "the release is that press's");
    control.hold(A, 2, PressFor::Follow, 1_040_000, 1_040_000).unwrap();
    assert_eq!(control.buttons(1_040_000).press_for, PressFor::Follow);
}

#[test]
fn the_scale_is_for_whoever_drives_and_only_while_the_button_is_let_go() {
    let mut control = driving();
    let percent = |control: &Control| control.buttons(1_000_000).scale.percent();
    assert_eq!(percent(&control), 100);
    assert_eq!(control.set_scale(A, 25, 1_000_000), Ok(()));
    assert_eq!((percent(&control), control.view(None, 1_000_000).scale_percent), (25, 25));
    for none in [0, 101, 255] {
        assert_eq!(control.set_scale(A, none, 1_000_000), Err(Refusal::NoScale));
    }
    assert_eq!(control.set_scale(B, 50, 1_000_000), Err(Refusal::NotInControl));
    control.hold(A, 1, PressFor::Follow, 1_000_000, 1_000_000).unwrap();
    assert_eq!(control.set_scale(A, 50, 1_000_000), Err(Refusal::Held));
    control.release(A, 1_010_000);
    assert_eq!(control.set_scale(A, 50, 1_020_000), Ok(()));
    control.leave(A);
    assert_eq!(percent(&control), 50, "it stays for whoever comes next");
    assert_eq!(Control::new(false).set_scale(A, 50, 0), Err(Refusal::ButtonsElsewhere));
}
