//! The thread that owns the bus: every period it takes what came, lets the master decide, and sends.
//!
//! ```text
//! reader thread: bus --frames--> channel --> cycle thread: master --frames--> bus
//!                                                ^   |
//!                       enable, stop, set-point  |   v  status, positions, reason, beat
//!                                          port (whoever holds it)
//! ```
//!
//! Whoever drives the arm waits for the beat that ends a cycle ([`Robot::pace`](crate::robot::Robot::pace))
//! and then sends one set-point, which the next cycle takes: two clocks of the same rate would now and
//! then give a cycle two of them and another none, and a drive a step twice as large.
//!
//! Deadlines are absolute: a cycle that began late makes none after it late. After one that was late
//! by more than a period the count begins anew, so that no SYNC is sent in a hurry.

use super::bus::{Bus, Receive, Transmit};
use crate::precedence::{Duty, step_forward};
use crate::robot::lateness::Lateness;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use tetrad_core::arm::canopen::master::{Counters, Master};
use tetrad_core::arm::canopen::{Cause, Frame};
use tetrad_core::arm::port::PortStatus;
use tetrad_core::arm::puma560::Counts;

/// How long the reader waits before it looks whether it is still wanted.
const READ_WITHIN: Duration = Duration::from_millis(50);

/// The most frames that wait for the cycle thread: 0.2 s of a full bus at 1 Mbit/s. Only a bus that is no
/// CAN bus brings more.
const BACKLOG: usize = 4_096;

/// Cycles in which the drives are told to stop when the port is closed: one may go astray.
const LAST_CYCLES: u32 = 3;

/// Opens the bus, and opens it again after it was lost.
pub type Opener = Box<dyn Fn() -> io::Result<Bus> + Send>;

/// What the port asks for; the newest counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    Enable,
    Stop,
}

/// What port and thread tell each other.
#[derive(Debug, Default)]
pub(super) struct Shared {
    pub(super) request: Option<Request>,
    pub(super) confirm_homed: bool,
    pub(super) set_point: Option<Counts>,
    pub(super) status: PortStatus,
    /// When the status last became another.
    pub(super) changed: Option<Instant>,
    pub(super) reason: Option<String>,
    /// Of a lost arm: whether drives are left that hear what they are told.
    pub(super) reachable: bool,
    /// Where the drives were when they became ready, until the port has taken it.
    pub(super) start: Option<Counts>,
    /// Positions, and when the oldest came.
    pub(super) positions: Option<(Counts, Instant)>,
    pub(super) counters: Counters,
    pub(super) unsent: u64,
    /// Frames for which there was no room.
    pub(super) crowded_out: u64,
    /// Bytes since the bus was opened that belong to no frame.
    pub(super) garbage: u64,
    pub(super) lateness: Lateness,
    /// Cycles that took what there was, counting and wrapping.
    pub(super) beats: u64,
}

/// Shared by both; nobody holds the lock while waiting for anything.
#[derive(Clone, Debug, Default)]
pub(super) struct Link {
    shared: Arc<Mutex<Shared>>,
    beat: Arc<Condvar>,
    ended: Arc<AtomicBool>,
}

impl Link {
    pub(super) fn lock(&self) -> MutexGuard<'_, Shared> {
        // plain values are never half written
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until there was another beat than `last`, no longer than until `give_up`; the newest.
    pub(super) fn wait_for_beat(&self, last: u64, give_up: Instant) -> u64 {
        let left = give_up.saturating_duration_since(Instant::now());
        let waited = self.beat.wait_timeout_while(self.lock(), left, |shared| shared.beats == last);
        waited.unwrap_or_else(PoisonError::into_inner).0.beats
    }

    fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    /// Tells the thread to stop the arm and end.
    pub(super) fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

/// Starts the thread on a bus that is open.
///
/// # Errors
/// The system has no thread to give.
pub(super) fn spawn(
    master: Master,
    bus: Bus,
    opener: Opener,
    period: Duration,
    link: &Link,
) -> io::Result<JoinHandle<()>> {
    let line = Line::new(bus, link)?;
    let link = link.clone();
    let start = Instant::now();
    let published = PortStatus::Disabled;
    let cycle = Cycle { master, opener, line: Some(line), link, start, published, lost: String::new() };
    thread::Builder::new().name("canopen-cycle".to_owned()).spawn(move || cycle.run(period))
}

/// A bus in use.
struct Line {
    transmit: Box<dyn Transmit>,
    frames: Receiver<io::Result<Frame>>,
    reader: Option<JoinHandle<()>>,
    wanted: Arc<AtomicBool>,
    /// Bytes that belong to no frame.
    garbage: Arc<AtomicU64>,
}

impl Line {
    fn new(bus: Bus, link: &Link) -> io::Result<Self> {
        let (sender, frames) = sync_channel(BACKLOG);
        let wanted = Arc::new(AtomicBool::new(true));
        let garbage = Arc::new(AtomicU64::new(0));
        let reader = Reader {
            receive: bus.receive,
            frames: sender,
            wanted: Arc::clone(&wanted),
            garbage: Arc::clone(&garbage),
            link: link.clone(),
        };
        let thread = thread::Builder::new().name("canopen-read".to_owned()).spawn(move || reader.run())?;
        Ok(Self { transmit: bus.transmit, frames, reader: Some(thread), wanted, garbage })
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.wanted.store(false, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            // it has nothing to say but frames
            let _ = reader.join();
        }
    }
}

/// The reader thread's own.
struct Reader {
    receive: Box<dyn Receive>,
    frames: SyncSender<io::Result<Frame>>,
    wanted: Arc<AtomicBool>,
    garbage: Arc<AtomicU64>,
    link: Link,
}

impl Reader {
    fn run(mut self) {
        step_forward(Duty::Drive);
        while self.wanted.load(Ordering::Relaxed) && !self.link.has_ended() {
            let received = self.receive.receive(READ_WITHIN);
            self.garbage.store(self.receive.garbage(), Ordering::Relaxed);
            match received {
                Ok(None) => {}
                Ok(Some(frame)) => match self.frames.try_send(Ok(frame)) {
                    Ok(()) => {}
                    Err(TrySendError::Full(_)) => self.link.lock().crowded_out += 1,
                    Err(TrySendError::Disconnected(_)) => return,
                },
                Err(error) => {
                    // the cycle thread lets go of the line when it sees this, or that nobody sends any more
                    let _ = self.frames.try_send(Err(error));
                    return;
                }
            }
        }
    }
}

struct Cycle {
    master: Master,
    opener: Opener,
    line: Option<Line>,
    link: Link,
    start: Instant,
    published: PortStatus,
    /// What the system said when the bus was lost.
    lost: String,
}

impl Cycle {
    fn run(mut self, period: Duration) {
        step_forward(Duty::Drive);
        let mut out = Vec::new();
        let mut deadline = Instant::now() + period;
        let mut left = LAST_CYCLES;
        while left > 0 {
            self.listen_until(deadline);
            let late = deadline.elapsed();
            let ended = self.link.has_ended();
            if ended {
                self.master.stop();
                left -= 1;
            }
            self.step(late, &mut out);
            self.send(&mut out);
            self.link.beat.notify_all();
            deadline = if late > period { Instant::now() + period } else { deadline + period };
        }
    }

    fn now_us(&self) -> u64 {
        // 584,000 years fit
        u64::try_from(self.start.elapsed().as_micros()).unwrap_or(u64::MAX)
    }

