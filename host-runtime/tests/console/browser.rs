//! Chromium, driven over WebDriver: chromedriver as a process, one session, and what a hand does with it.
//!
//! Calls wait for their answer; what fails is a panic, for only tests are here. What was started ends with
//! the value that started it, also where a test has failed.

use super::webdriver::Session;
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// What the tests need beyond Rust.
const MISSING: &str = "missing: apt-get install --no-install-recommends chromium chromium-driver";

/// Longer than anything takes on a computer that is busy.
pub(crate) const LONG: Duration = Duration::from_secs(60);

/// How often something is looked at that is waited for.
const POLL: Duration = Duration::from_millis(20);

/// A window of its size in CSS pixels.
pub(crate) const DESK: (u32, u32) = (1280, 720);

/// Buttons of the mouse, as WebDriver counts them.
pub(crate) const LEFT: u8 = 0;
pub(crate) const MIDDLE: u8 = 1;
pub(crate) const RIGHT: u8 = 2;

/// The space bar.
pub(crate) const SPACE: &str = " ";

/// Keys without a character, as WebDriver writes them (section 17.4.2).
pub(crate) const TAB: &str = "\u{e004}";
pub(crate) const ENTER: &str = "\u{e007}";
pub(crate) const ALT: &str = "\u{e00a}";
pub(crate) const ESCAPE: &str = "\u{e00c}";

/// How much of a canvas is not black, 0 to 1: an expression of the page.
pub(crate) fn lit(css: &str) -> String {
    format!(
        "((canvas) => {{
           const pen = new OffscreenCanvas(canvas.width, canvas.height).getContext('2d', {{ willReadFrequently: true }});
           pen.drawImage(canvas, 0, 0);
           const {{ data }} = pen.getImageData(0, 0, canvas.width, canvas.height);
           let lit = 0;
           for (let at = 0; at < data.length; at += 4) lit += data[at] + data[at + 1] + data[at + 2] > 60;
           return lit / (data.length / 4);
         }})(document.querySelector({css:?}))"
    )
}

/// A browser with one window, in a profile of its own.
pub(crate) struct Browser {
    session: Session,
    _driver: Driver,
    _profile: tempfile::TempDir,
}

/// chromedriver, in a group of processes to which its browser's belong too.
struct Driver(Child);

impl Browser {
    /// Opens one, or reports the test as skipped where this computer has none.
    pub(crate) fn open(test: &str) -> Option<Self> {
        let has = |program: &str| {
            let mut asked = Command::new(program);
            asked.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
            asked.status().is_ok_and(|status| status.success())
        };
        if has("chromedriver") && has("chromium") {
            return Some(Self::start());
        }
        tetrad_tests::skip(test, MISSING);
        None
    }

    fn start() -> Self {
        let profile = tempfile::tempdir().expect("a directory");
        let (driver, port) = Driver::start(profile.path());
        let (width, height) = DESK;
        let capabilities = json!({
            "goog:chromeOptions": {
                "binary": "/usr/bin/chromium",
                "args": [
                    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                    format!("--window-size={width},{height}"),
                ],
            },
            "goog:loggingPrefs": {"browser": "ALL"},
            // an authority that somebody has made is not known to it
            "acceptInsecureCerts": true,
        });
        let session = Session::new(port, capabilities).expect("chromedriver opens chromium");
        let browser = Self { session, _driver: driver, _profile: profile };
        browser.look(DESK, "light");
        browser
    }

    /// Loads a page, to its end, until it is seen.
    pub(crate) fn go(&self, url: &str) {
        self.session.post("/url", json!({"url": url}));
        self.until_painted();
    }

    /// Loads the page again.
    pub(crate) fn reload(&self) {
        self.session.post("/refresh", json!({}));
        self.until_painted();
    }

    /// Before it has painted a page for the first time, Chromium drops the keys that are meant for it.
    fn until_painted(&self) {
        self.until("document.hidden || performance.getEntriesByType('paint').length > 0");
    }

