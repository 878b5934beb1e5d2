//! The slave station at the end of whatever carries an operator's packets: motion and buttons of one operator
//! in, the arm's state out.
//!
//! - What came is as old as this station's own clock says. Silence is no release and no press: after the
//!   law's times the arm stops, and goes on or waits for a press as the law has it.
//! - The stop begins within the command timeout (100 ms by default) of the last motion that came: a cycle and
//!   a [`LATE_SHARE`]th are taken off, since the cycle in which a motion has grown too old may be the next one,
//!   and the computer may run that one late.
//! - Buttons are states and counts, so a lost packet loses nothing: a stop is asked for as long as it is
//!   pressed, a reset by a count that is another than before. The first packet of a session asks for none.
//! - A reset answers how the arm stands. One that was asked for before somebody at the arm stopped it, before
//!   a fault, or while nothing was heard, is no answer to that: it is refused, and has to be asked for again.
//! - Whether a packet counts at all (its session, its number) was decided by the carrier. Where it says
//!   that the operator's session is another, the one before has ended: the arm comes to rest at once, and
//!   takes a release and a press.

use super::resetting::{Reset, Resetting};
use super::settling::Settling;
use super::{Cycle, EnableThenReset, Station};
use crate::arm::port::{PortError, RobotPort};
use crate::arm::puma560::Joints;
use crate::arm::slave::Stamp;
use crate::arm::teleop::{Counts, Order, State};
use crate::config::{SlaveConfig, SlaveConfigError};
use crate::geometry::Pose;
use crate::real::Real;
use crate::wire::{ArmStatePacket, ButtonsPacket, CommandEcho, MotionPacket};
use core::fmt;

/// How often the arm's state is told while nothing new is, microseconds.
const TELL_US: u64 = 10_000;

/// Who was not heard for so long has not seen how the arm stands, microseconds: buttons are told each 20 ms.
const UNHEARD_US: u64 = 500_000;

/// Cycles may come late by this part of the command timeout, and the stop still begins within it: 10 ms of
/// 100. Between processes on two busy cores 2 to 8 ms were seen, where nothing asks for real-time priority.
const LATE_SHARE: u32 = 10;

/// A slave with its arm and its operator.
pub struct OperatedSlave<T, P> {
    station: Station<T, P>,
    session: u32,
    sequence: u32,
    told_us: Option<u64>,
    /// The session that the operator's packets are of.
    operator: Option<u32>,
    buttons: Option<(ButtonsPacket, u64)>,
    /// The resets that the operator had asked for when the arm's stop was news; `None` until that is known.
    resets: Option<u32>,
    /// How the arm stood after the last cycle.
    state: State,
    /// When the arm was stopped, or failed, without the operator.
    stopped_us: Option<u64>,
    /// Somebody at the arm has stopped it since the last cycle.
    stopped_here: bool,
    resetting: Option<Resetting>,
    refused: Option<NoReset>,
    /// The newest motion that was taken, until it is followed.
    fresh: Option<Fresh>,
    /// The last cycle followed a motion that no cycle had followed before.
    followed: bool,
    command: Option<CommandEcho>,
    settling: Settling<T>,
}

/// Why a reset of the operator was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoReset {
    /// The arm does not allow it.
    Refused(EnableThenReset),
    /// It was asked for by somebody who could not know how the arm stands.
    Outdated,
}

impl fmt::Display for NoReset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Outdated => f.write_str(
                "it was asked for before the arm was stopped, or while the link was down; ask again",
            ),
        }
    }
}

impl core::error::Error for NoReset {}

/// A motion that has come and was not followed yet.
#[derive(Clone, Copy, Debug)]
struct Fresh {
    session: u32,
    sequence: u32,
    received_us: u64,
}

impl<T: fmt::Debug, P> fmt::Debug for OperatedSlave<T, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OperatedSlave").field("station", &self.station).finish_non_exhaustive()
    }
}

