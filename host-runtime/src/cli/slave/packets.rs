//! Where a slave's commands come from: a pipe, or a file at the pace at which it was recorded.

use crate::exit::{Exit, Failure};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::{Duration, Instant};
use tetrad_core::wire::{DecodeError, Decoder, MotionPacket, Packet};

/// Packets that may wait to be looked at. The loop empties the queue every cycle; what does not fit
/// is newer than what a stalled loop will want to see, and counted.
const QUEUE: usize = 1024;

/// Bytes read at once.
const CHUNK: usize = 4096;

/// The longest pause of a recording that is waited for.
const LONGEST_PAUSE: Duration = Duration::from_secs(60);

/// Where packets come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// Standard input: as they come.
    Pipe,
    /// A file: at the pace of its capture times.
    File(PathBuf),
}

/// A packet, and when it came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    pub(super) packet: MotionPacket,
    pub(super) at: Instant,
}

/// How a stream of packets stands.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "looked at where it is made, never kept")]
pub(super) enum Next {
    Packet(Arrival),
    /// None for now.
    Nothing,
    /// The other end went away; the error, if it was one.
    Ended(Option<io::Error>),
}

/// Packets that are read by a thread of their own.
pub(super) struct Packets {
    /// Until it begins to read.
    reader: Option<Reader>,
    arrivals: Receiver<Result<Arrival, io::Error>>,
    counts: Arc<Counts>,
    failed: Option<io::Error>,
}

#[derive(Debug, Default)]
struct Counts {
    damaged: AtomicU64,
    foreign: AtomicU64,
    impossible: AtomicU64,
    crowded_out: AtomicU64,
    first_foreign: OnceLock<DecodeError>,
}

/// What came and never got to the arm.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Losses {
    /// Frames whose bytes were changed or lost on the way.
    pub damaged: u64,
    /// Whole frames that this program does not understand: those of another version, say.
    pub foreign: u64,
    /// Packets that were understood and may not be used.
    pub impossible: u64,
    /// Packets for which there was no room.
    pub crowded_out: u64,
    /// Why the first of the foreign ones was not understood.
    pub first_foreign: Option<DecodeError>,
}

impl Packets {
    /// Opens what packets are to be read from.
    ///
    /// # Errors
    /// [`Failure`] naming a file that cannot be read.
    pub(super) fn open(origin: &Origin) -> Result<Self, Failure> {
        let (input, paced): (Box<dyn Read + Send>, bool) = match origin {
            Origin::Pipe => (Box::new(io::stdin()), false),
            Origin::File(path) => (Box::new(open(path)?), true),
        };
        let (sender, arrivals) = sync_channel(QUEUE);
        let counts = Arc::new(Counts::default());
        let reader = Reader { input, paced, sender, counts: Arc::clone(&counts), pace: None };
        let mut packets = Self { reader: Some(reader), arrivals, counts, failed: None };
        if !paced {
            // a pipe that nobody empties would hold up whoever fills it
            packets.begin();
        }
        Ok(packets)
    }

    /// Begins to read, a recording from its beginning on.
    pub(super) fn begin(&mut self) {
        if let Some(reader) = self.reader.take() {
            thread::spawn(move || reader.run());
        }
    }

    /// The next packet that has come.
    pub(super) fn next(&mut self) -> Next {
        match self.arrivals.try_recv() {
            Ok(Ok(arrival)) => Next::Packet(arrival),
            Ok(Err(error)) => {
                self.failed = Some(error);
                Next::Nothing
            }
            Err(TryRecvError::Empty) => Next::Nothing,
            Err(TryRecvError::Disconnected) => Next::Ended(self.failed.take()),
        }
    }

    /// What came and was dropped, so far.
    pub(super) fn losses(&self) -> Losses {
        let count = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        Losses {
            damaged: count(&self.counts.damaged),
            foreign: count(&self.counts.foreign),
            impossible: count(&self.counts.impossible),
            crowded_out: count(&self.counts.crowded_out),
            first_foreign: self.counts.first_foreign.get().copied(),
        }
    }
}

impl Counts {
    fn not_a_packet(&self, error: DecodeError) {
        let counter = match error {
            DecodeError::BadFraming | DecodeError::Overlong | DecodeError::TooShort | DecodeError::BadCrc => {
                &self.damaged
            }
            DecodeError::UnknownVersion(_)
            | DecodeError::UnknownKind(_)
            | DecodeError::MalformedBody
            | DecodeError::TrailingBytes => {
                self.first_foreign.get_or_init(|| error);
                &self.foreign
            }
            DecodeError::Value(_) => &self.impossible,
        };
        counter.fetch_add(1, Ordering::Relaxed);
    }
}

fn open(path: &Path) -> Result<File, Failure> {
    File::open(path).map_err(|cause| {
        let cause = anyhow::Error::new(cause).context(format!("cannot read {}", path.display()));
        Failure::new(Exit::BadArguments, cause)
            .help("--packets takes a file that `tetrad track --packets` wrote, or - for standard input")
    })
}

/// What the thread works with.
struct Reader {
    input: Box<dyn Read + Send>,
    paced: bool,
    sender: SyncSender<Result<Arrival, io::Error>>,
    counts: Arc<Counts>,
    /// When the recording began here, and on its own clock.
    pace: Option<(Instant, u64)>,
}

impl Reader {
    fn run(mut self) {
        let mut decoder = Decoder::new();
        let mut chunk = vec![0; CHUNK];
        loop {
            let length = match self.input.read(&mut chunk) {
                Ok(0) => return,
                Ok(length) => length,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => {
                    // a loop that is gone needs no reason
                    let _ = self.sender.send(Err(error));
                    return;
                }
            };
            for packet in decoder.packets(chunk.get(..length).unwrap_or_default()) {
                match packet {
                    Ok(Packet::Motion(packet)) => {
                        if !self.deliver(packet) {
                            return;
                        }
                    }
                    // what cameras saw is for somebody else
                    Ok(
                        Packet::Observation(_)
                        | Packet::ArmState(_)
                        | Packet::Buttons(_)
                        | Packet::Command(_)
                        | Packet::Notice(_)
                        | Packet::Preview(_)
                        | Packet::Shown(_),
                    ) => {}
                    Err(error) => self.counts.not_a_packet(error),
                }
            }
        }
    }

    /// Hands a packet over when its time has come; whether anybody still wants it.
    fn deliver(&mut self, packet: MotionPacket) -> bool {
        if self.paced {
            let (began, first_us) = *self.pace.get_or_insert((Instant::now(), packet.capture_us));
            let due = Duration::from_micros(packet.capture_us.saturating_sub(first_us));
            let pause = due.saturating_sub(began.elapsed());
            if pause > LONGEST_PAUSE {
                // a clock that leapt: go on from here
                self.pace = Some((Instant::now(), packet.capture_us));
            } else {
                thread::sleep(pause);
            }
        }
        match self.sender.try_send(Ok(Arrival { packet, at: Instant::now() })) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.counts.crowded_out.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}
