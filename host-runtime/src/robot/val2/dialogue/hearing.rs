//! What the conversation makes of what the controller says.

use super::{Asked, Dialogue, NOT_CALIBRATED, Pending};
use crate::robot::val2::convention::{Convention, ValDegrees};
use crate::robot::val2::reader::Heard;
use crate::robot::val2::text;
use std::time::Duration;
use tetrad_core::arm::port::PortStatus;

/// How far apart two answers of WHERE may be that agree, degrees: encoders at rest.
const AGREE_DEG: f64 = 0.1;

/// How many answers of WHERE are asked for until two agree: an arm that comes to rest meanwhile.
const READINGS: u8 = 10;

/// How many questions are answered at start-up.
const QUESTIONS: u8 = 8;

/// The most numbers of a WHERE that are kept: more than it can have makes it nonsense.
const NUMBERS: usize = 16;

impl Dialogue {
    /// What one thing that was heard leads to.
    pub(super) fn hear(&mut self, heard: Heard, now: Duration) {
        if matches!(&heard, Heard::Question(question) if text::is_start_up(question)) {
            // whoever asks this was switched on just now, and does not know where its joints are
            self.uncalibrated = true;
        }
        let following = match self.status {
            PortStatus::Ready | PortStatus::Stopped => true,
            // what comes before the first words is of the time before
            PortStatus::Enabling => self.pending.is_some(),
            _ => false,
        };
        match (self.pending.take(), heard) {
            // after a fault or a loss nothing is answered
            _ if !following => {}
            (Some(pending), heard) if listening_only(pending.asked) => {
                self.hear_attention(pending, heard, now)
            }
            (_, Heard::Noise) => self.nonsense("noise came from the line"),
            (Some(pending), Heard::Line(line)) => self.hear_line(pending, &line),
            (Some(pending), Heard::Question(question)) => self.hear_question(pending, &question, now),
            (Some(pending), Heard::Error(error)) => self.hear_error(pending, &error),
            (Some(pending), Heard::Prompt) if pending.echoed => self.answered(pending, now),
            // one more prompt, before the echo: of the exchange before
            (pending, Heard::Prompt) => self.pending = pending,
            (None, Heard::Line(line)) => self.nonsense(&format!("unasked, the controller said {line:?}")),
            (None, Heard::Question(question)) => self.unknown_question(&question),
            (None, Heard::Error(error)) => self.refused(&error),
        }
    }

    /// While attention is asked for, only questions, our echo and the prompt count.
    fn hear_attention(&mut self, mut pending: Pending, heard: Heard, now: Duration) {
        match heard {
            Heard::Question(question) => {
                self.questions += 1;
                if self.questions > QUESTIONS {
                    self.nonsense(&format!("the controller asks {question:?} again and again"));
                } else if text::is_start_up(&question) {
                    self.ask(Asked::StartUp, text::NO.to_owned(), now);
                } else if question.to_uppercase().contains(text::CHANGE) {
                    self.ask(Asked::StartUp, String::new(), now);
                } else {
                    self.unknown_question(&question);
                }
                return;
            }
            // what an interrupted session left stands before it on the line
            Heard::Line(line) => pending.echoed |= line.to_uppercase().contains(text::SPOIL),
            // the prompt before our echo is that of the exchange before
            Heard::Prompt if !matches!(pending.asked, Asked::Attention(_)) || pending.echoed => {
                (pending.asked, pending.since) = (Asked::Quiet, now);
            }
            Heard::Prompt | Heard::Error(_) | Heard::Noise => {}
        }
        self.pending = Some(pending);
    }

    fn hear_line(&mut self, mut pending: Pending, line: &str) {
        if !pending.echoed {
            if !text::is_echo(line, &pending.sent) {
                self.nonsense(&format!("the controller echoed {line:?} for {:?}", pending.sent));
                return;
            }
            pending.echoed = true;
        } else if matches!(pending.asked, Asked::FirstWhere(_) | Asked::Where)
            && pending.numbers.len() < NUMBERS
        {
            text::numbers(line, &mut pending.numbers);
        }
        self.pending = Some(pending);
    }

