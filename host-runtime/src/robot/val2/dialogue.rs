//! The conversation with the controller, without a line: bytes and time in, bytes out.
//!
//! ```text
//! enable -> attention -> (start-up questions) -> settle -> (calibrate) -> speed -> where, where -> ready
//! ready:    a point, where, a point, ...           one exchange at a time, the next when the prompt is back
//! ```
//!
//! Here is what is asked of it and what it says by itself; what it makes of the controller's words is in
//! `hearing`.
//!
//! # What keeps the arm from moving by mistake
//!
//! - Each line is compared with its echo before anything is built on it: a point whose echo differs is
//!   never moved to.
//! - An error text, noise, an echo that differs, a question that is not known, silence: whatever is
//!   not understood ends the session. Nothing more is sent until it is enabled anew.
//! - Enabling begins with a line that is no command ([`text::SPOIL`]): half a line that an interrupted
//!   session left at the controller is spoilt by it, not carried out.
//! - Where the arm is counts when two answers of WHERE agree.
//! - A controller that was switched off and on has lost its place: it asks its start-up questions, and
//!   from then on has to be calibrated before it is ready.

mod hearing;

use std::time::Duration;

use tetrad_core::arm::port::{JointReading, PortError, PortFault, PortStatus};
use tetrad_core::arm::puma560::Joints;
use tetrad_core::config::PumaConfig;

use super::convention::{Convention, ValDegrees};
use super::pace::{Last, Moves, Pace};
use super::reader::Reader;
use super::settings::{Dialect, Val2Config};
use super::text;

/// How often attention is asked for before the controller is given up.
const TRIES: u8 = 3;

/// How long the line must be quiet after the prompt before the first command: answers to what was
/// typed before may still come.
const QUIET: Duration = Duration::from_millis(300);

/// How long a calibration may take.
const CALIBRATION: Duration = Duration::from_secs(120);

/// How much may come while the line is to become quiet, bytes: four screens.
const BABBLE: usize = 8192;

/// How long a controller may take from one start-up question to the next, or to the prompt.
const START_UP: Duration = Duration::from_secs(30);

/// What was said to the controller and not answered yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Asked {
    /// [`text::SPOIL`], for the how-many-th time.
    Attention(u8),
    /// A question of start-up, answered with no.
    StartUp,
    /// Nothing: the line is to be quiet.
    Quiet,
    Speed,
    Calibrate,
    /// Whether to calibrate: yes.
    Sure,
    /// How many readings are left until it is given up.
    FirstWhere(u8),
    Where,
    /// POINT #P.
    Point,
    /// Its new joints.
    Joints,
    /// That no more is to be changed.
    NoChange,
    /// DO SET #P=#PPOINT(...).
    Set,
    Move,
}

#[derive(Debug)]
struct Pending {
    asked: Asked,
    /// What was sent, without its end; its echo is to be the same.
    sent: String,
    echoed: bool,
    since: Duration,
    numbers: Vec<f64>,
    /// An error text came that a calibration mends.
    uncalibrated: bool,
}

/// The conversation. Times are since any one moment, the same for all calls.
#[derive(Debug)]
pub struct Dialogue {
    config: Val2Config,
    arm: PumaConfig,
    pace: Pace,
    reader: Reader,
    pending: Option<Pending>,
    output: String,
    status: PortStatus,
    /// Why it is not ready, and what would mend it.
    reason: Option<String>,
    /// What reading joints gives where the controller is lost.
    loss: PortError,
    /// Known to have lost its place; only a calibration of our own mends that.
    uncalibrated: bool,
    calibrations: u8,
    questions: u8,
    unquiet: usize,
    convention: Option<Convention>,
    first: Option<ValDegrees>,
    measured: Option<(Joints<f64>, Duration)>,
    /// The newest set-point accepted.
    target: Option<(Joints<f64>, Duration)>,
    /// The point of the exchange under way.
    going: Joints<f64>,
    /// The last point that was moved to, or where the arm was found.
    sent: Joints<f64>,
    moves: Moves,
}

impl Dialogue {
    /// A conversation that has not begun.
    #[must_use]
    pub fn new(config: &Val2Config, arm: &PumaConfig) -> Self {
        let share = f64::from(config.speed) / 100.0;
        Self {
            config: config.clone(),
            arm: *arm,
            pace: Pace::new(arm.joints.map(|joint| joint.max_speed_rad_s), share, config.watchdog),
            reader: Reader::default(),
            pending: None,
            output: String::new(),
            status: PortStatus::Disabled,
            reason: None,
            loss: PortError::Lost,
            uncalibrated: false,
            calibrations: 0,
            questions: 0,
            unquiet: 0,
            convention: None,
            first: None,
            measured: None,
            target: None,
            going: [0.0; 6],
            sent: [0.0; 6],
            moves: Moves::default(),
        }
    }

