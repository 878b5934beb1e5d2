//! Somebody at the drive page: what is seen and pressed to move the arm.

use super::browser::{Browser, LONG, SPACE};
use super::witness::{Witness, is_moving};
use std::time::{Duration, Instant};

/// So long nothing moves that is not to move.
pub(crate) const A_WHILE: Duration = Duration::from_millis(500);

/// What came to nothing on a busy computer is pressed again.
const AGAIN: Duration = Duration::from_secs(4);

/// Opens the drive page and takes control by its key.
pub(crate) fn take_control(browser: &Browser, url: &str) {
    browser.go(url);
    take(browser);
}

/// Takes control where the page is open.
pub(crate) fn take(browser: &Browser) {
    let (can_take, has) =
        ("!document.getElementById('take').disabled", "!document.getElementById('give').disabled");
    let began = Instant::now();
    loop {
        browser.until(&format!("{can_take} || {has}"));
        if browser.within(Duration::ZERO, has) {
            return;
        }
        browser.tap("t");
        if browser.within(AGAIN, has) {
            return;
        }
        // it was still with a page that has gone
        assert!(began.elapsed() < LONG, "control is not given:\n{}", browser.text("body"));
    }
}

/// Resets and holds the space bar until the arm moves; it stays down.
#[track_caller]
pub(crate) fn hold(browser: &Browser, witness: &Witness) {
    let moves = |limit| witness.sees_motion(limit);
    press(browser, witness, || browser.key_down(SPACE), || browser.key_up(SPACE), moves);
}

/// Resets and presses something until that comes of it in the time it is given; what is pressed stays down.
#[track_caller]
pub(crate) fn press(
    browser: &Browser,
    witness: &Witness,
    down: impl Fn(),
    up: impl Fn(),
    so: impl Fn(Duration) -> bool,
) {
    let began = Instant::now();
    loop {
        reset(browser, witness);
        down();
        if so(AGAIN) {
            return;
        }
        up();
        assert!(began.elapsed() < LONG, "nothing comes of the press:\n{}", browser.text("body"));
    }
}

/// Resets until the arm waits for a press, in control again where a busy computer had the page silent for too long.
#[track_caller]
pub(crate) fn reset(browser: &Browser, witness: &Witness) {
    let began = Instant::now();
    loop {
        if browser.script("return document.getElementById('give').disabled") == true {
            take(browser);
        }
        browser.tap("r");
        let is_ready = |live: &serde_json::Value| {
            live["snapshot"]["arm"]["state"] == "armed" && live["control"]["stopped"] == false
        };
        if witness.within(AGAIN, is_ready).is_ok() {
            return;
        }
        assert!(began.elapsed() < LONG, "the arm is not ready:\n{}", browser.text("body"));
    }
}

/// The arm does not follow any more.
#[track_caller]
pub(crate) fn sees_stop(witness: &Witness) {
    witness.until("the stop", |live| !is_moving(live));
}

/// Nothing is held and the arm has stopped, for good: a busy page that was silent for a moment goes on with its press.
#[track_caller]
pub(crate) fn stays_stopped(witness: &Witness) {
    let drives = |live: &serde_json::Value| live["control"]["pressed"] == true || is_moving(live);
    let began = Instant::now();
    loop {
        witness.until("the end of the press", |live| !drives(live));
        if witness.within(A_WHILE, drives).is_err() {
            return;
        }
        assert!(began.elapsed() < LONG, "the arm goes on");
    }
}

/// Has the page count how often it tells that a button is held, from now on.
pub(crate) fn count_holds(browser: &Browser) {
    browser.script(
        "window.holdsTold = 0;
         const send = WebSocket.prototype.send;
         WebSocket.prototype.send = function (data) {
           if (JSON.parse(data).type === 'hold') window.holdsTold += 1;
           return send.call(this, data);
         };",
    );
}

/// How often it has.
#[track_caller]
pub(crate) fn holds_told(browser: &Browser) -> u64 {
    browser.script("return window.holdsTold").as_u64().expect("a page that counts")
}

/// Has the page write down when it last told that a button is held, from now on.
pub(crate) fn note_holds(browser: &Browser) {
    browser.script(
        "sessionStorage.removeItem('held');
         if (window.notesHolds) return;
         window.notesHolds = true;
         const send = WebSocket.prototype.send;
         WebSocket.prototype.send = function (data) {
           if (JSON.parse(data).type === 'hold') sessionStorage.setItem('held', performance.timeOrigin + performance.now());
           return send.call(this, data);
         };",
    );
}

/// By how much that was after what was [noted](note), milliseconds by the page's own clock.
#[track_caller]
pub(crate) fn held_after_ms(browser: &Browser) -> f64 {
    let told = browser.script(
        "return Number(sessionStorage.getItem('held') ?? NaN) - Number(sessionStorage.getItem('noted') ?? NaN)",
    );
    told.as_f64().expect("a press and what ended it were noted")
}

/// Has the page write down when an event comes first, before anything else hears of it.
pub(crate) fn note(browser: &Browser, target: &str, event: &str) {
    browser.script(&format!(
        "sessionStorage.removeItem('noted');
         {target}.addEventListener('{event}', () => {{
           const at = performance.timeOrigin + performance.now();
           if (!sessionStorage.getItem('noted')) sessionStorage.setItem('noted', at);
         }}, {{ capture: true, once: true }});"
    ));
}

/// When it came, by the operator's clock.
#[track_caller]
pub(crate) fn noted_us(browser: &Browser, witness: &Witness) -> u64 {
    browser.until("sessionStorage.getItem('noted')");
    let told = browser.script("return Number(sessionStorage.getItem('noted'))");
    witness.at_us((told.as_f64().expect("milliseconds") * 1e3) as i64)
}
