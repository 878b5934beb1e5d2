//! A smart camera: a microcontroller that tracks by itself and sends observations over a serial port.
//!
//! ```text
//! serial port --bytes--> wire::Decoder --packets--> Receiver --newest--> the operator's loop
//!    ^                                                  +-- thumbnails --> Preview --picture--> the console
//!    | opened again where it went away; told to start wherever nothing comes
//! ```
//!
//! To the operator it is a camera station: its observations come with the times of the station's own
//! clock, and how late the packets are is told by the quickest of them.
//!
//! A program that has such a camera for itself tells it what to do:
//!
//! ```text
//! command --Commander--> serial port --> answers, observations --SmartCamera--> one after the other
//! ```

#[cfg(all(test, unix))]
mod board;
mod commander;
mod receiver;
mod smart_camera;
mod thumbnails;

pub use commander::{Commander, Unanswered};
pub use receiver::{Line, NodeCounts, Receiver};
pub use smart_camera::{Seen, SmartCamera, SmartCameraError};
pub use thumbnails::Pieced;

use super::back_off::BackOff;
use super::newest::Newest;
use super::preview::{Marks, Preview};
use crate::link::{Picture, Received};
use crate::locked::lock;
use crate::robot::clock::Clock;
use serialport::{ClearBuffer, DataBits, FlowControl, Parity, SerialPort, StopBits};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::wire::{Command, Notice, NoticePacket, ObservationPacket};

/// How long a read waits: until then nobody hears of the program's end.
const PATIENCE: Duration = Duration::from_millis(50);

/// A camera that sends nothing for so long is taught and told to start, microseconds: it was just switched on, or
/// stopped.
const SILENCE_US: u64 = 1_000_000;

/// Bytes read at a time: more than a whole packet.
const CHUNK: usize = 512;

/// Pictures of thumbnails a second, at most: faster ones are for nobody.
const MOST_PICTURES: f64 = 15.0;

/// What a smart camera is told.
#[derive(Clone, Copy, Debug)]
pub struct Told {
    /// The program's own session.
    pub session: u32,
    /// What it is taught: only these balls, of which there may be none.
    pub taught: [Option<LearntBall>; BALLS],
    /// A thumbnail of a ball is shown every so many pictures; 0 for none.
    pub preview_every: u16,
}

/// A smart camera on a serial port. Where it is dropped, the port is closed.
pub struct SerialNode {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    newest: Newest,
    counts: Mutex<NodeCounts>,
    /// The newest picture that was not taken.
    picture: Mutex<Option<Received<Picture>>>,
    stop: AtomicBool,
}

