//! Commands to a smart camera, one at a time: each is told again under its number until it is answered, and
//! so done once (docs/wire.md). Knows no port and is told the time.

use std::collections::VecDeque;
use tetrad_core::wire::{Command, CommandPacket, MAX_FRAME_LEN, Notice, NoticePacket, encode};

/// An answer that has not come by then is asked for again, microseconds: a frame each way takes 8 ms at 115,200
/// baud, and what is learnt waits for a picture.
const AGAIN_US: u64 = 300_000;

/// A camera that has not answered by then is not there, microseconds: one that looks for four balls in the whole
/// picture with 16 million instructions a second is 8 s away.
const PATIENCE_US: u64 = 15_000_000;

/// A camera that did not answer for a long time.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("it does not answer when told to {}", name(.0))]
pub struct Unanswered(pub Command);

/// What a smart camera is told, in order.
#[derive(Debug)]
pub struct Commander {
    session: u32,
    /// The number of the next command.
    next: u32,
    waiting: VecDeque<Command>,
    asked: Option<Asked>,
}

/// A command that has no answer yet.
#[derive(Clone, Copy, Debug)]
struct Asked {
    packet: CommandPacket,
    since_us: u64,
    again_us: u64,
}

impl Commander {
    /// Nothing to tell so far; `session` is chosen anew by each program.
    #[must_use]
    pub const fn new(session: u32) -> Self {
        Self { session, next: 0, waiting: VecDeque::new(), asked: None }
    }

    /// Tells this behind all that was told before.
    pub fn tell(&mut self, command: Command) {
        self.waiting.push_back(command);
    }

    /// Whether all that was told is answered, or given up.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.asked.is_none() && self.waiting.is_empty()
    }

    /// What is to be written to the line now, if anything is.
    ///
    /// # Errors
    /// [`Unanswered`]; what was to be told behind that is forgotten.
    pub fn due(&mut self, now_us: u64) -> Result<Option<Vec<u8>>, Unanswered> {
        let mut asked = match self.asked {
            Some(asked) => asked,
            None => {
                let Some(command) = self.waiting.pop_front() else { return Ok(None) };
                let packet = CommandPacket { session: self.session, sequence: self.next, command };
                self.next = self.next.wrapping_add(1);
                Asked { packet, since_us: now_us, again_us: now_us }
            }
        };
        if now_us.saturating_sub(asked.since_us) >= PATIENCE_US {
            self.asked = None;
            self.waiting.clear();
            return Err(Unanswered(asked.packet.command));
        }
        let due = now_us >= asked.again_us;
        if due {
            asked.again_us = now_us + AGAIN_US;
        }
        self.asked = Some(asked);
        Ok(due.then(|| frame(&asked.packet)))
    }

    /// What a notice answers, if it is the answer that is waited for.
    pub fn heard(&mut self, notice: &NoticePacket) -> Option<(Command, Notice)> {
        let command =
            self.asked.filter(|asked| notice.answers == Some(asked.packet.sequence))?.packet.command;
        self.asked = None;
        Some((command, notice.notice))
    }
}

/// One frame, behind a zero byte that ends what noise has begun.
fn frame(packet: &CommandPacket) -> Vec<u8> {
    let mut out = [0; 1 + MAX_FRAME_LEN];
    // what is not finite is not sent, and not answered: places and colours are finite where they are read
    let length = encode(&(*packet).into(), &mut out[1..]).unwrap_or_default();
    out[..=length].to_vec()
}

/// What a command asks for.
fn name(command: &Command) -> &'static str {
    match command {
        Command::Start => "start",
        Command::Stop => "stop",
        Command::Learn { .. } => "learn a ball",
        Command::SetReference { .. } => "take a ball's colours",
        Command::SetWindow { .. } => "look for a ball",
        Command::SelfTest => "test itself",
        Command::Preview { .. } => "show its balls",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::wire::{Decoder, Packet};

    /// The command in what is written.
    fn told(written: Result<Option<Vec<u8>>, Unanswered>) -> Option<(u32, Command)> {
        let bytes = written.unwrap()?;
        let mut decoder = Decoder::new();
        let mut packets = decoder.packets(&bytes);
        let Some(Ok(Packet::Command(packet))) = packets.next() else { panic!("{bytes:?}") };
        assert_eq!((packet.session, packets.next()), (7, None));
        Some((packet.sequence, packet.command))
    }

    fn answer(answers: Option<u32>, notice: Notice) -> NoticePacket {
        NoticePacket { camera: 0, session: 1, sequence: 5, answers, notice }
    }

    #[test]
    fn one_command_after_the_other_each_until_it_is_answered() {
        let mut commander = Commander::new(7);
        assert!(commander.is_idle());
        assert_eq!(told(commander.due(0)), None);
        commander.tell(Command::Stop);
        commander.tell(Command::Start);
        assert_eq!(told(commander.due(1_000)), Some((0, Command::Stop)));
        assert_eq!(told(commander.due(1_001)), None, "an answer takes a while");
        assert_eq!(told(commander.due(1_000 + AGAIN_US)), Some((0, Command::Stop)), "the same number");
        assert_eq!(commander.heard(&answer(None, Notice::Done)), None);
        assert_eq!(commander.heard(&answer(Some(1), Notice::Done)), None);
        let (done, failed) = (Notice::Done, Notice::SelfTestFailed);
        assert_eq!(commander.heard(&answer(Some(0), done)), Some((Command::Stop, done)));
        assert_eq!(commander.heard(&answer(Some(0), done)), None, "the second answer to what was told twice");
        assert_eq!(told(commander.due(1_002 + AGAIN_US)), Some((1, Command::Start)));
        assert_eq!(commander.heard(&answer(Some(1), failed)), Some((Command::Start, failed)));
        assert_eq!(told(commander.due(u64::MAX)), None);
        assert!(commander.is_idle());
    }

    #[test]
    fn who_never_answers_is_given_up() {
        let mut commander = Commander::new(7);
        commander.tell(Command::SelfTest);
        commander.tell(Command::Start);
        for now_us in (0..PATIENCE_US).step_by(AGAIN_US as usize) {
            assert_eq!(told(commander.due(now_us)), Some((0, Command::SelfTest)));
        }
        assert_eq!(commander.due(PATIENCE_US), Err(Unanswered(Command::SelfTest)));
        assert_eq!(commander.due(PATIENCE_US), Ok(None), "nothing is told behind it");
    }
}
