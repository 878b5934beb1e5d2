//! From a fresh page to an arm that moves.

use super::browser::{Browser, ENTER, SPACE, TAB};
use super::driver::sees_stop;
use super::program::Program;
use super::turn;
use super::witness::{Witness, is_moving};
use std::time::{Duration, Instant};

/// What an operator may need from the fresh page to the arm that moves.
const OPERATOR: Duration = Duration::from_secs(60);

/// So long a press is held that comes to nothing.
const PRESS: Duration = Duration::from_secs(4);

/// Counts what the operator does, and how long it all takes.
struct Session {
    began: Instant,
    steps: u32,
}

impl Session {
    fn begin() -> Self {
        Self { began: Instant::now(), steps: 0 }
    }

    fn step(&mut self) {
        self.steps += 1;
    }

    /// Presses until the arm moves. A press that a busy computer has ended is made again, as an operator would:
    /// the page says so.
    fn press(&mut self, browser: &Browser, witness: &Witness, down: impl Fn(), up: impl Fn()) {
        loop {
            down();
            self.step();
            if witness.sees_motion(PRESS) {
                return;
            }
            assert!(self.began.elapsed() < OPERATOR, "the arm does not move:\n{}", browser.text("body"));
            up();
        }
    }

    fn moves(&self, by: &str) {
        let took = self.began.elapsed();
        println!(
            "measured: from a fresh page to a moving arm by {by}: {} steps, {:.1} s",
            self.steps,
            took.as_secs_f64()
        );
        assert!(took < OPERATOR, "{took:?}");
    }
}

#[test]
fn by_keyboard_alone() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::start::by_keyboard_alone") else { return };
    let demo = Program::demo();
    let witness = Witness::of(demo.address());
    let mut session = Session::begin();
    browser.go(&demo.url("/"));
    // STOP first, then the pages
    while browser.script("return document.activeElement.getAttribute('href')") != "/drive" {
        browser.tap(TAB);
        session.step();
        assert!(session.steps < 20, "the drive page cannot be reached by Tab");
    }
    browser.tap(ENTER);
    browser.until("location.pathname === '/drive'");
    browser.until("document.getElementById('take') && !document.getElementById('take').disabled");
    browser.tap("t");
    browser.until("!document.getElementById('reset').disabled");
    witness.until("the hand", |live| live["snapshot"]["hand"]["position_mm"].is_array());
    browser.tap("r");
    witness.until("an arm that waits", |live| live["snapshot"]["arm"]["state"] == "armed");
    session.steps += 3;
    session.press(&browser, &witness, || browser.key_down(SPACE), || browser.key_up(SPACE));
    session.moves("keyboard");
    browser.key_up(SPACE);
    sees_stop(&witness);
    // a key that repeats, or is pressed with another, is no press
    browser.script(
        "for (const more of [{repeat: true}, {ctrlKey: true}])
           document.body.dispatchEvent(new KeyboardEvent('keydown', {code: 'Space', key: ' ', bubbles: true, ...more}))",
    );
    assert!(witness.within(Duration::from_millis(500), is_moving).is_err());
}

#[test]
fn by_mouse_alone() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::start::by_mouse_alone") else { return };
    let demo = Program::demo();
    let witness = Witness::of(demo.address());
    let mut session = Session::begin();
    browser.go(&demo.url("/"));
    browser.click("nav a[href='/drive']");
    browser.until("document.getElementById('take') && !document.getElementById('take').disabled");
    browser.click("#take");
    browser.until("!document.getElementById('reset').disabled");
    witness.until("the hand", |live| live["snapshot"]["hand"]["position_mm"].is_array());
    browser.click("#reset");
    witness.until("an arm that waits", |live| live["snapshot"]["arm"]["state"] == "armed");
    session.steps += 3;
    session.press(&browser, &witness, || browser.mouse_down("#hold"), || browser.mouse_up());
    session.moves("mouse");
    browser.mouse_up();
    sees_stop(&witness);
    browser.click("#stop");
    witness.until("the stop", |live| live["control"]["stopped"] == true);
    browser.until("document.getElementById('control').textContent.includes('Reset')");
}
