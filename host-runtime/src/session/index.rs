//! Where in a session's file which message stands: for whoever looks at one moment of it, and not at all.
//!
//! The file is not read for that. From record to record only the heads are, and the list of messages that
//! stands behind each chunk; so a file that was cut short, or is being written, has an index too, as far as
//! its last whole chunk. What is looked at is read by the chunk, and only where the chunk's check sum fits.

use super::configuration::Beginning;
use super::error::SessionError;
use super::reader::{HEAD, LONGEST_CHUNK, Reader, compressed, damaged};
use super::topic::Topic;
use crate::regular_file;
use mcap::parse_record;
use mcap::records::{Record, op};
use std::borrow::Cow;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// The most messages that are kept track of: four hours of two cameras and an arm, 64 MB.
const MOST_MESSAGES: usize = 4 << 20;

/// The longest list of a chunk's messages, bytes: a million of one topic.
const LONGEST_LIST: u64 = 16 << 20;

/// Chunks that are kept after they were read: what belongs to one moment stands in one or two.
const KEPT: usize = 3;

/// What every MCAP file begins with, bytes.
const MAGIC: u64 = 8;

/// Of a chunk, before its bytes: two times, a length and a check sum; then the length of its compression's
/// name, which is none, and the length again.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// One message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    /// When, microseconds by the session's clock.
    pub time_us: u64,
    chunk: u32,
    /// From the chunk's first byte.
    offset: u32,
}

/// A chunk that was passed.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    /// Where its bytes begin.
    data: u64,
    length: u64,
    crc: u32,
}

/// Where a session's messages stand in its file.
#[derive(Debug)]
pub struct Index {
    path: PathBuf,
    beginning: Beginning,
    version: String,
    names: Vec<String>,
    chunks: Vec<Chunk>,
    spots: BTreeMap<Topic, Vec<Spot>>,
    cut: bool,
}

impl Index {
    /// Goes through the file of `reader`, `length` bytes of it.
    fn of_file(reader: &Reader, file: impl Read + Seek, length: u64) -> Result<Self, SessionError> {
        let index = Self {
            path: reader.path().to_owned(),
            beginning: reader.beginning().clone(),
            version: reader.version().to_owned(),
            names: reader.names().to_vec(),
            chunks: Vec::new(),
            spots: BTreeMap::new(),
            cut: false,
        };
        Walk { index, file: BufReader::new(file), length, topics: BTreeMap::new() }.go()
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

    /// The cameras' names.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether the file has no end: it was cut short, or is being written.
    #[must_use]
    pub const fn cut(&self) -> bool {
        self.cut
    }

    /// Every topic that there is something of.
    pub fn topics(&self) -> impl Iterator<Item = (Topic, &[Spot])> {
        self.spots.iter().map(|(topic, spots)| (*topic, spots.as_slice()))
    }

    /// A topic's messages, in the order of their times.
    #[must_use]
    pub fn of(&self, topic: Topic) -> &[Spot] {
        self.spots.get(&topic).map_or(&[], Vec::as_slice)
    }

    /// The last message of a topic at that time or before.
    #[must_use]
    pub fn last(&self, topic: Topic, time_us: u64) -> Option<Spot> {
        let spots = self.of(topic);
        let after = spots.partition_point(|spot| spot.time_us <= time_us);
        spots.get(after.checked_sub(1)?).copied()
    }

    /// The times of the first message and of the last, microseconds.
    #[must_use]
    pub fn span_us(&self) -> Option<(u64, u64)> {
        let first = self.spots.values().filter_map(|spots| spots.first()).map(|spot| spot.time_us).min()?;
        let last = self.spots.values().filter_map(|spots| spots.last()).map(|spot| spot.time_us).max()?;
        Some((first, last))
    }
}

/// An index that is being made.
struct Walk<F> {
    index: Index,
    file: BufReader<F>,
    length: u64,
    topics: BTreeMap<u16, Option<Topic>>,
}

impl<F: Read + Seek> Walk<F> {
    fn go(mut self) -> Result<Index, SessionError> {
        let mut at = MAGIC;
        self.index.cut = !self.all(&mut at)?;
        for spots in self.index.spots.values_mut() {
            // as good as sorted already: a topic's messages come as they are made
            spots.sort_by_key(|spot| spot.time_us);
        }
        Ok(self.index)
    }

    /// Record after record; whether the file has an end.
    fn all(&mut self, at: &mut u64) -> Result<bool, SessionError> {
        loop {
            let mut head = [0; HEAD];
            if self.length.saturating_sub(*at) < HEAD as u64 {
                return Ok(false);
            }
            self.seek(*at)?;
            self.fill(&mut head)?;
            let [opcode, length @ ..] = head;
            let body = *at + HEAD as u64;
            let length = u64::from_le_bytes(length);
            let next = body.checked_add(length).filter(|next| *next <= self.length);
            let Some(next) = next else { return Ok(false) };
            match opcode {
                op::CHUNK => self.chunk(*at, body, length)?,
                op::MESSAGE_INDEX => self.list(*at, length)?,
                op::DATA_END | op::FOOTER => return Ok(true),
                _ => {}
            }
            *at = next;
        }
    }

