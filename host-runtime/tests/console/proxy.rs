//! A line between the browser and the console that can be cut, can hang, and can be late.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// How long a line that hangs waits before it looks whether it still does.
const POLL: Duration = Duration::from_millis(5);

/// What is passed on at once, bytes.
const CHUNK: usize = 16 * 1024;

/// So many chunks are on their way in a line that is late; whoever sends more waits.
const ON_THE_WAY: usize = 2048;

/// Passes on whatever comes, both ways.
pub(crate) struct Proxy {
    address: SocketAddr,
    console: Arc<Mutex<SocketAddr>>,
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
    /// Everything gets through so much later, microseconds.
    late_us: AtomicU64,
    open: Mutex<Vec<TcpStream>>,
}

impl Proxy {
    /// In front of a console. It is there until the tests end.
    pub(crate) fn to(console: SocketAddr) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a port");
        let address = listener.local_addr().expect("an address");
        let console = Arc::new(Mutex::new(console));
        let line = Arc::new(Line::default());
        let (leads_to, passing) = (Arc::clone(&console), Arc::clone(&line));
        std::thread::spawn(move || {
            for browser in listener.incoming().map_while(Result::ok) {
                if passing.cut.load(Ordering::Relaxed) {
                    continue;
                }
                // a console that has ended is a browser's connection that ends
                let to = *leads_to.lock().expect("no panic");
                let Ok(console) = TcpStream::connect(to) else { continue };
                let path = Arc::new(Mutex::new(String::new()));
                for (from, to, asks) in [(&browser, &console, true), (&console, &browser, false)] {
                    let (from, to) = (from.try_clone().expect("a socket"), to.try_clone().expect("a socket"));
                    let (line, path) = (Arc::clone(&passing), Arc::clone(&path));
                    let (reads, comes) = sync_channel(ON_THE_WAY);
                    std::thread::spawn(move || read(from, &reads));
                    std::thread::spawn(move || line.pass(&comes, to, &path, asks));
                }
                passing.open.lock().expect("no panic").extend([browser, console]);
            }
        });
        Self { address, console, line }
    }

    /// Who connects from now on gets to another console.
    pub(crate) fn lead_to(&self, console: SocketAddr) {
        *self.console.lock().expect("no panic") = console;
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

    /// Everything gets through, so much later, each way.
    pub(crate) fn delay(&self, late: Duration) {
        let late_us = u64::try_from(late.as_micros()).expect("less than an age");
        self.line.late_us.store(late_us, Ordering::Relaxed);
    }

    /// Who connects is let through again.
    pub(crate) fn open(&self) {
        self.line.cut.store(false, Ordering::Relaxed);
    }

    /// Everything gets through again, at once.
    pub(crate) fn mend(&self) {
        self.open();
        self.delay(Duration::ZERO);
        self.line.hangs.store(false, Ordering::Relaxed);
        *self.line.holds_up.lock().expect("no panic") = None;
    }
}

/// What came, and when; nothing at the end.
type Chunk = (Instant, Vec<u8>);

/// Reads one direction of one connection to its end.
fn read(mut from: TcpStream, reads: &SyncSender<Chunk>) {
    let mut chunk = vec![0; CHUNK];
    // a connection that is reset has ended
    while let Ok(length @ 1..) = from.read(&mut chunk) {
        if reads.send((Instant::now(), chunk[..length].to_vec())).is_err() {
            return;
        }
    }
}

impl Line {
    /// One direction of one connection.
    fn pass(&self, comes: &Receiver<Chunk>, mut to: TcpStream, path: &Mutex<String>, asks: bool) {
        for (came, bytes) in comes {
            if asks && bytes.starts_with(b"GET ") {
                let head = String::from_utf8_lossy(&bytes);
                head.split(' ').nth(1).unwrap_or_default().clone_into(&mut path.lock().expect("no panic"));
            }
            while self.hangs.load(Ordering::Relaxed) || self.is_held_up(path) || !self.is_due(came) {
                std::thread::sleep(POLL);
            }
            if to.write_all(&bytes).is_err() {
                break;
            }
        }
        // the other side may have closed it
        let _ = to.shutdown(Shutdown::Both);
    }

    fn is_due(&self, came: Instant) -> bool {
        came.elapsed() >= Duration::from_micros(self.late_us.load(Ordering::Relaxed))
    }

    fn is_held_up(&self, path: &Mutex<String>) -> bool {
        let held_up = *self.holds_up.lock().expect("no panic");
        held_up.is_some_and(|held_up| path.lock().expect("no panic").starts_with(held_up))
    }
}
