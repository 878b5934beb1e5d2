use super::*;
use crate::console::ViewKind;
use crate::console::desk::Shown;
use crate::console::testing::{LONG, Tab};
use crate::link::Doorbell;
use crate::link::authority::{make_authority, make_station};
use crate::robot::clock::Clock;
use crate::settings::station::ConsoleTls;
use futures_util::StreamExt as _;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, RootCertStore};
use serde_json::json;
use std::io::Write as _;
use std::net::TcpStream as StdStream;
use std::path::Path;
use std::sync::atomic::Ordering;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_tungstenite::tungstenite::Message;

mod crowd;

/// A console at a port of its own.
fn console(drives: bool) -> (Console, Desk) {
    let views = vec![("left".to_owned(), ViewKind::Hand), ("left eye".to_owned(), ViewKind::Eye)];
    let desk = Desk::new(drives, views, Clock::wall(), Doorbell::default());
    (Console::start(&anywhere(), desk.clone()).expect("a console"), desk)
}

fn anywhere() -> ConsoleSettings {
    ConsoleSettings { listen: "127.0.0.1:0".parse().expect("an address"), ..ConsoleSettings::demo() }
}

#[track_caller]
fn wait(what: &str, so: impl Fn() -> bool) {
    let began = std::time::Instant::now();
    while !so() {
        assert!(began.elapsed() < LONG, "{what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn the_next_free_port_where_that_is_wanted() {
    let (first, desk) = console(true);
    let taken = ConsoleSettings { listen: first.address(), ..anywhere() };
    let second = Console::start(&taken, desk.clone()).unwrap();
    assert!(second.address().port() > first.address().port());
    let only = ConsoleSettings { port: ConsolePort::Given, ..taken };
    let refused = Console::start(&only, desk).unwrap_err().to_string();
    assert!(
        refused.contains("[console] listen") && refused.contains(&first.address().to_string()),
        "{refused}"
    );
}

#[test]
fn a_token_that_is_none_is_said_with_its_file() {
    let (_, desk) = console(true);
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("token");
    let settings = ConsoleSettings { token_file: Some(file.clone()), ..anywhere() };
    let refused = |desk: &Desk| Console::start(&settings, desk.clone()).unwrap_err().to_string();
    assert!(refused(&desk).contains("cannot read") && refused(&desk).contains("token"));
    std::fs::write(&file, "short\n").unwrap();
    assert!(refused(&desk).starts_with("[console] token_file: "), "{}", refused(&desk));
}

#[tokio::test]
async fn one_tab_drives_another_looks_and_may_stop() {
    let (console, desk) = console(true);
    let mut first = Tab::open(console.address()).await;
    first.take().await;
    first.press(|| desk.buttons().pressed).await;
    let mut second = Tab::open(console.address()).await;
    second.say(json!({"type": "take", "name": "tablet"})).await;
    second.say(json!({"type": "reset"})).await;
    second.hear().await;
    second.hold().await;
    second
        .until("who drives", |live| {
            live["control"]["yours"] == false
                && live["control"]["holder"].as_str().is_some_and(|name| name.contains("test"))
        })
        .await;
    assert!(second.refused.iter().any(|why| why.contains("another page")), "{:?}", second.refused);
    assert_eq!(desk.buttons().resets, 0);
    second.say(json!({"type": "stop"})).await;
    wait("the stop", || desk.buttons().stop);
    first.hold().await;
    first.until("the stop", |live| live["control"]["stopped"] == true).await;
    assert!(!desk.buttons().pressed);
}

#[tokio::test]
async fn what_is_held_before_control_is_taken_drives_nothing_until_it_is_pressed_anew() {
    let (console, desk) = console(true);
    let mut tab = Tab::open(console.address()).await;
    let told =
        |tab: &Tab, press: u64| json!({"type": "hold", "press": press, "shown_us": tab.live["now_us"]});
    tab.hear().await;
    tab.say(told(&tab, 1)).await;
    tab.take().await;
    assert_eq!(tab.refused, ["this page is not in control: take control first"]);
    // the button was never let go
    for _ in 0..5 {
        tab.say(told(&tab, 1)).await;
        tab.hear().await;
        assert!(!desk.buttons().pressed && tab.live["control"]["pressed"] == false);
    }
    assert!(desk.control().view(None, desk.now_us()).held_us.is_none(), "none ever counted");
    tab.hear().await;
    assert!(tab.refused[1..].iter().all(|why| why.starts_with("this press has ended")), "{:?}", tab.refused);
    tab.release().await;
    tab.press(|| desk.buttons().pressed).await;
}

#[tokio::test]
async fn a_socket_that_is_gone_has_let_go_and_given_up() {
    let (console, desk) = console(true);
    let mut tab = Tab::open(console.address()).await;
    tab.take().await;
    tab.press(|| desk.buttons().pressed).await;
    drop(tab);
    wait("control is free", || desk.control().view(None, desk.now_us()).holder.is_none());
    assert!(!desk.buttons().pressed);
    // the page that is loaded again holds nothing
    let mut again = Tab::open(console.address()).await;
    again.hear().await;
    again.hold().await;
    again.until("the refusal", |live| live["control"]["holder"].is_null()).await;
    assert!(!desk.buttons().pressed);
}

#[tokio::test]
async fn what_is_not_understood_lets_go() {
    let (console, desk) = console(true);
    for message in ["{", "{\"type\":\"hold\"}", "{\"type\":\"fly\"}", "\u{0}"] {
        let mut tab = Tab::open(console.address()).await;
        tab.take().await;
        tab.press(|| desk.buttons().pressed).await;
        tab.say(json!({"type": "here"})).await;
        tab.raw(Message::text(message)).await;
        while !tab.refused.iter().any(|why| why.contains("not understood")) {
            tab.hear().await;
        }
        let seen = desk.control().view(None, desk.now_us());
        assert_eq!((seen.pressed, seen.press_age_us), (false, None), "{message}");
        drop(tab);
        wait("control is free", || desk.control().view(None, desk.now_us()).holder.is_none());
    }
    // nor is anybody heard to the end who says too much
    let mut tab = Tab::open(console.address()).await;
    tab.take().await;
    tab.raw(Message::text("x".repeat(100_000))).await;
    wait("it is closed", || desk.control().view(None, desk.now_us()).holder.is_none());
}

#[tokio::test]
async fn the_line_is_measured_by_echoes_which_hold_nothing() {
    let (console, desk) = console(true);
    let mut tab = Tab::open(console.address()).await;
    tab.take().await;
    tab.press(|| desk.buttons().pressed).await;
    let before_us = desk.now_us();
    tab.say(json!({"type": "echo", "sent_us": 123_456})).await;
    let echo = loop {
        let Some(Message::Text(text)) = tab.next().await else { panic!("the socket is closed") };
        let told: serde_json::Value = serde_json::from_str(&text).unwrap();
        if told["type"] == "echo" {
            break told;
        }
    };
    assert_eq!(echo["sent_us"], 123_456);
    let answered_us = echo["now_us"].as_u64().unwrap();
    assert!((before_us..=desk.now_us()).contains(&answered_us));
    // nor is it a sign of somebody being there
    let wait_for = async {
        while desk.control().view(None, desk.now_us()).holder.is_some() {
            tab.say(json!({"type": "echo", "sent_us": 1})).await;
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::time::timeout(LONG, wait_for).await.expect("it is in control no more");
    assert!(!desk.buttons().pressed);
}

#[tokio::test]
async fn pictures_come_one_at_a_time_and_the_newest() {
    let (console, desk) = console(true);
    let mut tab = Tab::try_open(console.address(), "/pictures?views=0,7").await.unwrap();
    wait("somebody looks", || desk.is_looked_at(0));
    assert!(!desk.is_looked_at(1));
    let shown = |sequence: u32| Shown {
        sequence,
        taken_us: desk.now_us(),
        width: 4,
        height: 3,
        balls: Vec::new(),
        jpeg: vec![sequence as u8; 5].into(),
    };
    desk.show(0, shown(1));
    let sequence = |message: Option<Message>| {
        let Some(Message::Binary(bytes)) = message else { panic!("{message:?}") };
        let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
        let header: serde_json::Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
        assert_eq!((&header["view"], &header["width"]), (&json!(0), &json!(4)));
        assert!(header["taken_us"].as_u64().is_some_and(|taken_us| taken_us <= desk.now_us()), "{header}");
        let sequence = header["sequence"].as_u64().unwrap();
        assert_eq!(&bytes[4 + length..], [sequence as u8; 5]);
        sequence
    };
    assert_eq!(sequence(tab.next().await), 1);
    for number in 2..9 {
        desk.show(0, shown(number));
    }
    tab.say(json!({"type": "shown", "view": 0})).await;
    assert_eq!(sequence(tab.next().await), 8, "those in between are left out");
    let thanked = || desk.views()[0].thanked.load(Ordering::Relaxed);
    assert_eq!(thanked(), 1, "what was not sent is not thanked for");
    tab.say(json!({"type": "shown", "view": 0})).await;
    wait("the thanks", || thanked() == 2);
    drop(tab);
    wait("nobody looks", || !desk.is_looked_at(0));
    assert!(Tab::try_open(console.address(), "/pictures").await.is_err(), "of no view");
}

#[tokio::test]
async fn web_sockets_leave_room_for_a_stop() {
    let (console, desk) = console(true);
    let mut tabs = Vec::new();
    for _ in 0..crate::console::app::WEB_SOCKETS {
        tabs.push(Tab::open(console.address()).await);
    }
    assert!(Tab::try_open(console.address(), "/live").await.is_err());
    let mut stop = StdStream::connect(console.address()).unwrap();
    stop.write_all(b"POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n").unwrap();
    wait("the stop", || desk.buttons().stop);
}

/// Trusts the authority of these keys.
fn connector(keys: &Path) -> TlsConnector {
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from_pem_file(keys.join("authority.pem")).unwrap()).unwrap();
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    TlsConnector::from(Arc::new(config.with_root_certificates(roots).with_no_client_auth()))
}

async fn secure(connector: &TlsConnector, console: SocketAddr) -> io::Result<TlsStream<TcpStream>> {
    let plain = TcpStream::connect(console).await?;
    connector.connect(ServerName::try_from("arm").unwrap(), plain).await
}

#[tokio::test]
async fn elsewhere_it_is_served_over_tls_with_the_stations_keys() {
    let dir = tempfile::tempdir().unwrap();
    let name = "arm".parse().unwrap();
    make_authority(dir.path()).unwrap();
    make_station(dir.path(), &name).unwrap();
    let desk = Desk::new(true, Vec::new(), Clock::wall(), Doorbell::default());
    let files = |key| ConsoleTls { certificate: dir.path().join("arm.pem"), key: dir.path().join(key) };
    let settings = ConsoleSettings { tls: Some(files("arm.key")), ..anywhere() };
    let console = Console::start(&settings, desk.clone()).unwrap();
    assert!(console.url().starts_with("https://"));
    let mut secure = secure(&connector(dir.path()), console.address()).await.unwrap();
    secure.write_all(b"GET /drive HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").await.unwrap();
    let mut answer = Vec::new();
    let _ = secure.read_to_end(&mut answer).await;
    assert!(answer.starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&answer));

    let refused = |tls| {
        let settings = ConsoleSettings { tls: Some(tls), ..anywhere() };
        Console::start(&settings, desk.clone()).unwrap_err().to_string()
    };
    assert!(refused(files("other.key")).starts_with("[console] key: cannot read"));
    std::fs::write(dir.path().join("other.key"), std::fs::read(dir.path().join("authority.key")).unwrap())
        .unwrap();
    assert!(refused(files("other.key")).contains("not of one make"), "{}", refused(files("other.key")));
}
