//! A client for SDO transfers of up to four bytes (CiA 301, expedited), one request at a time.
//!
//! It owns neither bus nor clock: it gives the frame to send and takes those that come. An answer is
//! believed only for the very object that was asked for: after a timeout the late answer to an earlier
//! request may come in place of the one waited for.

use super::frame::{Frame, SDO_REQUEST};
use core::fmt;

/// How often a request without an answer is sent, in all.
const ATTEMPTS: u8 = 3;

/// An entry of an object dictionary.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Object {
    /// Index.
    pub index: u16,
    /// Sub-index.
    pub sub: u8,
}

/// `0x1600:01`.
impl fmt::Display for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:#06x}:{:02x}", self.index, self.sub)
    }
}

impl fmt::Debug for Object {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// The value of the object.
    Read(Object),
    /// That it takes the lowest `bytes` (1 to 4) of `value`.
    Write {
        /// The object.
        object: Object,
        /// The value, as its bits.
        value: u32,
        /// How many bytes the object has.
        bytes: u8,
    },
}

impl Request {
    const fn object(&self) -> Object {
        match self {
            Self::Read(object) | Self::Write { object, .. } => *object,
        }
    }

    fn frame(&self, node: u8) -> Frame {
        let Object { index, sub } = self.object();
        let [low, high] = index.to_le_bytes();
        let (command, value) = match self {
            Self::Read(_) => (0x40, 0),
            // expedited, size told: n of bits 2 and 3 are the bytes that hold no data
            Self::Write { value, bytes, .. } => (0x23 | ((4u8.saturating_sub(*bytes) & 3) << 2), *value),
        };
        let [a, b, c, d] = value.to_le_bytes();
        Frame::of(SDO_REQUEST, node, [command, low, high, sub, a, b, c, d])
    }
}

/// How a request ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The value read, as its bits, missing bytes 0; 0 after a write.
    Value(u32),
    /// The node refused, with this abort code.
    Abort(AbortCode),
    /// It did not answer, however often it was asked.
    Silence,
    /// It answered with something that no expedited transfer holds.
    Nonsense,
}

/// Why a node refused (CiA 301, SDO abort codes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbortCode(pub u32);

impl AbortCode {
    /// Whether the object is not there or cannot be written, so that doing without it is an answer.
    #[must_use]
    pub const fn is_absence(self) -> bool {
        matches!(self.0, 0x0601_0000 | 0x0601_0002 | 0x0602_0000 | 0x0609_0011)
    }
}

impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "abort {:#010x}", self.0)?;
        let meaning = match self.0 {
            0x0504_0000 => "timed out",
            0x0601_0000 => "access not supported",
            0x0601_0001 => "write only",
            0x0601_0002 => "read only",
            0x0602_0000 => "no such object",
            0x0604_0041 => "cannot be mapped to a PDO",
            0x0604_0042 => "more than a PDO holds",
            0x0607_0010 => "wrong length",
            0x0609_0011 => "no such sub-index",
            0x0609_0030 => "value out of range",
            0x0800_0020 => "cannot be stored",
            0x0800_0022 => "not in this state of the device",
            _ => return Ok(()),
        };
        write!(f, ", {meaning}")
    }
}

/// The client for one node.
#[derive(Clone, Debug)]
pub struct Client {
    node: u8,
    timeout_us: u64,
    pending: Option<Pending>,
    answer: Option<Answer>,
}

#[derive(Clone, Copy, Debug)]
struct Pending {
    request: Request,
    /// When it was sent last; `None` before the first time.
    sent_us: Option<u64>,
    attempts: u8,
}

impl Client {
    /// For the node, which has `timeout_us` to answer each time it is asked.
    #[must_use]
    pub const fn new(node: u8, timeout_us: u64) -> Self {
        Self { node, timeout_us, pending: None, answer: None }
    }

    /// Forgets what was asked.
    pub const fn reset(&mut self) {
        self.pending = None;
        self.answer = None;
    }

