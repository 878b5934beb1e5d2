//! What goes over the stream beside the packets: who is there, what time it is, and configuration.
//!
//! | tag | message | fields, lowest byte first |
//! |---|---|---|
//! | 1 | hello | session u32 |
//! | 2 | ask | id u32, the asker's time u64 |
//! | 3 | answer | id u32, heard u64, answered u64: the answerer's times |
//! | 4 | configuration | length u32, so many bytes |
//!
//! Times are microseconds. A stream is read by [`Reader`] in pieces of any size.

/// The longest configuration, bytes.
pub const MAX_CONFIGURATION: usize = 64 * 1024;

/// What is said over the stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Message {
    /// The first message of each end: the session its packets belong to.
    Hello {
        /// Chosen anew each time the station starts.
        session: u32,
    },
    /// What time is it there?
    Ask {
        /// Comes back in the answer.
        id: u32,
        /// When it was asked, the asker's clock.
        asked_us: u64,
    },
    /// The answer to it.
    Answer {
        /// That of the question.
        id: u32,
        /// When the question was heard, the answerer's clock.
        heard_us: u64,
        /// When the answer was sent.
        answered_us: u64,
    },
    /// What the other station shall know, in a form the stations agree on.
    Configuration(Vec<u8>),
}

/// Why a stream is no stream of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MessageError {
    /// A tag that is not known.
    #[error("message {0} is not known")]
    UnknownTag(u8),
    /// A configuration is longer than is allowed.
    #[error("a configuration of {0} bytes is too long: at most {MAX_CONFIGURATION}")]
    TooLong(u32),
}

impl Message {
    /// The message's bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Hello { session } => [&[1][..], &session.to_le_bytes()].concat(),
            Self::Ask { id, asked_us } => [&[2][..], &id.to_le_bytes(), &asked_us.to_le_bytes()].concat(),
            Self::Answer { id, heard_us, answered_us } => {
                [&[3][..], &id.to_le_bytes(), &heard_us.to_le_bytes(), &answered_us.to_le_bytes()].concat()
            }
            Self::Configuration(bytes) => {
                // longer ones are refused where they are given: see MAX_CONFIGURATION
                let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
                [&[4][..], &length.to_le_bytes(), bytes].concat()
            }
        }
    }
}

/// Messages out of a stream that comes in pieces.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    bytes: Vec<u8>,
}

impl Reader {
    /// Takes a piece of the stream.
    pub fn feed(&mut self, piece: &[u8]) {
        self.bytes.extend_from_slice(piece);
    }

    /// The next message that is complete.
    ///
    /// # Errors
    /// [`MessageError`]; there is no way to read on behind it.
    pub fn message(&mut self) -> Result<Option<Message>, MessageError> {
        let Some((&tag, fields)) = self.bytes.split_first() else { return Ok(None) };
        let parsed = match tag {
            1 => fields
                .first_chunk()
                .map(|session| (4, Message::Hello { session: u32::from_le_bytes(*session) })),
            2 => parse_ask(fields),
            3 => parse_answer(fields),
            4 => parse_configuration(fields)?,
            unknown => return Err(MessageError::UnknownTag(unknown)),
        };
        Ok(parsed.map(|(used, message)| {
            self.bytes.drain(..=used);
            message
        }))
    }
}

fn parse_ask(fields: &[u8]) -> Option<(usize, Message)> {
    let (id, rest) = fields.split_first_chunk()?;
    let asked = rest.first_chunk()?;
    Some((12, Message::Ask { id: u32::from_le_bytes(*id), asked_us: u64::from_le_bytes(*asked) }))
}

fn parse_answer(fields: &[u8]) -> Option<(usize, Message)> {
    let (id, rest) = fields.split_first_chunk()?;
    let (heard, rest) = rest.split_first_chunk()?;
    let answered = rest.first_chunk()?;
    let message = Message::Answer {
        id: u32::from_le_bytes(*id),
        heard_us: u64::from_le_bytes(*heard),
        answered_us: u64::from_le_bytes(*answered),
    };
    Some((20, message))
}

fn parse_configuration(fields: &[u8]) -> Result<Option<(usize, Message)>, MessageError> {
    let Some((length, rest)) = fields.split_first_chunk() else { return Ok(None) };
    let length = u32::from_le_bytes(*length);
    let wanted = usize::try_from(length).unwrap_or(usize::MAX);
    if wanted > MAX_CONFIGURATION {
        return Err(MessageError::TooLong(length));
    }
    Ok(rest.get(..wanted).map(|bytes| (4 + wanted, Message::Configuration(bytes.to_vec()))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message() -> impl Strategy<Value = Message> {
        prop_oneof![
            any::<u32>().prop_map(|session| Message::Hello { session }),
            any::<(u32, u64)>().prop_map(|(id, asked_us)| Message::Ask { id, asked_us }),
            any::<(u32, u64, u64)>().prop_map(|(id, heard_us, answered_us)| Message::Answer {
                id,
                heard_us,
                answered_us
            }),
            prop::collection::vec(any::<u8>(), 0..200).prop_map(Message::Configuration),
        ]
    }

    proptest! {
        #[test]
        fn messages_come_back_however_the_stream_is_cut(
            messages in prop::collection::vec(message(), 1..6),
            piece in 1_usize..40,
        ) {
            let stream: Vec<u8> = messages.iter().flat_map(Message::encode).collect();
            let mut reader = Reader::default();
            let mut received = Vec::new();
            for piece in stream.chunks(piece) {
                reader.feed(piece);
                while let Some(message) = reader.message().unwrap() {
                    received.push(message);
                }
            }
            prop_assert_eq!(received, messages);
        }

        #[test]
        fn any_bytes_are_taken_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let mut reader = Reader::default();
            reader.feed(&bytes);
            while let Ok(Some(_)) = reader.message() {}
        }
    }

    #[test]
    fn what_cannot_be_read_is_refused() {
        let mut reader = Reader::default();
        reader.feed(&[9]);
        assert_eq!(reader.message(), Err(MessageError::UnknownTag(9)));
        let mut reader = Reader::default();
        reader.feed(&[4, 1, 0, 1, 0]);
        assert_eq!(reader.message(), Err(MessageError::TooLong(65_537)), "refused before it has come");
    }
}
