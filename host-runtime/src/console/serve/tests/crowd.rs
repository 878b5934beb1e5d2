//! A crowd that holds on to its connections keeps nobody out who may stop the arm.

use super::*;
use axum::http::Request;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::tungstenite::error::Error as SocketError;
use tokio_tungstenite::{WebSocketStream, client_async};

const TOKEN: &str = "0123456789abcdef0123456789abcdef";

/// More than there is room for; so many at least do not get in, or have to go.
const STRANGERS: usize = 100;
const CROWDED_OUT: usize = STRANGERS - SOCKETS;

/// So long the console may take until it has seen those who came, before more come.
const SEEN_WITHIN: Duration = Duration::from_secs(1);

/// Half a request.
const HALF: &[u8] = b"POST /api/stop HTTP/1.1\r\nHost: ";

/// A console with a token, and the files that it has them of.
struct Guarded {
    console: Console,
    desk: Desk,
    keys: tempfile::TempDir,
}

impl Guarded {
    fn start(tls: bool) -> Self {
        let keys = tempfile::tempdir().unwrap();
        make_authority(keys.path()).unwrap();
        make_station(keys.path(), &"arm".parse().unwrap()).unwrap();
        let file = |name| keys.path().join(name);
        std::fs::write(file("token"), TOKEN).unwrap();
        let files = ConsoleTls { certificate: file("arm.pem"), key: file("arm.key") };
        let settings = ConsoleSettings {
            token_file: Some(file("token")),
            tls: Some(files).filter(|_| tls),
            ..anywhere()
        };
        let desk = Desk::new(true, Vec::new(), Clock::wall(), Doorbell::default());
        Self { console: Console::start(&settings, desk.clone()).unwrap(), desk, keys }
    }

    async fn plain(&self) -> TcpStream {
        TcpStream::connect(self.console.address()).await.unwrap()
    }

    /// A WebSocket of the driving page, with the token.
    async fn page<S: AsyncRead + AsyncWrite + Unpin>(
        &self,
        stream: S,
        scheme: &str,
    ) -> Result<WebSocketStream<S>, SocketError> {
        let url = format!("{scheme}://{}/live", self.console.address());
        let mut request: Request<()> = url.into_client_request()?;
        request.headers_mut().insert("authorization", format!("Bearer {TOKEN}").parse().unwrap());
        Ok(client_async(request, stream).await?.0)
    }
}

/// How many strangers there are to come until no room is left and enough were crowded out.
fn lacks(desk: &Desk) -> usize {
    let counts = desk.counts();
    let here = counts.sockets.load(Ordering::Relaxed);
    assert!(here <= SOCKETS, "{here}");
    let out = counts.crowded_out.load(Ordering::Relaxed) as usize;
    (SOCKETS - here) + CROWDED_OUT.saturating_sub(out)
}

/// Strangers come until there are too many, however slow the computer is: where some have been here for too long already,
/// others come instead. They hold on for as long as what is given is kept.
async fn crowd<S>(desk: &Desk, mut stranger: impl AsyncFnMut(usize) -> S) -> Vec<S> {
    let began = std::time::Instant::now();
    let mut strangers = Vec::new();
    loop {
        let come = lacks(desk);
        if come == 0 {
            return strangers;
        }
        assert!(began.elapsed() < LONG, "the crowd: {come} to come, {} have", strangers.len());
        for _ in 0..come {
            let one = stranger(strangers.len()).await;
            strangers.push(one);
        }
        let came = std::time::Instant::now();
        while lacks(desk) > 0 && came.elapsed() < SEEN_WITHIN {
            sleep(Duration::from_millis(1)).await;
        }
    }
}

