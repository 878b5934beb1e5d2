//! A line between the browser and the console that can be cut, or can hang.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// How long a line that hangs waits before it looks whether it still does.
const POLL: Duration = Duration::from_millis(5);

/// What is passed on at once, bytes.
const CHUNK: usize = 16 * 1024;

/// Passes on whatever comes, both ways.
pub(crate) struct Proxy {
    address: SocketAddr,
    line: Arc<Line>,
}

#[derive(Default)]
struct Line {
    /// Nothing gets through, nothing is closed.
    hangs: AtomicBool,
    /// As `hangs`, for connections that asked for a path which begins so.
    holds_up: Mutex<Option<&'static str>>,
    /// Who connects is closed at once.
    cut: AtomicBool,
    open: Mutex<Vec<TcpStream>>,
}

impl Proxy {
    /// In front of a console. It is there until the tests end.
    pub(crate) fn to(console: SocketAddr) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
        let address = listener.local_addr().expect("an address");
        let line = Arc::new(Line::default());
        let passing = Arc::clone(&line);
        std::thread::spawn(move || {
            for browser in listener.incoming().map_while(Result::ok) {
                if passing.cut.load(Ordering::Relaxed) {
                    continue;
                }
                // a console that has ended is a browser's connection that ends
                let Ok(console) = TcpStream::connect(console) else { continue };
                let path = Arc::new(Mutex::new(String::new()));
                for (from, to, asks) in [(&browser, &console, true), (&console, &browser, false)] {
                    let (from, to) = (from.try_clone().expect("a socket"), to.try_clone().expect("a socket"));
                    let (line, path) = (Arc::clone(&passing), Arc::clone(&path));
                    std::thread::spawn(move || line.pass(from, to, &path, asks));
                }
                passing.open.lock().expect("no panic").extend([browser, console]);
            }
        });
        Self { address, line }
    }

    /// The address of a page, through this line.
    pub(crate) fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.address)
    }

    /// Closes every connection, and every one that comes.
    pub(crate) fn cut(&self) {
        self.line.cut.store(true, Ordering::Relaxed);
        for socket in self.line.open.lock().expect("no panic").drain(..) {
            // the other side may have closed it
            let _ = socket.shutdown(Shutdown::Both);
        }
    }

    /// Nothing gets through any more; every connection stays open.
    pub(crate) fn hang(&self) {
        self.line.hangs.store(true, Ordering::Relaxed);
    }

    /// Nothing gets through that was asked for at a path that begins so.
    pub(crate) fn hold_up(&self, path: &'static str) {
        *self.line.holds_up.lock().expect("no panic") = Some(path);
    }

    /// Everything gets through again.
    pub(crate) fn mend(&self) {
        self.line.cut.store(false, Ordering::Relaxed);
        self.line.hangs.store(false, Ordering::Relaxed);
        *self.line.holds_up.lock().expect("no panic") = None;
    }
}

impl Line {
    /// One direction of one connection.
    fn pass(&self, mut from: TcpStream, mut to: TcpStream, path: &Mutex<String>, asks: bool) {
        let mut chunk = vec![0; CHUNK];
        while let Ok(length) = from.read(&mut chunk) {
            let bytes = &chunk[..length];
            if asks && bytes.starts_with(b"GET ") {
                let head = String::from_utf8_lossy(bytes);
                head.split(' ').nth(1).unwrap_or_default().clone_into(&mut path.lock().expect("no panic"));
            }
            while self.hangs.load(Ordering::Relaxed) || self.is_held_up(path) {
                std::thread::sleep(POLL);
            }
            if length == 0 || to.write_all(bytes).is_err() {
                break;
            }
        }
        for socket in [from, to] {
            // the other direction may have closed it
            let _ = socket.shutdown(Shutdown::Both);
        }
    }

    fn is_held_up(&self, path: &Mutex<String>) -> bool {
        let held_up = *self.holds_up.lock().expect("no panic");
        held_up.is_some_and(|held_up| path.lock().expect("no panic").starts_with(held_up))
    }
}
