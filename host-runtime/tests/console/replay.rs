//! The replay page with a recorded session: scrubbed, read whole, exported, and its plots in their places.

use super::browser::{Browser, DESK, LONG, SPACE, lit};
use super::driver::{A_WHILE, hold, sees_stop, take_control};
use super::pages::{TABLET, screens};
use super::program::Program;
use super::turn;
use super::witness::Witness;
use serde_json::{Value, json};
use std::time::Instant;

/// A tablet held sideways, CSS pixels.
const SIDEWAYS: (u32, u32) = (1024, 768);

/// Every plot is drawn, as large as its place, and no two places have a pixel in common.
const PLOTS_ARE_IN_PLACE: &str = "((places) => {
  const boxes = places.map((place) => place.getBoundingClientRect());
  const drawn = places.every((place, at) => {
    const svg = place.querySelector('.main-svg')?.getBoundingClientRect();
    return svg && Math.abs(svg.width - boxes[at].width) < 2 && Math.abs(svg.height - boxes[at].height) < 2;
  });
  const apart = boxes.every((one, at) => boxes.slice(at + 1).every((other) =>
    one.right <= other.left + 0.5 || other.right <= one.left + 0.5 || one.bottom <= other.top + 0.5 || other.bottom <= one.top + 0.5));
  const inside = boxes.every((box) => box.left >= 0 && box.right <= innerWidth && box.width > 250 && box.height > 250);
  return places.length >= 5 && drawn && apart && inside;
})([...document.querySelectorAll('#plots .plot')])";

/// Records a session in which the arm is driven for a moment.
fn record(browser: &Browser, sessions: &std::path::Path) {
    let program = Program::recorded(sessions);
    let witness = Witness::of(program.address());
    take_control(browser, &program.url("/drive"));
    hold(browser, &witness);
    browser.key_up(SPACE);
    sees_stop(&witness);
    program.end();
}

#[test]
fn a_session_that_grows_is_gone_on_with_where_it_was() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::replay::a_session_that_grows_is_gone_on_with_where_it_was")
    else {
        return;
    };
    let sessions = tempfile::tempdir().expect("a directory");
    // its own session, while it is recorded
    let program = Program::recorded(sessions.path());
    browser.go(&program.url("/replay?session=driven.mcap"));
    let length = "document.getElementById('slider').max";
    // as soon as there is something of it
    grows(&browser, &format!("!document.getElementById('slider').disabled && {length} > 1e6"));
    browser.until("/\\(\\d+ of /.test(document.getElementById('time').textContent)");
    browser.script(
        "const slider = document.getElementById('slider');
         slider.value = 900000;
         slider.dispatchEvent(new Event('input'));",
    );
    let shown = "document.getElementById('time').textContent.startsWith('0.900 s (')";
    browser.until(shown);
    let before = browser.script(&format!("return Number({length})")).as_f64().expect("a length");
    grows(&browser, &format!("{length} > {before}"));
    browser.until(shown);
    browser.until(&format!("{} > 0.5", lit("#views canvas")));
}

/// Looks again until that comes of it.
#[track_caller]
fn grows(browser: &Browser, so: &str) {
    let began = Instant::now();
    while browser.script(&format!("return Boolean({so})")) != true {
        assert!(began.elapsed() < LONG, "{so} does not come true:\n{}", browser.text("body"));
        browser.click("#again");
        std::thread::sleep(A_WHILE);
    }
}

/// The moment that is shown, seconds.
fn shown_s(browser: &Browser) -> f64 {
    let text = browser.text("#time");
    text.split(' ')
        .next()
        .and_then(|seconds| seconds.parse().ok())
        .unwrap_or_else(|| panic!("no time: {text}"))
}

/// Has the page take all that was known at the end of the session for silent then, or for heard, and looks at what it
/// says of it.
fn says_what_was_silent(browser: &Browser, silent: bool) {
    browser.script(&format!(
        "window.json ??= Response.prototype.json;
         Response.prototype.json = async function () {{
           const told = await window.json.call(this);
           const [silent, age_us] = [{silent}, 700_000];
           const arm = silent ? {{ slowed: [], speed_share: null }} : {{ slowed: ['slowed'], speed_share: 0.25 }};
           if (told?.arm) Object.assign(told.arm, {{ silent, standing: `pretended, ${{silent}}`, ...arm }});
           const balls = ['red', 'green', 'blue', 'yellow'].map((name) => ({{ name, state: 'visible', visible: 1 }}));
           // there is no picture to ask for where there was none by then
           for (const one of told?.cameras?.filter(({{ age_us }}) => age_us !== null) ?? []) {{
             Object.assign(one, {{ stale: silent, age_us, balls }});
           }}
           if (told?.hand) Object.assign(told.hand, {{ silent, age_us }});
           return told;
         }};"
    ));
    let text = |id: &str| format!("document.getElementById('{id}').textContent");
    let told = format!("return {} === 'pretended, {silent}'", text("standing"));
    let began = Instant::now();
    while browser.script(&told) != true {
        assert!(began.elapsed() < LONG, "no moment is asked for anew:\n{}", browser.text("body"));
        // from elsewhere to the end, where all was heard; a moment that was being asked for already is as it was
        browser.tap("\u{e011}");
        browser.tap("\u{e010}");
        std::thread::sleep(A_WHILE);
    }
    let now = browser.script(&format!(
        "return [document.body.classList.contains('unheard'),
           [...document.querySelectorAll('#views figure')].map((figure) =>
             [figure.classList.contains('stale'), figure.querySelector('.stamp').textContent]),
           {}.includes('Share of its speednot known'),
           {}.startsWith('Knownnothing: not heard for 700 ms'),
           {}.includes('not known')]",
        text("arm"),
        text("hand"),
        text("cameras")
    ));
    let stamp = if silent { "STALE: taken 700 ms before" } else { "taken 700 ms before" };
    let figure = json!([silent, stamp]);
    assert_eq!(now, json!([silent, [figure.clone(), figure], silent, silent, silent]));
}

