//! A session's file read from its beginning, message by message, as far as it goes.
//!
//! A file that ends before its end (the power was cut, the disk was full) is read up to its last whole
//! chunk, and [`Reader::cut`] says so. A chunk whose bytes are not those that were written is an error:
//! nothing of it is handed out.

use super::configuration::Beginning;
use super::error::SessionError;
use super::schema::tetrad::Configuration;
use super::topic::Topic;
use crate::regular_file;
use mcap::parse_record;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use prost::Message as _;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Bytes before a record's body: its kind and its length.
pub(super) const HEAD: usize = 9;

/// One message of a topic that is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its topic.
    pub topic: Topic,
    /// When, microseconds by the session's clock.
    pub time_us: u64,
    /// The picture's number where it is one, else the place in its topic.
    pub sequence: u32,
    /// Where in the file the chunk that it stands in begins.
    pub at: u64,
    /// The message.
    pub bytes: Vec<u8>,
}

/// A session's file, read from its beginning.
pub struct Reader {
    path: PathBuf,
    records: Records<Box<dyn Read + Send>>,
    beginning: Beginning,
    names: Vec<String>,
    version: String,
    topics: BTreeMap<u16, Option<Topic>>,
    /// How the session ended, as its last record says.
    end: Option<BTreeMap<String, String>>,
}

impl Reader {
    /// Opens a session and reads what it began with.
    ///
    /// # Errors
    /// A file that cannot be read, is no MCAP or no session of this program, or is damaged.
    pub fn open(path: &Path) -> Result<Self, SessionError> {
        let read = |cause| SessionError::Read { path: path.to_owned(), cause };
        let file = regular_file::open(path).map_err(read)?;
        let length = file.metadata().map_err(read)?.len();
        Self::of(file, length, path)
    }

    /// The same of bytes from anywhere, `length` of them; `path` is only for messages.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn of(input: impl Read + Send + 'static, length: u64, path: &Path) -> Result<Self, SessionError> {
        let mut records = Records::new(Box::new(input) as Box<dyn Read + Send>, length);
        let mut topics = BTreeMap::new();
        let configuration = loop {
            match records.next(path)? {
                Some(Found::Channel { id, topic, encoding }) => {
                    let first = topic == Topic::Configuration.name(&[]) && encoding == "protobuf";
                    topics.insert(id, first.then_some(Topic::Configuration));
                }
                Some(Found::Message { channel, bytes, at, .. }) => {
                    if let Some(Some(Topic::Configuration)) = topics.get(&channel) {
                        break Configuration::decode(bytes.as_slice())
                            .map_err(|error| damaged(path, at, format!("/configuration: {error}")))?;
                    }
                    return Err(SessionError::not_a_session(
                        path,
                        "an MCAP file of another program: it does not begin with a /configuration; give a recording of `tetrad record` or `tetrad operator --record`",
                    ));
                }
                Some(Found::End(_)) => {}
                None => {
                    let reason = if records.cut {
                        "cut short before anything was recorded: there is nothing in it to be had"
                    } else {
                        "an MCAP file without a single message: give a recording of `tetrad record` or `tetrad operator --record`"
                    };
                    return Err(SessionError::not_a_session(path, reason));
                }
            }
        };
        let version = configuration.version.clone();
        let beginning = Beginning::of(&configuration).map_err(|reason| {
            let reason = format!(
                "what the session began with cannot be understood: {reason}; it was recorded by tetrad {version}"
            );
            SessionError::not_a_session(path, reason)
        })?;
        let names = beginning.names();
        Ok(Self { path: path.to_owned(), records, beginning, names, version, topics, end: None })
    }

    /// What the session began with.
    #[must_use]
    pub const fn beginning(&self) -> &Beginning {
        &self.beginning
    }

    /// The version of the program that recorded it.
    #[must_use]
    pub fn version(&self) -> &str {
        &self.version
    }

    /// The file.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The cameras' names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether the file ended before its end; known once [`next_entry`](Self::next_entry) has given `None`.
    #[must_use]
    pub const fn cut(&self) -> bool {
        self.records.cut
    }

    /// How the session ended, as its last record says; known once [`next_entry`](Self::next_entry) has
    /// given `None`.
    #[must_use]
    pub const fn end(&self) -> Option<&BTreeMap<String, String>> {
        self.end.as_ref()
    }

    /// How much of the file was read, bytes.
    #[must_use]
    pub const fn taken(&self) -> u64 {
        self.records.taken
    }

    /// The next message of a topic that is known.
    ///
    /// # Errors
    /// [`SessionError::Damaged`] or [`SessionError::Read`].
    pub fn next_entry(&mut self) -> Result<Option<Entry>, SessionError> {
        while let Some(found) = self.records.next(&self.path)? {
            match found {
                Found::Channel { id, topic, encoding } => {
                    let known = Topic::of_name(&topic, &self.names).filter(|_| encoding == "protobuf");
                    self.topics.insert(id, known);
                }
                Found::Message { channel, time_ns, sequence, bytes, at } => {
                    if let Some(Some(topic)) = self.topics.get(&channel) {
                        let time_us = (time_ns / 1_000).saturating_sub(self.beginning.epoch_us);
                        return Ok(Some(Entry { topic: *topic, time_us, sequence, at, bytes }));
                    }
                }
                Found::End(end) => self.end = Some(end),
            }
        }
        Ok(None)
    }

    /// The message in an entry.
    ///
    /// # Errors
    /// [`SessionError::Damaged`] where it is none.
    pub fn decode<M: prost::Message + Default>(&self, entry: &Entry) -> Result<M, SessionError> {
        M::decode(entry.bytes.as_slice()).map_err(|error| {
            damaged(&self.path, entry.at, format!("{}: {error}", entry.topic.name(&self.names)))
        })
    }
}