/// Asks for a stop by a connection of its own.
async fn stop(mut stream: impl AsyncRead + AsyncWrite + Unpin) -> String {
    let request = format!(
        "POST /api/stop HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}\r\n\
         Content-Length: 0\r\nConnection: close\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    // over TLS an end may come without a farewell
    let _ = stream.read_to_end(&mut answer).await;
    String::from_utf8(answer).unwrap()
}

async fn hears<S: AsyncRead + AsyncWrite + Unpin>(page: &mut WebSocketStream<S>) {
    for _ in 0..3 {
        let told = timeout(LONG, page.next()).await.expect("something comes");
        assert!(matches!(told, Some(Ok(Message::Text(_)))), "{told:?}");
    }
}

#[tokio::test]
async fn a_hundred_idle_strangers_keep_out_no_stop_and_no_page() {
    for said in [b"".as_slice(), HALF, b"GET /health HTTP/1.1\r\nHost: localhost\r\n\r\n"] {
        let guarded = Guarded::start(false);
        let mut driving = guarded.page(guarded.plain().await, "ws").await.unwrap();
        hears(&mut driving).await;
        let strangers = crowd(&guarded.desk, async |_| {
            let mut stranger = guarded.plain().await;
            stranger.write_all(said).await.unwrap();
            stranger
        })
        .await;
        // while all of them hold on
        let answer = stop(guarded.plain().await).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(guarded.desk.buttons().stop);
        hears(&mut guarded.page(guarded.plain().await, "ws").await.unwrap()).await;
        hears(&mut driving).await;
        drop(strangers);
        // it has room again for whoever comes
        wait("they are gone", || guarded.desk.counts().sockets.load(Ordering::Relaxed) <= 2);
    }
}

#[tokio::test]
async fn over_tls_neither() {
    let guarded = Guarded::start(true);
    let console = guarded.console.address();
    let connector = connector(guarded.keys.path());
    let page = async || guarded.page(secure(&connector, console).await.unwrap(), "wss").await.unwrap();
    let mut driving = page().await;
    hears(&mut driving).await;
    let strangers = crowd(&guarded.desk, async |number| {
        match number % 3 {
            // nothing, the beginning of a hello that never ends, and all of it with half a request behind
            0 => Box::new(guarded.plain().await) as Box<dyn AsyncRead>,
            1 => {
                let mut stranger = guarded.plain().await;
                stranger.write_all(&[0x16, 0x03, 0x01, 0x02, 0x00]).await.unwrap();
                Box::new(stranger)
            }
            _ => {
                let mut stranger = secure(&connector, console).await.unwrap();
                stranger.write_all(HALF).await.unwrap();
                Box::new(stranger)
            }
        }
    })
    .await;
    let answer = stop(secure(&connector, console).await.unwrap()).await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    assert!(guarded.desk.buttons().stop);
    hears(&mut page().await).await;
    hears(&mut driving).await;
    drop(strangers);
}

/// On loopback nobody has a token: who asks for nothing gives way there too.
#[tokio::test]
async fn a_hundred_sockets_are_bounded_and_disturb_nobody_who_drives() {
    let (console, desk) = console(true);
    let mut tab = Tab::open(console.address()).await;
    tab.take().await;
    tab.press(|| desk.buttons().pressed).await;
    let others = crowd(&desk, async |number| {
        let mut other = TcpStream::connect(console.address()).await.unwrap();
        if number % 2 == 0 {
            other.write_all(HALF).await.unwrap();
        }
        other
    })
    .await;
    // its socket is open still; who was silent for that long on a slow computer is not in control any more
    tab.take().await;
    tab.press(|| desk.buttons().pressed).await;
    let mut late = StdStream::connect(console.address()).unwrap();
    late.write_all(b"POST /api/stop HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\n\r\n").unwrap();
    wait("the stop", || desk.buttons().stop);
    let mut page = Tab::open(console.address()).await;
    page.until("the stop", |live| live["control"]["stopped"] == true).await;
    drop(others);
    wait("there is room", || desk.counts().sockets.load(Ordering::Relaxed) <= 3);
}
