//! Whatever ends the press stops the arm, in time by the slave's own clock.

use super::browser::{Browser, ESCAPE, SPACE};
use super::driver::{
    A_WHILE, held_after_ms, hold, note, note_holds, noted_us, sees_stop, stays_stopped, take, take_control,
};
use super::program::{Ended, Program};
use super::proxy::Proxy;
use super::turn;
use super::witness::{Witness, is_moving};

/// So often each is tried. A try does not count where the arm stood already: on a busy computer the page is not in time
/// by itself.
const TRIES: usize = 3;
const MOST_TRIES: usize = 12;

/// The page tells of no button after what ended its press, milliseconds by its own clock, which is rounded.
const HELD_AFTER_MS: f64 = 1.0;

/// When the last message came that held the button, by the operator's clock.
#[track_caller]
fn last_held_us(witness: &Witness) -> u64 {
    let live = witness.until("a press", |live| live["control"]["held_us"].is_u64());
    live["control"]["held_us"].as_u64().unwrap_or_default()
}

/// Whether the page knows of what ended its press.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Knows {
    Of,
    Not,
}

/// Drives by the space bar, has the press ended in some way, and looks at what the arm did.
///
/// `end` gives when it was, by the operator's clock, if it was, and leaves the drive page open and in control. A page
/// that knows of it tells of no button any more.
fn stops(test: &str, what: &str, knows: Knows, end: impl Fn(&Browser, &Witness, &Program) -> Option<u64>) {
    let _turn = turn();
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    take_control(&browser, &program.url("/drive"));
    let mut tries = Vec::new();
    for _ in 0..MOST_TRIES {
        note_holds(&browser);
        hold(&browser, &witness);
        let Some(at_us) = end(&browser, &witness, &program) else {
            browser.key_up(SPACE);
            continue;
        };
        sees_stop(&witness);
        let held_after_ms = held_after_ms(&browser);
        assert!(
            knows == Knows::Not || held_after_ms <= HELD_AFTER_MS,
            "the page told of the button {held_after_ms} ms after its end"
        );
        let held_us = last_held_us(&witness);
        // the key is still down, as far as the keyboard knows
        assert!(witness.within(A_WHILE, is_moving).is_err(), "what has ended begins by itself");
        browser.key_up(SPACE);
        tries.extend(program.so_far().was_moving(at_us).then_some(Ended { at_us, held_us }));
        if tries.len() == TRIES {
            break;
        }
    }
    program.end().stopped_in_time(what, &tries);
}

#[test]
fn the_space_bar_is_let_go() {
    stops("console::stops::the_space_bar_is_let_go", "space bar let go", Knows::Of, |browser, witness, _| {
        note(browser, "window", "keyup");
        browser.key_up(SPACE);
        Some(noted_us(browser, witness))
    });
}

/// Goes to another tab and back. The page hears that it has lost the focus and that it is hidden; only one of the
/// two is left to reach what the page does about it.
fn leaves(browser: &Browser, witness: &Witness, (target, event): (&str, &str), without: &str) -> Option<u64> {
    browser.script(&format!(
        "window.addEventListener('{without}', event => event.stopImmediatePropagation(), {{capture: true}})"
    ));
    note(browser, target, event);
    let drive = browser.tab();
    browser.open_another_tab();
    stays_stopped(witness);
    browser.close_for(&drive);
    browser.until("document.hasFocus()");
    // an arm that stood already is not waited for, and whoever comes back at once has not been away
    (browser.script("return sessionStorage.getItem('noted') !== null") == true)
        .then(|| noted_us(browser, witness))
}

#[test]
fn the_focus_is_lost() {
    stops("console::stops::the_focus_is_lost", "focus lost", Knows::Of, |browser, witness, _| {
        leaves(browser, witness, ("window", "blur"), "visibilitychange")
    });
}

#[test]
fn the_tab_is_hidden() {
    stops("console::stops::the_tab_is_hidden", "tab hidden", Knows::Of, |browser, witness, _| {
        leaves(browser, witness, ("document", "visibilitychange"), "blur")
    });
}

#[test]
fn the_page_is_loaded_again_and_holds_nothing() {
    stops(
        "console::stops::the_page_is_loaded_again_and_holds_nothing",
        "page loaded again",
        Knows::Of,
        |browser, witness, _| {
            note(browser, "window", "pagehide");
            browser.reload();
            let at_us = noted_us(browser, witness);
            // the key is still down; the page knows of no press and is not in control
            browser.until("document.getElementById('take') && !document.getElementById('take').disabled");
            let live = witness.until("nobody in control", |live| live["control"]["holder"].is_null());
            assert_eq!(live["control"]["pressed"], false);
            take(browser);
            Some(at_us)
        },
    );
}