pub(super) fn damaged(path: &Path, at: u64, reason: String) -> SessionError {
    SessionError::Damaged { path: path.to_owned(), at, reason }
}

/// A file whose chunks would first have to be unpacked.
pub(super) fn compressed(path: &Path, how: &str) -> SessionError {
    let reason = format!(
        "its chunks are compressed ({how}), which is not read here: unpack it with `mcap decompress {} -o plain.mcap`",
        path.display()
    );
    SessionError::not_a_session(path, reason)
}

/// What is of interest in a file.
enum Found {
    Channel { id: u16, topic: String, encoding: String },
    Message { channel: u16, time_ns: u64, sequence: u32, bytes: Vec<u8>, at: u64 },
    End(BTreeMap<String, String>),
}

/// The longest chunk that is read, bytes, and the longest record: ours end with the picture that makes them longer
/// than 2 MiB, and no picture is longer than 8192 x 8192 pixels of three bytes.
pub(super) const LONGEST_CHUNK: u64 = 256 << 20;

/// The records of a file, those in chunks as well.
struct Records<R> {
    input: R,
    length: u64,
    linear: LinearReader,
    /// What is left of the chunk that is being read, and where in it the next record begins.
    chunk: Vec<u8>,
    place: usize,
    /// Bytes taken from the input.
    taken: u64,
    /// Where the chunk begins.
    at: u64,
    over: bool,
    cut: bool,
}

impl<R: Read> Records<R> {
    fn new(input: R, length: u64) -> Self {
        // none is asked memory for that is longer than the file, or than any that is written: a file of 3 GB may
        // take 4 kB on the disk
        let longest = usize::try_from(length.min(LONGEST_CHUNK)).unwrap_or(usize::MAX);
        let options = LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(longest);
        let linear = LinearReader::new_with_options(options);
        Self { input, length, linear, chunk: Vec::new(), place: 0, taken: 0, at: 0, over: false, cut: false }
    }

    fn next(&mut self, path: &Path) -> Result<Option<Found>, SessionError> {
        loop {
            while self.place < self.chunk.len() {
                if let Some(found) = self.in_chunk(path)? {
                    return Ok(Some(found));
                }
            }
            if self.over {
                return Ok(None);
            }
            if let Some(found) = self.in_file(path)? {
                return Ok(Some(found));
            }
        }
    }

