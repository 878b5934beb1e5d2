//! The operator's clock, as a page knows it: what it says, and that a program that was started again has another.

use super::browser::Browser;
use super::driver::A_WHILE;
use super::program::Program;
use super::proxy::Proxy;
use super::turn;
use serde_json::Value;

/// Notes what is known at each step. Times of the page's clock are milliseconds, those of the operator's microseconds.
const TRY: &str = "
const { LineClock } = await import(new URL('/line-clock.js', location.href));
const clock = new LineClock();
const told = { nothing: clock.age(49.9e6, 1000) };
clock.heard(49.9e6, 1000);
told.heard = clock.age(49.9e6, 1000);
// an echo that was back soon
clock.answered(1000, 50e6, 1010);
told.quick = clock.age(50e6, 1010);
// one that was not: it bounds nothing better
clock.answered(2000, 51.895e6, 3000);
told.slow = clock.age(51.895e6, 3000);
// a little later than now, and far later
told.soon = clock.age(52.05e6, 3000);
told.another = clock.age(112e6, 3000);
// bounds contradict each other by 2 ms, and by 100 ms; then there are new ones
clock.heard(52.002e6, 3000);
told.hair = clock.age(51.9e6, 3000);
clock.heard(52.1e6, 3000);
told.gap = clock.age(51.9e6, 3000);
clock.answered(3000, 52.11e6, 3010);
told.anew = clock.age(52.11e6, 3010);
// a browser whose timer knows whole milliseconds only, and clocks that drift apart by more than is allowed for
const rounded = new LineClock();
const operatorUs = (ms) => (ms * 1.0003 + 5000) * 1000;
told.unknown = 0;
for (let ms = 1000; ms < 60_000; ms += 25.3) {
  rounded.answered(Math.floor(ms), operatorUs(ms + 0.2), Math.floor(ms + 0.4));
  const age = rounded.age(operatorUs(ms - 100), ms);
  if (!age || Math.abs(age.ms - 100) > 2) told.unknown += 1;
}
return told;";

#[test]
fn bounds_of_echoes_tell_how_old_a_time_is() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::line_clock::bounds_of_echoes_tell_how_old_a_time_is") else {
        return;
    };
    let program = Program::operator();
    browser.go(&program.url("/"));
    let told = browser.script(&format!("return (async () => {{ {TRY} }})()"));
    let is = |what: &str, ms: f64, within: f64| {
        let near = |key: &str, wanted: f64| {
            told[what][key].as_f64().is_some_and(|is| (is - wanted).abs() < 0.01 * wanted.max(1.0))
        };
        assert!(near("ms", ms) && near("within", within), "{what} is not {ms} within {within}: {told}");
    };
    for what in ["nothing", "heard", "another", "gap"] {
        assert!(told.get(what).is_some_and(Value::is_null), "{what} is not known: {told}");
    }
    is("quick", 5.0, 5.0);
    // the clocks have drifted apart by 0.2 ms meanwhile, at the most
    is("slow", 100.0, 5.2);
    is("soon", 0.0, 5.2);
    is("hair", 101.1, 0.9);
    is("anew", 5.0, 5.0);
    assert_eq!(told["unknown"], 0, "rounded: {told}");
}

/// What all stamps say, and whether they are marked as stale.
const STAMPS: &str = "[...document.querySelectorAll('.stamp')]
    .map((stamp) => [stamp.textContent, stamp.closest('.stale') !== null])";

#[test]
fn pictures_of_a_program_that_has_ended_are_old() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::line_clock::pictures_of_a_program_that_has_ended_are_old")
    else {
        return;
    };
    let mut program = Program::operator();
    let proxy = Proxy::to(program.address());
    let fresh = format!(
        "((all) => all.length > 0 && all.every(([text, stale]) => /^\\d+ ms$/.test(text) && !stale))({STAMPS})"
    );
    for page in ["/drive", "/slave"] {
        browser.go(&proxy.url(page));
        browser.until(&fresh);
        proxy.cut();
        drop(program);
        browser.until("document.getElementById('link').textContent.includes('NO CONNECTION')");
        // of the next program the page hears all but pictures
        proxy.hold_up("/pictures");
        program = Program::operator();
        proxy.lead_to(program.address());
        proxy.open();
        browser.until("document.getElementById('link').textContent === 'connected'");
        browser.until("/^\\d+ ms there and back$/.test(document.querySelector('.trip').textContent)");
        std::thread::sleep(A_WHILE);
        let told = browser.script(&format!("return {STAMPS}"));
        let stamps = told.as_array().cloned().unwrap_or_default();
        assert!(!stamps.is_empty() && stamps.iter().all(|stamp| stamp[1] == true), "{page}: {told}");
        proxy.mend();
        browser.until(&fresh);
    }
}
