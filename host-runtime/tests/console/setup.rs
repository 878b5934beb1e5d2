//! From the opened set-up page to cameras that track by what was learnt there.

use super::browser::Browser;
use super::program::Program;
use super::turn;
use super::witness::Witness;
use serde_json::Value;
use std::time::{Duration, Instant};

/// What an operator may need for it.
const OPERATOR: Duration = Duration::from_secs(60);

/// Every ball is seen by every camera.
fn tracks(live: &Value) -> bool {
    let mut cameras = live["snapshot"]["cameras"].as_array().into_iter().flatten();
    cameras.all(|camera| {
        let mut balls = camera["balls"].as_array().into_iter().flatten();
        balls.all(|ball| ball["state"] == "visible" || ball["state"] == "occluded")
    })
}

/// Has the balls found, and uses what was learnt.
fn sets_up(test: &str, by: &str, find: impl Fn(&Browser), take: impl Fn(&Browser)) {
    let _turn = turn();
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let began = Instant::now();
    browser.go(&program.url("/setup"));
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.until("!document.getElementById('find').disabled");
    find(&browser);
    browser.until("document.getElementById('said').textContent.includes('found by 2 of 2 cameras')");
    take(&browser);
    browser.until("document.getElementById('said').textContent.includes('in use')");
    let live = witness.until("all balls in both cameras", tracks);
    let took = began.elapsed();
    println!("measured: from the opened set-up page to tracking by {by}: {:.1} s", took.as_secs_f64());
    assert!(took < OPERATOR, "{took:?}");
    assert_eq!(live["control"]["stopped"], true, "what is used anew stops the arm");
    assert!(browser.log().is_empty(), "nothing is wrong in its console");
}

#[test]
fn the_balls_are_found_by_keyboard_alone() {
    let test = "console::setup::the_balls_are_found_by_keyboard_alone";
    sets_up(test, "keyboard", |browser| browser.tap("f"), |browser| browser.tap("u"));
}

#[test]
fn the_balls_are_found_by_mouse_alone() {
    let test = "console::setup::the_balls_are_found_by_mouse_alone";
    sets_up(test, "mouse", |browser| browser.click("#find"), |browser| browser.click("#use"));
}