    /// How the arm stands.
    #[must_use]
    pub const fn status(&self) -> PortStatus {
        self.status
    }

    /// Why it stands so and what would mend it, where the status does not say it all. The
    /// controller's own words are quoted.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        let under_way = match self.pending.as_ref().map(|pending| pending.asked) {
            Some(Asked::Move) => "the move under way",
            Some(Asked::Calibrate | Asked::Sure) => "the calibration under way",
            _ => return self.reason.clone(),
        };
        if self.status != PortStatus::Stopped {
            return self.reason.clone();
        }
        let why = self.reason.as_deref().unwrap_or("the arm was asked to stop");
        Some(format!("{why}; the controller finishes {under_way}, which only its emergency stop cuts short"))
    }

    /// Points that were moved to since it was made.
    #[must_use]
    pub const fn moves(&self) -> Moves {
        self.moves
    }

    /// What is to be sent now.
    pub fn take_output(&mut self) -> String {
        std::mem::take(&mut self.output)
    }

    /// Begins to switch the arm on: from now on it is being enabled, and [`Dialogue::begin`] is to
    /// follow once the line is open.
    pub fn enable(&mut self) {
        self.forget();
        (self.status, self.reason, self.loss) = (PortStatus::Enabling, None, PortError::NotMeasured);
        (self.measured, self.convention, self.first) = (None, None, None);
        (self.calibrations, self.questions, self.unquiet) = (0, 0, 0);
    }

    /// The line is open: the first words.
    pub fn begin(&mut self, now: Duration) {
        if self.status == PortStatus::Enabling {
            self.reader = Reader::default();
            self.ask(Asked::Attention(TRIES), text::SPOIL.to_owned(), now);
        }
    }

    /// Ends it: nothing that was written is gone to, no further move is sent. The move under way is
    /// finished by the controller.
    pub fn stop(&mut self) {
        self.target = None;
        if matches!(self.status, PortStatus::Ready | PortStatus::Enabling) {
            self.status = PortStatus::Stopped;
            self.reason = None;
        }
    }

    /// The line cannot be used any more.
    pub fn line_lost(&mut self, reason: String) {
        self.fail(PortStatus::Lost, reason);
    }

    /// Where the joints were last read to be.
    ///
    /// # Errors
    /// [`PortError::NotMeasured`], [`PortError::Nonsense`], [`PortError::Lost`].
    pub fn read_joints(&self, now: Duration) -> Result<JointReading<f64>, PortError> {
        if self.status == PortStatus::Lost {
            return Err(self.loss);
        }
        let (joints, at) = self.measured.ok_or(PortError::NotMeasured)?;
        let age = now.saturating_sub(at).as_micros();
        Ok(JointReading { joints, age_us: u32::try_from(age).unwrap_or(u32::MAX) })
    }

    /// Takes the newest set-point.
    ///
    /// # Errors
    /// [`PortError`]; the one before stays.
    pub fn write_set_point(&mut self, joints: &Joints<f64>, now: Duration) -> Result<(), PortError> {
        let (PortStatus::Ready, Some(convention)) = (self.status, &self.convention) else {
            return Err(PortError::NotReady(self.status));
        };
        if let Some((number, _)) = (1..).zip(joints).find(|(_, angle)| !angle.is_finite()) {
            return Err(PortError::NotFinite(number));
        }
        if let Some(number) = convention.outside(&self.sent, joints) {
            return Err(PortError::OutOfRange(number));
        }
        let accepted = self.target.map(|(joints, at)| (joints, now.saturating_sub(at)));
        self.pace.check(&Last { sent: self.sent, accepted }, joints)?;
        self.target = Some((*joints, now));
        Ok(())
    }

    /// Takes what came from the controller.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        for byte in bytes {
            if let Some(heard) = self.reader.push(*byte) {
                self.hear(heard, now);
            }
        }
        if let Some(Pending { asked: Asked::Quiet, since, .. }) = &mut self.pending
            && !bytes.is_empty()
        {
            *since = now;
            self.unquiet = self.unquiet.saturating_add(bytes.len());
            if self.unquiet > BABBLE {
                self.nonsense("the line does not become quiet");
            }
        }
    }

    /// Sees to what time brings: silence, the watchdog, the next exchange.
    pub fn tick(&mut self, now: Duration) {
        self.watch(now);
        if self.pending.is_some() {
            self.expire(now);
        } else if matches!(self.status, PortStatus::Ready | PortStatus::Stopped) {
            self.next(now);
        }
    }

    /// Too long without a set-point is a stop.
    fn watch(&mut self, now: Duration) {
        let late = self.target.is_some_and(|(_, at)| now.saturating_sub(at) > self.config.watchdog);
        if late && self.status == PortStatus::Ready {
            self.stop();
            let allowed = self.config.watchdog.as_millis();
            self.reason = Some(format!(
                "no set-point came for {allowed} ms, so the arm was stopped; enable it to go on"
            ));
        }
    }

    /// What waits for an answer for too long.
    fn expire(&mut self, now: Duration) {
        let Some(pending) = &self.pending else { return };
        let allowed = match pending.asked {
            Asked::Quiet => QUIET,
            Asked::StartUp => START_UP,
            Asked::Calibrate | Asked::Sure => CALIBRATION,
            _ => self.config.timeout,
        };
        if now.saturating_sub(pending.since) <= allowed {
            return;
        }
        match pending.asked {
            Asked::Quiet => self.settled(now),
            Asked::Attention(left) if left > 1 => {
                self.ask(Asked::Attention(left - 1), text::SPOIL.to_owned(), now);
            }
            _ => {
                let reason = format!(
                    "the controller did not answer {:?} within {} ms; check its power, the cable and the line's speed, then enable",
                    pending.sent,
                    allowed.as_millis()
                );
                self.fail(PortStatus::Lost, reason);
            }
        }
    }

    /// The next exchange of an arm that is ready or stopped.
    fn next(&mut self, now: Duration) {
        // stopped before it was found
        let Some(convention) = &self.convention else { return };
        let due = self.measured.is_none_or(|(_, at)| now.saturating_sub(at) >= self.config.where_period);
        if due {
            self.ask(Asked::Where, text::WHERE.to_owned(), now);
            return;
        }
        let Some((target, _)) = self.target else { return };
        let going = self.pace.step(&self.sent, &target);
        let point = text::hundredths(&convention.to_val(&going));
        if point == text::hundredths(&convention.to_val(&self.sent)) {
            return;
        }
        self.going = going;
        match self.config.dialect {
            Dialect::Point => self.ask(Asked::Point, text::POINT.to_owned(), now),
            Dialect::PPoint => self.ask(Asked::Set, text::set_point(&point), now),
        }
    }

    fn ask(&mut self, asked: Asked, sent: String, now: Duration) {
        self.output.push_str(&sent);
        self.output.push(text::END);
        let echoed = sent.is_empty();
        let pending = Pending { asked, sent, echoed, since: now, numbers: Vec::new(), uncalibrated: false };
        self.pending = Some(pending);
    }

    /// The controller answered with an error text.
    fn refused(&mut self, error: &str) {
        if text::is_not_calibrated(error) {
            self.uncalibrated = true;
            self.fail(PortStatus::NotHomed, format!("the controller says {error}: {NOT_CALIBRATED}"));
        } else {
            // VAL's errors are texts, without numbers
            let fault = PortFault { joint: None, code: 0 };
            self.fail(
                PortStatus::Fault(fault),
                format!("the controller says {error}; mend it at the arm, then enable"),
            );
        }
    }

    fn unknown_question(&mut self, question: &str) {
        let reason = format!(
            "the controller asks {question:?}, which is not answered for you; answer it at a terminal, then enable"
        );
        self.fail(PortStatus::Fault(PortFault { joint: None, code: 0 }), reason);
    }

    /// What makes no sense is a loss: no more is built on it.
    fn nonsense(&mut self, what: &str) {
        let reason = format!("{what}; check the cable and the line's speed, then enable");
        self.fail(PortStatus::Lost, reason);
        self.loss = PortError::Nonsense;
    }

    fn fail(&mut self, status: PortStatus, reason: String) {
        self.forget();
        (self.status, self.reason, self.loss) = (status, Some(reason), PortError::Lost);
    }

    fn forget(&mut self) {
        (self.target, self.pending) = (None, None);
        self.output.clear();
    }
}

/// Why an arm is not homed.
const NOT_CALIBRATED: &str = "the arm is not calibrated; bring it into a free place and begin again with \
     calibrate=yes in the address (it moves every joint a little), or give CAL at a terminal first";

#[cfg(test)]
mod tests;
