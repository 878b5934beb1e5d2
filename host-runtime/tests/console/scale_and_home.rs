//! The way home, and how far the hand leads: chosen by the operator, within what the slave's file allows.

use super::browser::{Browser, SPACE};
use super::driver::{A_WHILE, hold, press, reset, sees_stop, stays_stopped, take_control};
use super::program::Program;
use super::turn;
use super::witness::{Witness, is_moving};
use serde_json::Value;

/// Whoever is nearer than this is there, millimetres.
const THERE_MM: f64 = 1.0;

/// The tool, millimetres in the robot's base.
fn tool_mm(live: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| live["snapshot"]["arm"]["tool_mm"][axis].as_f64().unwrap_or(f64::NAN))
}

fn apart_mm(one: [f64; 3], other: [f64; 3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).powi(2)).sum::<f64>().sqrt()
}

fn goes_home(live: &Value) -> bool {
    live["snapshot"]["arm"]["goes_home"] == true
}

#[test]
fn the_arm_goes_home_while_it_is_held() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::scale_and_home::the_arm_goes_home_while_it_is_held") else {
        return;
    };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    take_control(&browser, &program.url("/drive"));
    reset(&browser, &witness);
    let home = tool_mm(&witness.until("the arm", |live| tool_mm(live)[0].is_finite()));
    let away = |live: &Value| apart_mm(tool_mm(live), home);

    for by in ["key", "mouse", "space bar on its button"] {
        hold(&browser, &witness);
        witness.until("the arm away from home", |live| away(live) > 30.0);
        browser.key_up(SPACE);
        sees_stop(&witness);
        let from = away(&witness.until("the arm", |_| true));
        let down = || match by {
            "key" => browser.key_down("h"),
            "mouse" => browser.mouse_down("#hold-home"),
            _ => {
                browser.script("document.getElementById('hold-home').focus()");
                browser.key_down(SPACE);
            }
        };
        let up = || match by {
            "key" => browser.key_up("h"),
            "mouse" => browser.mouse_up(),
            _ => browser.key_up(SPACE),
        };
        // let go on the way it stays where it is
        press(&browser, &witness, down, up, |limit| witness.within(limit, goes_home).is_ok());
        witness.until("the arm on its way", |live| away(live) < from - 5.0);
        up();
        sees_stop(&witness);
        let held = witness.within(A_WHILE, |live| is_moving(live) || away(live) < THERE_MM);
        assert!(held.is_err(), "by {by}: it goes on when it is let go");
        // a busy computer may end the press on the way
        let shown = "return document.getElementById('hold-home').getAttribute('aria-pressed')";
        press(&browser, &witness, down, up, |limit| {
            witness.within(limit, goes_home).is_ok()
                && witness.within(limit, |live| away(live) < THERE_MM).is_ok()
                && browser.script(shown) == "true"
        });
        up();
        sees_stop(&witness);
    }

    // a key that is called otherwise by now is up nevertheless
    hold(&browser, &witness);
    browser.key_up(SPACE);
    sees_stop(&witness);
    let (down, up) = (|| browser.key_down("h"), || browser.key_up("h"));
    press(&browser, &witness, down, up, |limit| witness.within(limit, goes_home).is_ok());
    browser.script(
        "document.body.dispatchEvent(new KeyboardEvent('keyup', {key: '\u{127}', code: 'KeyH', bubbles: true}))",
    );
    stays_stopped(&witness);
    up();

    // who holds both is not understood: neither moves the arm
    hold(&browser, &witness);
    browser.key_down("h");
    sees_stop(&witness);
    assert!(witness.within(A_WHILE, is_moving).is_err(), "two buttons are held");
    browser.key_up("h");
    assert!(witness.within(A_WHILE, is_moving).is_err(), "what has ended begins by itself");
    browser.key_up(SPACE);
    let told = browser.log();
    assert!(told.is_empty(), "{told:#?}");
}

#[test]
fn the_scale_is_chosen_while_nothing_is_held() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::scale_and_home::the_scale_is_chosen_while_nothing_is_held")
    else {
        return;
    };
    let program = Program::operator();
    let witness = Witness::of(program.address());
    browser.go(&program.url("/drive"));
    // nobody's to change who is not in control
    browser.until("document.getElementById('less').disabled && document.getElementById('more').disabled");
    browser.tap("-");
    take_control(&browser, &program.url("/drive"));
    let most =
        witness.until("the slave", |live| live["snapshot"]["slave"]["scale"].is_f64())["snapshot"]["slave"]["scale"]
            .as_f64()
            .expect("a scale");
    assert_eq!(browser.text("#scale"), "100 %");
    let chosen = |percent: u8| {
        witness.until("the scale", |live| live["control"]["scale_percent"] == percent);
        browser.until(&format!("document.getElementById('scale').textContent === '{percent} %'"));
    };
    browser.tap("-");
    chosen(50);
    browser.click("#less");
    chosen(25);
    browser.click("#more");
    chosen(50);
    browser.tap("-");
    chosen(25);

    // the press after that follows by it, and keeps it
    hold(&browser, &witness);
    let live = witness.until("a moving arm", is_moving);
    let scale = live["snapshot"]["arm"]["scale"].as_f64().expect("a scale");
    assert!((scale - 0.25 * most).abs() < 1e-6, "{scale} of {most}");
    browser.tap("+");
    browser.until("document.getElementById('control').textContent.includes('let go, then change the scale')");
    assert_eq!(witness.until("the scale", |_| true)["control"]["scale_percent"], 25);
    browser.key_up(SPACE);
    sees_stop(&witness);
    browser.tap("+");
    chosen(50);
    for _ in 0..3 {
        browser.tap("+");
    }
    chosen(100);
    assert_eq!(browser.script("return document.getElementById('more').disabled"), true);
    // in the picture of the arm the same keys go nearer and farther
    browser.script("document.getElementById('scene').focus()");
    browser.tap("-");
    assert!(
        witness.within(A_WHILE, |live| live["control"]["scale_percent"] != 100).is_err(),
        "a key of the picture changes the scale"
    );
}