    /// The cookies of the page's place, as WebDriver tells them (section 14).
    pub(crate) fn cookies(&self) -> Value {
        self.session.get("/cookie")
    }

    /// What the body of a function returns, in the page.
    #[track_caller]
    pub(crate) fn script(&self, body: &str) -> Value {
        self.session.post("/execute/sync", json!({"script": body, "args": []}))
    }

    /// An element's text, as it is shown.
    #[track_caller]
    pub(crate) fn text(&self, css: &str) -> String {
        let element = self.session.element(css);
        let told = json!({"script": "return arguments[0].innerText", "args": [element]});
        self.session.post("/execute/sync", told).as_str().unwrap_or_default().to_owned()
    }

    /// Waits until an expression is true in the page.
    #[track_caller]
    pub(crate) fn until(&self, expression: &str) {
        assert!(self.within(LONG, expression), "{expression} does not come true:\n{}", self.text("body"));
    }

    /// The same, and whether it did so in time.
    #[track_caller]
    pub(crate) fn within(&self, limit: Duration, expression: &str) -> bool {
        let began = Instant::now();
        while self.script(&format!("return Boolean({expression})")) != true {
            if began.elapsed() > limit {
                return false;
            }
            std::thread::sleep(POLL);
        }
        true
    }

    /// Presses a key and keeps it down.
    pub(crate) fn key_down(&self, key: &str) {
        self.keys(&json!([{"type": "keyDown", "value": key}]));
    }

    /// Lets go of a key.
    pub(crate) fn key_up(&self, key: &str) {
        self.keys(&json!([{"type": "keyUp", "value": key}]));
    }

