//! From a page's button to the arm, through everything but a browser.

use super::*;
use crate::console::testing::{Tab, post};
use crate::settings::{FilterArgs, Mode, PredictionFlag, SmoothingFlag};
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::path::Path;
use std::sync::mpsc;
use std::time::{Duration, Instant};

mod session;

/// The arm begins its stop so long after the button is not told of any more, microseconds.
const STOP_US: u64 = 100_000;

/// So often it is tried: what is measured is by whose clock the arm stops, not how long a busy computer holds
/// up a thread.
const TRIES: usize = 3;

/// A reset that comes to nothing is asked for again.
const RESET: Duration = Duration::from_secs(3);

/// The tool is seen to move by so much, millimetres.
const MOVED_MM: f64 = 5.0;

fn args(out: &Path) -> DemoArgs {
    let filter =
        FilterArgs { smoothing: SmoothingFlag::OneEuro, lead_ms: 0, prediction: PredictionFlag::Velocity };
    let (scene, mode) = ("demo".to_owned(), Mode::Refined);
    DemoArgs { seconds: None, headless: false, out: out.to_owned(), scene, mode, filter, record: None }
}

/// A page whose button is held.
struct Driver {
    tab: Tab,
    heard: Instant,
}

impl Driver {
    async fn open(console: SocketAddr) -> Self {
        let mut tab = Tab::open(console).await;
        tab.hear().await;
        tab.take().await;
        Self { tab, heard: Instant::now() }
    }

    /// What the loop knows next, the button being held.
    async fn hold(&mut self) -> &Value {
        self.tab.hear().await;
        self.heard = Instant::now();
        self.tab.hold().await;
        &self.tab.live["snapshot"]["arm"]
    }

    /// The operator's clock.
    fn now_us(&self) -> u64 {
        self.tab.live["now_us"].as_u64().unwrap() + self.heard.elapsed().as_micros() as u64
    }

    /// Resets, presses, and holds until the arm moves.
    async fn drive(&mut self) {
        self.tab.say(json!({"type": "reset"})).await;
        let began = Instant::now();
        let mut reset = began;
        let mut from: Option<Vec<f64>> = None;
        loop {
            assert!(began.elapsed().as_secs() < 60, "the arm did not move: {}", self.tab.live);
            let arm = self.hold().await;
            let state = arm["state"].as_str().unwrap_or_default().to_owned();
            if state != "engaged" {
                from = None;
                if matches!(state.as_str(), "stopped" | "fault") && reset.elapsed() > RESET {
                    self.tab.say(json!({"type": "reset"})).await;
                    reset = Instant::now();
                }
                continue;
            }
            let arm = &self.tab.live["snapshot"]["arm"];
            let tool: Vec<f64> =
                arm["tool_mm"].as_array().unwrap().iter().map(|mm| mm.as_f64().unwrap()).collect();
            let from = from.get_or_insert_with(|| tool.clone());
            let way: f64 = tool.iter().zip(from.iter()).map(|(to, from)| (to - from).powi(2)).sum();
            if way.sqrt() > MOVED_MM {
                return;
            }
        }
    }
}

/// How long after a time the arm began to stop, by the slave's own clock, which is the operator's here;
/// `None` where it was not moving at that time: the computer had been too busy to tell of the button.
fn stop_after(out: &Path, at_us: u64) -> Option<u64> {
    let text = std::fs::read_to_string(out.join("arm_state.csv")).unwrap();
    let rows: Vec<(u64, bool)> = text
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            ((fields[1].parse::<f64>().unwrap() * 1e6).round() as u64, fields[3] == "engaged")
        })
        .collect();
    let (before, after) = rows.split_at(rows.partition_point(|(slave_us, _)| *slave_us < at_us));
    // the state just before counts: a stop may well be in force by the very next row
    before.last().filter(|(_, engaged)| *engaged)?;
    let (stopped_us, _) = after.iter().find(|(_, engaged)| !engaged).expect("it stopped");
    Some(stopped_us - at_us)
}

/// A demo in a thread of its own, its results in `out`.
struct Demo {
    console: SocketAddr,
    interrupt: Interrupt,
    thread: std::thread::JoinHandle<Result<(), Failure>>,
}

impl Demo {
    fn start(out: &Path) -> Self {
        Self::start_as(out, None, |_, _| ())
    }

    /// With a recording, or other settings than a demo's own.
    fn start_as(
        out: &Path,
        record: Option<&Path>,
        change: impl FnOnce(&mut OperatorSettings, &mut SlaveSettings) + Send + 'static,
    ) -> Self {
        let record = record.map(Path::to_owned);
        let (told, hears) = mpsc::channel();
        let interrupt = Interrupt::by_hand();
        let asked = interrupt.clone();
        let out = out.to_owned();
        let thread = std::thread::spawn(move || {
            let args = args(&out);
            let (mut operator, mut slave) = stations(&args, &super::super::scene(&args.scene)?);
            // the arm's own watch over its set-points is not what is tried here
            slave.arm.port = Some("sim:?watchdog_ms=5000".parse().unwrap());
            change(&mut operator, &mut slave);
            let listen = "127.0.0.1:0".parse().unwrap();
            let console = ConsoleSettings { listen, ..ConsoleSettings::demo() };
            let order = Order {
                station: None,
                operator: &operator,
                slave: &slave,
                network: None,
                console: Some(&console),
                hold: HoldToRun::Console,
                longest: None,
                out: Some(&out),
                record: record.as_deref(),
            };
            order.carry_out(&interrupt, |console| told.send(console.address()).unwrap())
        });
        let console = hears.recv_timeout(Duration::from_secs(120)).expect("a console");
        Self { console, interrupt: asked, thread }
    }

