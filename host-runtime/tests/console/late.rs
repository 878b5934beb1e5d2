//! A line that is late: what the page shows is as old as it says, and nobody drives by it.

use super::browser::{Browser, SPACE};
use super::driver::{count_holds, holds_told, reset, take, take_control};
use super::program::Program;
use super::proxy::Proxy;
use super::turn;
use super::witness::{Witness, is_moving};
use std::time::Duration;

/// A line that is slow, and no slower than what presses are taken from.
const SLOW: Duration = Duration::from_millis(60);

/// Control is asked for so long after a press, before the press can have been refused, milliseconds.
const TAKEN_AFTER_MS: u32 = 30;

/// So much later everything gets through, each way.
const LATE: Duration = Duration::from_secs(3);

/// The ages of all pictures of the page, seconds, where they are marked as stale.
const AGES: &str = "[...document.querySelectorAll('figure.stale .stamp')]
    .map((stamp) => Number(stamp.textContent.match(/STALE: ([\\d.]+) s old/)?.[1] ?? NaN))";

#[test]
fn a_late_line_makes_pictures_as_old_as_they_are_and_nobody_drives_by_it() {
    let _turn = turn();
    let test = "console::late::a_late_line_makes_pictures_as_old_as_they_are_and_nobody_drives_by_it";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let proxy = Proxy::to(program.address());
    take_control(&browser, &proxy.url("/drive"));
    let figures = "document.querySelectorAll('figure .stamp').length";
    let fresh = format!("{figures} >= 2 && document.querySelectorAll('figure.stale').length === 0");
    browser.until(&fresh);
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.until("/^\\d+ ms there and back$/.test(document.querySelector('.trip').textContent)");

    proxy.delay(LATE);
    // everything keeps coming, so that the page is never silent; it is late, and says by how much
    browser.until("document.getElementById('link').textContent === 'LATE: what you see is old'");
    browser.until(
        "/^[3-9]\\.\\d s old, ([6-9]|1\\d)\\.\\d s there and back$/.test(document.querySelector('.trip').textContent)",
    );
    assert_eq!(browser.script("return document.body.classList.contains('late')"), true);
    let least = LATE.as_secs_f64();
    browser.until(&format!("{figures} >= 2 && {AGES}.length === {figures}"));
    // pictures that come late are new ones, and old nevertheless
    std::thread::sleep(LATE);
    let ages = browser.script(&format!("return {AGES}"));
    println!("measured: pictures through a line that is {least} s late: {ages} s old");
    let ages = ages.as_array().cloned().unwrap_or_default();
    assert!(
        ages.len() >= 2 && ages.iter().all(|age| age.as_f64().is_some_and(|age| age >= least)),
        "{ages:?}"
    );

    // whoever takes control through such a line does not keep it, or is not believed to hold the button
    take(&browser);
    browser.tap("r");
    browser.key_down(SPACE);
    browser.until(
        "/too long ago|press has ended|not in control/.test(document.getElementById('control').textContent)",
    );
    assert!(witness.within(LATE, is_moving).is_err(), "somebody drives by what is old");
    browser.key_up(SPACE);

    // a page that has known no other line cannot know which way is the slow one, and says how well it knows
    proxy.cut();
    proxy.open();
    browser.until(&format!(
        "[...document.querySelectorAll('figure.stale .stamp')]
           .filter((stamp) => / s old, give or take \\d/.test(stamp.textContent)).length === {figures}"
    ));

    proxy.mend();
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.until(&fresh);
}

#[test]
fn a_press_begun_before_control_was_taken_moves_nothing_over_a_slow_line() {
    let _turn = turn();
    let test = "console::late::a_press_begun_before_control_was_taken_moves_nothing_over_a_slow_line";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let proxy = Proxy::to(program.address());
    take_control(&browser, &proxy.url("/drive"));
    reset(&browser, &witness);
    browser.tap("g");
    browser.until("!document.getElementById('take').disabled");
    proxy.delay(SLOW);
    count_holds(&browser);
    let held_us =
        witness.until("who drives", |live| live["control"]["holder"].is_null())["control"]["held_us"].clone();

    // the refusal of the press comes only after control was asked for
    let key = |what: &str, key: &str, code: &str| {
        format!(
            "document.body.dispatchEvent(new KeyboardEvent('{what}', {{key: '{key}', code: '{code}', bubbles: true}}));"
        )
    };
    let (down, up) = (key("keydown", " ", "Space"), key("keyup", " ", "Space"));
    let take = key("keydown", "t", "KeyT");
    browser.script(&format!(
        "{down} setTimeout(() => {{ {take} window.told = window.holdsTold; }}, {TAKEN_AFTER_MS})"
    ));
    browser.until("window.told > 0 && !document.getElementById('give').disabled");
    let drives = |live: &serde_json::Value| live["control"]["pressed"] == true || is_moving(live);
    assert!(witness.within(LATE, drives).is_err(), "a press drives that was begun without control");
    let live = witness.until("what was held", |_| true);
    assert_eq!(live["control"]["held_us"], held_us, "it counted");
    assert_eq!(
        Some(holds_told(&browser)),
        browser.script("return window.told").as_u64(),
        "the page goes on holding"
    );
    // why that press came to nothing is over
    let words = browser.text("#control");
    assert!(words.starts_with("You are in control"), "{words}");
    browser.script(&up);
}
