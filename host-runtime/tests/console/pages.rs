//! Every page that the overview leads to: STOP comes first, nothing is wrong in its console, and pictures of
//! it, light and dark, are left to be looked at.

use super::browser::{Browser, DESK, ENTER, ESCAPE, SPACE, TAB};
use super::driver::{A_WHILE, reset, take_control};
use super::program::Program;
use super::turn;
use super::witness::Witness;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// A tablet held upright, CSS pixels.
pub(crate) const TABLET: (u32, u32) = (768, 1024);

/// A desk's screen at 400 %, CSS pixels: from there on nothing has to be scrolled sideways (WCAG 2.2, 1.4.10).
const NARROW: (u32, u32) = (320, 256);

/// Where pictures of pages are left.
pub(crate) fn screens() -> PathBuf {
    let folder = tetrad_tests::target().join("verify/screens");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Paths of the pages: what the overview links to, and what that links to.
fn pages(browser: &Browser, program: &Program) -> BTreeSet<String> {
    let mut known = BTreeSet::new();
    let mut left = vec!["/".to_owned()];
    while let Some(path) = left.pop() {
        if known.insert(path.clone()) {
            browser.go(&program.url(&path));
            let links = browser.script(
                "return [...document.querySelectorAll('a[href]')]
                   .filter(link => link.origin === location.origin && !link.hasAttribute('download'))
                   .map(link => link.pathname)",
            );
            left.extend(links.as_array().into_iter().flatten().filter_map(Value::as_str).map(str::to_owned));
        }
    }
    assert!(known.contains("/drive"), "{known:?}");
    known
}

/// The page is loaded, has heard of the hand, and shows what it is there for.
fn settle(browser: &Browser) {
    browser.until("document.readyState === 'complete'");
    browser.until("document.getElementById('link')?.textContent !== 'connecting ...'");
    // where there are views, each has a picture
    browser.until(
        "location.pathname === '/replay' || !document.getElementById('views') ||
         ((stamps) => stamps.length > 0 && stamps.every((stamp) => /\\d ms/.test(stamp.textContent)))(
           [...document.querySelectorAll('#views .stamp')])",
    );
    browser.until("document.querySelectorAll('figure.stale').length === 0");
}

#[test]
fn stop_comes_first_and_is_reached_by_keyboard_on_every_page() {
    let _turn = turn();
    let Some(browser) =
        Browser::open("console::pages::stop_comes_first_and_is_reached_by_keyboard_on_every_page")
    else {
        return;
    };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    for path in pages(&browser, &program) {
        for key in [ENTER, SPACE, ESCAPE, "s"] {
            // in control, so that the stop can be reset and seen again
            take_control(&browser, &program.url("/drive"));
            reset(&browser, &witness);
            browser.tap("g");
            browser.go(&program.url(&path));
            browser.until("document.getElementById('link').textContent === 'connected'");
            match key {
                ESCAPE => {}
                // also in a list and in a number's field: no letter is text there
                "s" => {
                    browser.script("document.querySelector('select, input[type=number]')?.focus()");
                }
                _ => {
                    browser.tap(TAB);
                    assert_eq!(browser.script("return document.activeElement.id"), "stop", "{path}");
                }
            }
            browser.tap(key);
            witness.until("the stop", |live| live["control"]["stopped"] == true);
        }
        let seen = browser.script(
            "const at = document.getElementById('stop').getBoundingClientRect();
             scrollTo(0, document.body.scrollHeight);
             const then = document.getElementById('stop').getBoundingClientRect();
             return [at.top >= 0, then.top >= 0, then.bottom <= innerHeight, then.height >= 44]",
        );
        assert_eq!(
            seen,
            serde_json::json!([true, true, true, true]),
            "{path}: STOP is always there to be hit"
        );
    }

    // at the place of S another letter is another button's, and one that is not Latin stops
    take_control(&browser, &program.url("/drive"));
    reset(&browser, &witness);
    let at_s = |key: char| {
        browser.script(&format!(
            "document.body.dispatchEvent(new KeyboardEvent('keydown', {{key: '{key}', code: 'KeyS', bubbles: true}}))"
        ))
    };
    let stopped = |live: &Value| live["control"]["stopped"] == true;
    at_s('r');
    assert!(witness.within(A_WHILE, stopped).is_err(), "R stops");
    at_s('\u{44b}');
    witness.until("the stop", stopped);
}

#[test]
fn every_page_is_clean_and_has_its_picture_taken() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::pages::every_page_is_clean_and_has_its_picture_taken") else {
        return;
    };
    let folder = screens();
    let program = Program::operator();
    let witness = Witness::of(program.address());
    witness.until("the hand", |live| live["snapshot"]["hand"]["position_mm"].is_array());
    let mut taken = 0;
    for path in pages(&browser, &program) {
        // what the pages were told before is not of this one
        browser.log();
        for (size, of) in [(DESK, "desk"), (TABLET, "tablet"), (NARROW, "narrow screen")] {
            for scheme in ["light", "dark"] {
                browser.look(size, scheme);
                browser.go(&program.url(&path));
                settle(&browser);
                let name = if path == "/" { "overview" } else { path.trim_matches('/') };
                let file =
                    folder.join(format!("{}-{}-{scheme}.png", name.replace('/', "-"), of.replace(' ', "-")));
                std::fs::write(&file, browser.picture()).expect("a picture");
                taken += 1;
                let wide = browser.script("return document.documentElement.scrollWidth > innerWidth");
                assert_eq!(wide, false, "{path} does not fit a {of}");
                let shown = browser.script(
                    "return ['stop', 'link'].every((id) => {
                       const box = document.getElementById(id).getBoundingClientRect();
                       return box.left >= 0 && box.right <= innerWidth && box.top >= 0 && box.bottom <= innerHeight;
                     })",
                );
                assert_eq!(shown, true, "{path}: STOP and the link's state are to be seen on a {of}");
            }
        }
        let told = browser.log();
        assert!(told.is_empty(), "{path}: {told:#?}");
    }
    // no link leads to where the token is asked for
    for (size, of) in [(DESK, "desk"), (TABLET, "tablet")] {
        for scheme in ["light", "dark"] {
            browser.look(size, scheme);
            browser.go(&program.url("/sign-in"));
            browser.until("document.readyState === 'complete' && document.getElementById('token')");
            let file = folder.join(format!("sign-in-{of}-{scheme}.png"));
            std::fs::write(&file, browser.picture()).expect("a picture");
            taken += 1;
        }
    }
    println!("measured: {taken} pictures of pages in {}", folder.display());
}