    /// Whether nothing is asked and no answer waits to be taken.
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.pending.is_none() && self.answer.is_none()
    }

    /// Asks; what was asked before is forgotten.
    pub const fn ask(&mut self, request: Request) {
        self.pending = Some(Pending { request, sent_us: None, attempts: 0 });
        self.answer = None;
    }

    /// The answer, once.
    pub const fn take_answer(&mut self) -> Option<Answer> {
        self.answer.take()
    }

    /// The frame to be sent now, if any: a new request, or one again that went without an answer.
    pub fn poll(&mut self, now_us: u64) -> Option<Frame> {
        let pending = self.pending.as_mut()?;
        let due = pending.sent_us.is_none_or(|sent| now_us.saturating_sub(sent) >= self.timeout_us);
        if !due {
            return None;
        }
        if pending.attempts == ATTEMPTS {
            self.pending = None;
            self.answer = Some(Answer::Silence);
            return None;
        }
        pending.attempts += 1;
        pending.sent_us = Some(now_us);
        Some(pending.request.frame(self.node))
    }

    /// Takes the bytes of a frame from the node's answering COB-ID; whether they were the answer that
    /// was waited for.
    pub fn receive(&mut self, data: &[u8]) -> bool {
        let Some(Pending { request, sent_us: Some(_), .. }) = self.pending else { return false };
        let &[command, low, high, sub, a, b, c, d] = data else { return false };
        if (Object { index: u16::from_le_bytes([low, high]), sub }) != request.object() {
            return false;
        }
        let value = u32::from_le_bytes([a, b, c, d]);
        self.answer = Some(match (command & 0xE0, request) {
            (0x80, _) => Answer::Abort(AbortCode(value)),
            (0x60, Request::Write { .. }) => Answer::Value(0),
            (0x40, Request::Read(_)) if command & 2 != 0 => {
                // with its size told, bytes beyond it are not defined
                let unused = if command & 1 != 0 { (command >> 2) & 3 } else { 0 };
                Answer::Value(value & (u32::MAX >> (8 * unused)))
            }
            _ => Answer::Nonsense,
        });
        self.pending = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;
    use std::string::ToString as _;

    const STATUS: Object = Object { index: 0x6041, sub: 0 };

    fn asked(request: Request) -> (Client, Frame) {
        let mut client = Client::new(5, 1000);
        client.ask(request);
        let frame = client.poll(0).unwrap();
        (client, frame)
    }

    #[test]
    fn requests_have_the_bytes_of_the_standard() {
        let (_, frame) = asked(Request::Read(STATUS));
        assert_eq!(format!("{frame:?}"), "605#4041600000000000");
        for (bytes, want) in [(1, 0x2F), (2, 0x2B), (3, 0x27), (4, 0x23)] {
            let (_, frame) = asked(Request::Write { object: STATUS, value: 0x0102_0304, bytes });
            assert_eq!(frame.data(), [want, 0x41, 0x60, 0, 4, 3, 2, 1]);
        }
    }

    #[test]
    fn an_answer_is_read_in_its_size() {
        for (command, want) in [(0x4F, 0x04), (0x4B, 0x0304), (0x43, 0x0102_0304), (0x42, 0x0102_0304)] {
            let (mut client, _) = asked(Request::Read(STATUS));
            assert!(client.receive(&[command, 0x41, 0x60, 0, 4, 3, 2, 1]));
            assert_eq!(client.take_answer(), Some(Answer::Value(want)));
            assert!(client.is_idle());
        }
    }

    #[test]
    fn an_abort_says_what_it_means() {
        let (mut client, _) = asked(Request::Read(STATUS));
        assert!(client.receive(&[0x80, 0x41, 0x60, 0, 0, 0, 2, 6]));
        let Some(Answer::Abort(code)) = client.take_answer() else { panic!("no abort") };
        assert!(code.is_absence() && !AbortCode(0x0604_0041).is_absence());
        assert_eq!(code.to_string(), "abort 0x06020000, no such object");
    }

    #[test]
    fn answers_for_another_object_or_of_another_shape_are_not_believed() {
        let (mut client, _) = asked(Request::Read(STATUS));
        assert!(!client.receive(&[0x4B, 0x40, 0x60, 0, 1, 0, 0, 0]));
        assert!(!client.receive(&[0x4B, 0x41, 0x60, 1, 1, 0, 0, 0]));
        assert!(!client.receive(&[0x4B, 0x41, 0x60]));
        assert_eq!(client.take_answer(), None);
        // a segmented answer: these objects have none
        assert!(client.receive(&[0x41, 0x41, 0x60, 0, 9, 0, 0, 0]));
        assert_eq!(client.take_answer(), Some(Answer::Nonsense));
        // nothing is waited for
        assert!(!client.receive(&[0x4B, 0x41, 0x60, 0, 1, 0, 0, 0]));
    }

    #[test]
    fn silence_is_asked_into_three_times() {
        let (mut client, first) = asked(Request::Read(STATUS));
        assert_eq!(client.poll(999), None);
        assert_eq!(client.poll(1000), Some(first));
        assert_eq!(client.poll(2000), Some(first));
        assert_eq!(client.take_answer(), None);
        assert_eq!(client.poll(3000), None);
        assert_eq!(client.take_answer(), Some(Answer::Silence));
    }
}