    fn end(self) {
        self.interrupt.flag().store(true, std::sync::atomic::Ordering::Relaxed);
        self.thread.join().expect("no panic").expect("the arm was stopped by a button");
    }
}

#[test]
fn a_page_moves_the_arm_and_its_silence_or_its_end_stops_it() {
    let dir = tempfile::tempdir().unwrap();
    let demo = Demo::start(dir.path());
    let console = demo.console;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let (mut silent, mut cut) = (Vec::new(), Vec::new());
    runtime.block_on(async {
        for _ in 0..TRIES {
            let mut driver = Driver::open(console).await;
            driver.drive().await;
            // the page hangs: its socket stays open
            silent.push(driver.now_us());
            driver.tab.until("the stop", |live| live["snapshot"]["arm"]["state"] != "engaged").await;
            driver.tab.release().await;
            driver.drive().await;
            cut.push(driver.now_us());
            drop(driver);
            let mut witness = Tab::open(console).await;
            witness.until("the stop", |live| live["snapshot"]["arm"]["state"] != "engaged").await;
            witness.until("control is free", |live| live["control"]["holder"].is_null()).await;
        }
    });
    demo.end();
    for (what, times_us) in [("silent", silent), ("cut", cut)] {
        let stops_us: Vec<u64> = times_us.iter().filter_map(|at_us| stop_after(dir.path(), *at_us)).collect();
        println!("{what}: the arm began its stop {stops_us:?} us later");
        let soonest_us = stops_us.iter().min().expect("the computer was not too busy every time");
        assert!(*soonest_us <= STOP_US, "{what}: {stops_us:?} us");
    }
}

/// Whether every camera sees all four balls.
fn all_seen(live: &Value) -> bool {
    let cameras = live["snapshot"]["cameras"].as_array().unwrap();
    let seen = |ball: &Value| matches!(ball["state"].as_str(), Some("visible" | "occluded"));
    let whole = |camera: &Value| {
        let balls = camera["balls"].as_array().unwrap();
        balls.len() == 4 && balls.iter().all(seen)
    };
    cameras.len() == 2 && cameras.iter().all(whole)
}

/// Finds all four balls by both cameras.
async fn find(console: SocketAddr) -> Value {
    let mut found = Value::Null;
    // a ball may stand before another just then
    for _ in 0..20 {
        let (status, told) = post(console, "/api/setup/find", &json!({})).await;
        assert_eq!(status, 200, "{told}");
        found = told;
        if found["said"] == "the four balls were found by 2 of 2 cameras" {
            break;
        }
    }
    found
}

#[test]
fn a_page_finds_the_balls_anew_and_the_arm_follows_them() {
    let dir = tempfile::tempdir().unwrap();
    let demo = Demo::start(dir.path());
    let console = demo.console;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let mut page = Tab::open(console).await;
        page.until("both cameras", all_seen).await;
        let found = find(console).await;
        assert_eq!(found["cameras"][0]["in_use"], false, "{found}");
        let (status, saved) = post(console, "/api/setup/save", &json!({})).await;
        assert_eq!(status, 200, "{saved}");
        let (status, used) = post(console, "/api/setup/use", &json!({})).await;
        assert_eq!((status, &used["cameras"][1]["in_use"]), (200, &json!(true)), "{used}");
        page.until("the stop", |live| live["control"]["stopped"] == true).await;
        page.until("both cameras say that they were taught", |live| {
            let lines = live["snapshot"]["lines"].to_string();
            lines.matches("taught anew").count() == 2 && lines.contains("set up anew: a frame with arms of")
        })
        .await;
        let taught_us = page.live["now_us"].as_u64().unwrap();
        page.until("the hand, of what was seen after that", |live| {
            let snapshot = &live["snapshot"];
            let [time_us, age_us] =
                [&snapshot["time_us"], &snapshot["hand"]["age_us"]].map(|us| us.as_u64().unwrap_or_default());
            let later = time_us.saturating_sub(age_us) > taught_us;
            later && all_seen(live) && snapshot["hand"]["state"] == "both"
        })
        .await;
        drop(page);
        let mut driver = Driver::open(console).await;
        driver.drive().await;
        // who drives is not taught under his hand
        let (status, told) = post(console, "/api/setup/use", &json!({})).await;
        assert_eq!(status, 409, "{told}");
        driver.tab.release().await;
        driver.tab.until("rest", |live| live["snapshot"]["arm"]["state"] != "engaged").await;
    });
    demo.end();
    for view in ["left", "right"] {
        let file = dir.path().join(format!("colours-{view}.toml"));
        let text = std::fs::read_to_string(&file).unwrap();
        let colours = crate::colours::Colours::parse(&text, view).unwrap();
        assert!(colours.learnt_balls().iter().all(Option::is_some), "{text}");
    }
}