    fn hear_question(&mut self, pending: Pending, question: &str, now: Duration) {
        let change = question.to_uppercase().contains(text::CHANGE);
        if text::is_start_up(question) {
            let reason = "the controller has been switched off and on; calibrate the arm, then enable";
            self.fail(PortStatus::Lost, reason.to_owned());
            return;
        }
        match (pending.asked, &self.convention) {
            _ if !pending.echoed => self.unknown_question(question),
            (Asked::Point, Some(convention)) if change && self.status == PortStatus::Ready => {
                let point = text::point(&text::hundredths(&convention.to_val(&self.going)));
                self.ask(Asked::Joints, point, now);
            }
            (Asked::Point | Asked::Joints, _) if change => self.ask(Asked::NoChange, String::new(), now),
            (Asked::Calibrate, _) if !change => self.ask(Asked::Sure, text::YES.to_owned(), now),
            _ => self.unknown_question(question),
        }
    }

    fn hear_error(&mut self, mut pending: Pending, error: &str) {
        let not_calibrated = text::is_not_calibrated(error);
        self.uncalibrated |= not_calibrated;
        let mends = self.config.calibrate && self.calibrations == 0 && self.status == PortStatus::Enabling;
        if not_calibrated && mends {
            pending.uncalibrated = true;
            self.pending = Some(pending);
        } else {
            self.refused(error);
        }
    }

    /// The prompt is back.
    fn answered(&mut self, pending: Pending, now: Duration) {
        if pending.uncalibrated {
            self.calibrate(now);
            return;
        }
        if self.status == PortStatus::Stopped && !matches!(pending.asked, Asked::Where | Asked::Move) {
            return;
        }
        match pending.asked {
            Asked::Attention(_) | Asked::StartUp | Asked::Quiet => {}
            Asked::Calibrate | Asked::Sure => {
                self.uncalibrated = false;
                self.ask(Asked::Speed, text::speed(self.config.speed), now);
            }
            Asked::Speed => self.ask(Asked::FirstWhere(READINGS), text::WHERE.to_owned(), now),
            Asked::FirstWhere(left) => self.found(left, &pending.numbers, now),
            Asked::Where => self.measured_again(&pending.numbers, now),
            Asked::Point => self.nonsense("POINT was answered without the question CHANGE?"),
            Asked::Joints | Asked::NoChange | Asked::Set => {
                self.moves.add(now);
                self.ask(Asked::Move, text::MOVE.to_owned(), now);
            }
            Asked::Move => self.sent = self.going,
        }
    }

    /// The line is quiet after the prompt: the controller listens, and nothing else is under way.
    pub(super) fn settled(&mut self, now: Duration) {
        self.pending = None;
        if self.status != PortStatus::Enabling {
            return;
        }
        if self.uncalibrated {
            self.calibrate(now);
        } else {
            self.ask(Asked::Speed, text::speed(self.config.speed), now);
        }
    }

    /// Calibrates where the operator asked for it. The arm moves by it.
    fn calibrate(&mut self, now: Duration) {
        if self.config.calibrate && self.calibrations == 0 {
            self.calibrations += 1;
            self.ask(Asked::Calibrate, text::CALIBRATE.to_owned(), now);
        } else {
            self.fail(PortStatus::NotHomed, NOT_CALIBRATED.to_owned());
        }
    }

    /// One of the first answers of WHERE.
    fn found(&mut self, left: u8, numbers: &[f64], now: Duration) {
        let Some(joints) = text::joints(numbers) else {
            self.nonsense(&format!("WHERE gave {} numbers, not 6 or 12", numbers.len()));
            return;
        };
        let agree = |first: ValDegrees| first.iter().zip(&joints).all(|(a, b)| (a - b).abs() <= AGREE_DEG);
        if self.first.is_some_and(agree) {
            let convention = Convention::at(&joints, &self.arm);
            self.sent = convention.to_model(&joints);
            self.measured = Some((self.sent, now));
            self.convention = Some(convention);
            self.status = PortStatus::Ready;
        } else if left > 1 {
            self.first = Some(joints);
            self.ask(Asked::FirstWhere(left - 1), text::WHERE.to_owned(), now);
        } else {
            self.nonsense("no two answers of WHERE agree: the arm moves, or the line loses characters");
        }
    }

    fn measured_again(&mut self, numbers: &[f64], now: Duration) {
        let Some((joints, convention)) = text::joints(numbers).zip(self.convention.as_ref()) else {
            self.nonsense(&format!("WHERE gave {} numbers, not 6 or 12", numbers.len()));
            return;
        };
        let joints = convention.to_model(&joints);
        if let Some(joint) = self.pace.misplaced(&self.sent, &joints) {
            self.nonsense(&format!("joint {joint} is not where it was sent"));
            return;
        }
        self.measured = Some((joints, now));
    }
}

/// Whether answers are passed over until the controller listens.
const fn listening_only(asked: Asked) -> bool {
    matches!(asked, Asked::Attention(_) | Asked::StartUp | Asked::Quiet)
}
