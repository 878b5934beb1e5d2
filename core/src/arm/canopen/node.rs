//! One drive as the master sees it: what it told last, how long ago, and what it is to be told.

use super::cause::{Cause, DriveName, Nonsense};
use super::cia402::{DISABLE_VOLTAGE, ENABLE_OPERATION, FAULT_RESET, QUICK_STOP, State};
use super::frame::{Frame, NmtState, RPDO1};
use super::sdo::{AbortCode, Answer, Client, Request};
use super::setup::{DEVICE_PROFILE_402, ERROR_CODE, Step, Steps, steps};
use crate::config::CanopenConfig;

/// Answers in a row that make no sense before the drive is not believed.
const NONSENSE_IN_A_ROW: u32 = 3;

/// Cycles for which a fault reset is tried, and from one rising edge to the next.
const RESET_CYCLES: u32 = 100;
const RESET_EVERY: u32 = 10;

/// Cycles without motion after which an axis is at rest.
const REST_CYCLES: u32 = 10;

/// How often the mode of operation is asked for before it is not taken up, once a cycle.
const MODE_QUESTIONS: u32 = 50;

/// How many times its largest speed a position may seem to have moved.
const BELIEVED_SPEEDS: u32 = 4;
/// Counts that are believed on top of it: an encoder's noise.
const BELIEVED_COUNTS: i64 = 16;

/// How far the set-up of a drive is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// Not to the end.
    Busy,
    /// Everything is written.
    Done,
}

/// One drive.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) name: DriveName,
    /// The farthest that its motor can turn in a cycle, counts.
    pub(super) step: i32,
    steps: Steps,
    at: usize,
    questions: u32,
    sdo: Client,
    pub(super) nmt: Option<NmtState>,
    heartbeat_us: Option<u64>,
    pub(super) status: Option<u16>,
    pub(super) position: Option<i32>,
    pub(super) position_us: u64,
    fresh: bool,
    /// Cycles in a row without a TPDO.
    pub(super) missing: u32,
    nonsense: u32,
    what: Option<Nonsense>,
    /// The last error code that it told, by EMCY or when asked.
    pub(super) error: u16,
    /// Restarted, or with another NMT state than it was put in, since it was set up.
    pub(super) restarted: bool,
    pub(super) confirmed: bool,
    resetting: u32,
    still: u32,
    still_at: i32,
    /// Where it is sent.
    pub(super) target: i32,
    /// The controlword it is sent.
    pub(super) control: u16,
}

impl Node {
    pub(super) fn new(config: &CanopenConfig, name: DriveName, step: i32) -> Self {
        Self {
            name,
            step,
            steps: steps(config, name.node),
            at: 0,
            questions: 0,
            sdo: Client::new(name.node, u64::from(config.sdo_timeout_ms) * 1_000),
            nmt: None,
            heartbeat_us: None,
            status: None,
            position: None,
            position_us: 0,
            fresh: false,
            missing: 0,
            nonsense: 0,
            what: None,
            error: 0,
            restarted: false,
            confirmed: false,
            resetting: 0,
            still: 0,
            still_at: 0,
            target: 0,
            control: DISABLE_VOLTAGE,
        }
    }

    /// Begins the set-up anew: nothing that was heard before counts.
    pub(super) fn begin(&mut self) {
        self.at = 0;
        self.questions = 0;
        self.sdo.reset();
        self.nmt = None;
        self.heartbeat_us = None;
        self.status = None;
        self.position = None;
        self.missing = 0;
        self.nonsense = 0;
        self.error = 0;
        self.restarted = false;
        self.control = DISABLE_VOLTAGE;
    }

    pub(super) fn state(&self) -> Option<State> {
        self.status.and_then(State::of)
    }

    /// Whether bit `bit` of the last statusword is set.
    pub(super) fn has_status_bit(&self, bit: u8) -> bool {
        self.status.is_some_and(|word| word >> (bit & 15) & 1 == 1)
    }

    // ---- what comes in

    pub(super) fn heartbeat(&mut self, now_us: u64, state: NmtState) {
        self.heartbeat_us = Some(now_us);
        self.nmt = Some(state);
        if state == NmtState::BootUp {
            self.restarted = true;
            self.confirmed = false;
        }
    }