impl<T: Real, P: RobotPort<T>> OperatedSlave<T, P> {
    /// A slave that is stopped; its arm is switched on by the operator's first reset. `session` is what
    /// this station's packets are of.
    ///
    /// # Errors
    /// [`SlaveConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &SlaveConfig, port: P, session: u32) -> Result<Self, SlaveConfigError> {
        config.check()?;
        let mut config = *config;
        let timeout_us = &mut config.teleop.command_timeout_us;
        let late_us = *timeout_us / LATE_SHARE;
        // a timeout that is no longer than a cycle has nothing to give
        *timeout_us = timeout_us.saturating_sub(config.governor.cycle_us + late_us).max(1);
        Ok(Self {
            station: Station::new(&config, port)?,
            session,
            sequence: 0,
            told_us: None,
            operator: None,
            buttons: None,
            resets: None,
            state: State::Stopped,
            stopped_us: None,
            stopped_here: false,
            resetting: None,
            refused: None,
            fresh: None,
            followed: false,
            command: None,
            settling: Settling::new(),
        })
    }

    /// The slave and its arm.
    #[must_use]
    pub const fn station(&self) -> &Station<T, P> {
        &self.station
    }

    /// The arm's port, for what only it can do.
    pub const fn port_mut(&mut self) -> &mut P {
        self.station.port_mut()
    }

    /// How many commands came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.station.counts()
    }

    /// Why the operator's last reset was not done, once.
    pub const fn take_refusal(&mut self) -> Option<NoReset> {
        self.refused.take()
    }

    /// The newest motion that moved the arm, and when it passed each stage.
    #[must_use]
    pub const fn command(&self) -> Option<CommandEcho> {
        self.command
    }

    /// Somebody at the arm stops it. The operator may reset it, once the stop is known there.
    pub const fn stop(&mut self) {
        self.station.stop();
        self.stopped_here = true;
        self.resetting = None;
    }

    /// The station ends: the arm comes to rest, and no reset of the operator changes that. To be called in
    /// each cycle until it has.
    pub const fn end(&mut self) {
        self.station.end();
        self.resetting = None;
    }

    /// Stops the arm at its port too, as at the end of a run, and tells so.
    ///
    /// # Errors
    /// [`PortError`] where the port cannot be told.
    pub fn shut_down(&mut self) -> Result<(), PortError> {
        self.station.shut_down()
    }

    /// Begins a cycle, before what came is taken.
    pub fn begin_cycle(&mut self, now_us: u64) {
        if core::mem::replace(&mut self.stopped_here, false) {
            self.stopped_at(now_us);
        }
    }

    /// The carrier lets through packets of one session at a time: another has taken that one's place.
    fn hear_session(&mut self, session: u32) {
        let before = self.operator.replace(session);
        if before.is_some_and(|before| before != session) {
            self.station.end_sender();
        }
    }

    /// Takes a motion that came at `received_us` of this station's clock. Whether it was taken: what is
    /// refused is counted, and told with the state that it leads to.
    pub fn take_motion(&mut self, motion: &MotionPacket, received_us: u64) -> bool {
        self.hear_session(motion.session);
        let taken = self.station.take(motion, received_us).is_ok();
        if taken {
            let MotionPacket { session, sequence, .. } = *motion;
            self.fresh = Some(Fresh { session, sequence, received_us });
        }
        taken
    }

    /// Takes the operator's buttons that came at `received_us` of this station's clock. `told_us` is when
    /// they were told, by this clock; where that is not known, when they came.
    pub fn take_buttons(&mut self, buttons: &ButtonsPacket, received_us: u64, told_us: u64, now_us: u64) {
        self.hear_session(buttons.session);
        let before = self.buttons.replace((*buttons, received_us));
        self.station.press_is_for(buttons.press_for, buttons.scale);
        self.station.hold_to_run(buttons.pressed, received_us);
        if buttons.stop {
            self.station.stop();
            self.resetting = None;
        }
        let heard = before.is_some_and(|(before, heard_us)| {
            before.session == buttons.session && received_us.saturating_sub(heard_us) <= UNHEARD_US
        });
        let knows = heard && self.stopped_us.is_none_or(|stopped_us| told_us > stopped_us);
        let known = self.resets.replace(buttons.resets);
        let same_session = before.is_some_and(|(before, _)| before.session == buttons.session);
        if buttons.stop || !same_session || known == Some(buttons.resets) {
            return;
        }
        if knows && known.is_some() {
            self.resetting = Some(Resetting::asked(now_us));
            self.refused = None;
        } else if before.is_some_and(|(before, _)| before.resets != buttons.resets) {
            self.refused = Some(NoReset::Outdated);
        }
    }

    /// The rest of the cycle, after what came: the law, the limits and the port. `clock` tells when its
    /// stages were done.
    pub fn cycle(&mut self, now_us: u64, clock: impl Fn() -> u64) -> Cycle<T> {
        self.go_on_resetting(now_us);
        let before = self.state;
        let cycle = self.station.cycle_by(now_us, clock);
        self.state = cycle.step.decision.status.state();
        if self.state == State::Fault && before != State::Fault {
            self.stopped_at(now_us);
        }
        self.followed = self.follow(&cycle, now_us);
        cycle
    }

    /// Tells the arm's state, where it is due: `send` says whether it could be sent.
    pub fn tell(&mut self, cycle: &Cycle<T>, now_us: u64, send: impl FnOnce(ArmStatePacket) -> bool) {
        let due = self.told_us.is_none_or(|told_us| now_us.saturating_sub(told_us) >= TELL_US);
        if !(self.followed || due) {
            return;
        }
        let age_us = |heard_us: u64| u32::try_from(now_us.saturating_sub(heard_us)).unwrap_or(u32::MAX);
        let stamp = Stamp {
            session: self.session,
            sequence: self.sequence,
            time_us: now_us,
            command: self.command,
            settled: self.settling.settled(),
            buttons_age_us: self.buttons.map(|(_, heard_us)| age_us(heard_us)),
        };
        // numbers that may not be sent are no reason to hold up the arm: its fault tells the same
        if send(cycle.step.report(&cycle.reading, &stamp)) {
            self.sequence = self.sequence.wrapping_add(1);
        }
        self.told_us = Some(now_us);
    }

    /// The arm was stopped, or has failed, without the operator: whatever is asked for until that is known
    /// there is no answer to it.
    const fn stopped_at(&mut self, now_us: u64) {
        self.stopped_us = Some(now_us);
        self.resets = None;
        self.resetting = None;
    }

    fn go_on_resetting(&mut self, now_us: u64) {
        let Some(mut resetting) = self.resetting.take() else { return };
        match resetting.go_on(&mut self.station, now_us) {
            Reset::Done => {}
            Reset::Waits => self.resetting = Some(resetting),
            Reset::Refused(refusal) => self.refused = Some(NoReset::Refused(refusal)),
        }
    }

    /// Notes which motion the arm was moved by and which it has reached; whether there is a new one.
    fn follow(&mut self, cycle: &Cycle<T>, now_us: u64) -> bool {
        if let Some(reading) = &cycle.reading.joints {
            self.settling.measured(&reading.joints, now_us.saturating_sub(u64::from(reading.age_us)));
        }
        let Order::Follow(goal) = &cycle.step.decision.order else {
            self.fresh = None;
            self.settling.let_go();
            return false;
        };
        let (Some(fresh), Some(written_us)) = (self.fresh.take(), cycle.written_us) else { return false };
        if self.command.is_some_and(|before| before.session != fresh.session) {
            self.settling.restart();
        }
        let after = |us: u64| u32::try_from(us.saturating_sub(fresh.received_us)).unwrap_or(u32::MAX);
        self.command = Some(CommandEcho {
            session: fresh.session,
            sequence: fresh.sequence,
            received_us: fresh.received_us,
            solved_after_us: after(cycle.solved_us),
            written_after_us: after(written_us),
        });
        // the port has been told: there is time now
        if let Some(joints) = self.goal_joints(cycle, goal) {
            self.settling.goal(fresh.sequence, fresh.received_us, joints);
        }
        true
    }

    /// The joints at the goal, as the arm stands now.
    fn goal_joints(&self, cycle: &Cycle<T>, goal: &Pose<T>) -> Option<Joints<T>> {
        let set_point = cycle.step.governed?.set_point;
        let arm = self.station.slave().arm();
        let solutions = arm.inverse(goal, &set_point).ok()?;
        solutions.get(arm.configuration(&set_point)).map(|solution| solution.joints)
    }
}
