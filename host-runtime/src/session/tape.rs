//! A session that is recorded while something more important goes on.
//!
//! ```text
//! operator's loop --+
//! camera threads ---+--Feed--> queue, bounded in bytes --> thread "record" --> Writer --> file
//! ```
//!
//! Whoever feeds it waits for no disk: where the queue is full a message is left out and counted
//! ([`Feed::offer`]), unless there is nothing that a wait could delay ([`Feed::put`]). What was left out is
//! told, and written at the end of the file. A disk that fails ends the recording and nothing else.

use super::error::SessionError;
use super::schema::foxglove::{Level, Log, Timestamp};
use super::schema::tetrad::Configuration;
use super::topic::Topic;
use super::writer::{Writer, Written};
use crate::locked::lock;
use std::collections::{BTreeMap, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// What may wait for the disk, bytes: two seconds of two cameras of 640x480 at 30 frames/s in RGB.
const MOST_BYTES: usize = 128 << 20;

/// Buffers that are kept to be filled again: their memory is warm.
const SPARE: usize = 8;

/// What stands before a topic whose messages were left out, in the record at the end.
pub(super) const LEFT_OUT: &str = "left out ";

/// A message that waits.
struct Entry {
    topic: Topic,
    time_us: u64,
    sequence: u32,
    bytes: Vec<u8>,
}

#[derive(Default)]
struct State {
    queue: VecDeque<Entry>,
    bytes: usize,
    spare: Vec<Vec<u8>>,
    left_out: BTreeMap<Topic, u64>,
    /// No more is taken: the tape is being ended, or writing has failed.
    closed: bool,
    failed: Option<SessionError>,
}

struct Shared {
    state: Mutex<State>,
    most_bytes: usize,
    epoch_us: u64,
    /// Something came, or nothing will any more.
    came: Condvar,
    /// Something went.
    went: Condvar,
}

/// Where messages are handed in; cheap to clone.
#[derive(Clone)]
pub struct Feed(Arc<Shared>);

/// A session that is being recorded, on a thread of its own.
pub struct Tape {
    feed: Feed,
    path: PathBuf,
    cameras: Vec<String>,
    thread: Option<JoinHandle<Writer>>,
}

/// What a recording came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recorded {
    /// The file.
    pub written: Written,
    /// Messages that were left out, by the names of their topics.
    pub left_out: BTreeMap<String, u64>,
}

impl Tape {
    /// Creates the file and starts its thread.
    ///
    /// # Errors
    /// [`SessionError::Write`].
    pub fn start(path: &Path, configuration: &Configuration) -> Result<Self, SessionError> {
        Self::bounded(path, configuration, MOST_BYTES)
    }

    fn bounded(path: &Path, configuration: &Configuration, most_bytes: usize) -> Result<Self, SessionError> {
        let writer = Writer::create(path, configuration)?;
        let shared = Shared {
            state: Mutex::default(),
            most_bytes,
            epoch_us: configuration.epoch_us,
            came: Condvar::new(),
            went: Condvar::new(),
        };
        let feed = Feed(Arc::new(shared));
        let theirs = Arc::clone(&feed.0);
        let thread = std::thread::Builder::new()
            .name("record".to_owned())
            .spawn(move || write_all(&theirs, writer))
            .map_err(|cause| SessionError::write(path, cause))?;
        let cameras = configuration.cameras.iter().map(|camera| camera.name.clone()).collect();
        Ok(Self { feed, path: path.to_owned(), cameras, thread: Some(thread) })
    }

    /// Where messages are handed in.
    #[must_use]
    pub const fn feed(&self) -> &Feed {
        &self.feed
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// How many messages were left out so far.
    #[must_use]
    pub fn left_out(&self) -> u64 {
        self.feed.lock().left_out.values().sum()
    }

    /// Whether writing has failed; [`take_failure`](Self::take_failure) has why.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        // nothing else closes it before it is finished
        self.feed.lock().closed
    }

    /// Why writing has failed, once.
    #[must_use]
    pub fn take_failure(&self) -> Option<SessionError> {
        self.feed.lock().failed.take()
    }

