//! `/live`: what the loop knows to the page, thirty times a second, and the page's buttons back.
//!
//! Reading does not wait for writing: a page that takes nothing any more can still stop the arm, and its
//! socket is closed after [`STALLED`].

use super::app::State;
use super::control::{Control, ControlView};
use super::desk::{Desk, Seat};
use super::snapshot::Snapshot;
use crate::station::operator::SCALES;
use axum::extract::State as Of;
use axum::extract::ws::{Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use futures_util::stream::SplitSink;
use futures_util::{SinkExt as _, StreamExt as _};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tetrad_core::wire::PressFor;
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio::time::{MissedTickBehavior, interval, timeout};

/// The longest message of a page, bytes.
pub(super) const MAX_MESSAGE: usize = 4096;

/// A page that takes nothing for so long is closed.
pub(super) const STALLED: Duration = Duration::from_secs(2);

/// So often pages are told, even where the loop has nothing new.
const TELL: Duration = Duration::from_millis(33);

/// Answers that wait to be sent; what is more is left out.
const ANSWERS: usize = 16;

/// The longest name of a tab, characters.
const MAX_NAME: usize = 40;

/// What a page says.
#[derive(Debug, Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
enum Said {
    /// It wants to drive; the others are told that name.
    Take {
        #[serde(default)]
        name: String,
    },
    /// It does not want to drive any more.
    Give,
    /// The button is held since the press of that number, for the way home where it says so; the newest
    /// snapshot it had was of `shown_us`.
    Hold {
        press: u64,
        #[serde(default)]
        home: bool,
        shown_us: u64,
    },
    /// The share of the slave's scale that the next press shall follow by.
    Scale {
        percent: u8,
    },
    /// The button is let go.
    Release,
    /// It is there.
    Here,
    /// It measures the line: its own clock, to be sent back with ours.
    Echo {
        sent_us: u64,
    },
    Stop,
    Reset,
    /// The joints are homed.
    Homed,
}

/// What a page is told.
#[derive(Serialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
enum Told<'a> {
    Hello {
        version: &'static str,
        page: u64,
        views: Vec<ViewTold<'a>>,
        /// The shares of the slave's scale to choose from, percent.
        scales: [u8; SCALES.len()],
    },
    Live {
        now_us: u64,
        control: ControlView,
        snapshot: &'a Snapshot,
    },
    Refused {
        what: &'static str,
        why: String,
    },
    Echo {
        sent_us: u64,
        now_us: u64,
    },
}

#[derive(Serialize)]
struct ViewTold<'a> {
    name: &'a str,
    kind: super::ViewKind,
}

pub(super) async fn upgrade(Of(state): Of<State>, socket: WebSocketUpgrade) -> Response {
    let Ok(permit) = Arc::clone(&state.web_sockets).try_acquire_owned() else {
        return super::app::full();
    };
    let socket = socket.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    socket.on_upgrade(move |socket| serve(socket, state.desk, permit))
}

async fn serve(socket: WebSocket, desk: Desk, _permit: OwnedSemaphorePermit) {
    let _counted = Counted::new(&desk);
    let seat = desk.seat();
    let (out, mut from) = socket.split();
    let (answer, answers) = mpsc::channel(ANSWERS);
    let read = async {
        while let Some(Ok(message)) = from.next().await {
            let told = match message {
                Message::Text(text) => hear(&desk, &seat, &text),
                Message::Close(_) => break,
                Message::Binary(_) => Some(unreadable(&desk, &seat)),
                Message::Ping(_) | Message::Pong(_) => None,
            };
            if let Some(told) = told {
                let _ = answer.try_send(told);
            }
        }
    };
    // whichever ends first ends the other, and the seat with it
    tokio::select! {
        () = read => {}
        () = write(out, answers, &desk, &seat) => {}
    }
}