    /// Whether a frame of the node's SDO channel was the answer that was waited for.
    pub(super) fn sdo_answer(&mut self, data: &[u8]) -> bool {
        self.sdo.receive(data)
    }

    /// A TPDO1. `moving` is whether the position has to be one that the joint can have come to.
    pub(super) fn feedback(&mut self, now_us: u64, data: &[u8], moving: bool) {
        let nonsense = match *data {
            [a, b, c, d, e, f] => {
                let word = u16::from_le_bytes([a, b]);
                let position = i32::from_le_bytes([c, d, e, f]);
                let moved = self.position.map_or(0, |last| i64::from(position) - i64::from(last));
                let cycles = i64::from(self.missing) + 1;
                let believed = i64::from(BELIEVED_SPEEDS) * i64::from(self.step) * cycles + BELIEVED_COUNTS;
                if State::of(word).is_none() {
                    Nonsense::Status(word)
                } else if moving && moved.abs() > believed {
                    Nonsense::Jump(moved)
                } else {
                    self.accept(now_us, word, position);
                    return;
                }
            }
            _ => Nonsense::Length(data.len() as u8),
        };
        self.nonsense += 1;
        self.what = Some(nonsense);
    }

    fn accept(&mut self, now_us: u64, word: u16, position: i32) {
        self.status = Some(word);
        self.position = Some(position);
        self.position_us = now_us;
        self.fresh = true;
        self.nonsense = 0;
        // only an operational node sends PDOs: a heartbeat from before it was started is outdated
        self.nmt = Some(NmtState::Operational);
    }

    // ---- once a cycle

    /// Whether the drive answered the last SYNC; counts those it did not.
    pub(super) fn end_cycle(&mut self) -> bool {
        let fresh = core::mem::take(&mut self.fresh);
        self.missing = if fresh { 0 } else { self.missing.saturating_add(1) };
        if let (true, Some(position)) = (fresh, self.position) {
            // a tenth of a cycle at full speed: noise, not motion
            if (i64::from(position) - i64::from(self.still_at)).abs() <= i64::from(self.step / 10).max(2) {
                self.still = self.still.saturating_add(1);
            } else {
                self.still = 0;
                self.still_at = position;
            }
        }
        fresh
    }

    fn is_at_rest(&self) -> bool {
        self.still >= REST_CYCLES
    }

    /// What is wrong with what was heard, the other drives aside.
    pub(super) fn complaint(&self, now_us: u64, heartbeat_timeout_us: u64, missing: u32) -> Option<Cause> {
        if let (true, Some(what)) = (self.nonsense >= NONSENSE_IN_A_ROW, self.what) {
            return Some(Cause::Nonsense(self.name, what));
        }
        if self.restarted {
            return Some(Cause::Restarted(self.name));
        }
        let late = self.heartbeat_us.is_some_and(|at| now_us.saturating_sub(at) > heartbeat_timeout_us);
        if late || self.missing >= missing {
            return Some(Cause::Silent(self.name));
        }
        None
    }

    /// A step on in the set-up: the answer to the last request, and the next request.
    pub(super) fn configure(&mut self) -> Result<Progress, Cause> {
        let Some(step) = self.steps.get(self.at).copied() else { return Ok(Progress::Done) };
        if let Some(answer) = self.sdo.take_answer() {
            let object = step.object();
            let value = match answer {
                Answer::Value(value) => Some(value),
                Answer::Silence => return Err(Cause::Silent(self.name)),
                Answer::Nonsense => return Err(Cause::Nonsense(self.name, Nonsense::Answer(object))),
                Answer::Abort(code) if matches!(step, Step::Try(_)) && code.is_absence() => None,
                Answer::Abort(code) => return Err(self.refusal(&step, code)),
            };
            match (step, value) {
                (Step::DeviceType, Some(device)) if device & 0xFFFF != DEVICE_PROFILE_402 => {
                    return Err(Cause::NotADrive(self.name, device));
                }
                (Step::Vendor(want), Some(vendor)) if vendor != want => {
                    return Err(Cause::OtherVendor(self.name, vendor));
                }
                (Step::Mode, Some(mode)) if mode != u32::from(super::cia402::CYCLIC_SYNCHRONOUS_POSITION) => {
                    self.questions += 1;
                    if self.questions == MODE_QUESTIONS {
                        return Err(Cause::OtherMode(self.name, mode as u8));
                    }
                }
                _ => self.at += 1,
            }
        }
        match self.steps.get(self.at) {
            None => Ok(Progress::Done),
            Some(step) => {
                if self.sdo.is_idle() {
                    self.sdo.ask(step.request());
                }
                Ok(Progress::Busy)
            }
        }
    }