#[test]
fn the_page_hangs() {
    stops("console::stops::the_page_hangs", "page hung", Knows::Not, |browser, witness, _| {
        // nothing of the page runs for a second, and the socket stays open
        browser.script(
            "sessionStorage.setItem('noted', performance.timeOrigin + performance.now());
             setTimeout(() => { const end = performance.now() + 1000; while (performance.now() < end); }, 0);",
        );
        sees_stop(witness);
        Some(noted_us(browser, witness))
    });
}

/// The same through a line that something happens to. (Chromium's own way of being offline leaves sockets alone
/// that are open.)
fn loses_the_line(test: &str, what: &str, lose: impl Fn(&Proxy)) {
    let _turn = turn();
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let proxy = Proxy::to(program.address());
    browser.go(&proxy.url("/drive"));
    let mut tries = Vec::new();
    for _ in 0..MOST_TRIES {
        take(&browser);
        hold(&browser, &witness);
        let at_us = witness.now_us();
        lose(&proxy);
        sees_stop(&witness);
        let held_us = last_held_us(&witness);
        // the page says so itself
        browser.until("document.getElementById('link').textContent.includes('NO CONNECTION')");
        assert_eq!(browser.script("return document.body.classList.contains('silent')"), true);
        witness.until("nobody in control", |live| live["control"]["holder"].is_null());
        proxy.mend();
        browser.until("document.getElementById('link').textContent === 'connected'");
        assert!(witness.within(A_WHILE, is_moving).is_err(), "what has ended begins by itself");
        browser.key_up(SPACE);
        tries.extend(program.so_far().was_moving(at_us).then_some(Ended { at_us, held_us }));
        if tries.len() == TRIES {
            break;
        }
    }
    program.end().stopped_in_time(what, &tries);
}

#[test]
fn the_socket_is_cut() {
    loses_the_line("console::stops::the_socket_is_cut", "socket cut", Proxy::cut);
}

#[test]
fn the_line_hangs() {
    loses_the_line("console::stops::the_line_hangs", "line hangs", Proxy::hang);
}

#[test]
fn a_stop_that_is_not_heard_is_told() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::stops::a_stop_that_is_not_heard_is_told") else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    let proxy = Proxy::to(program.address());
    browser.go(&proxy.url("/drive"));
    browser.until("document.getElementById('link').textContent === 'connected'");
    let failed = "document.getElementById('stop').classList.contains('failed')";
    proxy.hang();
    browser.tap(ESCAPE);
    browser.until(failed);
    let told = browser.script("return getComputedStyle(document.getElementById('stop'), '::after').content");
    assert!(told.as_str().is_some_and(|told| told.contains("not heard")), "{told}");
    proxy.mend();
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.tap(ESCAPE);
    browser.until(&format!("!{failed}"));
    witness.until("the latch", |live| live["control"]["stopped"] == true);
}

#[test]
fn pictures_that_stand_still_are_dimmed_and_say_how_old_they_are() {
    let _turn = turn();
    let test = "console::stops::pictures_that_stand_still_are_dimmed_and_say_how_old_they_are";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let proxy = Proxy::to(program.address());
    browser.go(&proxy.url("/drive"));
    let all = |so: &str| {
        format!(
            "(all => all.length >= 2 && all.every({so}))([...document.querySelectorAll('figure:has(.stamp)')])"
        )
    };
    // by its stamp: a figure that has shown nothing yet is not marked yet either
    let fresh = all("one => /\\d ms$/.test(one.innerText.trim())");
    browser.until(&fresh);
    proxy.hold_up("/pictures");
    browser
        .until(&all("one => one.classList.contains('stale') && /STALE: [\\d.]+ s old/.test(one.innerText)"));
    let shown = browser.script("return getComputedStyle(document.querySelector('.stale canvas')).opacity");
    let opacity = shown.as_str().and_then(|text| text.parse::<f64>().ok());
    assert!(opacity.is_some_and(|opacity| opacity < 0.5), "{shown}");
    // what the arm does is still told; the page may have been busy with itself until now, as it is new
    browser.until("document.querySelector('#link').textContent === 'connected'");
    proxy.mend();
    browser.until(&fresh);
}
