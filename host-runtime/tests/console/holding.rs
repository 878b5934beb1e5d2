//! What does not hold the button: the space bar where it is for something else, the mouse's other buttons, and whatever
//! may keep from the page that it is let go.

use super::browser::{ALT, Browser, LEFT, MIDDLE, RIGHT, SPACE};
use super::driver::{
    A_WHILE, count_holds, hold, holds_told, press, reset, sees_stop, stays_stopped, take, take_control,
};
use super::program::Program;
use super::turn;
use super::witness::{Witness, is_moving};
use serde_json::Value;

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

/// While something is held, the page does not tell that a button is, which a console with a stop latched would refuse
/// anyway; nor does the arm move.
#[track_caller]
fn holds_nothing(browser: &Browser, witness: &Witness, what: &str, down: impl Fn()) {
    let before = holds_told(browser);
    down();
    assert!(witness.within(A_WHILE, drives).is_err(), "{what} drives");
    assert_eq!(holds_told(browser), before, "{what} holds the button");
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
    count_holds(&browser);
    reset(&browser, &witness);
    let stops = || {
        browser.key_down(SPACE);
        witness.until("the stop", |live| live["control"]["stopped"] == true);
    };

    // on STOP it stops, at the key's way down
    focus(&browser, "#stop");
    browser.until("document.getElementById('control').textContent.includes('M gives it to the arm')");
    holds_nothing(&browser, &witness, "the space bar on STOP", stops);
    browser.key_up(SPACE);

    // on STOP as the mouse has left it, too; a reset gives the space bar to the arm
    reset(&browser, &witness);
    browser.click("#stop");
    witness.until("the stop", |live| live["control"]["stopped"] == true);
    assert_eq!(focused(&browser), "stop");
    holds_nothing(&browser, &witness, "the space bar on STOP", stops);
    browser.key_up(SPACE);
    reset(&browser, &witness);
    assert_eq!(focused(&browser), "hold");
    assert_eq!(holds_told(&browser), 0);
    hold(&browser, &witness);
    assert!(holds_told(&browser) > 0, "the arm moves, and nothing was counted");

    // a press does not outlast the focus, and what gets it is not pressed by the key's way up
    focus(&browser, "#give");
    sees_stop(&witness);
    holds_nothing(&browser, &witness, "what has ended", || {});
    browser.key_up(SPACE);
    let live = witness.until("who drives", |_| true);
    assert!(live["control"]["holder"].is_string(), "control is still this page's");

    for css in ELSEWHERE {
        reset(&browser, &witness);
        focus(&browser, css);
        holds_nothing(&browser, &witness, &format!("the space bar on {css}"), || browser.key_down(SPACE));
        browser.key_up(SPACE);
    }

    // M gives it to the arm from wherever it is
    let down = || {
        focus(&browser, "#lines");
        browser.tap("m");
        assert_eq!(focused(&browser), "hold");
        browser.key_down(SPACE);
    };
    press(&browser, &witness, down, || browser.key_up(SPACE), |limit| witness.sees_motion(limit));
    browser.key_up(SPACE);
    sees_stop(&witness);
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
    for (button, muted) in [(RIGHT, "contextmenu"), (RIGHT, "pointermove"), (MIDDLE, "contextmenu")] {
        browser.go(&program.url("/drive"));
        browser.until("document.readyState === 'complete'");
        browser.script(&format!(
            "window.addEventListener('{muted}', (event) => {{
               event.preventDefault();
               event.stopImmediatePropagation();
             }}, {{capture: true}})"
        ));
        count_holds(&browser);
        take(&browser);
        let (down, up) = (|| browser.mouse_down("#hold"), || browser.mouse_up());
        press(&browser, &witness, down, up, |limit| witness.sees_motion(limit));
        browser.button_down(button);
        stays_stopped(&witness);
        browser.button_up(LEFT);
        browser.button_up(button);
        // nor does it hold anything alone
        let what = format!("button {button} of the mouse");
        holds_nothing(&browser, &witness, &what, || browser.button_down(button));
        browser.button_up(button);
    }
}

/// What comes before a menu of the browser's, or before something is dragged: both keep from the page what is let go
/// meanwhile. It happens far from the button.
const HIDES: [&str; 2] = [
    "new MouseEvent('contextmenu', {bubbles: true, cancelable: true})",
    "new DragEvent('dragstart', {bubbles: true, cancelable: true})",
];

#[test]
fn what_may_keep_the_keys_way_up_from_the_page_ends_the_press() {
    let _turn = turn();
    let test = "console::holding::what_may_keep_the_keys_way_up_from_the_page_ends_the_press";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    take_control(&browser, &program.url("/drive"));
    for event in HIDES {
        hold(&browser, &witness);
        browser.script(&format!("document.querySelector('nav a').dispatchEvent({event})"));
        stays_stopped(&witness);
        browser.key_up(SPACE);
    }
    // with Alt other keys are called otherwise, and it may be the window manager's
    hold(&browser, &witness);
    browser.key_down(ALT);
    stays_stopped(&witness);
    browser.key_up(SPACE);
    browser.key_up(ALT);
}
