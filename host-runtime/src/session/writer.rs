//! A session's file as it is written: chunk by chunk, each whole before it goes to the disk.

use super::error::SessionError;
use super::schema::DESCRIPTORS;
use super::schema::tetrad::Configuration;
use super::topic::Topic;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{WriteOptions, Writer as McapWriter};
use prost::Message;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Chunks are closed when they are larger, bytes: what a power cut may cost, and what a reader holds in
/// memory.
const CHUNK: u64 = 2 << 20;

/// The name of the metadata record at the end.
pub(super) const END: &str = "tetrad.end";

/// A file that counts what went into it.
struct Counted {
    file: File,
    bytes: u64,
}

impl Write for Counted {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let written = self.file.write(buffer)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// See the [module's text](self).
pub(super) struct Writer {
    path: PathBuf,
    /// `None` once it is finished or has failed.
    mcap: Option<McapWriter<NoSeek<Counted>>>,
    cameras: Vec<String>,
    epoch_us: u64,
    channels: BTreeMap<Topic, u16>,
}

/// What a finished file came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Written {
    /// Its size.
    pub bytes: u64,
    /// The messages in it.
    pub messages: u64,
}

impl Writer {
    /// Creates the file, or empties it, and writes what the session begins with.
    ///
    /// # Errors
    /// [`SessionError::Write`].
    pub(super) fn create(path: &Path, configuration: &Configuration) -> Result<Self, SessionError> {
        let file = File::create(path).map_err(|cause| SessionError::write(path, cause))?;
        // without seeking a chunk goes to the file in one piece, its length first: what a power cut
        // leaves can be read up to the last whole one
        let options = WriteOptions::new()
            .disable_seeking(true)
            .chunk_size(Some(CHUNK))
            .profile("")
            .library(concat!("tetrad ", env!("CARGO_PKG_VERSION")));
        let mcap = options
            .create(NoSeek::new(Counted { file, bytes: 0 }))
            .map_err(|cause| SessionError::write(path, cause))?;
        let mut writer = Self {
            path: path.to_owned(),
            mcap: Some(mcap),
            cameras: configuration.cameras.iter().map(|camera| camera.name.clone()).collect(),
            epoch_us: configuration.epoch_us,
            channels: BTreeMap::new(),
        };
        writer.write(Topic::Configuration, 0, 0, &configuration.encode_to_vec())?;
        writer.flush()?;
        Ok(writer)
    }

    /// Adds a message of `time_us` by the session's clock.
    ///
    /// # Errors
    /// [`SessionError::Write`]; nothing can be added after it.
    pub(super) fn write(
        &mut self,
        topic: Topic,
        time_us: u64,
        sequence: u32,
        message: &[u8],
    ) -> Result<(), SessionError> {
        let Some(mcap) = &mut self.mcap else { return Err(self.ended()) };
        let written = channel(mcap, &mut self.channels, topic, &self.cameras).and_then(|channel_id| {
            let log_time = self.epoch_us.saturating_add(time_us).saturating_mul(1_000);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            mcap.write_to_known_channel(&header, message)
        });
        written.map_err(|cause| self.fail(cause))
    }

    /// Hands what was written so far to the operating system.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub(super) fn flush(&mut self) -> Result<(), SessionError> {
        let Some(mcap) = &mut self.mcap else { return Err(self.ended()) };
        mcap.flush().map_err(|cause| self.fail(cause))
    }

    /// Adds how the session ended, and what lets readers find their way.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub(super) fn finish(mut self, end: BTreeMap<String, String>) -> Result<Written, SessionError> {
        let Some(mcap) = &mut self.mcap else { return Err(self.ended()) };
        let metadata = Metadata { name: END.to_owned(), metadata: end };
        let finished = mcap.write_metadata(&metadata).and_then(|()| mcap.finish());
        let summary = finished.map_err(|cause| self.fail(cause))?;
        let messages = summary.stats.map_or(0, |stats| stats.message_count);
        let counted = self.mcap.take().map(|mcap| mcap.into_inner().into_inner());
        Ok(Written { bytes: counted.map_or(0, |counted| counted.bytes), messages })
    }

    /// No more is tried after an error: a disk that is full would say so with every message.
    fn fail(&mut self, cause: mcap::McapError) -> SessionError {
        if let Some(mcap) = self.mcap.take() {
            // what could still be written at its end would only fail again
            drop(mcap.into_inner());
        }
        SessionError::write(&self.path, cause)
    }

    fn ended(&self) -> SessionError {
        SessionError::write(&self.path, io::Error::other("writing it has failed before"))
    }
}

/// The channel of a topic, added with its schema when it is first written.
fn channel(
    mcap: &mut McapWriter<NoSeek<Counted>>,
    channels: &mut BTreeMap<Topic, u16>,
    topic: Topic,
    cameras: &[String],
) -> Result<u16, mcap::McapError> {
    if let Some(id) = channels.get(&topic) {
        return Ok(*id);
    }
    let schema = mcap.add_schema(topic.schema(), "protobuf", DESCRIPTORS)?;
    let id = mcap.add_channel(schema, &topic.name(cameras), "protobuf", &BTreeMap::new())?;
    channels.insert(topic, id);
    Ok(id)
}
