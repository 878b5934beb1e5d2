//! The master: what it makes of the frames that come, and which it sends in each cycle. It owns neither
//! bus nor clock nor thread.
//!
//! ```text
//!           open, or enable after a loss                        enable
//!                 |                                               |
//!             listening --> configuring --> idle (no torque) --> enabling --> running
//!                 \_____________\______________\__________________\____________/
//!                                              |  asked to stop, loss, fault, another master
//!                                           stopped (quick stop) -- enable --> enabling, or listening
//! ```
//!
//! What each phase does is in `phases`, what stops the arm in `judgement`.

mod judgement;
mod phases;

use super::cause::{Cause, DriveName};
use super::frame::{EMERGENCY, Frame, HEARTBEAT, NmtCommand, NmtState, SDO_ANSWER, SYNC, TPDO1};
use super::node::Node;
use crate::arm::port::PortStatus;
use crate::arm::puma560::Counts;
use crate::config::{CanopenConfig, CanopenConfigError, Homing, JOINTS, PumaConfig};
use core::fmt;
use judgement::Obedience;

/// How far a motor may be sent in a cycle, in cycles at the joint's largest speed: a set-point that
/// comes a cycle late and the next one then make one step of two.
const STEP_SHARE: f64 = 1.2;

/// After how long a drive that was told to stop has confirmed it or does not, microseconds.
const OBEYED_US: u64 = 100_000;

/// Heartbeat byte of an operational node.
const OPERATIONAL: u8 = 5;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Listening,
    Configuring,
    Idle,
    Enabling,
    Running,
    Stopped,
}

/// What went over the bus and what did not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Cycles with SYNC.
    pub cycles: u64,
    /// Of those, the ones that not every drive answered in time.
    pub incomplete: u64,
    /// SDO answers that nobody waited for.
    pub stale_answers: u64,
    /// EMCY messages with an error in them.
    pub emergencies: u64,
    /// Set-points that were sent to the drives.
    pub set_points: u64,
}

/// Why the arm was stopped and, where drives did not confirm it, which did: what the operator reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reason {
    cause: Cause,
    obeyed: Option<Obedience>,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.cause.fmt(f)?;
        self.obeyed.map_or(Ok(()), |obeyed| write!(f, "; {obeyed}"))
    }
}

/// The master of six drives.
#[derive(Debug)]
pub struct Master {
    config: CanopenConfig,
    nodes: [Node; JOINTS],
    phase: Phase,
    since_us: Option<u64>,
    cause: Option<Cause>,
    /// Whether operation is to be enabled as soon as that can be.
    wanted: bool,
    /// Whether the drives were told anything since the bus was opened.
    owning: bool,
    /// Whether PDOs are exchanged.
    operational: bool,
    /// What every drive is to be told as a node.
    command: Option<NmtCommand>,
    heartbeat_us: Option<u64>,
    set_point: Option<Counts>,
    goal: Counts,
    without_set_point: u32,
    counters: Counters,
    /// Bytes on the line that belong to no frame.
    garbage: u64,
    /// Which drives obeyed the last stop, where not all did.
    obeyed: Option<Obedience>,
}