    /// Writes what waits, how the session ended (`end`) and what was left out, and closes the file.
    ///
    /// # Errors
    /// [`SessionError::Write`]: why it could not be written, now or before, where that was not taken.
    pub fn finish(mut self, mut end: BTreeMap<String, String>) -> Result<Recorded, SessionError> {
        self.feed.close();
        let writer = match self.thread.take().map(JoinHandle::join) {
            Some(Ok(writer)) => writer,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            // it is taken here alone, and by value
            None => return Ok(Recorded::default()),
        };
        let mut state = self.feed.lock();
        if let Some(failed) = state.failed.take() {
            return Err(failed);
        }
        let left_out: BTreeMap<String, u64> =
            state.left_out.iter().map(|(topic, count)| (topic.name(&self.cameras), *count)).collect();
        drop(state);
        for (name, count) in &left_out {
            end.insert(format!("{LEFT_OUT}{name}"), count.to_string());
        }
        Ok(Recorded { written: writer.finish(end)?, left_out })
    }
}

impl Drop for Tape {
    fn drop(&mut self) {
        self.feed.close();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Feed {
    /// Hands a message in, filled by `fill`, or leaves it out where too much waits already; whether it was
    /// taken. Never waits.
    pub fn offer(&self, topic: Topic, time_us: u64, sequence: u32, fill: impl FnOnce(&mut Vec<u8>)) -> bool {
        let mut state = self.lock();
        if state.closed {
            // what comes after the end is no part of the session
            return false;
        }
        if state.bytes >= self.0.most_bytes {
            *state.left_out.entry(topic).or_default() += 1;
            return false;
        }
        let mut bytes = state.spare.pop().unwrap_or_default();
        drop(state);
        fill(&mut bytes);
        self.push(self.lock(), Entry { topic, time_us, sequence, bytes });
        true
    }

    /// The same for those whom a wait delays nothing: waits until there is room. Whether it was taken,
    /// which it is not once writing has failed.
    pub fn put(&self, topic: Topic, time_us: u64, sequence: u32, fill: impl FnOnce(&mut Vec<u8>)) -> bool {
        let mut state = self.lock();
        while state.bytes >= self.0.most_bytes && !state.closed {
            state = self.0.went.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        drop(state);
        self.offer(topic, time_us, sequence, fill)
    }

    /// Hands in what is small and rare, and without which nothing after it can be replayed: it is taken where
    /// too much waits already, too.
    pub fn insist(&self, topic: Topic, time_us: u64, sequence: u32, message: &impl prost::Message) {
        let (state, bytes) = (self.lock(), message.encode_to_vec());
        if !state.closed {
            self.push(state, Entry { topic, time_us, sequence, bytes });
        }
    }

    /// Hands in a line that somebody should read.
    pub fn log(&self, time_us: u64, level: Level, line: &str) {
        let timestamp = Some(self.timestamp(time_us));
        let log = Log { timestamp, level: level.into(), message: line.to_owned(), name: "tetrad".to_owned() };
        self.message(Topic::Log, time_us, 0, &log);
    }

    /// [`offer`](Self::offer) of a whole message.
    pub fn message(&self, topic: Topic, time_us: u64, sequence: u32, message: &impl prost::Message) {
        self.offer(topic, time_us, sequence, |bytes| {
            bytes.extend_from_slice(&message.encode_to_vec());
        });
    }

    /// A time of the session as Foxglove's messages tell it.
    #[must_use]
    pub fn timestamp(&self, time_us: u64) -> Timestamp {
        Timestamp::of_us(self.0.epoch_us.saturating_add(time_us))
    }

    fn push(&self, mut state: MutexGuard<'_, State>, entry: Entry) {
        state.bytes += entry.bytes.len();
        state.queue.push_back(entry);
        drop(state);
        self.0.came.notify_one();
    }

    fn close(&self) {
        self.lock().closed = true;
        self.0.came.notify_all();
        self.0.went.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.0.state)
    }
}

/// Writes until the tape is closed and nothing waits any more.
fn write_all(shared: &Arc<Shared>, mut writer: Writer) -> Writer {
    let feed = Feed(Arc::clone(shared));
    loop {
        let mut state = feed.lock();
        let entry = loop {
            if let Some(entry) = state.queue.pop_front() {
                break entry;
            }
            if state.closed {
                return writer;
            }
            state = shared.came.wait(state).unwrap_or_else(PoisonError::into_inner);
        };
        drop(state);
        let Entry { topic, time_us, sequence, mut bytes } = entry;
        let written = writer.write(topic, time_us, sequence, &bytes);
        let length = bytes.len();
        bytes.clear();
        let mut state = feed.lock();
        // what is being written counts until it is
        state.bytes = state.bytes.saturating_sub(length);
        if state.spare.len() < SPARE {
            state.spare.push(bytes);
        }
        if let Err(failed) = written {
            state.failed = Some(failed);
            state.closed = true;
            state.queue.clear();
            state.bytes = 0;
        }
        drop(state);
        shared.went.notify_all();
    }
}

#[cfg(test)]
mod tests;