    /// Types a key.
    pub(crate) fn tap(&self, key: &str) {
        self.keys(&json!([{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]));
    }

    fn keys(&self, actions: &Value) {
        self.session
            .post("/actions", json!({"actions": [{"type": "key", "id": "keyboard", "actions": actions}]}));
    }

    /// Moves the mouse onto the middle of an element and presses its button there, without letting go.
    pub(crate) fn mouse_down(&self, css: &str) {
        let origin = self.session.element(css);
        self.mouse(&json!([
            {"type": "pointerMove", "origin": origin, "x": 0, "y": 0, "duration": 0},
            {"type": "pointerDown", "button": LEFT},
        ]));
    }

    /// Lets go of the mouse's button.
    pub(crate) fn mouse_up(&self) {
        self.button_up(LEFT);
    }

    /// Presses a button of the mouse where it is, and keeps it down.
    pub(crate) fn button_down(&self, button: u8) {
        self.mouse(&json!([{"type": "pointerDown", "button": button}]));
    }

    /// Lets go of one.
    pub(crate) fn button_up(&self, button: u8) {
        self.mouse(&json!([{"type": "pointerUp", "button": button}]));
    }

    /// Moves the mouse so many CSS pixels right of an element's middle and below it.
    pub(crate) fn point_at(&self, css: &str, (right, down): (i64, i64)) {
        let origin = self.session.element(css);
        self.mouse(&json!([{"type": "pointerMove", "origin": origin, "x": right, "y": down, "duration": 0}]));
    }

    /// Scrolls an element into sight, where the mouse reaches it.
    pub(crate) fn scroll_to(&self, css: &str) {
        self.script(&format!("document.querySelector({css:?}).scrollIntoView({{block: 'center'}})"));
    }

    /// A click so many CSS pixels right of an element's middle and below it.
    pub(crate) fn click_at(&self, css: &str, (right, down): (i64, i64)) {
        let origin = self.session.element(css);
        self.mouse(&json!([
            {"type": "pointerMove", "origin": origin, "x": right, "y": down, "duration": 0},
            {"type": "pointerDown", "button": LEFT},
            {"type": "pointerUp", "button": LEFT},
        ]));
    }

    /// A click with the mouse.
    pub(crate) fn click(&self, css: &str) {
        self.mouse_down(css);
        self.mouse_up();
    }

    fn mouse(&self, actions: &Value) {
        self.session
            .post("/actions", json!({"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]}));
    }

    /// Types into an element.
    pub(crate) fn write(&self, css: &str, text: &str) {
        self.session.post_to(css, "/value", json!({"text": text}));
    }

    /// The tab that is driven.
    pub(crate) fn tab(&self) -> Value {
        self.session.get("/window")
    }

    /// Opens another tab and goes to it.
    pub(crate) fn open_another_tab(&self) {
        let opened = self.session.post("/window/new", json!({"type": "tab"}));
        self.session.post("/window", json!({"handle": opened["handle"]}));
        // a new tab is not always the one that has the focus
        self.devtools("Page.bringToFront", &json!({}));
    }

    /// Closes the tab that is driven and goes to another.
    pub(crate) fn close_for(&self, tab: &Value) {
        self.session.delete("/window").expect("a tab that can be closed");
        self.session.post("/window", json!({"handle": tab}));
        self.devtools("Page.bringToFront", &json!({}));
    }

    /// The size of the page, and whether the operator likes it `light` or `dark`.
    pub(crate) fn look(&self, (width, height): (u32, u32), scheme: &str) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.devtools("Emulation.setDeviceMetricsOverride", &size);
        let liked = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.devtools("Emulation.setEmulatedMedia", &liked);
    }

    /// A picture of what is shown, PNG.
    pub(crate) fn picture(&self) -> Vec<u8> {
        let told = self.session.get("/screenshot");
        let text = told.as_str().unwrap_or_default();
        data_encoding::BASE64.decode(text.as_bytes()).expect("base64")
    }

    /// What the pages wrote to their console since the last question: errors of scripts, of the network, and
    /// what the content security policy refused.
    pub(crate) fn log(&self) -> Vec<Value> {
        let told = self.session.post("/se/log", json!({"type": "browser"}));
        told.as_array().cloned().expect("a list")
    }

    /// A command of the Chrome DevTools protocol.
    pub(crate) fn devtools(&self, command: &str, parameters: &Value) -> Value {
        self.session.post("/goog/cdp/execute", json!({"cmd": command, "params": parameters}))
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // a session that is gone already cannot be ended; what is left of it is killed with its driver
        let _ = self.session.delete("");
    }
}

impl Driver {
    /// At a port of its own, which it tells. Its browser's profile is of its own making, in a folder for such
    /// things: a page in one that it is given is not told in every case that it has lost the focus.
    fn start(temporary: &Path) -> (Self, u16) {
        // it takes a port that is free in IPv6, and ends where another has that one in IPv4
        let tries = (0..5).find_map(|_| Self::begin(temporary));
        tries.expect("chromedriver starts and tells its port: see what `chromedriver --port=0` says")
    }

    fn begin(temporary: &Path) -> Option<(Self, u16)> {
        let mut command = Command::new("chromedriver");
        command.env("TMPDIR", temporary);
        command.arg("--port=0").stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        // a signal for the tests is not one for the browser: it is closed
        let mut process = command.process_group(0).spawn().expect("chromedriver starts");
        let out = process.stdout.take().expect("a pipe");
        let driver = Self(process);
        let mut lines = BufReader::new(out).lines().map_while(Result::ok);
        let told = |line: String| {
            line.split_once("started successfully on port ")?.1.trim_end_matches('.').parse().ok()
        };
        let port = lines.find_map(told)?;
        // what it says afterwards is of no interest, but has to go somewhere
        std::thread::spawn(move || lines.for_each(drop));
        Some((driver, port))
    }
}

impl Drop for Driver {
    fn drop(&mut self) {
        // a group that has ended is no longer there to be killed
        let group = format!("-{}", self.0.id());
        let _ = Command::new("kill").args(["-KILL", "--", &group]).stderr(Stdio::null()).status();
        let _ = self.0.wait();
    }
}
