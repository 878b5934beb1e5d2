//! The slave's law: from the hand's motion to a goal for the arm, and when the arm may move at all.
//! Section 5; the states, the latch and the limits are ours.
//!
//! ```text
//!              reset                press                nothing to follow
//!   stopped ----------> armed ---------------> engaged <------------------> hold
//!     fault ------------^   ^                     |                           |
//!                           |       release       |  release, held for too long
//!                           +---------------------+---------------------------+
//!
//!   stop from anywhere, two senders ------> stopped
//!   the arm is not in order --------------> fault
//! ```
//!
//! | job | file |
//! |---|---|
//! | a command and what may be wrong with it | `command` |
//! | newest wins, one sender, counts | `inbox` |
//! | what the newest says | `newest` |
//! | the operator's button and its freshness | `hold_to_run` |
//! | hand -> goal | `law` |
//! | states, reasons, notes and their texts | `status` |
//! | what is told of the arm, what is decided | `decision` |
//!
//! - **Hold-to-run.** The arm moves while the button is heard to be pressed AND the commands say
//!   engaged, both fresh on this receiver's clock. Pressed is not enough: it takes a fresh press, that
//!   is one after a release that was heard. Where the commands carry the button, tell both:
//!   `take(&command)`, then `hold_to_run(command.engaged, command.received_us)` if it was taken.
//! - **Latch.** The press latches the hand and the arm's set-point, never what is measured, so an arm
//!   that sags does not creep from clutch to clutch. The scale is that of the press too. From there the goal is a function of where the
//!   hand is; lost commands lose nothing. The motion between the sender's latch and the first command
//!   that came counts too, where both are known to be younger than the press and are believed
//!   ([`BelievedMotion`](crate::config::BelievedMotion)).
//! - **Dropouts.** A hold ends by itself where the hand is believed to have moved from where it was
//!   last followed to where it is now: then the goal goes there, at most `most_m` away, and nothing
//!   is lost. Otherwise the hand is latched anew where it is and the arm stays: no jump; the hand's way
//!   while unseen is not followed. (Re-latching always, as others do, would lose motion with every
//!   burst of lost packets; resuming always would throw the arm after a long one.) After `resume_us`
//!   the operator has to let go and press again.
//! - **Home.** A press that is for going home ([`PressFor`]) moves the arm there while it is heard, as long as
//!   a command stands without being heard again; the hand plays no part in it. A press that goes on for
//!   something else has ended.
//! - **Stop.** A stop latches. What comes while stopped is looked at only to know old from new; the
//!   reset forgets it.
//!
//! Nothing here reads a clock: times are arguments, microseconds of one clock of the receiver that
//! only goes forward. [`Teleop`] is plain data, a copy of it behaves alike. Nothing panics or allocates.

mod command;

mod inbox;

mod newest;

mod hold_to_run;

mod status;

mod decision;

mod law;

pub use command::{BadCommand, Command, CommandRefusal};
pub use decision::{ArmCondition, ArmView, Decision, Order, ResetRefusal, Uncertainty};
pub use inbox::Counts;
pub use status::{ArmedReason, FaultReason, HoldReason, Note, Notes, State, Status, StopReason};

use crate::config::{TeleopConfig, TeleopConfigError, TeleopMode};
use crate::geometry::Pose;
use crate::hand::state::PoseState;
use crate::real::Real;
use crate::wire::{PressFor, ScaleShare};
use hold_to_run::HoldToRun;
use inbox::{Admitted, Inbox};
use law::{Follow, Law};
use newest::{Newest, SenderLatch};

#[cfg(test)]
pub(in crate::arm) mod tests;

