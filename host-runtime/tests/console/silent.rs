//! What is not heard any more is not shown as if it were so now.

use super::browser::Browser;
use super::program::Program;
use super::turn;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use tetrad::console::app::WEB_SOCKETS;

/// What keeps the arm from following, as nobody else says it.
const LIMIT: &str = "slowed for the test";

/// Has the page take what it is told for what these statements make of the `snapshot`.
fn alter(browser: &Browser, statements: &str) {
    browser.script(&format!(
        "window.parse ??= JSON.parse;
         JSON.parse = (text, ...more) => {{
           const told = window.parse(text, ...more);
           if (told?.type === 'live') {{
             const {{ snapshot }} = told;
             {statements}
           }}
           return told;
         }};"
    ));
}

/// Has the page take what it is told of the arm, the hand and the cameras for this.
fn pretend(browser: &Browser, arm: &Value, age_us: &Value) {
    alter(
        browser,
        &format!(
            "Object.assign(snapshot.arm ?? {{}}, {arm});
             for (const one of [snapshot.hand, ...snapshot.cameras, ...snapshot.links]) Object.assign(one ?? {{}}, {{age_us: {age_us}}});"
        ),
    );
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

/// One of the connections that pages have, taken up.
fn web_socket(program: &Program) -> TcpStream {
    let mut stream = TcpStream::connect(program.address()).expect("the console is there");
    let host = program.address();
    let request = format!(
        "GET /live HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).expect("it takes a request");
    let mut status = [0; 12];
    stream.read_exact(&mut status).expect("it answers");
    assert_eq!(status, *b"HTTP/1.1 101");
    stream
}

#[test]
fn a_page_without_a_place_says_why() {
    let _turn = turn();
    let Some(browser) = Browser::open("console::silent::a_page_without_a_place_says_why") else { return };
    let program = Program::operator();
    let link = "document.getElementById('link').textContent";
    let taken: Vec<TcpStream> = (0..WEB_SOCKETS).map(|_| web_socket(&program)).collect();
    browser.go(&program.url("/drive"));
    browser.until(&format!("{link} === 'NO CONNECTION: too many pages are open: close one'"));
    // and is heard once there is room
    drop(taken);
    browser.until(&format!("{link} === 'connected'"));
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

/// How many pixels of the scene have the colour of a property of the style: an expression of the page.
fn drawn_in(property: &str) -> String {
    format!(
        "((canvas) => {{
           const pen = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {{ willReadFrequently: true }});
           pen.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('{property}').trim();
           pen.fillRect(0, 0, 1, 1);
           const [r, g, b] = pen.getImageData(0, 0, 1, 1).data;
           pen.clearRect(0, 0, 1, 1);
           pen.drawImage(canvas, 0, 0);
           const {{ data }} = pen.getImageData(0, 0, canvas.width, canvas.height);
           let drawn = 0;
           for (let at = 0; at < data.length; at += 4) drawn += data[at] === r && data[at + 1] === g && data[at + 2] === b;
           return drawn;
         }})(document.getElementById('scene'))"
    )
}

#[test]
fn a_hand_and_cameras_that_are_silent_are_not_shown_as_known() {
    let _turn = turn();
    let test = "console::silent::a_hand_and_cameras_that_are_silent_are_not_shown_as_known";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    browser.go(&program.url("/drive"));
    let arm = json!({"silent": false});
    let gauges = "[...document.querySelectorAll('#gauges li')].map((bar) => bar.textContent)";
    // rate and balls of each camera
    let cells = "[...document.querySelectorAll('#cameras tr')].flatMap(
        ({ cells }) => [...cells].filter((cell, at) => at === 1 || at > 2).map((cell) => cell.textContent))";
    let words = "document.getElementById('scene-words').textContent";
    let hand = "document.getElementById('hand').textContent";
    let has_balls =
        ["--red", "--green", "--blue", "--yellow"].map(|colour| format!("{} > 0", drawn_in(colour)));
    let none = has_balls.clone().map(|has| format!("!({has})")).join(" && ");
    for _ in 0..2 {
        pretend(&browser, &arm, &json!(10_000));
        browser.until(&format!("/known by(all|two|one)/.test({hand}) && {hand}.includes('hand at')"));
        browser
            .until(&format!("{gauges}.length === 6 && {gauges}.every((text) => /\\d (mm|deg)$/.test(text))"));
        browser.until(&format!("{words}.includes('rings') && !{words}.includes('hollow')"));
        browser.until(&format!(
            "{cells}.length === 10 && {cells}.filter((text) => /^\\d+\\/s$/.test(text)).length === 2"
        ));
        browser.until(&format!("!{cells}.includes('not known') && {}", has_balls.join(" && ")));

        pretend(&browser, &arm, &json!(10_400_000));
        browser.until(&format!("{hand}.includes('known bynothing: not heard for 10.4 s')"));
        browser.until(&format!("{hand}.includes('hand was at') && !{hand}.includes('hand at')"));
        browser.until(&format!("{gauges}.every((text) => text.endsWith('not known'))"));
        browser.until(&format!("{words}.includes('hollow hand') && !{words}.includes('rings')"));
        browser.until(&format!("{cells}.every((text) => text === '' || text === 'not known')"));
        browser.until(&none);
    }
    let told = browser.log();
    assert!(told.is_empty(), "{told:#?}");
}

#[test]
fn a_station_that_is_away_is_not_in_the_same_program() {
    let _turn = turn();
    let test = "console::silent::a_station_that_is_away_is_not_in_the_same_program";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator();
    browser.go(&program.url("/drive"));
    let says = |heard: &str, lost: &str| {
        browser.until(&format!(
            "((cells) => cells.length === 4 && /{heard}/.test(cells[1]) && cells[2] === '{lost}')(
               [...document.querySelectorAll('#links td')].map((cell) => cell.textContent))"
        ));
    };
    // its slave is there
    says("\\d ms$", "same program");
    // as another computer's is that nobody has reached yet, that was reached, and that has got nothing lately
    for (link, heard, lost) in [
        (
            json!({"connected": false, "sent_packets": 0, "lost_packets": 0, "loss": null}),
            "^AWAY$",
            "none sent",
        ),
        (
            json!({"connected": true, "sent_packets": 40, "lost_packets": 1, "loss": 0.025, "loss_lately": 0.5}),
            "ms$",
            "50.0 % (2.5 % in all)",
        ),
        (
            json!({"connected": false, "sent_packets": 40, "lost_packets": 1, "loss": 0.025, "loss_lately": null}),
            "^AWAY$",
            "none sent (2.5 % in all)",
        ),
    ] {
        alter(&browser, &format!("Object.assign(snapshot.links[0], {link});"));
        says(heard, lost);
    }
}
