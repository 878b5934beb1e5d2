//! What is not heard any more is not shown as if it were so now.

use super::browser::Browser;
use super::program::Program;
use super::turn;
use serde_json::{Value, json};

/// What keeps the arm from following, as nobody else says it.
const LIMIT: &str = "slowed for the test";

/// Has the page take what it is told of the arm, the hand and the cameras for this.
fn pretend(browser: &Browser, arm: &Value, age_us: &Value) {
    browser.script(&format!(
        "window.parse ??= JSON.parse;
         JSON.parse = (text, ...more) => {{
           const told = window.parse(text, ...more);
           if (told?.type === 'live') {{
             Object.assign(told.snapshot.arm ?? {{}}, {arm});
             for (const one of [told.snapshot.hand, ...told.snapshot.cameras, ...told.snapshot.links]) Object.assign(one ?? {{}}, {{age_us: {age_us}}});
           }}
           return told;
         }};"
    ));
}

#[test]
fn an_arm_that_is_silent_is_not_shown_as_engaged() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::silent::an_arm_that_is_silent_is_not_shown_as_engaged")
    else {
        return;
    };
    let program = Program::operator();
    let engaged = "document.body.classList.contains('engaged')";
    let words = "document.getElementById('standing').textContent";
    for page in ["/drive", "/slave"] {
        browser.go(&program.url(page));
        browser.until(&format!("{words} !== 'not heard yet'"));
        let arm = |silent: bool| json!({"state": "engaged", "standing": "engaged", "silent": silent, "limits": [LIMIT]});
        pretend(&browser, &arm(false), &json!(10_000));
        browser.until(&format!("{engaged} && {words}.startsWith('engaged')"));
        browser.until(&format!("document.body.innerText.includes({LIMIT:?})"));
        pretend(&browser, &arm(true), &json!(10_000));
        browser.until(&format!("!{engaged} && {words}.includes('nobody knows')"));
        assert!(!browser.text("body").contains(LIMIT), "{page}: what limits a silent arm is not known");
    }
    let told = browser.log();
    assert!(told.is_empty(), "{told:#?}");
}

const TICK: &str = "\u{2713}";
const CROSS: &str = "\u{2717}";

#[test]
fn nothing_that_is_old_has_a_tick() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::silent::nothing_that_is_old_has_a_tick") else { return };
    let program = Program::operator();
    // (page, the lines that are about what was heard)
    for (page, lines) in [("/setup", "#tracked li"), ("/", "#list li")] {
        browser.go(&program.url(page));
        let marks = |mark: &str, age_us: &Value| {
            pretend(&browser, &json!({"silent": mark != TICK}), age_us);
            browser.until(&format!(
                "((lines) => lines.length >= 2 && lines.every((line) => line.textContent.startsWith('{mark}')))(
                   [...document.querySelectorAll('{lines}')].filter((line) => /(left|right|hand|arm|[{TICK}{CROSS}] slave): /.test(line.textContent)))"
            ));
        };
        for age_us in [json!(600_000), Value::Null] {
            marks(TICK, &json!(10_000));
            marks(CROSS, &age_us);
        }
    }
}