/// The law of one arm, in f32 or f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Teleop<T> {
    config: TeleopConfig,
    law: Law<T>,
    phase: Phase<T>,
    inbox: Inbox,
    button: HoldToRun,
    /// What the next press is for, and how far the hand leads by it.
    press_for: PressFor,
    scale: ScaleShare,
    /// The newest command; `None` before the first and after a reset.
    newest: Option<Newest<T>>,
    /// The latch of the hand that the newest command tells from, if its beginning was heard.
    latch: Option<SenderLatch>,
    /// When the last measured hand came.
    measured_us: Option<u64>,
    /// `paper` mode: the increments that came since the last step.
    pending: Option<Pose<T>>,
    now_us: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase<T> {
    Stopped(StopReason),
    Fault(FaultReason),
    /// With what it wants: [`ArmedReason::Press`] once a release was heard.
    Armed(ArmedReason),
    Running(Running<T>),
}

/// Engaged or hold.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Running<T> {
    /// `None` until the hand is latched.
    followed: Option<Followed<T>>,
    /// When the hand was last followed, or hold-to-run was pressed.
    since_us: u64,
    press_for: PressFor,
    /// Metres of the tool for one of the hand.
    scale: T,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Followed<T> {
    follow: Follow<T>,
    engagements: u32,
    /// When the hand that was last followed was seen, sender's clock.
    capture_us: u64,
}

