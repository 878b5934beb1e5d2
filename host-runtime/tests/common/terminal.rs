//! A program at a terminal of its own, with somebody at the keys.

use serialport::{SerialPort as _, TTYPort};
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::fd::{AsRawFd as _, BorrowedFd};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long anything may take.
const LONG: Duration = Duration::from_secs(120);

/// Held while a terminal is opened and its program started.
static STARTING: Mutex<()> = Mutex::new(());

/// Leaves a handle to this process alone.
fn keep(handle: &TTYPort) {
    // SAFETY: the handle is open for as long as it is borrowed here
    let handle = unsafe { BorrowedFd::borrow_raw(handle.as_raw_fd()) };
    rustix::io::fcntl_setfd(handle, rustix::io::FdFlags::CLOEXEC).expect("a handle can be kept");
}

/// What kind of terminal it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// It repeats keys and says nothing when they are let go.
    Plain,
    /// It tells of releases (kitty's protocol).
    Kitty,
}

/// See the module's text. Dropped, the program is killed.
pub(crate) struct Terminal {
    /// Gone once it is hung up.
    master: Option<TTYPort>,
    child: Child,
    said: Arc<Mutex<Vec<u8>>>,
    over: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Terminal {
    /// Starts `tetrad` with these words as arguments.
    #[track_caller]
    pub(crate) fn start(kind: Kind, dir: &Path, arguments: &str) -> Self {
        // another test's program may not inherit this terminal: it would never be hung up
        let starting = STARTING.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        keep(&master);
        keep(&slave);
        master.set_timeout(Duration::from_millis(20)).expect("a timeout");
        let name = slave.name().expect("its name");
        let end = || Stdio::from(File::options().read(true).write(true).open(&name).expect("its other end"));
        // a session of its own, or it would ask the terminal that runs the tests
        let mut command = Command::new("setsid");
        command.arg("--ctty").arg(env!("CARGO_BIN_EXE_tetrad")).args(arguments.split_whitespace());
        command.current_dir(dir).stdin(end()).stdout(end()).stderr(end());
        let child = command.spawn().expect("the program starts");
        let (said, over) = (Arc::<Mutex<Vec<u8>>>::default(), Arc::<AtomicBool>::default());
        let mut theirs = master.try_clone_native().expect("a second handle");
        keep(&theirs);
        drop(starting);
        let (heard, ended) = (Arc::clone(&said), Arc::clone(&over));
        let reader = std::thread::spawn(move || {
            // kept open, or the terminal hangs up before the program has it
            let _slave = slave;
            let mut buffer = [0; 4_096];
            while !ended.load(Ordering::Relaxed) {
                let count = theirs.read(&mut buffer).unwrap_or(0);
                let mut said = heard.lock().unwrap_or_else(PoisonError::into_inner);
                said.extend_from_slice(&buffer[..count]);
                answer(kind, &mut said, &mut theirs);
            }
        });
        Self { master: Some(master), child, said, over, reader: Some(reader) }
    }

    /// Strikes keys.
    pub(crate) fn strike(&mut self, keys: &str) {
        let master = self.master.as_mut().expect("it is not hung up");
        master.write_all(keys.as_bytes()).expect("the terminal is there");
    }

    /// What is on the screen.
    pub(crate) fn said(&self) -> String {
        String::from_utf8_lossy(&self.said.lock().unwrap_or_else(PoisonError::into_inner)).into_owned()
    }

    /// Does something again and again until the screen says this.
    #[track_caller]
    pub(crate) fn until(&mut self, what: &str, mut again: impl FnMut(&mut Self)) {
        let began = Instant::now();
        while !self.said().contains(what) {
            assert!(began.elapsed() < LONG, "never {what:?}: {}", self.said());
            again(self);
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Closes the terminal, as a window that is closed or a connection that is lost does.
    pub(crate) fn hang_up(&mut self) {
        self.stop_reading();
        self.master = None;
    }

    fn stop_reading(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }

    /// Waits for its end: the exit code, and what it said.
    #[track_caller]
    pub(crate) fn end(mut self) -> (Option<i32>, String) {
        let began = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("it can be waited for") {
                // its last words are on their way
                std::thread::sleep(Duration::from_millis(100));
                return (status.code(), self.said());
            }
            assert!(began.elapsed() < LONG, "it does not end: {}", self.said());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

/// Programs ask whether releases can be told, and then what terminal it is, which every one answers.
fn answer(kind: Kind, said: &mut Vec<u8>, terminal: &mut TTYPort) {
    const FLAGS: &[u8] = b"\x1b[?u";
    const WHO: &[u8] = b"\x1b[c";
    let asked = |said: &[u8], what: &[u8]| said.windows(what.len()).any(|window| window == what);
    if asked(said, WHO) {
        if kind == Kind::Kitty && asked(said, FLAGS) {
            let _ = terminal.write_all(b"\x1b[?0u");
        }
        let _ = terminal.write_all(b"\x1b[?62c");
        said.clear();
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // one that has ended is not there to be killed
        let _ = self.child.kill();
        let _ = self.child.wait();
        self.stop_reading();
    }
}
