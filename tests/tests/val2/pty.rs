//! The controller at the other end of a pseudo-terminal.

use super::controller::Controller;
use serialport::TTYPort;
use std::io::{Read, Write};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// A running emulator. Its device has a name that stays when it is unplugged and plugged in again.
pub(crate) struct Emulator {
    controller: Arc<Mutex<Controller>>,
    /// Printed unasked.
    unasked: Arc<Mutex<Vec<u8>>>,
    unplugged: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    folder: tempfile::TempDir,
}

impl Emulator {
    pub(crate) fn start(controller: Controller) -> Self {
        let mut emulator = Self {
            controller: Arc::new(Mutex::new(controller)),
            unasked: Arc::default(),
            unplugged: Arc::default(),
            thread: None,
            folder: tempfile::tempdir().expect("a folder"),
        };
        emulator.plug();
        emulator
    }

    pub(crate) fn device(&self) -> PathBuf {
        self.folder.path().join("ttyVAL")
    }

    pub(crate) fn address(&self, settings: &str) -> String {
        format!("val2:{}?{settings}", self.device().display())
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn controller(&self) -> MutexGuard<'_, Controller> {
        self.controller.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How many moves there were, and lines typed.
    pub(crate) fn so_far(&self) -> (usize, usize) {
        let controller = self.controller();
        (controller.visited.len(), controller.typed.len())
    }

    /// Has the controller do something, and sends what it prints.
    pub(crate) fn with(&self, act: impl FnOnce(&mut Controller) -> Vec<u8>) {
        let printed = act(&mut self.controller());
        self.unasked.lock().unwrap_or_else(PoisonError::into_inner).extend(printed);
    }

    /// Pulls the cable.
    pub(crate) fn unplug(&mut self) {
        self.unplugged.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            thread.join().expect("the emulator");
        }
        let _ = std::fs::remove_file(self.device());
    }

    /// Puts it in again.
    pub(crate) fn plug(&mut self) {
        let (master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        let name = serialport::SerialPort::name(&slave).expect("its name");
        symlink(name, self.device()).expect("a name for it");
        self.unplugged.store(false, Ordering::Release);
        let (controller, unasked) = (Arc::clone(&self.controller), Arc::clone(&self.unasked));
        let unplugged = Arc::clone(&self.unplugged);
        self.thread = Some(thread::spawn(move || serve(master, slave, &controller, &unasked, &unplugged)));
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.unplug();
    }
}

/// `_slave` keeps the terminal alive while no program has it open.
fn serve(
    mut master: TTYPort,
    _slave: TTYPort,
    controller: &Mutex<Controller>,
    unasked: &Mutex<Vec<u8>>,
    unplugged: &AtomicBool,
) {
    let mut buffer = [0; 256];
    serialport::SerialPort::set_timeout(&mut master, Duration::from_millis(1)).expect("a timeout");
    while !unplugged.load(Ordering::Acquire) {
        let count = master.read(&mut buffer).unwrap_or(0);
        let mut out = controller.lock().unwrap_or_else(PoisonError::into_inner).hear(&buffer[..count]);
        out.append(&mut unasked.lock().unwrap_or_else(PoisonError::into_inner));
        // nobody reads: like a real line, it is lost
        let _ = master.write_all(&out);
    }
}