#[test]
fn a_session_is_scrubbed_exported_and_plotted() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::replay::a_session_is_scrubbed_exported_and_plotted") else {
        return;
    };
    let sessions = tempfile::tempdir().expect("a directory");
    record(&browser, sessions.path());
    let folder = sessions.path().to_str().expect("a path in plain letters");
    let program = Program::operator_with(&format!("sessions = {folder:?}\n"), &[]);
    browser.go(&program.url("/replay"));
    browser.until("document.querySelectorAll('#session option').length === 2");
    // what was told before is of other pages
    browser.log();
    browser.script(
        "const session = document.getElementById('session');
         session.value = 'driven.mcap';
         session.dispatchEvent(new Event('change'));",
    );
    browser.until("!document.getElementById('slider').disabled");
    browser.until("document.querySelectorAll('#views canvas').length === 2");
    let length_s =
        browser.script("return document.getElementById('slider').max / 1e6").as_f64().expect("seconds");

    // moment by moment, by its keys, its buttons and its slider
    // the first picture is there some milliseconds after the recording
    browser.until("document.getElementById('time').textContent.includes(' s (1 of ')");
    browser.tap("\u{e014}");
    browser.until("document.getElementById('time').textContent.includes(' s (2 of ')");
    let second_s = shown_s(&browser);
    assert!(second_s > 0.0 && second_s < 1.0, "one picture on is {second_s} s");
    browser.click("#on");
    browser.until(&format!("parseFloat(document.getElementById('time').textContent) > {second_s}"));
    browser.script(
        "const slider = document.getElementById('slider');
         slider.value = slider.max / 2;
         slider.dispatchEvent(new Event('input'));",
    );
    let middle_s = length_s / 2.0;
    browser.until(&format!(
        "Math.abs(parseFloat(document.getElementById('time').textContent) - {middle_s}) < 0.01"
    ));
    browser.until(&format!("{} > 0.5", lit("#views canvas")));
    assert_ne!(browser.text("#standing"), "nothing is open");
    assert_eq!(browser.script("return document.querySelectorAll('#cameras tr').length"), 2);
    browser.tap("\u{e010}");
    browser.until(&format!(
        "Math.abs(parseFloat(document.getElementById('time').textContent) - {length_s}) < 0.01"
    ));
    // it plays by itself, from the beginning once more
    browser.tap("p");
    browser.until(&format!(
        "(now => now > 0.2 && now < {length_s} - 0.1)(parseFloat(document.getElementById('time').textContent))"
    ));
    browser.tap("p");

    // what was silent by the moment that is shown is not known
    for silent in [false, true] {
        says_what_was_silent(&browser, silent);
    }

    // all of it: plots beside each other whatever the window's size, and files
    browser.click("#whole");
    browser.until(PLOTS_ARE_IN_PLACE);
    let folder = screens();
    for (size, of) in [(DESK, "desk"), (SIDEWAYS, "sideways"), (TABLET, "tablet")] {
        for scheme in ["light", "dark"] {
            browser.look(size, scheme);
            browser.until(PLOTS_ARE_IN_PLACE);
            let wide = browser.script("return document.documentElement.scrollWidth > innerWidth");
            assert_eq!(wide, false, "the plots do not fit a {of}");
            for (part, to) in [("session", "0"), ("plots", "document.getElementById('plots').offsetTop - 60")]
            {
                browser.script(&format!("scrollTo(0, {to})"));
                let file = folder.join(format!("replay-{part}-{of}-{scheme}.png"));
                std::fs::write(&file, browser.picture()).expect("a picture");
            }
        }
    }
    browser.look(DESK, "light");
    // letters of plots are in the page's ink, which is tried for its contrast; they are drawn anew for another one
    browser.until(
        "(text => text && getComputedStyle(text).fill === getComputedStyle(document.body).color)
         (document.querySelector('#plots .xtick text'))",
    );

    let files = browser.script("return [...document.querySelectorAll('#files a')].map((link) => link.href)");
    let files: Vec<&str> = files.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    assert!(files.iter().any(|file| file.ends_with(".html")), "a report: {files:?}");
    for name in ["observations.csv", "pose.csv"] {
        let link =
            files.iter().find(|file| file.ends_with(name)).unwrap_or_else(|| panic!("{name}: {files:?}"));
        let told = browser.script(&format!("return fetch({link:?}).then((answer) => answer.text())"));
        let text = told.as_str().unwrap_or_default();
        let columns = text.lines().next().unwrap_or_default().split(',').count();
        let even = text.lines().all(|line| line.split(',').count() == columns);
        assert!(columns > 4 && text.lines().count() > 10 && even, "{name}: {text:.200}");
    }
    let told = browser.log();
    assert!(told.is_empty(), "{told:#?}");
}
