//! The slave's view in full screen: why a press does not count is to be read there too, and leaving it stops the arm.

use super::browser::{Browser, SPACE};
use super::driver::{hold, sees_stop, take_control};
use super::program::Program;
use super::turn;
use super::witness::Witness;

/// Something is seen of an element.
fn is_seen(css: &str) -> String {
    format!(
        "((box) => box.width > 0 && box.height > 0 && box.top >= 0 && box.bottom <= innerHeight)(
           document.querySelector({css:?}).getBoundingClientRect())"
    )
}

#[test]
fn why_a_press_does_not_count_is_told_in_full_screen() {
    let _turn = turn();
    let test = "console::full_screen::why_a_press_does_not_count_is_told_in_full_screen";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    browser.go(&program.url("/slave"));
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.tap("f");
    browser.until("document.body.classList.contains('full')");
    // nobody is in control: the space bar does nothing, and the page says why
    browser.until("document.getElementById('control').textContent.includes('Nobody is in control')");
    browser.tap(SPACE);
    browser.until("document.getElementById('control').textContent.includes('take control first')");
    for css in ["#control", "#standing", "#stop", "#hold"] {
        browser.until(&is_seen(css));
    }
    browser.tap("f");
    browser.until("!document.body.classList.contains('full')");

    // Esc there is the browser's: the page hears that it is left, and no key
    take_control(&browser, &program.url("/slave"));
    browser.tap("f");
    browser.until("document.body.classList.contains('full')");
    hold(&browser, &witness);
    browser.script("document.exitFullscreen()");
    sees_stop(&witness);
    witness.until("the latch", |live| live["control"]["stopped"] == true);
    browser.key_up(SPACE);
}