/// Tells the page until it takes nothing any more.
async fn write(
    mut out: SplitSink<WebSocket, Message>,
    mut answers: mpsc::Receiver<Utf8Bytes>,
    desk: &Desk,
    seat: &Seat,
) {
    let views = desk.views().iter().map(|view| ViewTold { name: &view.name, kind: view.kind }).collect();
    let version = env!("CARGO_PKG_VERSION");
    let mut next = text(&Told::Hello { version, page: seat.tab.0, views, scales: SCALES });
    let mut tick = interval(TELL);
    tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        if !matches!(timeout(STALLED, out.send(Message::Text(next))).await, Ok(Ok(()))) {
            return;
        }
        // a refusal is told before what comes after it
        next = tokio::select! {
            biased;
            Some(answer) = answers.recv() => answer,
            _ = tick.tick() => live(desk, seat),
        };
    }
}

fn live(desk: &Desk, seat: &Seat) -> Utf8Bytes {
    let now_us = desk.now_us();
    let control = desk.control().view(Some(seat.tab), now_us);
    text(&Told::Live { now_us, control, snapshot: &desk.snapshot() })
}

fn hear(desk: &Desk, seat: &Seat, message: &str) -> Option<Utf8Bytes> {
    let tab = seat.tab;
    let Ok(said) = serde_json::from_str(message) else { return Some(unreadable(desk, seat)) };
    let (what, done) = match said {
        Said::Take { name } => {
            let name = name_of(tab.0, &name);
            ("take", desk.with_control(|control, now_us| control.take(tab, &name, now_us)))
        }
        Said::Give => {
            tracing::info!(page = tab.0, "control is given up");
            desk.with_control(|control, _| control.leave(tab));
            return None;
        }
        Said::Hold { press, home, shown_us } => {
            let press_for = if home { PressFor::Home } else { PressFor::Follow };
            let hold = |control: &mut Control, now_us| control.hold(tab, press, press_for, shown_us, now_us);
            ("hold", desk.with_control(hold))
        }
        Said::Scale { percent } => {
            ("scale", desk.with_control(|control, now_us| control.set_scale(tab, percent, now_us)))
        }
        Said::Release => {
            desk.with_control(|control, now_us| control.release(tab, now_us));
            return None;
        }
        Said::Here => {
            desk.with_control(|control, now_us| control.here(tab, now_us));
            return None;
        }
        // it says nothing of the operator, and is no sign of somebody being there
        Said::Echo { sent_us } => return Some(text(&Told::Echo { sent_us, now_us: desk.now_us() })),
        Said::Stop => {
            tracing::warn!(page = tab.0, "stop is pressed");
            desk.stop();
            return None;
        }
        Said::Reset => ("reset", desk.with_control(|control, now_us| control.reset(tab, now_us))),
        Said::Homed => ("homed", desk.homed(tab)),
    };
    match done {
        Ok(()) => {
            // the button is told thirty times a second
            if what != "hold" {
                tracing::info!(page = tab.0, what, "the operator's page asks");
            }
            None
        }
        Err(why) => {
            tracing::debug!(page = tab.0, what, %why, "the operator's page is refused");
            Some(text(&Told::Refused { what, why: why.to_string() }))
        }
    }
}

/// Whoever cannot be understood is not believed to hold the button.
fn unreadable(desk: &Desk, seat: &Seat) -> Utf8Bytes {
    desk.with_control(|control, now_us| control.release(seat.tab, now_us));
    let why = "this message is not understood; the button counts as let go".to_owned();
    text(&Told::Refused { what: "message", why })
}

/// What the others are told: words of the page, and which tab it is.
fn name_of(tab: u64, given: &str) -> String {
    let given: String = given.chars().filter(|c| !c.is_control()).take(MAX_NAME).collect();
    match given.trim() {
        "" => format!("page {tab}"),
        name => format!("{name} (page {tab})"),
    }
}

fn text(told: &Told<'_>) -> Utf8Bytes {
    // plain numbers and words always are JSON
    serde_json::to_string(told).unwrap_or_default().into()
}

/// Counts the sockets that are open.
pub(super) struct Counted(Desk);

impl Counted {
    pub(super) fn new(desk: &Desk) -> Self {
        desk.counts().web_sockets.fetch_add(1, Ordering::Relaxed);
        Self(desk.clone())
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.counts().web_sockets.fetch_sub(1, Ordering::Relaxed);
    }
}
