//! Frames as lines of the Lawicel protocol ("SLCAN"), which CAN adapters on serial lines speak.
//!
//! Frames are lines of ASCII that end in CR: `t` and three digits of identifier, a digit of length, two
//! digits a byte. Adapters answer commands with CR or BEL and some add `z` or a time stamp; none of
//! that is waited for.

use super::frame::{Frame, MAX_DATA};

/// The longest line that means something: an extended frame with a time stamp.
const MAX_LINE: usize = 1 + 8 + 1 + 2 * MAX_DATA + 4;

/// Bytes of the longest line of a frame that CANopen uses.
const MAX_TEXT: usize = 1 + 3 + 1 + 2 * MAX_DATA + 1;

/// A frame's line, its CR included.
pub type Text = heapless::Vec<u8, MAX_TEXT>;

/// What a line from an adapter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// A frame that CANopen uses.
    Frame(Frame),
    /// Anything else that adapters say: confirmations, extended and remote frames.
    Other,
    /// Bytes that are no line of the protocol.
    Garbage,
}

/// A frame as a line.
#[must_use]
pub fn encode(frame: &Frame) -> Text {
    let mut text = Text::new();
    let mut then = |byte| {
        // there is room for the longest
        let _ = text.push(byte);
    };
    then(b't');
    for shift in [8, 4, 0] {
        then(digit(frame.id() >> shift));
    }
    then(digit(frame.data().len() as u16));
    for byte in frame.data() {
        then(digit(u16::from(byte >> 4)));
        then(digit(u16::from(*byte)));
    }
    then(b'\r');
    text
}

/// The lowest four bits as a digit.
const fn digit(value: u16) -> u8 {
    let value = (value & 0xF) as u8;
    if value < 10 { b'0' + value } else { b'A' + value - 10 }
}

/// Lines out of bytes that come in any pieces.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    line: heapless::Vec<u8, MAX_LINE>,
    overlong: bool,
    garbage: u64,
}

impl Decoder {
    /// A decoder that has seen nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { line: heapless::Vec::new(), overlong: false, garbage: 0 }
    }

    /// Takes a byte; gives the line that it ends.
    pub fn push(&mut self, byte: u8) -> Option<Line> {
        match byte {
            b'\r' => {
                let line = if self.overlong { Line::Garbage } else { parse(&self.line) };
                if line == Line::Garbage {
                    self.garbage += self.line.len() as u64;
                }
                self.line.clear();
                self.overlong = false;
                Some(line)
            }
            // an error of the adapter: the answer to one command, not part of a line
            0x07 => None,
            _ => {
                if self.line.push(byte).is_err() {
                    self.overlong = true;
                    self.garbage += 1;
                }
                None
            }
        }
    }

    /// How many bytes belonged to no line of the protocol; those of a line that has not ended count from
    /// where it is too long to be one.
    #[must_use]
    pub const fn garbage(&self) -> u64 {
        self.garbage
    }
}

fn hex(digits: &[u8]) -> Option<u16> {
    digits.iter().try_fold(0u16, |value, digit| {
        let digit = char::from(*digit).to_digit(16)?;
        Some(value << 4 | digit as u16)
    })
}

fn parse(line: &[u8]) -> Line {
    let frame = match line {
        [] | [b'z' | b'Z', ..] | [b'T' | b'r' | b'R' | b'F' | b'V' | b'N', ..] => return Line::Other,
        [b't', rest @ ..] => standard(rest),
        _ => None,
    };
    frame.map_or(Line::Garbage, Line::Frame)
}

fn standard(rest: &[u8]) -> Option<Frame> {
    let (id, rest) = rest.split_at_checked(3)?;
    let (length, rest) = rest.split_at_checked(1)?;
    let length = usize::from(hex(length)?);
    let (digits, stamp) = rest.split_at_checked(2 * length)?;
    if !(stamp.is_empty() || stamp.len() == 4) {
        return None;
    }
    let mut data = [0; MAX_DATA];
    let data = data.get_mut(..length)?;
    for (byte, pair) in data.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = hex(pair)? as u8;
    }
    Frame::new(hex(id)?, data)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    fn decoded(bytes: &[u8]) -> Vec<Line> {
        let mut decoder = Decoder::new();
        bytes.iter().filter_map(|byte| decoder.push(*byte)).collect()
    }

    fn frame(id: u16, data: &[u8]) -> Frame {
        Frame::new(id, data).unwrap()
    }

    #[test]
    fn a_frame_is_the_line_that_python_can_writes() {
        assert_eq!(encode(&frame(0x205, &[0x0F, 0x00])).as_slice(), b"t20520F00\r");
    }

    #[test]
    fn lines_come_back_as_frames_in_any_pieces() {
        let frames = [frame(0x080, &[]), frame(0x7FF, &[0xFF; 8]), frame(0x181, &[0x37, 0x02, 1, 2, 3, 4])];
        let line: Vec<u8> = frames.iter().flat_map(encode).collect();
        assert_eq!(decoded(&line), frames.map(Line::Frame));
    }

    #[test]
    fn what_adapters_say_beside_frames_is_passed_over() {
        let mut lines = decoded(b"\rz\r\x07V1013\rt08001A2B\rT000001238\rt1");
        assert_eq!(lines.remove(4), Line::Other);
        assert_eq!(lines, [Line::Other, Line::Other, Line::Other, Line::Frame(frame(0x080, &[]))]);
    }

    #[test]
    fn garbage_is_told_from_frames() {
        for text in
            ["t0801\r", "tXYZ0\r", "t0809112233445566778899\r", "t08001\r", "t8000\r", "hello\r", "t\r"]
        {
            assert_eq!(decoded(text.as_bytes()), [Line::Garbage], "{text:?}");
        }
        let mut long = vec![b't'; 500];
        long.push(b'\r');
        long.extend_from_slice(b"t0800\r");
        assert_eq!(decoded(&long), [Line::Garbage, Line::Frame(frame(0x080, &[]))]);
    }

    #[test]
    fn bytes_that_are_no_frames_are_counted_also_where_no_line_ends() {
        let count = |bytes: &[u8]| {
            let mut decoder = Decoder::new();
            for byte in bytes {
                let _ = decoder.push(*byte);
            }
            decoder.garbage()
        };
        assert_eq!(count(b"t0800\rz\r\x07V1013\r"), 0);
        assert_eq!(count(b"xx\rzz\rhello\r"), 7);
        assert_eq!(count(&[b'x'; MAX_LINE]), 0);
        assert_eq!(count(&[b'x'; MAX_LINE + 5]), 5);
        let mut ended = vec![b'x'; MAX_LINE + 5];
        ended.push(b'\r');
        assert_eq!(count(&ended), MAX_LINE as u64 + 5);
    }
}
