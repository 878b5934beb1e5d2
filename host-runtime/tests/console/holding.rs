//! What does not hold the button: the space bar where it is for something else, and the mouse's other buttons.

use super::browser::{Browser, LEFT, LONG, RIGHT, SPACE};
use super::driver::{A_WHILE, hold, reset, sees_stop, stays_stopped, take, take_control};
use super::program::Program;
use super::turn;
use super::witness::{Witness, is_moving};
use serde_json::Value;
use std::time::{Duration, Instant};

/// A press that came to nothing on a busy computer is made again.
const AGAIN: Duration = Duration::from_secs(4);

/// What else the keyboard reaches on the drive page; what it presses there does no harm to the test.
const ELSEWHERE: [&str; 6] =
    ["nav a[aria-current]", "#lines", "#scene", "details summary", "#homed", "#reset"];

fn focused(browser: &Browser) -> Value {
    browser.script("return document.activeElement.id")
}

fn focus(browser: &Browser, css: &str) {
    browser.script(&format!("document.querySelector({css:?}).focus()"));
    assert_eq!(
        browser.script(&format!("return document.activeElement === document.querySelector({css:?})")),
        true,
        "{css}"
    );
}

/// The button counts as held, or the arm moves.
fn drives(live: &Value) -> bool {
    live["control"]["pressed"] == true || is_moving(live)
}

#[test]
fn the_space_bar_is_for_what_has_the_focus() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::holding::the_space_bar_is_for_what_has_the_focus") else {
        return;
    };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    take_control(&browser, &program.url("/drive"));
    reset(&browser, &witness);

    // on STOP it stops, at the key's way down
    focus(&browser, "#stop");
    browser.until("document.getElementById('control').textContent.includes('M gives it to the arm')");
    browser.key_down(SPACE);
    witness.until("the stop", |live| live["control"]["stopped"] == true);
    assert!(witness.within(A_WHILE, drives).is_err(), "the space bar on STOP drives");
    browser.key_up(SPACE);

    // on STOP as the mouse has left it, too; a reset gives the space bar to the arm
    reset(&browser, &witness);
    browser.click("#stop");
    witness.until("the stop", |live| live["control"]["stopped"] == true);
    assert_eq!(focused(&browser), "stop");
    browser.key_down(SPACE);
    assert!(witness.within(A_WHILE, drives).is_err(), "the space bar on STOP drives");
    browser.key_up(SPACE);
    reset(&browser, &witness);
    assert_eq!(focused(&browser), "hold");
    hold(&browser, &witness);

    // a press does not outlast the focus, and what gets it is not pressed by the key's way up
    focus(&browser, "#give");
    sees_stop(&witness);
    assert!(witness.within(A_WHILE, is_moving).is_err(), "what has ended begins by itself");
    browser.key_up(SPACE);
    let live = witness.until("who drives", |_| true);
    assert!(live["control"]["holder"].is_string(), "control is still this page's");

    for css in ELSEWHERE {
        reset(&browser, &witness);
        focus(&browser, css);
        browser.key_down(SPACE);
        assert!(witness.within(A_WHILE, drives).is_err(), "the space bar on {css} drives");
        browser.key_up(SPACE);
    }

    // M gives it to the arm from wherever it is
    let began = Instant::now();
    loop {
        reset(&browser, &witness);
        focus(&browser, "#lines");
        browser.tap("m");
        assert_eq!(focused(&browser), "hold");
        browser.key_down(SPACE);
        if witness.sees_motion(AGAIN) {
            break;
        }
        browser.key_up(SPACE);
        assert!(began.elapsed() < LONG, "the arm does not move:\n{}", browser.text("body"));
    }
    browser.key_up(SPACE);
    sees_stop(&witness);
}

/// Holds the button with the mouse until the arm moves.
fn hold_by_mouse(browser: &Browser, witness: &Witness) {
    let began = Instant::now();
    loop {
        reset(browser, witness);
        browser.mouse_down("#hold");
        if witness.sees_motion(AGAIN) {
            return;
        }
        browser.mouse_up();
        assert!(began.elapsed() < LONG, "the arm does not move:\n{}", browser.text("body"));
    }
}

#[test]
fn the_mouses_other_buttons_hold_nothing() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::holding::the_mouses_other_buttons_hold_nothing") else {
        return;
    };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    // the page is told of the right button in two ways; each has to do alone
    for muted in ["contextmenu", "pointermove"] {
        browser.go(&program.url("/drive"));
        browser.until("document.readyState === 'complete'");
        browser.script(&format!(
            "window.addEventListener('{muted}', (event) => {{
               event.preventDefault();
               event.stopImmediatePropagation();
             }}, {{capture: true}})"
        ));
        take(&browser);
        hold_by_mouse(&browser, &witness);
        browser.button_down(RIGHT);
        if muted == "contextmenu" {
            browser.button_up(LEFT);
        }
        stays_stopped(&witness);
        if muted == "pointermove" {
            browser.button_up(LEFT);
        }
        browser.button_up(RIGHT);
        // nor does the right button alone
        browser.button_down(RIGHT);
        assert!(witness.within(A_WHILE, drives).is_err(), "the right button drives");
        browser.button_up(RIGHT);
    }
}