    fn chunk(&mut self, at: u64, body: u64, length: u64) -> Result<(), SessionError> {
        let mut head = [0; CHUNK_HEAD];
        if length < head.len() as u64 {
            return Err(self.damaged(at, "a chunk is shorter than its head"));
        }
        self.fill(&mut head)?;
        let number = |from: usize, bytes: usize| {
            head.iter().skip(from).take(bytes).rev().fold(0, |all, byte| all << 8 | u64::from(*byte))
        };
        let (name, crc) = (number(28, 4), number(24, 4));
        if name != 0 {
            let mut name = vec![0; usize::try_from(name.min(8)).unwrap_or(0)];
            self.seek(body + 32)?;
            self.fill(&mut name)?;
            return Err(compressed(&self.index.path, &String::from_utf8_lossy(&name)));
        }
        let bytes = number(32, 8);
        if bytes != length - head.len() as u64 || bytes > LONGEST_CHUNK {
            return Err(self.damaged(at, "a chunk's length is not that of its bytes, or beyond 256 MiB"));
        }
        let data = body + head.len() as u64;
        self.index.chunks.push(Chunk { data, length: bytes, crc: crc as u32 });
        Ok(())
    }

    /// Where the messages of one topic stand in the chunk before.
    fn list(&mut self, at: u64, length: u64) -> Result<(), SessionError> {
        if length > LONGEST_LIST {
            return Err(self.damaged(at, "a list of messages is longer than 16 MiB"));
        }
        let mut body = vec![0; usize::try_from(length).unwrap_or(0)];
        self.fill(&mut body)?;
        let list = match parse_record(op::MESSAGE_INDEX, &body) {
            Ok(Record::MessageIndex(list)) => list,
            Ok(_) => return Err(self.damaged(at, "no list of messages where there should be one")),
            Err(error) => return Err(self.damaged(at, error.to_string())),
        };
        let Some(chunk) = self.index.chunks.len().checked_sub(1) else { return Ok(()) };
        if !self.topics.contains_key(&list.channel_id) {
            self.channels(chunk)?;
        }
        let Some(Some(topic)) = self.topics.get(&list.channel_id) else { return Ok(()) };
        let epoch_us = self.index.beginning.epoch_us;
        let spots = list.records.iter().filter_map(|entry| {
            let time_us = (entry.log_time / 1_000).saturating_sub(epoch_us);
            Some(Spot {
                time_us,
                chunk: u32::try_from(chunk).ok()?,
                offset: u32::try_from(entry.offset).ok()?,
            })
        });
        self.index.spots.entry(*topic).or_default().extend(spots);
        if self.index.spots.values().map(Vec::len).sum::<usize>() > MOST_MESSAGES {
            let reason = "more than four million messages are in it, too many to be looked at: `tetrad replay --export-csv` reads it all";
            return Err(SessionError::not_a_session(&self.index.path, reason));
        }
        Ok(())
    }

    /// The channels that begin in a chunk: what its lists call them by.
    fn channels(&mut self, chunk: usize) -> Result<(), SessionError> {
        let Some(Chunk { data, length, .. }) = self.index.chunks.get(chunk).copied() else { return Ok(()) };
        let back = self.file.stream_position().map_err(|cause| self.unread(cause))?;
        let end = data + length;
        let mut at = data;
        while end.saturating_sub(at) >= HEAD as u64 {
            let mut head = [0; HEAD];
            self.seek(at)?;
            self.fill(&mut head)?;
            let [opcode, length @ ..] = head;
            let length = u64::from_le_bytes(length);
            let body = at + HEAD as u64;
            let Some(next) = body.checked_add(length).filter(|next| *next <= end) else {
                return Err(self.damaged(at, "a record of the chunk is longer than the chunk"));
            };
            if opcode == op::CHANNEL && length <= LONGEST_LIST {
                let mut body = vec![0; usize::try_from(length).unwrap_or(0)];
                self.fill(&mut body)?;
                if let Ok(Record::Channel(channel)) = parse_record(op::CHANNEL, &body) {
                    let known =
                        Topic::of_name(&channel.topic, &self.index.names).filter(|topic| is_kept(*topic));
                    let known = known.filter(|_| channel.message_encoding == "protobuf");
                    self.topics.insert(channel.id, known);
                }
            }
            at = next;
        }
        self.seek(back)
    }

    fn seek(&mut self, at: u64) -> Result<(), SessionError> {
        // what is near stays in the buffer
        let here = self.file.stream_position().map_err(|cause| self.unread(cause))?;
        let by = i64::try_from(at).ok().zip(i64::try_from(here).ok()).map(|(at, here)| at - here);
        let done = match by {
            Some(by) => self.file.seek_relative(by),
            None => self.file.seek(SeekFrom::Start(at)).map(drop),
        };
        done.map_err(|cause| self.unread(cause))
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), SessionError> {
        self.file.read_exact(bytes).map_err(|cause| self.unread(cause))
    }