impl Master {
    /// A master that has heard nothing yet.
    ///
    /// # Errors
    /// [`CanopenConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &CanopenConfig, puma: &PumaConfig) -> Result<Self, CanopenConfigError> {
        config.check()?;
        let speeds = motor_speeds(config, puma);
        let mut joints = (1..).zip(speeds);
        let nodes = config.nodes.map(|node| {
            // there is one for each
            let (joint, speed) = joints.next().unwrap_or_default();
            let step = libm::ceil(speed * config.period_s() * STEP_SHARE) as i32;
            Node::new(config, DriveName { joint, node }, step)
        });
        Ok(Self {
            config: *config,
            nodes,
            phase: Phase::Listening,
            since_us: None,
            cause: None,
            wanted: false,
            owning: false,
            operational: false,
            command: None,
            heartbeat_us: None,
            set_point: None,
            goal: [0; JOINTS],
            without_set_point: 0,
            counters: Counters::default(),
            garbage: 0,
            obeyed: None,
        })
    }

    // ---- what is asked of it

    /// Begins to switch on; after a stop or a loss, from where that needs.
    pub fn enable(&mut self) {
        match self.phase {
            Phase::Listening | Phase::Configuring | Phase::Idle => self.wanted = true,
            Phase::Enabling | Phase::Running => {}
            Phase::Stopped => {
                self.cause = None;
                if self.operational && self.nodes.iter().all(|node| node.missing == 0 && !node.restarted) {
                    self.begin_enabling();
                } else {
                    self.wanted = true;
                    self.owning = false;
                    self.operational = false;
                    self.enter(Phase::Listening);
                }
            }
        }
    }

    /// To rest; what was not begun is not begun any more.
    pub fn stop(&mut self) {
        self.wanted = false;
        if matches!(self.phase, Phase::Enabling | Phase::Running) {
            self.halt(Cause::Asked);
        }
    }

    /// Somebody has seen to it that every drive is homed ([`Homing::Confirm`]).
    pub fn confirm_homed(&mut self) {
        for node in &mut self.nodes {
            node.confirmed = true;
        }
    }

    /// The bus is gone.
    pub fn lose_bus(&mut self) {
        self.operational = false;
        self.owning = false;
        self.cause = Some(Cause::Bus);
        self.wanted = false;
        self.enter(Phase::Stopped);
    }

    /// Where the drives are to be sent in the next cycle; takes the place of any before. Without effect
    /// unless running.
    pub fn set_point(&mut self, counts: Counts) {
        if self.phase == Phase::Running {
            self.set_point = Some(counts);
        }
    }

    // ---- what it knows

    /// How the arm stands.
    #[must_use]
    pub fn status(&self) -> PortStatus {
        match (self.phase, &self.cause) {
            (Phase::Running, _) => PortStatus::Ready,
            (Phase::Enabling, _) => PortStatus::Enabling,
            (Phase::Stopped, Some(cause)) => cause.status(),
            (Phase::Idle, _) if self.not_homed().is_some() => PortStatus::NotHomed,
            _ if self.wanted => PortStatus::Enabling,
            _ => PortStatus::Disabled,
        }
    }

    /// Why it was stopped.
    #[must_use]
    pub const fn cause(&self) -> Option<Cause> {
        self.cause
    }

    /// Why it was stopped and, where drives did not confirm it, which did: what the operator reads.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.cause.map(|cause| Reason { cause, obeyed: self.obeyed })
    }

    /// Where the drives are, and when the oldest of these positions came.
    #[must_use]
    pub fn positions(&self) -> Option<(Counts, u64)> {
        let mut counts = [0; JOINTS];
        let mut oldest = u64::MAX;
        for (count, node) in counts.iter_mut().zip(&self.nodes) {
            *count = node.position?;
            oldest = oldest.min(node.position_us);
        }
        Some((counts, oldest))
    }

    /// Where the drives were last sent: while they are being enabled, where they are.
    #[must_use]
    pub fn targets(&self) -> Counts {
        let mut targets = [0; JOINTS];
        for (target, node) in targets.iter_mut().zip(&self.nodes) {
            *target = node.target;
        }
        targets
    }

    /// What went over the bus.
    #[must_use]
    pub const fn counters(&self) -> Counters {
        self.counters
    }

    /// The first drive whose positions are not to be trusted.
    fn not_homed(&self) -> Option<DriveName> {
        let lacking = |node: &&Node| match self.config.homing {
            Homing::Absolute => false,
            Homing::StatusBit(bit) => !node.has_status_bit(bit),
            Homing::Confirm => !node.confirmed,
        };
        self.nodes.iter().find(lacking).map(|node| node.name)
    }

    // ---- what comes in

    /// Takes a frame that somebody else sent.
    pub fn receive(&mut self, now_us: u64, frame: &Frame) {
        if let Some(foreign) = self.foreign(frame) {
            self.consider(Cause::OtherMaster(foreign));
            return;
        }
        let moving = matches!(self.phase, Phase::Enabling | Phase::Running);
        let Some(node) = self.nodes.iter_mut().find(|node| node.name.node == frame.node()) else { return };
        match (frame.function(), frame.data()) {
            (TPDO1, data) if self.operational => node.feedback(now_us, data, moving),
            (SDO_ANSWER, data) => self.counters.stale_answers += u64::from(!node.sdo_answer(data)),
            (HEARTBEAT, &[byte]) => {
                if let Some(state) = NmtState::of(byte) {
                    node.heartbeat(now_us, state);
                }
            }
            (EMERGENCY, &[low, high, ..]) => {
                node.error = u16::from_le_bytes([low, high]);
                self.counters.emergencies += u64::from(node.error != 0);
            }
            _ => {}
        }
    }

    /// So many bytes since the bus was opened belong to no frame.
    pub const fn hear_garbage(&mut self, bytes: u64) {
        self.garbage = bytes;
    }

    // ---- the cycle

    /// Ends the cycle that is over, decides, and gives the frames that begin the next one.
    pub fn cycle(&mut self, now_us: u64, out: &mut impl Extend<Frame>) {
        let since_us = *self.since_us.get_or_insert(now_us);
        let in_phase_us = now_us.saturating_sub(since_us);
        if self.operational {
            let mut complete = true;
            for node in &mut self.nodes {
                complete &= node.end_cycle();
            }
            self.counters.incomplete += u64::from(!complete);
            if let Some(cause) = self.judge(now_us) {
                self.consider(cause);
            }
        }
        match self.phase {
            Phase::Listening => {
                if in_phase_us >= u64::from(self.config.listen_ms) * 1_000 {
                    self.begin_configuring();
                }
            }
            Phase::Configuring => self.configure(),
            Phase::Idle => self.idle(),
            Phase::Enabling => self.enabling(in_phase_us),
            Phase::Running => self.running(),
            Phase::Stopped => {
                self.stopped();
                if in_phase_us >= OBEYED_US && self.operational && self.obeyed.is_none() {
                    self.obeyed = self.obedience();
                }
            }
        }
        self.emit(now_us, out);
    }

    fn halt(&mut self, cause: Cause) {
        self.cause = Some(cause);
        self.wanted = false;
        self.set_point = None;
        self.enter(Phase::Stopped);
        self.stopped();
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.since_us = None;
        self.obeyed = None;
    }

    fn emit(&mut self, now_us: u64, out: &mut impl Extend<Frame>) {
        if !self.owning {
            return;
        }
        if let Some(command) = self.command.take() {
            out.extend(self.nodes.iter().map(|node| command.to(node.name.node)));
        }
        let every_us = u64::from(self.config.heartbeat_ms) * 1_000;
        if self.heartbeat_us.is_none_or(|last| now_us.saturating_sub(last) >= every_us) {
            self.heartbeat_us = Some(now_us);
            out.extend([Frame::of(HEARTBEAT, self.config.master, [OPERATIONAL])]);
        }
        if self.operational {
            out.extend(self.nodes.iter().map(Node::command));
            out.extend([Frame::of(SYNC, 0, [])]);
            self.counters.cycles += 1;
        }
        // what is not urgent comes after SYNC
        out.extend(self.nodes.iter_mut().filter_map(|node| node.sdo_request(now_us)));
    }
}

/// The largest speed of each motor, counts per second: that of its joint, and what the earlier motors
/// turn of it, to be made up for.
fn motor_speeds(config: &CanopenConfig, puma: &PumaConfig) -> [f64; JOINTS] {
    let mut speeds = [0.0f64; JOINTS];
    for (place, (row, joint)) in config.coupling.iter().zip(&puma.joints).enumerate() {
        let carried: f64 = row.iter().zip(&speeds).map(|(share, speed)| share.abs() * speed).sum();
        if let Some(speed) = speeds.get_mut(place) {
            *speed = joint.max_speed_rad_s + carried;
        }
    }
    for (speed, counts) in speeds.iter_mut().zip(&config.counts_per_rad) {
        *speed *= counts.abs();
    }
    speeds
}
