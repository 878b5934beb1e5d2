//! A second operator: refused, told who drives, and able to stop the arm.

use super::browser::{Browser, ESCAPE, SPACE};
use super::driver::{hold, sees_stop, take_control};
use super::program::Program;
use super::turn;
use super::witness::{Witness, is_moving};
use std::time::Duration;

/// What the first operator is called.
const NAME: &str = "Ada";

/// How a second operator stops the arm.
fn stops_it(test: &str, stop: impl Fn(&Browser, &Program)) {
    let _turn = turn();
    let Some(browser) = Browser::open(test) else { return };
    let Some(other) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    browser.go(&program.url("/drive"));
    browser.write("#name", NAME);
    // the browser keeps it
    take_control(&browser, &program.url("/drive"));
    assert_eq!(browser.script("return document.getElementById('name').value"), NAME);
    hold(&browser, &witness);
    let holder = witness.until("who drives", |live| live["control"]["holder"].is_string());
    let holder = holder["control"]["holder"].as_str().unwrap_or_default().to_owned();
    assert!(holder.starts_with(NAME), "{holder}");

    other.go(&program.url("/drive"));
    other.until("!document.getElementById('take').disabled");
    // it says who has control without being asked, and why it is refused when it asks
    other.until(&format!("document.getElementById('control').textContent.includes({holder:?})"));
    other.tap("t");
    other.until("document.getElementById('control').textContent.includes('another page is in control')");
    assert_eq!(other.script("return document.getElementById('hold').disabled"), true);
    // nor do its keys do anything
    other.tap("r");
    other.tap(SPACE);
    let control = &witness.until("who drives", |_| true)["control"];
    assert_eq!(control["holder"].as_str(), Some(holder.as_str()));
    assert_eq!(control["stopped"], false);

    stop(&other, &program);
    sees_stop(&witness);
    witness.until("the latch", |live| live["control"]["stopped"] == true);
    browser.until("/stopped.*reset/i.test(document.getElementById('control').textContent)");
    // the first operator's key is still down; pressing again without a reset does not help
    browser.key_up(SPACE);
    browser.key_down(SPACE);
    assert!(witness.within(Duration::from_millis(500), is_moving).is_err(), "a stop latches");
    browser.key_up(SPACE);
    // who is in control resets and goes on
    hold(&browser, &witness);
    browser.key_up(SPACE);
    sees_stop(&witness);
}

#[test]
fn a_second_operator_is_refused_and_stops_the_arm_by_key() {
    stops_it("console::others::a_second_operator_is_refused_and_stops_the_arm_by_key", |other, _| {
        other.tap(ESCAPE);
    });
}

#[test]
fn a_second_operator_stops_the_arm_by_mouse_from_another_page() {
    stops_it(
        "console::others::a_second_operator_stops_the_arm_by_mouse_from_another_page",
        |other, program| {
            other.go(&program.url("/"));
            other.click("#stop");
        },
    );
}
