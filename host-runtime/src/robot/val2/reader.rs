//! Bytes from the controller -> what they mean.
//!
//! Only what is certain of the terminal is taken for granted: lines end in CR, LF or both; a `.` that
//! begins a line is the prompt; a `?` ends a question; an error text stands between asterisks.
//! Columns, headers and the wording are left alone. No input makes it panic or grow.

/// The longest line that is believed, bytes: three lines of an 80-column terminal.
const MAX_LINE: usize = 240;

/// What the controller said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Heard {
    /// It waits for a command.
    Prompt,
    /// A line of text, without its end and the blanks around it. Never empty.
    Line(String),
    /// A question, with its question mark: it waits for the answer.
    Question(String),
    /// An error text with its asterisks, as it stood.
    Error(String),
    /// A byte that no terminal prints, or a line without end: noise.
    Noise,
}

/// Takes one byte at a time; keeps the line that is not ended yet.
#[derive(Debug, Default)]
pub struct Reader {
    line: String,
    /// Something other than blanks was on this line and has been told already.
    told: bool,
}

impl Reader {
    /// Takes one byte; gives back what it completes.
    pub fn push(&mut self, byte: u8) -> Option<Heard> {
        match byte {
            b'\r' | b'\n' => return self.end_of_line(),
            // padding and the bell
            0 | 7 => return None,
            b'\t' => self.line.push(' '),
            b' '..=b'~' => self.line.push(char::from(byte)),
            _ => {
                self.line.clear();
                return Some(Heard::Noise);
            }
        }
        match byte {
            b'.' if !self.told && self.line.trim_start() == "." => {
                // the line goes on with the echo of the next command
                self.line.clear();
                Some(Heard::Prompt)
            }
            // not within an error text
            b'?' if !self.line.contains('*') => {
                self.told = true;
                Some(Heard::Question(self.take()))
            }
            b'*' => self.closed_error(),
            _ if self.line.len() > MAX_LINE => {
                self.line.clear();
                Some(Heard::Noise)
            }
            _ => None,
        }
    }

    /// The text from one asterisk to the next; what stood before it belongs to no answer.
    fn closed_error(&mut self) -> Option<Heard> {
        let opened = self.line.find('*')?;
        if opened + 1 == self.line.len() {
            return None;
        }
        let text = self.line.split_off(opened);
        self.line.clear();
        self.told = true;
        Some(Heard::Error(text))
    }

    fn end_of_line(&mut self) -> Option<Heard> {
        self.told = false;
        let text = self.take();
        if text.is_empty() {
            None
        } else if text.contains('*') {
            // the other asterisk was lost: an error all the same
            Some(Heard::Error(text))
        } else {
            Some(Heard::Line(text))
        }
    }

    fn take(&mut self) -> String {
        let text = self.line.trim().to_owned();
        self.line.clear();
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hear(bytes: &[u8]) -> Vec<Heard> {
        let mut reader = Reader::default();
        bytes.iter().filter_map(|byte| reader.push(*byte)).collect()
    }

    fn line(text: &str) -> Heard {
        Heard::Line(text.to_owned())
    }

    fn error(text: &str) -> Heard {
        Heard::Error(text.to_owned())
    }

    #[test]
    fn an_answer_with_its_echo_and_the_prompt() {
        let heard = hear(b"SPEED 30\r\n\r\n.WHERE\r\n  JT1   JT2\r\n 1.5  -2.5\r\n.");
        let expected = [
            line("SPEED 30"),
            Heard::Prompt,
            line("WHERE"),
            line("JT1   JT2"),
            line("1.5  -2.5"),
            Heard::Prompt,
        ];
        assert_eq!(heard, expected);
    }

    #[test]
    fn a_question_is_heard_before_its_line_ends() {
        let heard = hear(b"Load VAL-II from floppy (Y/N)? n\r\nInitialize (Y/N)?");
        let question = |text: &str| Heard::Question(text.to_owned());
        let expected = [question("Load VAL-II from floppy (Y/N)?"), line("n"), question("Initialize (Y/N)?")];
        assert_eq!(heard, expected);
    }

    #[test]
    fn an_error_text_is_kept_as_it_stood() {
        assert_eq!(
            hear(b"*Envelope error* JT 4\r\n."),
            [error("*Envelope error*"), line("JT 4"), Heard::Prompt]
        );
        assert_eq!(hear(b"*Envelope err\r\n"), [error("*Envelope err")]);
        assert_eq!(hear(b"Illegal*\r\n"), [error("Illegal*")]);
        assert_eq!(hear(b"*What?*\r\n"), [error("*What?*")]);
        assert_eq!(hear(b"  *A* *B*\r\n"), [error("*A*"), error("*B*")]);
    }

    #[test]
    fn only_a_point_that_begins_a_line_is_the_prompt() {
        assert_eq!(hear(b"a.\r\n"), [line("a.")]);
        assert_eq!(hear(b"\n  .\n"), [Heard::Prompt]);
        assert_eq!(hear(b"why? .\n"), [Heard::Question("why?".to_owned()), line(".")]);
    }

    #[test]
    fn noise_is_told_and_takes_its_line_with_it() {
        assert_eq!(hear(b"WH\xffERE\r\n"), [Heard::Noise, line("ERE")]);
        assert_eq!(hear(&[b'x'; MAX_LINE + 1]), [Heard::Noise]);
        assert_eq!(hear(b"\0\x07\r\n"), []);
    }
}