    fn refusal(&self, step: &Step, code: AbortCode) -> Cause {
        match step {
            // a node without a device type is no drive either
            Step::DeviceType => Cause::NotADrive(self.name, 0),
            _ => Cause::Refused(self.name, step.object(), code),
        }
    }

    /// Asks for the error code, unless it is known or being asked for; takes the answer.
    pub(super) fn learn_error(&mut self) {
        match self.sdo.take_answer() {
            Some(Answer::Value(code)) if self.error == 0 => self.error = code as u16,
            // a drive without the object stays at 0: unknown
            Some(_) => {}
            None if self.error == 0 && self.sdo.is_idle() => self.sdo.ask(Request::Read(ERROR_CODE)),
            None => {}
        }
    }

    /// The SDO frame that is due.
    pub(super) fn sdo_request(&mut self, now_us: u64) -> Option<Frame> {
        self.sdo.poll(now_us)
    }

    // ---- what it is told

    /// Resets the drive's fault in the next cycles, if it has one.
    pub(super) fn begin_reset(&mut self) {
        self.resetting = if self.state().is_some_and(State::is_fault) { RESET_CYCLES } else { 0 };
        self.error = 0;
        self.sdo.reset();
    }

    /// Whether its fault is still being reset.
    pub(super) const fn is_resetting(&self) -> bool {
        self.resetting > 0
    }

    /// Where the axis is, as long as it does not follow targets: when it begins to, nothing moves.
    fn follow_position(&mut self) {
        if let Some(position) = self.position {
            self.target = position;
        }
    }

    /// Without torque, but never by letting go of a moving axis.
    pub(super) fn tell_idle(&mut self) {
        self.follow_position();
        self.control = match self.state() {
            Some(State::OperationEnabled) => QUICK_STOP,
            Some(State::QuickStopActive) if !self.is_at_rest() => QUICK_STOP,
            _ => DISABLE_VOLTAGE,
        };
    }

    /// To rest, and to stay there.
    pub(super) fn tell_stop(&mut self) {
        self.follow_position();
        self.control = QUICK_STOP;
    }

    /// A step towards operation. `patient` is whether a drive that holds in quick stop is still asked
    /// to go on from there, rather than switched off and on.
    pub(super) fn tell_enable(&mut self, patient: bool) {
        let Some(state) = self.state() else {
            self.control = DISABLE_VOLTAGE;
            return;
        };
        if state != State::OperationEnabled {
            self.follow_position();
        }
        if state != State::Fault {
            self.resetting = 0;
        }
        self.control = match state {
            State::Fault if self.resetting > 0 => {
                self.resetting -= 1;
                if self.resetting.is_multiple_of(RESET_EVERY) { DISABLE_VOLTAGE } else { FAULT_RESET }
            }
            State::QuickStopActive if !self.is_at_rest() => QUICK_STOP,
            State::QuickStopActive if !patient => DISABLE_VOLTAGE,
            state => state.towards_operation(),
        };
    }

    /// Nearer to `set_point`, no farther than the motor can go in a cycle.
    pub(super) fn tell_target(&mut self, set_point: i32) {
        let (least, most) = (self.target.saturating_sub(self.step), self.target.saturating_add(self.step));
        self.target = set_point.max(least).min(most);
        self.control = ENABLE_OPERATION;
    }

    /// The frame with controlword and target.
    pub(super) fn command(&self) -> Frame {
        let [a, b] = self.control.to_le_bytes();
        let [c, d, e, f] = self.target.to_le_bytes();
        Frame::of(RPDO1, self.name.node, [a, b, c, d, e, f])
    }
}
