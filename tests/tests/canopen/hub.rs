//! Pseudo terminals joined to one bus: behind each a CAN adapter that speaks the Lawicel protocol.

use serialport::{SerialPort, TTYPort};
use std::io::{Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

struct Port {
    /// Whether a program has opened its channel.
    open: AtomicBool,
    writer: Mutex<TTYPort>,
}

/// Ends its threads when dropped.
pub(crate) struct Hub {
    names: Vec<String>,
    ended: Arc<AtomicBool>,
    cut: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    /// Kept open, so that a terminal outlives the programs that open it.
    _slaves: Vec<TTYPort>,
}

impl Hub {
    pub(crate) fn new(ports: usize) -> Self {
        let mut masters = Vec::new();
        let mut slaves = Vec::new();
        for _ in 0..ports {
            let (mut master, slave) = TTYPort::pair().expect("a pseudo terminal");
            // a program that does not read loses frames, and holds up nobody
            master.set_timeout(Duration::from_millis(20)).expect("a timeout");
            masters.push(master);
            slaves.push(slave);
        }
        let names = slaves.iter().map(|slave| slave.name().expect("a name")).collect();
        let writer = |master: &TTYPort| Mutex::new(master.try_clone_native().expect("a second handle"));
        let shared: Arc<Vec<Port>> = Arc::new(
            masters
                .iter()
                .map(|master| Port { open: AtomicBool::new(false), writer: writer(master) })
                .collect(),
        );
        let (ended, cut) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let serve = |(own, master)| {
            let (shared, ended, cut) = (Arc::clone(&shared), Arc::clone(&ended), Arc::clone(&cut));
            thread::spawn(move || serve(own, master, &shared, &ended, &cut))
        };
        let threads = masters.into_iter().enumerate().map(serve).collect();
        Self { names, ended, cut, threads, _slaves: slaves }
    }

    /// The terminal behind which adapter `port` is.
    pub(crate) fn name(&self, port: usize) -> &str {
        &self.names[port]
    }

    /// From now on nothing gets through.
    pub(crate) fn cut(&self) {
        self.cut.store(true, Ordering::Relaxed);
    }
}

impl Drop for Hub {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            thread.join().expect("the hub");
        }
    }
}

fn serve(own: usize, mut master: TTYPort, ports: &[Port], ended: &AtomicBool, cut: &AtomicBool) {
    let mut buffer = [0; 512];
    let mut line = Vec::new();
    while !ended.load(Ordering::Relaxed) {
        // nothing in 20 ms, or a program that just went away: both are silence
        let count = master.read(&mut buffer).unwrap_or(0);
        let mut replies = Vec::new();
        let mut frames = Vec::new();
        for byte in &buffer[..count] {
            line.push(*byte);
            if *byte == b'\r' {
                match line[0] {
                    b'O' => ports[own].open.store(true, Ordering::Relaxed),
                    b'C' => ports[own].open.store(false, Ordering::Relaxed),
                    b't' => frames.extend_from_slice(&line),
                    _ => {}
                }
                replies.extend_from_slice(if line[0] == b't' { b"z\r" } else { b"\r" });
                line.clear();
            }
        }
        let write = |port: &Port, bytes: &[u8]| {
            // what is not taken is lost, as on any adapter
            let _ = port.writer.lock().unwrap_or_else(PoisonError::into_inner).write_all(bytes);
        };
        if !replies.is_empty() {
            write(&ports[own], &replies);
        }
        if !frames.is_empty() && !cut.load(Ordering::Relaxed) {
            for (_, port) in ports.iter().enumerate().filter(|(other, _)| *other != own) {
                if port.open.load(Ordering::Relaxed) {
                    write(port, &frames);
                }
            }
        }
    }
}