impl SerialNode {
    /// Listens at `device` from now on. That nothing is there is no error: it is opened as soon as
    /// there is, and `told` then what it gets. `ring` wakes the operator's loop whenever there are new
    /// observations.
    ///
    /// # Errors
    /// The system has no thread left.
    pub fn start(
        device: &Path,
        baud: u32,
        clock: Clock,
        told: Told,
        ring: impl Fn() + Send + 'static,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared {
            newest: Newest::default(),
            counts: Mutex::default(),
            picture: Mutex::default(),
            stop: AtomicBool::new(false),
        });
        let preview = (told.preview_every > 0).then(|| shared.preview(clock.clone())).transpose()?;
        let listener = Listener {
            device: device.to_owned(),
            baud,
            clock,
            shared: Arc::clone(&shared),
            receiver: Receiver::default(),
            commander: Commander::new(told.session),
            told,
            preview,
            told_us: None,
            back_off: BackOff::default(),
            not_open: String::new(),
        };
        let thread =
            std::thread::Builder::new().name("node".to_owned()).spawn(move || listener.listen(&ring))?;
        Ok(Self { shared, thread: Some(thread) })
    }

    /// The newest observations, if they were not taken yet.
    #[must_use]
    pub fn observation(&self) -> Option<Received<ObservationPacket>> {
        self.shared.newest.take()
    }

    /// The newest picture of what it shows of its balls, if it was not taken yet; as old as the newest thumbnail in it.
    #[must_use]
    pub fn picture(&self) -> Option<Received<Picture>> {
        lock(&self.shared.picture).take()
    }

    /// What the operator should know and was not told yet: a port that went away or came back.
    #[must_use]
    pub fn take_notices(&self) -> Vec<String> {
        self.shared.newest.notices()
    }

    /// What became of what was received.
    #[must_use]
    pub fn counts(&self) -> NodeCounts {
        *self.shared.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for SerialNode {
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Shared {
    /// What draws and encodes the pictures, beside the thread that listens.
    fn preview(self: &Arc<Self>, clock: Clock) -> io::Result<Preview> {
        let shared = Arc::clone(self);
        Preview::start(MOST_PICTURES, Marks::Drawn, move |picture, _, _| {
            // it was taken by this clock: see `Pieced`
            let (received_us, captured_us) = (clock.now_us(), Some(picture.capture_us));
            *lock(&shared.picture) = Some(Received { what: picture, received_us, captured_us });
        })
    }
}

/// The thread's own.
struct Listener {
    device: PathBuf,
    baud: u32,
    clock: Clock,
    shared: Arc<Shared>,
    receiver: Receiver,
    commander: Commander,
    told: Told,
    /// `None` where nothing is shown.
    preview: Option<Preview>,
    /// When it was told to start, last, since the port was opened.
    told_us: Option<u64>,
    back_off: BackOff,
    /// Why the port is not open, as it was told.
    not_open: String,
}

impl Listener {
    fn listen(mut self, ring: &dyn Fn()) {
        while !self.shared.stop.load(Ordering::Relaxed) {
            if let Some(wait) = self.back_off.wait(self.clock.now_us()) {
                std::thread::sleep(wait);
                continue;
            }
            let lost = match open(&self.device, self.baud) {
                Ok(port) => {
                    self.tell("the port is open: it is listened to".to_owned());
                    self.not_open.clear();
                    self.back_off = BackOff::default();
                    match self.read(port, ring) {
                        Ok(()) => return,
                        Err(error) => format!("the port went away ({error}): plug the camera in again"),
                    }
                }
                Err(error) => format!("the port cannot be opened ({error}): plug the camera in"),
            };
            if self.not_open != lost {
                self.tell(format!("{lost}; it is tried again and again"));
                self.not_open = lost;
            }
            self.back_off.failed(self.clock.now_us());
        }
    }

    /// Reads until the end of the program, or of the port.
    fn read(&mut self, mut port: Box<dyn SerialPort>, ring: &dyn Fn()) -> io::Result<()> {
        let line = Line::of(&self.device, self.baud);
        // what came while nobody listened is old
        port.clear(ClearBuffer::Input)?;
        self.receiver.open();
        let mut bytes = [0; CHUNK];
        let mut heard_us = None;
        self.told_us = None;
        while !self.shared.stop.load(Ordering::Relaxed) {
            self.command(&mut *port, heard_us)?;
            let count = match port.read(&mut bytes) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => count,
                Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {
                    continue;
                }
                Err(error) => return Err(error),
            };
            let now_us = self.clock.now_us();
            let came = self.receiver.take(bytes.get(..count).unwrap_or_default(), line, now_us);
            *self.shared.counts.lock().unwrap_or_else(PoisonError::into_inner) = self.receiver.counts();
            if let Some(notice) = self.receiver.take_notice() {
                self.tell(notice);
            }
            if let Some(answer) = self.receiver.take_answer() {
                self.answered(&answer);
            }
            if let Some(preview) = &mut self.preview
                && let Some(picture) = self.receiver.take_picture()
                && let Some(view) = picture.view()
            {
                preview.offer(&view, &picture.packet, &[None; BALLS]);
            }
            if let Some(came) = came {
                heard_us = Some(now_us);
                self.shared.newest.put(came);
                ring();
            }
        }
        Ok(())
    }

    /// Writes the commands that are due. A camera that has sent no observations since the port was opened, or for a
    /// while, is taught, told what to show and to start: it may have been switched off, and have forgotten all.
    fn command(&mut self, port: &mut dyn SerialPort, heard_us: Option<u64>) -> io::Result<()> {
        let now_us = self.clock.now_us();
        let lately =
            |at_us: Option<u64>| at_us.is_some_and(|at_us| now_us.saturating_sub(at_us) < SILENCE_US);
        if self.commander.is_idle() && !lately(heard_us) && !lately(self.told_us) {
            for (ball, learnt) in Ball::ALL.into_iter().zip(self.told.taught) {
                learnt
                    .into_iter()
                    .for_each(|learnt| self.commander.tell(Command::SetReference { ball, learnt }));
            }
            self.commander.tell(Command::Preview { every: self.told.preview_every });
            self.commander.tell(Command::Start);
            self.told_us = Some(now_us);
        }
        // one that does not answer may still send, and is listened to
        match self.commander.due(now_us).unwrap_or_default().map(|frame| port.write_all(&frame)) {
            // it takes nothing just now: it is told again
            Some(Err(error)) if !matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {
                Err(error)
            }
            _ => Ok(()),
        }
    }

    /// Takes an answer; a ball that it cannot be taught is the user's affair.
    fn answered(&mut self, answer: &NoticePacket) {
        if let Some((_, Notice::NotTaught { ball, why })) = self.commander.heard(answer) {
            let why = smart_camera::in_words(&why);
            self.tell(format!("the {} ball was not taught: {why}; learn it anew", ball.name()));
        }
    }

    fn tell(&self, what: String) {
        self.shared.newest.tell([format!("node:serial:{}: {what}", self.device.display())]);
    }
}

/// The port, for one program alone.
fn open(device: &Path, baud: u32) -> Result<Box<dyn SerialPort>, serialport::Error> {
    serialport::new(device.to_string_lossy(), baud)
        .data_bits(DataBits::Eight)
        .parity(Parity::None)
        .stop_bits(StopBits::One)
        .flow_control(FlowControl::None)
        .timeout(PATIENCE)
        .open()
}

#[cfg(all(test, unix))]
mod tests;