    fn unread(&self, cause: std::io::Error) -> SessionError {
        SessionError::Read { path: self.index.path.clone(), cause }
    }

    fn damaged(&self, at: u64, reason: impl Into<String>) -> SessionError {
        damaged(&self.index.path, at, reason.into())
    }
}

/// What a page shows of a session; the rest of it says the same for other programs.
const fn is_kept(topic: Topic) -> bool {
    match topic {
        Topic::Image(_)
        | Topic::Observations(_)
        | Topic::Taught(_)
        | Topic::HandBegins
        | Topic::Hand
        | Topic::Buttons
        | Topic::Arm
        | Topic::Delays
        | Topic::Log => true,
        Topic::Configuration
        | Topic::Annotations(_)
        | Topic::Instant
        | Topic::Pose
        | Topic::Filtered
        | Topic::Command
        | Topic::Joints
        | Topic::SetPoint
        | Topic::Transforms => false,
    }
}

/// Reads the messages of an [`Index`].
#[derive(Debug)]
pub struct Lookup<F = File> {
    index: Index,
    file: F,
    /// The last chunks, the newest at the end.
    chunks: VecDeque<(u32, Vec<u8>)>,
}

impl Lookup {
    /// Goes through a session.
    ///
    /// # Errors
    /// As [`Reader::open`], and a file whose records do not follow one another.
    pub fn open(path: &Path) -> Result<Self, SessionError> {
        let reader = Reader::open(path)?;
        let read = |cause| SessionError::Read { path: path.to_owned(), cause };
        let file = regular_file::open(path).map_err(read)?;
        let length = file.metadata().map_err(read)?.len();
        Self::of(&reader, file, length)
    }
}

impl<F: Read + Seek> Lookup<F> {
    /// The same of bytes from anywhere, `length` of them, of which `reader` has read the beginning.
    ///
    /// # Errors
    /// As [`open`](Lookup::open).
    pub fn of(reader: &Reader, mut file: F, length: u64) -> Result<Self, SessionError> {
        let index = Index::of_file(reader, &mut file, length)?;
        Ok(Self { index, file, chunks: VecDeque::new() })
    }

    /// Where everything is.
    #[must_use]
    pub const fn index(&self) -> &Index {
        &self.index
    }

    /// A message and its number.
    ///
    /// # Errors
    /// [`SessionError::Damaged`] where its chunk is not what was written, or it is no such message.
    pub fn message<M: prost::Message + Default>(&mut self, spot: Spot) -> Result<(u32, M), SessionError> {
        let found = found(self.chunk(spot.chunk)?, spot.offset as usize);
        let message = found.and_then(|(sequence, bytes)| {
            Ok((sequence, M::decode(bytes.as_ref()).map_err(|error| error.to_string())?))
        });
        message.map_err(|reason| self.wrong(spot, reason))
    }

    /// What a message is that does not say what it should.
    pub(super) fn wrong(&self, spot: Spot, reason: String) -> SessionError {
        let at = self.index.chunks.get(spot.chunk as usize).map_or(0, |chunk| chunk.data);
        damaged(&self.index.path, at, reason)
    }

    /// The bytes of a chunk.
    fn chunk(&mut self, number: u32) -> Result<&[u8], SessionError> {
        if let Some(known) = self.chunks.iter().position(|(known, _)| *known == number) {
            // the newest stands at the end
            if let Some(chunk) = self.chunks.remove(known) {
                self.chunks.push_back(chunk);
            }
        } else {
            let path = &self.index.path;
            let Some(Chunk { data, length, crc }) = self.index.chunks.get(number as usize).copied() else {
                return Err(damaged(path, 0, "a message stands in no chunk".to_owned()));
            };
            let read = |cause| SessionError::Read { path: path.clone(), cause };
            let mut bytes = if self.chunks.len() < KEPT { None } else { self.chunks.pop_front() }
                .map_or_else(Vec::new, |(_, bytes)| bytes);
            // at most LONGEST_CHUNK
            bytes.resize(length as usize, 0);
            self.file.seek(SeekFrom::Start(data)).map_err(read)?;
            self.file.read_exact(&mut bytes).map_err(read)?;
            if crc != 0 && crc32fast::hash(&bytes) != crc {
                return Err(damaged(path, data, "its check sum is not that of its bytes".to_owned()));
            }
            self.chunks.push_back((number, bytes));
        }
        Ok(self.chunks.back().map_or(&[], |(_, bytes)| bytes))
    }
}

/// The message at a place of a chunk: its number and its bytes.
fn found(chunk: &[u8], offset: usize) -> Result<(u32, Cow<'_, [u8]>), String> {
    let short = || "a message is not where the list of its chunk says".to_owned();
    let rest = chunk.get(offset..).unwrap_or_default();
    let (head, body) = rest.split_first_chunk::<HEAD>().ok_or_else(short)?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).map_err(|_| short())?;
    match parse_record(opcode, body.get(..length).ok_or_else(short)?) {
        Ok(Record::Message { header, data }) => Ok((header.sequence, data)),
        _ => Err(short()),
    }
}

#[cfg(test)]
mod tests;