impl<T: Real> Teleop<T> {
    /// A law that is stopped and has heard nothing.
    ///
    /// # Errors
    /// [`TeleopConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &TeleopConfig) -> Result<Self, TeleopConfigError> {
        config.check()?;
        Ok(Self {
            config: *config,
            law: Law::new(config),
            phase: Phase::Stopped(StopReason::Started),
            inbox: Inbox::new(),
            button: HoldToRun::unheard(),
            press_for: PressFor::Follow,
            scale: ScaleShare::FULL,
            newest: None,
            latch: None,
            measured_us: None,
            pending: None,
            now_us: 0,
        })
    }

    /// The settings.
    #[must_use]
    pub const fn config(&self) -> &TeleopConfig {
        &self.config
    }

    /// How many commands came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.inbox.counts
    }

    /// Takes a command as it comes. Only the newest counts.
    ///
    /// # Errors
    /// [`CommandRefusal`]; the command is dropped and counted. One with numbers that cannot be used
    /// makes the arm hold, one of a second sender stops it.
    pub fn take(&mut self, command: &Command) -> Result<(), CommandRefusal> {
        let received_us = command.received_us;
        self.now_us = self.now_us.max(received_us);
        let silence_us = self.config.resume_us;
        let admitted = self.inbox.admit(command.session, command.sequence, received_us, silence_us);
        if admitted == Err(CommandRefusal::AnotherSender)
            && matches!(self.phase, Phase::Armed(_) | Phase::Running(_))
        {
            self.phase = Phase::Stopped(StopReason::TwoSenders);
        }
        if admitted? == Admitted::NewSender {
            if self.newest.is_some() && matches!(self.phase, Phase::Running(_)) {
                self.phase = Phase::Armed(ArmedReason::NewSender);
            }
            self.forget_commands();
        }
        if let Some(before) = self.newest.filter(|before| before.engagements != command.engagements) {
            self.latch = Some(SenderLatch { before_us: before.capture_us, first_us: received_us });
            self.pending = None;
        }
        let newest = Newest::read(command);
        self.newest = Some(newest);
        // the way home is the button's alone
        if !command.engaged && self.press_for == PressFor::Follow {
            self.release();
        }
        let motion = newest.motion.map_err(|bad| {
            self.inbox.counts.bad = self.inbox.counts.bad.saturating_add(1);
            CommandRefusal::Bad(bad)
        })?;
        if command.state.is_measured() {
            self.measured_us = Some(received_us);
        }
        if self.config.mode == TeleopMode::Paper {
            self.pending = Some(self.pending.map_or(motion.increment, |pending| Pose {
                translation: pending.translation + motion.increment.translation,
                rotation: command::nearest_rotation(&(pending.rotation * motion.increment.rotation)),
            }));
        }
        Ok(())
    }

    /// The sender of commands has ended, and another may have begun in its place: known from what carries
    /// them, without waiting for a silence. The arm comes to rest, and it takes a release and a press
    /// of whoever is next. What is left of the old session is refused.
    pub fn end_sender(&mut self) {
        self.inbox.end_sender();
        self.forget_commands();
        if matches!(self.phase, Phase::Armed(_) | Phase::Running(_)) {
            self.phase = Phase::Armed(ArmedReason::NewSender);
        }
    }

    /// Takes the state of the operator's button, heard at `received_us` of this receiver's clock. To be
    /// told again and again, also while nothing changes: silence makes the arm hold.
    pub fn hold_to_run(&mut self, pressed: bool, received_us: u64) {
        self.now_us = self.now_us.max(received_us);
        let heard = self.button.is_fresh(received_us, self.config.resume_us);
        self.button.hear(pressed, received_us);
        if !pressed {
            self.release();
        } else if !heard && matches!(self.phase, Phase::Armed(_)) {
            // it may have been pressed while it was not heard
            self.phase = Phase::Armed(ArmedReason::LetGo(HoldReason::NoHoldToRun));
        }
    }

    /// Takes what a press is for, and the scale that counts from the next press on. To be told before
    /// [the button](Self::hold_to_run) that it belongs to. A press that is on for something else ends: it
    /// takes a release and another one.
    pub fn press_is_for(&mut self, press_for: PressFor, scale: ScaleShare) {
        let goes_on = self.button.is_pressed() && self.press_for != press_for;
        if goes_on && matches!(self.phase, Phase::Armed(ArmedReason::Press) | Phase::Running(_)) {
            self.phase = Phase::Armed(ArmedReason::PressChanged);
        }
        (self.press_for, self.scale) = (press_for, scale);
    }

    /// Stops the arm; it takes a reset to move it again. To be called in each step while a stop input
    /// is active.
    pub const fn stop(&mut self) {
        self.stop_for(StopReason::Asked);
    }

    /// [Stops](Self::stop) the arm for another reason than that somebody asked.
    pub const fn stop_for(&mut self, reason: StopReason) {
        if !matches!(self.phase, Phase::Fault(_)) {
            self.phase = Phase::Stopped(reason);
        }
    }

    /// Ends a stop or a fault: nothing moves before the next press. Where there is neither, nothing
    /// is done.
    ///
    /// # Errors
    /// [`ResetRefusal`] where hold-to-run is not heard to be released or the arm is not in order.
    pub fn reset(&mut self, now_us: u64, arm: &ArmView<T>) -> Result<(), ResetRefusal> {
        self.keep_time(now_us);
        if matches!(self.phase, Phase::Armed(_) | Phase::Running(_)) {
            return Ok(());
        }
        if !self.button_is_fresh() {
            return Err(ResetRefusal::NoHoldToRun);
        }
        if self.button.is_pressed() {
            return Err(ResetRefusal::Pressed);
        }
        arm.check().map_err(ResetRefusal::Arm)?;
        self.forget_commands();
        self.phase = Phase::Armed(ArmedReason::Press);
        Ok(())
    }

    /// Decides what the arm shall do now. To be called at the arm's own rate.
    pub fn step(&mut self, now_us: u64, arm: &ArmView<T>) -> Decision<T> {
        self.keep_time(now_us);
        if let (Err(reason), Phase::Armed(_) | Phase::Running(_)) = (arm.check(), &self.phase) {
            self.phase = Phase::Fault(reason);
        }
        if let Phase::Armed(ArmedReason::Press) = self.phase
            && self.is_pressed()
        {
            self.phase = Phase::Running(Running {
                followed: None,
                since_us: self.now_us,
                press_for: self.press_for,
                scale: self.law.scale(self.scale),
            });
        }
        let mut notes = Notes::default();
        let (order, status) = match self.phase {
            Phase::Stopped(reason) => (Order::Stop, Status::Stopped(reason)),
            Phase::Fault(reason) => (Order::Stop, Status::Fault(reason)),
            Phase::Armed(reason) => (Order::Stop, Status::Armed(self.wanted(reason))),
            Phase::Running(running) => self.run(running, arm, &mut notes),
        };
        let scale = match self.phase {
            Phase::Running(running) => running.scale,
            _ => self.law.scale(self.scale),
        };
        let newest = self.newest.as_ref();
        let covariance = newest.filter(|_| order.goal().is_some()).and_then(|newest| newest.covariance);
        Decision {
            order,
            status,
            notes,
            uncertainty: covariance.map(|p| self.law.uncertainty(&p, scale)),
            scale,
            command_age_us: newest.map(|newest| self.now_us.saturating_sub(newest.received_us)),
        }
    }

    fn run(&mut self, running: Running<T>, arm: &ArmView<T>, notes: &mut Notes) -> (Order<T>, Status) {
        let pending = self.pending.take();
        let followed = match running.press_for {
            PressFor::Home => self.may_go_home().map(|()| None),
            PressFor::Follow => self.usable().and_then(|(newest, hand)| {
                let followed = self.followed(&running, &newest, &hand, pending, arm, notes)?;
                if newest.state == PoseState::Predicted {
                    notes.add(Note::Predicted);
                }
                Ok(Some(followed))
            }),
        };
        let held_us = self.now_us.saturating_sub(running.since_us);
        if held_us > u64::from(self.config.resume_us) {
            // also where all is well again: nobody has looked for so long
            let reason = ArmedReason::LetGo(followed.err().unwrap_or(HoldReason::NoCommand));
            self.phase = Phase::Armed(reason);
            *notes = Notes::default();
            return (Order::Stop, Status::Armed(reason));
        }
        match followed {
            Ok(followed) => {
                self.phase = Phase::Running(Running { followed, since_us: self.now_us, ..running });
                let order = followed.map_or(Order::Home, |followed| Order::Follow(*followed.follow.goal()));
                if order == Order::Home {
                    notes.add(Note::GoesHome);
                }
                (order, Status::Engaged)
            }
            Err(reason) => {
                *notes = Notes::default();
                (Order::Stop, Status::Hold(reason))
            }
        }
    }

    /// The newest command and its hand, if they can be followed now.
    fn usable(&self) -> Result<(Newest<T>, Pose<T>), HoldReason> {
        if !self.button_is_fresh() {
            return Err(HoldReason::NoHoldToRun);
        }
        let newest = self.newest.filter(|_| self.command_is_fresh()).ok_or(HoldReason::NoCommand)?;
        let hand = newest.motion.map_err(HoldReason::BadCommand)?.since_engage;
        match newest.state {
            PoseState::Held | PoseState::Lost => Err(HoldReason::HandNotSeen),
            PoseState::Predicted if !self.is_recent(self.measured_us, self.config.predicted_us) => {
                Err(HoldReason::HandNotMeasured)
            }
            _ => Ok((newest, hand)),
        }
    }

    /// The way home is asked for by the button alone, so the button is what must be as fresh as a command.
    fn may_go_home(&self) -> Result<(), HoldReason> {
        let timeout_us = self.config.command_timeout_us.min(self.config.hold_to_run_timeout_us);
        if self.button.is_fresh(self.now_us, timeout_us) { Ok(()) } else { Err(HoldReason::NoHoldToRun) }
    }

    /// Follows the hand, or latches it where it cannot be followed to.
    fn followed(
        &self,
        running: &Running<T>,
        newest: &Newest<T>,
        hand: &Pose<T>,
        pending: Option<Pose<T>>,
        arm: &ArmView<T>,
        notes: &mut Notes,
    ) -> Result<Followed<T>, HoldReason> {
        let same = running.followed.filter(|before| before.engagements == newest.engagements);
        let believed = same.filter(|before| {
            let gap_us = newest.capture_us.saturating_sub(before.capture_us);
            self.law.believes(before.follow.last(), hand, gap_us)
        });
        let mut follow = match believed {
            Some(before) => before.follow,
            None if !newest.state.is_measured() => return Err(HoldReason::HandNotMeasured),
            None => {
                notes.add(if same.is_some() { Note::HandJumped } else { Note::Latched });
                Follow::latched(self.latch_of(newest, hand, same.is_some()), arm.set_point, running.scale)
            }
        };
        match self.config.mode {
            TeleopMode::SinceEngage => self.law.follow(&mut follow, hand, &arm.set_point, notes),
            TeleopMode::Paper => {
                let increment = pending.filter(|_| believed.is_some());
                let goal = increment.map_or(*follow.goal(), |increment| {
                    self.law.paper(&follow, &arm.measured, &arm.set_point, &increment, notes)
                });
                follow.step_to(*hand, goal);
            }
        }
        Ok(Followed { follow, engagements: newest.engagements, capture_us: newest.capture_us })
    }

    /// Where the hand counts from: where the sender latched it, if that was after the press and it
    /// can have come from there; else where it is now.
    fn latch_of(&self, newest: &Newest<T>, hand: &Pose<T>, jumped: bool) -> Pose<T> {
        let known = self.latch.is_some_and(|latch| {
            let gap_us = newest.capture_us.saturating_sub(latch.before_us);
            self.button.pressed_us() <= latch.first_us
                && gap_us <= u64::from(self.config.resume_us)
                && self.law.believes(&Pose::identity(), hand, gap_us)
        });
        if known && !jumped { Pose::identity() } else { *hand }
    }

    /// A release was heard.
    const fn release(&mut self) {
        if matches!(self.phase, Phase::Armed(_) | Phase::Running(_)) {
            self.phase = Phase::Armed(ArmedReason::Press);
        }
    }

    /// Whether the button is pressed, and no fresh command says that the hand that it would have the arm follow
    /// is not engaged. Where there is no fresh command the press is taken, and held.
    fn is_pressed(&self) -> bool {
        let clutched = self.press_for == PressFor::Follow
            && self.command_is_fresh()
            && self.newest.is_some_and(|newest| !newest.engaged);
        self.button_is_fresh() && self.button.is_pressed() && !clutched
    }

    fn wanted(&self, reason: ArmedReason) -> ArmedReason {
        let pressed = self.button_is_fresh() && self.button.is_pressed();
        if pressed && reason == ArmedReason::Press { ArmedReason::Engage } else { reason }
    }

    fn button_is_fresh(&self) -> bool {
        self.button.is_fresh(self.now_us, self.config.hold_to_run_timeout_us)
    }

    fn command_is_fresh(&self) -> bool {
        let received_us = self.newest.map(|newest| newest.received_us);
        self.is_recent(received_us, self.config.command_timeout_us)
    }

    fn is_recent(&self, at_us: Option<u64>, within_us: u32) -> bool {
        at_us.is_some_and(|at_us| self.now_us.saturating_sub(at_us) <= u64::from(within_us))
    }

    const fn forget_commands(&mut self) {
        self.newest = None;
        self.latch = None;
        self.measured_us = None;
        self.pending = None;
    }

    /// Time goes on. Something that came in a moment after `now_us` was read is no fault of the
    /// clock; more than a command's timeout is.
    fn keep_time(&mut self, now_us: u64) {
        if now_us.saturating_add(u64::from(self.config.command_timeout_us)) >= self.now_us {
            self.now_us = self.now_us.max(now_us);
            return;
        }
        self.now_us = now_us;
        self.inbox.rewind(now_us);
        self.button = HoldToRun::unheard();
        self.forget_commands();
        self.phase = Phase::Fault(FaultReason::ClockWentBack);
    }
}