    fn listen_until(&mut self, deadline: Instant) {
        // what had come by the deadline is taken, not what goes on coming
        let mut late = 0;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let Some(line) = &self.line else { return thread::sleep(left) };
            if left.is_zero() {
                late += 1;
                if late > BACKLOG {
                    return;
                }
            }
            let heard = line.frames.recv_timeout(left);
            match heard {
                Ok(Ok(frame)) => {
                    let now_us = self.now_us();
                    self.master.receive(now_us, &frame);
                }
                Ok(Err(error)) => self.lose(&error),
                Err(RecvTimeoutError::Timeout) => return,
                Err(RecvTimeoutError::Disconnected) => self.lose(&io::ErrorKind::BrokenPipe.into()),
            }
        }
    }

    fn lose(&mut self, error: &io::Error) {
        self.line = None;
        self.lost = error.to_string();
        self.master.lose_bus();
    }

    /// Why the arm was stopped, in words.
    fn reason(&self) -> Option<String> {
        match self.master.cause()? {
            Cause::Bus => {
                Some(format!("the CAN bus is gone: {}; check adapter and interface, then enable", self.lost))
            }
            _ => self.master.reason().map(|reason| reason.to_string()),
        }
    }

    fn step(&mut self, late: Duration, out: &mut Vec<Frame>) {
        let now_us = self.now_us();
        let link = self.link.clone();
        let request = link.lock().request.take();
        if request == Some(Request::Enable) && self.line.is_none() {
            self.reopen();
        }
        let mut shared = link.lock();
        if std::mem::take(&mut shared.confirm_homed) {
            self.master.confirm_homed();
        }
        let unseen = self.master.status() != self.published
            && matches!(self.master.status(), PortStatus::Fault(_) | PortStatus::Lost);
        match request {
            // what nobody can have read yet is not acknowledged
            Some(Request::Enable) if unseen || self.line.is_none() => {}
            Some(Request::Enable) => self.master.enable(),
            Some(Request::Stop) => self.master.stop(),
            None => {}
        }
        if let Some(counts) = shared.set_point.take() {
            self.master.set_point(counts);
        }
        if let Some(line) = &self.line {
            shared.garbage = line.garbage.load(Ordering::Relaxed);
            self.master.hear_garbage(shared.garbage);
        }
        // under the same lock: whoever writes knows which cycle is the next to take it
        shared.beats = shared.beats.wrapping_add(1);
        self.master.cycle(now_us, out);
        self.publish(&mut shared, late);
    }

    fn publish(&mut self, shared: &mut Shared, late: Duration) {
        let status = self.master.status();
        if status == PortStatus::Ready && self.published != PortStatus::Ready {
            shared.start = Some(self.master.targets());
        }
        if status != PortStatus::Ready {
            shared.start = None;
            shared.set_point = None;
        }
        if status != self.published {
            shared.changed = Some(Instant::now());
        }
        self.published = status;
        // what was asked for in the meantime shows until it is dealt with
        if shared.request.is_none() {
            shared.status = status;
        }
        shared.reachable = self.line.is_some() && self.master.is_partly_lost();
        let reason = self.reason();
        if shared.reason != reason {
            shared.reason = reason;
        }
        let at = |us| self.start + Duration::from_micros(us);
        shared.positions = self.master.positions().map(|(counts, us)| (counts, at(us)));
        shared.counters = self.master.counters();
        shared.lateness.record(u64::try_from(late.as_micros()).unwrap_or(u64::MAX));
    }

    fn send(&mut self, out: &mut Vec<Frame>) {
        if let (Some(line), false) = (&mut self.line, out.is_empty()) {
            match line.transmit.send(out) {
                Ok(sent) => {
                    let unsent = out.len().saturating_sub(sent) as u64;
                    if unsent > 0 {
                        self.link.lock().unsent += unsent;
                    }
                }
                Err(error) => self.lose(&error),
            }
        }
        out.clear();
    }

    fn reopen(&mut self) {
        match (self.opener)().and_then(|bus| Line::new(bus, &self.link)) {
            Ok(line) => self.line = Some(line),
            Err(error) => self.lose(&error),
        }
    }
}
