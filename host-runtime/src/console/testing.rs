//! A page without a browser, for tests.

use futures_util::{SinkExt as _, StreamExt as _};
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// Longer than anything takes.
pub(crate) const LONG: Duration = Duration::from_secs(60);

/// Asks over a connection of its own; the status, and the answer's JSON.
pub(crate) async fn post(console: SocketAddr, path: &str, body: &Value) -> (u16, Value) {
    let body = body.to_string();
    let request = format!(
        "POST {path} HTTP/1.1\r\nhost: {console}\r\nconnection: close\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    );
    let asked = async {
        let mut stream = TcpStream::connect(console).await?;
        stream.write_all(request.as_bytes()).await?;
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).await?;
        std::io::Result::Ok(answer)
    };
    let answer = timeout(LONG, asked).await.expect("an answer").expect("a connection");
    let answer = String::from_utf8(answer).expect("text");
    let (head, body) = answer.split_once("\r\n\r\n").expect("a head");
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
    (status, serde_json::from_str(body).unwrap_or(Value::Null))
}

/// One tab: the socket of a page, and what it was told last.
pub(crate) struct Tab {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    pub(crate) live: Value,
    pub(crate) refused: Vec<String>,
    /// The number of the press, and how many refusals were heard before.
    press: u64,
    heeded: usize,
}

impl Tab {
    /// Opens /live.
    pub(crate) async fn open(console: SocketAddr) -> Self {
        Self::try_open(console, "/live").await.expect("a socket")
    }

    pub(crate) async fn try_open(
        console: SocketAddr,
        path: &str,
    ) -> Result<Self, tokio_tungstenite::tungstenite::Error> {
        let (socket, _) = connect_async(format!("ws://{console}{path}")).await?;
        Ok(Self { socket, live: Value::Null, refused: Vec::new(), press: 1, heeded: 0 })
    }

    pub(crate) async fn say(&mut self, message: Value) {
        self.socket.send(Message::text(message.to_string())).await.expect("it is sent");
    }

    pub(crate) async fn raw(&mut self, message: Message) {
        self.socket.send(message).await.expect("it is sent");
    }

    /// The next message of any kind; `None` where the socket is closed.
    pub(crate) async fn next(&mut self) -> Option<Message> {
        timeout(LONG, self.socket.next()).await.expect("something comes").and_then(Result::ok)
    }

    /// The next of what the loop knows.
    pub(crate) async fn hear(&mut self) -> &Value {
        loop {
            let Some(Message::Text(text)) = self.next().await else { panic!("the socket is closed") };
            let told: Value = serde_json::from_str(&text).expect("JSON");
            match told["type"].as_str() {
                Some("live") => {
                    self.live = told;
                    return &self.live;
                }
                Some("refused") => self.refused.push(told["why"].as_str().unwrap_or_default().to_owned()),
                Some("hello") => {}
                other => panic!("{other:?}"),
            }
        }
    }

    /// Goes on hearing until something is so.
    pub(crate) async fn until(&mut self, what: &str, so: impl Fn(&Value) -> bool) {
        let wait = async { while !so(self.hear().await) {} };
        timeout(LONG, wait).await.unwrap_or_else(|_| panic!("{what} did not come"));
    }

    /// Takes control, with the button let go.
    pub(crate) async fn take(&mut self) {
        self.say(json!({"type": "take", "name": "test"})).await;
        self.say(json!({"type": "release"})).await;
        self.until("control", |live| live["control"]["yours"] == true).await;
    }

    /// Says that the button is held; pressed anew where the press has ended.
    pub(crate) async fn hold(&mut self) {
        if self.refused.len() > self.heeded {
            // a computer that was too busy for a moment has ended it
            self.heeded = self.refused.len();
            self.press += 1;
        }
        let shown_us = self.live["now_us"].clone();
        self.say(json!({"type": "hold", "press": self.press, "shown_us": shown_us})).await;
    }

    /// Holds the button until something is so.
    pub(crate) async fn press(&mut self, so: impl Fn() -> bool) {
        let wait = async {
            while !so() {
                self.hear().await;
                self.hold().await;
            }
        };
        timeout(LONG, wait).await.expect("the press counts");
    }

    /// Lets go of the button.
    pub(crate) async fn release(&mut self) {
        self.press += 1;
        self.say(json!({"type": "release"})).await;
    }
}
