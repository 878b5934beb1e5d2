//! Who must not get in, while the arm is driven.

use super::browser::{Browser, SPACE};
use super::driver::{hold, take};
use super::program::Program;
use super::turn;
use super::witness::Witness;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

const TOKEN: &str = "0123456789abcdef-of-the-tests";

/// More connections than there is room for.
const SOCKETS: usize = 100;

/// So often it is tried that the arm is driven on without a break. A computer that is too busy for the page breaks it by
/// itself: a try counts where there was no break for as long before the strangers came as they stay.
const TRIES: usize = 3;
const MOST_TRIES: usize = 12;
const LEAST_TRIES: usize = 2;

/// So long before, about as long as they stay.
const QUIET: Duration = Duration::from_secs(2);

/// Sends a request as it stands and gives the status of the answer.
fn status(console: SocketAddr, request: &[u8]) -> Option<u16> {
    let mut stream = TcpStream::connect(console).ok()?;
    stream.set_read_timeout(Some(Duration::from_secs(20))).ok()?;
    // a body that is too large is refused before it was sent to its end
    let _ = stream.write_all(request);
    let mut answer = [0; 12];
    stream.read_exact(&mut answer).ok()?;
    std::str::from_utf8(&answer).ok()?.strip_prefix("HTTP/1.1 ")?.parse().ok()
}

/// What strangers try, and what has to come of it.
fn attempts(host: SocketAddr) -> Vec<(&'static str, Vec<u8>, u16)> {
    let bearer = format!("Authorization: Bearer {TOKEN}\r\n");
    let request = |head: &str, host: &str, more: &str, body: &[u8]| {
        let length = body.len();
        let head = format!("{head} HTTP/1.1\r\nHost: {host}\r\n{more}Content-Length: {length}\r\n\r\n");
        [head.as_bytes(), body].concat()
    };
    let host = host.to_string();
    let socket = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                  Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let foreign = "Origin: http://elsewhere.example\r\n";
    let cross = format!("{bearer}{foreign}");
    vec![
        ("no token", request("POST /api/stop", &host, "", b""), 401),
        ("no token, a socket", request("GET /live", &host, socket, b""), 401),
        (
            "a wrong token",
            request("POST /api/stop", &host, "Authorization: Bearer 0123456789abcdef\r\n", b""),
            401,
        ),
        (
            "a wrong cookie",
            request("GET /live", &host, &format!("{socket}Cookie: tetrad_token=no\r\n"), b""),
            401,
        ),
        ("another site's page", request("POST /api/stop", &host, &cross, b""), 403),
        ("another site's socket", request("GET /live", &host, &format!("{socket}{cross}"), b""), 403),
        (
            "another site's form",
            request("POST /api/stop", &host, &format!("{bearer}Sec-Fetch-Site: cross-site\r\n"), b""),
            403,
        ),
        ("another name", request("GET /drive", "elsewhere.example", &bearer, b""), 421),
        ("an oversized body", request("POST /sign-in", &host, &bearer, &vec![b'x'; 1 << 20]), 413),
    ]
}

#[test]
fn strangers_are_refused_and_driving_goes_on() {
    let _turn = turn();
    let test = "console::strangers::strangers_are_refused_and_driving_goes_on";
    let Some(browser) = Browser::open(test) else { return };
    let program = Program::operator_with("token_file = \"token\"\n", &[("token", TOKEN)]);
    let console = program.address();
    let witness = Witness::with_token(console, Some(TOKEN));

    // a browser is asked for the token, and told when that is not it
    browser.go(&program.url("/drive"));
    browser.write("#token", "not-the-token-of-here");
    browser.click("button[type=submit]");
    browser.until("document.body.innerText.includes('That is not the token.')");
    browser.write("#token", TOKEN);
    browser.click("button[type=submit]");
    browser.until("location.pathname === '/'");
    assert_eq!(browser.script("return document.cookie"), "", "no script sees the token");
    browser.go(&program.url("/drive"));
    take(&browser);

    let (mut spans_us, mut quiet_us) = (Vec::new(), Vec::new());
    for _ in 0..MOST_TRIES {
        hold(&browser, &witness);
        let began_us = witness.now_us();
        std::thread::sleep(QUIET);
        let from_us = witness.now_us();
        for (who, request, refused) in attempts(console) {
            assert_eq!(status(console, &request), Some(refused), "{who}");
        }
        let mut crowd: Vec<TcpStream> =
            (0..SOCKETS).map(|_| TcpStream::connect(console).expect("a connection")).collect();
        // those for whom there is room ask for the page, and never finish
        for stranger in &mut crowd {
            let _ = stranger.write_all(b"GET /drive HTTP/1.1\r\nHost: ");
        }
        std::thread::sleep(Duration::from_secs(1));
        let sockets = witness.until("the crowd", |_| true);
        assert_ne!(sockets["control"]["stopped"], true, "nobody has stopped it");
        let to_us = witness.now_us();
        drop(crowd);
        browser.key_up(SPACE);
        if program.so_far().moved_throughout(began_us, from_us) {
            quiet_us.push((began_us, from_us));
            spans_us.push((from_us, to_us));
        }
        if spans_us.len() == TRIES {
            break;
        }
    }
    let record = program.end();
    let unbroken =
        spans_us.iter().filter(|(from_us, to_us)| record.moved_throughout(*from_us, *to_us)).count();
    let tries = spans_us.len();
    assert!(tries >= LEAST_TRIES, "the computer was too busy all but {tries} times");
    println!(
        "measured: driven on without a break among strangers and {SOCKETS} sockets: {unbroken} of {tries} times; \
         picture to datagram, p99: {:.2} ms, and {:.2} ms before they came",
        record.delay_p99_ms(&spans_us),
        record.delay_p99_ms(&quiet_us)
    );
    // a break may fall among strangers by chance, on a computer that has them elsewhere too; not as a rule
    assert!(3 * unbroken >= 2 * tries, "{unbroken} of {tries}");
}
