//! What a board logs, in words: defmt's frames, by the program that they are of.

use defmt_decoder::{DecodeError, Table};
use std::path::Path;
use std::{fs, io};

/// The messages, each behind its level.
///
/// # Errors
/// The program cannot be read or logs nothing, or the bytes are no log of it.
pub fn messages(program: &Path, bytes: &[u8]) -> io::Result<Vec<String>> {
    let table = Table::parse(&fs::read(program)?).map_err(io::Error::other)?;
    let table =
        table.ok_or_else(|| io::Error::other(format!("{}: built without a log", program.display())))?;
    let mut decoder = table.new_stream_decoder();
    decoder.received(bytes);
    let mut messages = Vec::new();
    loop {
        match decoder.decode() {
            Ok(message) => {
                let level = message.level().map_or("", |level| level.as_str());
                messages.push(format!("{level} {}", message.display_message()));
            }
            Err(DecodeError::UnexpectedEof) => return Ok(messages),
            Err(error @ DecodeError::Malformed) => return Err(io::Error::other(error)),
        }
    }
}
