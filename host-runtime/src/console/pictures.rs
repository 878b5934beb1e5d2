//! `/pictures?views=0,1`: the newest pictures of these views, each a binary message.
//!
//! | bytes | |
//! |---|---|
//! | 4 | length of the header, lowest byte first |
//! | so many | the header, JSON: view, sequence, taken_us, age_us, width, height, balls |
//! | the rest | the JPEG file |
//!
//! Of each view one picture at most is on its way: the page thanks for it (`{"type":"shown","view":0}`) once it
//! is drawn, and gets what is the newest then. A page that is slow gets fewer pictures, never older ones.

use super::app::State;
use super::desk::{Desk, Look, Shown};
use super::live::{Counted, MAX_MESSAGE, STALLED};
use super::snapshot::BallView;
use axum::extract::State as Of;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::{StatusCode, Uri};
use axum::response::{IntoResponse as _, Response};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use tokio::sync::OwnedSemaphorePermit;
use tokio::time::timeout;

#[derive(Serialize)]
struct Header<'a> {
    view: usize,
    sequence: u32,
    /// By the operator's clock, which a page knows by echoes of /live.
    taken_us: u64,
    /// Since it was taken, as it leaves.
    age_us: u64,
    width: u16,
    height: u16,
    balls: &'a [BallView],
}

#[derive(Deserialize)]
#[serde(tag = "type", rename_all = "kebab-case")]
enum Said {
    Shown { view: usize },
}

/// A view as this page sees it.
struct Line {
    view: usize,
    sent: Option<u32>,
    on_its_way: bool,
}

pub(super) async fn upgrade(Of(state): Of<State>, uri: Uri, socket: WebSocketUpgrade) -> Response {
    let Some(views) = views(uri.query().unwrap_or_default()) else {
        return (StatusCode::BAD_REQUEST, "say which: /pictures?views=0,1\n").into_response();
    };
    let Ok(permit) = Arc::clone(&state.web_sockets).try_acquire_owned() else {
        return super::app::full();
    };
    let look = state.desk.look(views);
    let socket = socket.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    socket.on_upgrade(move |socket| serve(socket, state.desk, look, permit))
}

/// `views=0,1`
fn views(query: &str) -> Option<Vec<usize>> {
    let list = query.split('&').find_map(|part| part.strip_prefix("views="))?;
    let mut views = list.split(',').map(|view| view.parse().ok()).collect::<Option<Vec<usize>>>()?;
    views.sort_unstable();
    views.dedup();
    Some(views)
}

async fn serve(mut socket: WebSocket, desk: Desk, look: Look, _permit: OwnedSemaphorePermit) {
    let _counted = Counted::new(&desk);
    let mut news = desk.watch_pictures();
    let line = |view: &usize| Line { view: *view, sent: None, on_its_way: false };
    let mut lines: Vec<Line> = look.views().iter().map(line).collect();
    loop {
        news.mark_unchanged();
        for line in &mut lines {
            let Some(message) = line.next(&desk) else { continue };
            if !matches!(timeout(STALLED, socket.send(message)).await, Ok(Ok(()))) {
                return;
            }
        }
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Text(text))) => {
                    let Ok(Said::Shown { view }) = serde_json::from_str(&text) else { return };
                    if let Some(line) = lines.iter_mut().find(|line| line.view == view && line.on_its_way) {
                        line.on_its_way = false;
                        desk.thank(view);
                    }
                }
                Some(Ok(Message::Ping(_) | Message::Pong(_))) => {}
                Some(Ok(Message::Binary(_) | Message::Close(_)) | Err(_)) | None => return,
            },
            // the desk outlives its sockets
            _ = news.changed() => {}
        }
    }
}

impl Line {
    /// The newest picture, if it was not sent yet and nothing is on its way.
    fn next(&mut self, desk: &Desk) -> Option<Message> {
        if self.on_its_way {
            return None;
        }
        let shown = desk.shown(self.view).filter(|shown| self.sent != Some(shown.sequence))?;
        self.sent = Some(shown.sequence);
        self.on_its_way = true;
        Some(Message::Binary(encode(self.view, &shown, desk.now_us()).into()))
    }
}

fn encode(view: usize, shown: &Shown, now_us: u64) -> Vec<u8> {
    let header = Header {
        view,
        sequence: shown.sequence,
        taken_us: shown.taken_us,
        age_us: now_us.saturating_sub(shown.taken_us),
        width: shown.width,
        height: shown.height,
        balls: &shown.balls,
    };
    // plain numbers and words always are JSON
    let header = serde_json::to_vec(&header).unwrap_or_default();
    let mut message = Vec::with_capacity(4 + header.len() + shown.jpeg.len());
    message.extend((header.len() as u32).to_le_bytes());
    message.extend(&header);
    message.extend(&*shown.jpeg);
    message
}