    /// The next record of the chunk.
    fn in_chunk(&mut self, path: &Path) -> Result<Option<Found>, SessionError> {
        let short = || damaged(path, self.at, "a record of the chunk is longer than the chunk".to_owned());
        let rest = self.chunk.get(self.place..).unwrap_or_default();
        let (head, body) = rest.split_first_chunk::<HEAD>().ok_or_else(short)?;
        let [opcode, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).map_err(|_| short())?;
        let body = body.get(..length).ok_or_else(short)?;
        let found = found(opcode, body, self.at).map_err(|reason| damaged(path, self.at, reason))?;
        self.place += HEAD + length;
        Ok(found)
    }

    /// The next record of the file; a chunk is kept to be read.
    fn in_file(&mut self, path: &Path) -> Result<Option<Found>, SessionError> {
        let at = self.taken;
        match self.linear.next_event() {
            None => self.over = true,
            Some(Ok(LinearReadEvent::ReadRequest(wanted))) => {
                let room = self.linear.insert(wanted);
                let read = self.input.read(room);
                let read = read.map_err(|cause| SessionError::Read { path: path.to_owned(), cause })?;
                self.linear.notify_read(read);
                self.taken += read as u64;
            }
            Some(Ok(LinearReadEvent::Record { opcode: op::CHUNK, data })) => {
                self.at = at.saturating_sub((HEAD + data.len()) as u64);
                let wrong = |reason: String| damaged(path, self.at, reason);
                self.place = 0;
                self.chunk.clear();
                match parse_record(op::CHUNK, data).map_err(|error| wrong(error.to_string()))? {
                    Record::Chunk { header, data } => {
                        if !header.compression.is_empty() {
                            return Err(compressed(path, &header.compression));
                        }
                        if header.uncompressed_crc != 0 && crc32fast::hash(&data) != header.uncompressed_crc {
                            return Err(wrong("its check sum is not that of its bytes".to_owned()));
                        }
                        self.chunk.extend_from_slice(&data);
                    }
                    _ => return Err(wrong("no chunk where there should be one".to_owned())),
                }
            }
            Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                if opcode == op::FOOTER {
                    // what follows is eight bytes that say so
                    self.over = true;
                }
                let begins = at.saturating_sub((HEAD + data.len()) as u64);
                return found(opcode, data, begins).map_err(|reason| damaged(path, begins, reason));
            }
            Some(Err(error)) => {
                self.over = true;
                return match error {
                    mcap::McapError::UnexpectedEof if self.taken >= 8 => {
                        self.cut = true;
                        Ok(None)
                    }
                    mcap::McapError::UnexpectedEof | mcap::McapError::BadMagic => {
                        Err(SessionError::NotMcap { path: path.to_owned() })
                    }
                    mcap::McapError::RecordTooLarge { len, .. } | mcap::McapError::ChunkTooLarge(len) => {
                        if len <= self.length.saturating_sub(self.taken) {
                            let reason = format!("a record of {len} bytes, longer than any that is written");
                            return Err(damaged(path, at, reason));
                        }
                        // it reaches beyond the end of the file
                        self.cut = true;
                        Ok(None)
                    }
                    error => Err(damaged(path, at, error.to_string())),
                };
            }
        }
        Ok(None)
    }
}

/// What a record holds that is of interest.
fn found(opcode: u8, body: &[u8], at: u64) -> Result<Option<Found>, String> {
    if !matches!(opcode, op::CHANNEL | op::MESSAGE | op::METADATA) {
        return Ok(None);
    }
    Ok(match parse_record(opcode, body).map_err(|error| error.to_string())? {
        Record::Channel(channel) => {
            Some(Found::Channel { id: channel.id, topic: channel.topic, encoding: channel.message_encoding })
        }
        Record::Message { header, data } => Some(Found::Message {
            channel: header.channel_id,
            time_ns: header.log_time,
            sequence: header.sequence,
            bytes: data.into_owned(),
            at,
        }),
        Record::Metadata(metadata) if metadata.name == super::writer::END => {
            Some(Found::End(metadata.metadata))
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests;
