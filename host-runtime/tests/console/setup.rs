//! From the opened set-up page to cameras that track by what was learnt there.

use super::browser::Browser;
use super::program::Program;
use super::turn;
use super::witness::Witness;
use serde_json::Value;
use std::time::{Duration, Instant};

/// What an operator may need for it.
const OPERATOR: Duration = Duration::from_secs(60);

/// So much later nothing is left of what the cameras saw before, microseconds.
const LATER_US: u64 = 1_000_000;

/// Every ball is seen by both cameras, in what they have seen well after that time.
fn tracks_after(live: &Value, since_us: u64) -> bool {
    let time_us = live["snapshot"]["time_us"].as_u64().unwrap_or_default();
    let seen_since = |camera: &&Value| {
        let age_us = camera["age_us"].as_u64().unwrap_or(u64::MAX);
        time_us.saturating_sub(age_us) > since_us + LATER_US
    };
    let cameras = live["snapshot"]["cameras"].as_array().into_iter().flatten().filter(seen_since);
    let balls = cameras.flat_map(|camera| camera["balls"].as_array().into_iter().flatten());
    balls.filter(|ball| ball["state"] == "visible" || ball["state"] == "occluded").count() == 8
}

/// What was learnt is in use, and all balls are tracked by it; the cameras of the scene have known them before.
#[track_caller]
fn until_tracked(browser: &Browser, witness: &Witness) -> Value {
    browser.until("document.getElementById('said').textContent.includes('in use')");
    let told = witness.until("a time", |live| live["snapshot"]["time_us"].is_u64());
    let since_us = told["snapshot"]["time_us"].as_u64().unwrap_or_default();
    witness.until("all balls in both cameras", |live| tracks_after(live, since_us))
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
    let live = until_tracked(&browser, &witness);
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

/// Where a ball is in the still picture that is shown, of its width and its height: the middle of the pixels that have
/// its colour most of all. An operator's eye does the same.
const SEE: &str = "
const [view, ball] = [VIEW, BALL];
const over = document.querySelectorAll('canvas.over')[view];
const { width, height } = over;
const pen = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
pen.drawImage(over, 0, 0);
const { data } = pen.getImageData(0, 0, width, height);
const likeness = {
  red: (r, g, b) => r - Math.max(g, b),
  green: (r, g, b) => g - Math.max(r, b),
  blue: (r, g, b) => b - Math.max(r, g),
  yellow: (r, g, b) => Math.min(r, g) - b - Math.abs(r - g),
}[ball];
const all = [];
for (let at = 0; at < width * height; at += 1) {
  const like = likeness(data[4 * at], data[4 * at + 1], data[4 * at + 2]);
  if (like > 40) all.push([like, at]);
}
all.sort((one, other) => other[0] - one[0]);
const best = all.slice(0, 60).map(([, at]) => [at % width, Math.floor(at / width)]);
const middle = (values) => values.sort((a, b) => a - b)[Math.floor(values.length / 2)];
const box = over.getBoundingClientRect();
return [0, 1].map((axis) => middle(best.map((place) => place[axis])) + 0.5)
  .map((place, axis) => Math.round((place / [width, height][axis] - 0.5) * [box.width, box.height][axis]));";

#[test]
fn each_ball_is_clicked() {
    let test = "console::setup::each_ball_is_clicked";
    let _turn = turn();
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let began = Instant::now();
    browser.go(&program.url("/setup"));
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.until("!document.getElementById('still').disabled");
    browser.click("#still");
    browser.until("document.querySelectorAll('figure.stands').length === 2");
    for view in [0, 1] {
        for ball in ["red", "green", "blue", "yellow"] {
            // the first of a camera is chosen; each click chooses the next
            if ball == "red" {
                browser.click("input[name=ball][value=red]");
            }
            browser.until(&format!("document.querySelector('input[value={ball}]').checked"));
            let see = SEE.replace("VIEW", &view.to_string()).replace("BALL", &format!("{ball:?}"));
            let at = browser.script(&see);
            let place = |axis: usize| at[axis].as_i64().unwrap_or_else(|| panic!("no {ball} ball: {at}"));
            browser.click_at(&format!(".learnt:nth-child({}) canvas.over", view + 1), (place(0), place(1)));
            let learnt = format!("the {ball} ball is learnt");
            browser.until(&format!("document.getElementById('said').textContent.includes({learnt:?})"));
        }
    }
    // what was learnt is by a click, nothing was found for the operator
    let known =
        browser.script("return [...document.querySelectorAll('.balls .how')].map((how) => how.textContent)");
    let known = known.as_array().cloned().unwrap_or_default();
    assert_eq!(known.len(), 8);
    assert!(known.iter().all(|how| how == "(pointed at)"), "{known:?}");
    browser.click("#use");
    let live = until_tracked(&browser, &witness);
    let took = began.elapsed();
    println!("measured: from the opened set-up page to tracking by clicks: {:.1} s", took.as_secs_f64());
    assert!(took < OPERATOR, "{took:?}");
    assert_eq!(live["control"]["stopped"], true, "what is used anew stops the arm");
    assert!(browser.log().is_empty(), "nothing is wrong in its console");
}
