//! What the set-up page shows of what was learnt, and what is kept of it: the row under the pointer, what would be
//! mistaken for a ball, files of colours, the arms of the frame.

use super::browser::{Browser, DESK, LONG};
use super::pages::{TABLET, screens};
use super::program::Program;
use super::turn;
use serde_json::Value;
use std::time::{Duration, Instant};

/// From one look at something that is waited for to the next.
const POLL: Duration = Duration::from_millis(200);

/// What the page says of what it was asked for.
const SAID: &str = "document.getElementById('said').textContent";

/// Opens the page, and has the balls found.
fn find(browser: &Browser, program: &Program) {
    browser.go(&program.url("/setup"));
    browser.until("document.getElementById('link').textContent === 'connected'");
    browser.until("!document.getElementById('find').disabled");
    browser.tap("f");
    browser.until(&format!("{SAID}.includes('found by 2 of 2 cameras')"));
    browser.until("document.querySelectorAll('figure.stands').length === 2");
}

/// Moves the mouse over the first camera's picture, so far below its middle, until the words under the plot are of
/// that row; gives it.
#[track_caller]
fn row_at(browser: &Browser, down: i64) -> i64 {
    let wanted = browser
        .script(&format!(
            "const over = document.querySelector('canvas.over');
             const box = over.getBoundingClientRect();
             return Math.round((0.5 + {down} / box.height) * over.height - 0.5)"
        ))
        .as_i64()
        .expect("a row");
    let began = Instant::now();
    for right in [0, 1].into_iter().cycle() {
        browser.point_at("canvas.over", (right, down));
        std::thread::sleep(POLL);
        let words = browser.text("#row");
        let row =
            words.split_once(", row ").and_then(|(_, rest)| rest.split(':').next()?.parse::<i64>().ok());
        // the mouse is at a whole pixel of the screen
        if row.is_some_and(|row| (row - wanted).abs() <= 4) && words.contains("the threshold of") {
            break;
        }
        assert!(began.elapsed() < LONG, "no row {wanted}: {words}");
    }
    wanted
}

/// How much of the first camera's picture has a colour, 0 to 1.
const COLOURED: &str = "((over) => {
  const { width, height } = over;
  const pen = new OffscreenCanvas(width, height).getContext('2d', { willReadFrequently: true });
  pen.drawImage(over, 0, 0);
  const { data } = pen.getImageData(0, 0, width, height);
  let coloured = 0;
  for (let at = 0; at < data.length; at += 4) {
    coloured += Math.max(data[at], data[at + 1], data[at + 2]) - Math.min(data[at], data[at + 1], data[at + 2]) > 40;
  }
  return coloured / (width * height);
})(document.querySelector('canvas.over'))";

#[test]
fn what_was_learnt_is_looked_at() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::teaching::what_was_learnt_is_looked_at") else { return };
    let program = Program::operator();
    find(&browser, &program);

    // the row under the pointer, as the pointer goes down
    let upper = row_at(&browser, -20);
    browser.until("document.querySelector('#scan .main-svg')");
    let lower = row_at(&browser, 20);
    assert!(lower > upper, "row {lower} below row {upper}");
    browser.until("document.querySelectorAll('#scan .scatterlayer .trace').length >= 7");

    // what would be mistaken for red, and the still picture again
    browser.point_at("#stop", (0, 0));
    let coloured = browser.script(&format!("return {COLOURED}")).as_f64().expect("a share");
    let show = ".learnt .balls li:first-child button";
    let shows = |words: &str| {
        browser.scroll_to(show);
        browser.click(show);
        browser.until(&format!("document.querySelector('.still').textContent === '{words}'"));
    };
    shows("mistaken for red");
    assert_eq!(browser.script(&format!("return document.querySelector({show:?}).ariaPressed")), "true");
    let marked = browser.script(&format!("return {COLOURED}")).as_f64().expect("a share");
    assert_ne!(marked, coloured, "another picture");
    let folder = screens();
    for (size, of) in [(DESK, "desk"), (TABLET, "tablet")] {
        for scheme in ["light", "dark"] {
            browser.look(size, scheme);
            browser.script("scrollTo(0, 0)");
            let file = folder.join(format!("setup-found-{of}-{scheme}.png"));
            std::fs::write(&file, browser.picture()).expect("a picture");
        }
    }
    browser.look(DESK, "light");
    shows("STILL");
    browser.until(&format!("Math.abs({COLOURED} - {coloured}) < 0.02"));
    let told = browser.log();
    assert!(told.is_empty(), "{told:#?}");
}

#[test]
fn colours_and_arms_are_kept() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::teaching::colours_and_arms_are_kept") else { return };
    let program = Program::demo();
    find(&browser, &program);
    let click = |css: &str| {
        browser.scroll_to(css);
        browser.click(css);
    };
    let says = |words: &str| browser.until(&format!("{SAID}.includes({words:?})"));

    click("#save");
    says("saved: ");
    let files = ["left", "right"].map(|view| program.out().join(format!("colours-{view}.toml")));
    let texts = files.each_ref().map(|file| std::fs::read_to_string(file).expect("a file of colours"));
    assert!(texts.iter().all(|text| text.contains("[yellow]")), "{texts:?}");
    click("#load");
    says("loaded; not in use yet");
    let download = "return fetch(document.querySelector('#files a').href).then((answer) => answer.text())";
    let kept: Value = browser.script(download);
    assert!(kept.as_str().is_some_and(|text| text.contains("[yellow]")), "{kept}");

    // a length is entered, and is known to whoever opens the page later
    let enter = |mm: &str| {
        browser.scroll_to("#arm_mm");
        browser.script("document.getElementById('arm_mm').value = ''");
        browser.write("#arm_mm", mm);
        click("#arm button");
    };
    enter("90");
    says("arms of 90 mm");
    browser.reload();
    browser.until("document.getElementById('arm_mm').value === '90'");

    // files that are given: what was saved, and one in which a key is wrong
    let upload = "#files input[type=file]";
    browser.write(upload, files[0].to_str().expect("a path in plain letters"));
    says("loaded from colours-left.toml");
    let bad = program.out().join("bad.toml");
    let wrong = texts[0].replacen("reference = [", "reference = [999, ", 1);
    assert_ne!(wrong, texts[0]);
    std::fs::write(&bad, wrong).expect("a file");
    browser.write(upload, bad.to_str().expect("a path in plain letters"));
    says("bad.toml: [red] reference");
    assert_eq!(browser.script("return document.getElementById('said').classList.contains('bad')"), true);
}
