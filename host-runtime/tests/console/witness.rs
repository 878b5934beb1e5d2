//! Somebody who looks on over a socket of their own: what the arm does, and the operator's clock.

use super::browser::LONG;
use futures_util::StreamExt as _;
use serde_json::Value;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;

/// The tool is seen to move by so much, millimetres.
const MOVED_MM: f64 = 5.0;

#[derive(Default)]
struct Seen {
    live: Value,
    /// The operator's clock less the computer's, microseconds: the most that any message showed is the one
    /// that was held up least.
    ahead_us: Option<i64>,
}

/// A viewer that is no browser.
pub(crate) struct Witness {
    seen: Arc<(Mutex<Seen>, Condvar)>,
    end: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Witness {
    /// Looks on.
    pub(crate) fn of(console: SocketAddr) -> Self {
        Self::with_token(console, None)
    }

    pub(crate) fn with_token(console: SocketAddr, token: Option<&str>) -> Self {
        let mut request = format!("ws://{console}/live").into_client_request().expect("a request");
        if let Some(token) = token {
            let bearer = format!("Bearer {token}").parse().expect("a header");
            request.headers_mut().insert("authorization", bearer);
        }
        let seen = Arc::new((Mutex::new(Seen::default()), Condvar::new()));
        let end = Arc::new(AtomicBool::new(false));
        let (sees, ends) = (Arc::clone(&seen), Arc::clone(&end));
        let thread = std::thread::spawn(move || {
            let runtime =
                tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
            runtime.block_on(async {
                let (mut socket, _) = tokio_tungstenite::connect_async(request).await.expect("a socket");
                while !ends.load(Ordering::Relaxed) {
                    // thirty come each second; none come where the program has ended
                    let next = timeout(Duration::from_millis(100), socket.next()).await;
                    match next {
                        Ok(Some(Ok(Message::Text(text)))) => see(&sees, &text),
                        Ok(None | Some(Err(_))) => break,
                        Ok(Some(Ok(_))) | Err(_) => {}
                    }
                }
            });
        });
        Self { seen, end, thread: Some(thread) }
    }

    /// Waits until something is so, and gives what was known then.
    #[track_caller]
    pub(crate) fn until(&self, what: &str, so: impl Fn(&Value) -> bool) -> Value {
        self.within(LONG, so).unwrap_or_else(|last| {
            let (control, arm) = (&last["control"], &last["snapshot"]["arm"]["standing"]);
            panic!("{what} does not come: {control}, arm {arm}")
        })
    }

    /// The same, giving what was known last where it does not come in time.
    pub(crate) fn within(&self, limit: Duration, so: impl Fn(&Value) -> bool) -> Result<Value, Value> {
        let began = Instant::now();
        let mut seen = self.seen.0.lock().expect("no panic");
        while seen.live.is_null() || !so(&seen.live) {
            let Some(left) = limit.checked_sub(began.elapsed()) else { return Err(seen.live.clone()) };
            seen = self.seen.1.wait_timeout(seen, left).expect("no panic").0;
        }
        Ok(seen.live.clone())
    }

    /// Waits until the arm follows the hand and its tool has gone some way; `false` where it does not in time.
    pub(crate) fn sees_motion(&self, limit: Duration) -> bool {
        let from = Mutex::new(None::<Vec<f64>>);
        let moved = |live: &Value| {
            let mut from = from.lock().expect("no panic");
            if !is_moving(live) {
                *from = None;
                return false;
            }
            let told = live["snapshot"]["arm"]["tool_mm"].as_array().into_iter().flatten();
            let tool: Vec<f64> = told.filter_map(Value::as_f64).collect();
            let start = from.get_or_insert_with(|| tool.clone());
            tool.iter().zip(start.iter()).map(|(to, from)| (to - from).powi(2)).sum::<f64>().sqrt() > MOVED_MM
        };
        self.within(limit, moved).is_ok()
    }

    /// What the operator's clock says.
    pub(crate) fn now_us(&self) -> u64 {
        self.at_us(unix_us())
    }

    /// What it said at a time of the computer's clock, microseconds since 1970.
    pub(crate) fn at_us(&self, unix_us: i64) -> u64 {
        self.until("the clock", |_| true);
        let ahead_us = self.seen.0.lock().expect("no panic").ahead_us.expect("a message came");
        u64::try_from(unix_us + ahead_us).expect("a time after the start")
    }
}

impl Drop for Witness {
    fn drop(&mut self) {
        self.end.store(true, Ordering::Relaxed);
        // a witness that never got in is a test that has failed already
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Whether the arm follows the hand.
pub(crate) fn is_moving(live: &Value) -> bool {
    live["snapshot"]["arm"]["state"] == "engaged"
}

fn see(sees: &(Mutex<Seen>, Condvar), text: &str) {
    let came_us = unix_us();
    let told: Value = serde_json::from_str(text).expect("JSON");
    if told["type"] != "live" {
        return;
    }
    let now_us = told["now_us"].as_i64().expect("a time");
    let mut seen = sees.0.lock().expect("no panic");
    seen.ahead_us = Some(seen.ahead_us.map_or(now_us - came_us, |ahead_us| ahead_us.max(now_us - came_us)));
    seen.live = told;
    sees.1.notify_all();
}

fn unix_us() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).expect("after 1970");
    i64::try_from(since.as_micros()).expect("before the year 294,000")
}
