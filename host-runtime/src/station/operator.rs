//! The operator station: what the cameras saw in, the hand's motion and the buttons out, the arm's state
//! back.
//!
//! ```text
//! observations --> Pairing --> HandStage --> MotionSender --motion--> slave
//!  (1 to 8 cameras)  instants    pose          buttons, again and again -->
//!                                              <-- arm's state, to be told and for the delays
//! ```
//!
//! The operator moves the arm while hold-to-run is pressed: that is what the motion calls engaged and
//! what the buttons say, and it takes both. The slave latches hand and set-point at the press, as it
//! does for every sender; the hand's own frame stays that of the first complete instant, so that a turn
//! of the hand between two presses does not turn the axes that the arm moves along.
//!
//! One loop calls [`Operator::step`] whenever something came or is due. Nothing waits.

use super::delays::{Delays, SentMotion};
use super::motion::MotionSender;
use super::pairing::{Joined, Pairing, Sighting};
use crate::link::{Carrier, Received};
use crate::pipeline::{HandStage, HandStep};
use crate::robot::clock::Clock;
use tetrad_core::config::{FilterConfig, FilterConfigError, HandConfig};
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::filter::PoseFilter;
use tetrad_core::hand::tracker::HandMode;
use tetrad_core::hand::view::{CameraModel, HandView};
use tetrad_core::wire::{
    ArmStatePacket, ButtonsPacket, EncodeError, MotionPacket, ObservationPacket, PressFor, ScaleShare,
};

/// Buttons are told at least so often, microseconds: five times within the 100 ms after which a slave
/// holds, so that it takes five losses in a row to make it.
pub const BUTTONS_US: u64 = 20_000;

/// The shares of the slave's scale that keys and buttons step through, percent.
pub const SCALES: [u8; 6] = [2, 5, 10, 25, 50, 100];

/// The size of a camera's pictures before the first has come, px. Nothing is computed with it.
const UNKNOWN_SIZE: (u16, u16) = (640, 480);

/// What an operator works with.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorConfig {
    /// The feature frame.
    pub arms: Arms,
    /// How the pose is computed.
    pub mode: HandMode,
    /// The hand's stages.
    pub hand: HandConfig,
    /// How the pose is smoothed and carried on.
    pub filter: FilterConfig,
    /// The cameras' nominal focal lengths, px, in their order, one for each camera; `None` where nobody
    /// knows.
    pub focal_px: Vec<Option<f32>>,
}

/// The operator's buttons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Buttons {
    /// Hold-to-run.
    pub pressed: bool,
    /// Stop: the arm stays stopped until a reset.
    pub stop: bool,
    /// Counts the resets that were asked for, and wraps.
    pub resets: u32,
    /// What the press is for.
    pub press_for: PressFor,
    /// The share of the slave's scale that the next press follows by.
    pub scale: ScaleShare,
}

/// What was made of an instant.
#[derive(Clone, Debug, PartialEq)]
pub struct OperatorStep {
    /// When it was made, by the carrier's clock, microseconds.
    pub asked_us: u64,
    /// What the cameras saw.
    pub joined: Joined,
    /// Where the hand is.
    pub hand: HandStep,
    /// What the slave was told.
    pub motion: MotionPacket,
    /// When it passed the stages; `None` where it could not be sent.
    pub sent: Option<SentMotion>,
}

/// What came of one turn of the loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OperatorTurn {
    /// The instant whose time had come.
    pub step: Option<OperatorStep>,
    /// The arm's state, if a new one came.
    pub arm: Option<Received<ArmStatePacket>>,
    /// What could not be sent: numbers that may not.
    pub unsent: Option<EncodeError>,
}

/// See the [module's text](self).
#[derive(Clone, Debug)]
pub struct Operator {
    session: u32,
    pairing: Pairing,
    hand: HandStage,
    focal_px: Vec<Option<f32>>,
    sender: MotionSender,
    buttons: Buttons,
    told_us: Option<u64>,
    told: u32,
    delays: Delays,
    unplaced: u64,
}

impl Operator {
    /// An operator of these cameras, whose packets are of that session.
    ///
    /// # Errors
    /// [`FilterConfigError`] for a filter that cannot be worked with.
    pub fn new(config: &OperatorConfig, session: u32) -> Result<Self, FilterConfigError> {
        let filter = PoseFilter::new(config.filter)?;
        Ok(Self {
            session,
            pairing: Pairing::new(config.focal_px.len()),
            hand: HandStage::new(config.mode, config.arms, config.hand, filter),
            focal_px: config.focal_px.clone(),
            sender: MotionSender::new(session),
            buttons: Buttons::default(),
            told_us: None,
            told: 0,
            delays: Delays::new(session),
            unplaced: 0,
        })
    }

    /// Takes what a camera saw. Where it is not known when the picture was taken, because the other
    /// station's clock has not been compared yet, it is left out.
    pub fn observe(&mut self, camera: usize, observation: &Received<ObservationPacket>) {
        self.delays.observed(observation);
        let Received { what, received_us, captured_us } = observation;
        let Some(capture_us) = *captured_us else {
            self.unplaced += 1;
            return;
        };
        let sighting = Sighting {
            capture_us,
            ready_us: capture_us.saturating_add(u64::from(what.ready_us)),
            received_us: *received_us,
            balls: what.balls,
            size: (what.width, what.height),
        };
        self.pairing.take(camera, &sighting);
    }

    /// One turn: the next instant if its time has come, its motion and the buttons to the slave, the arm's
    /// state from it. The clock is the carrier's.
    pub fn step<C: Carrier>(&mut self, slave: &C, buttons: Buttons, clock: &Clock) -> OperatorTurn {
        let mut turn = OperatorTurn::default();
        // a release goes before anything else
        let now_us = clock.now_us();
        if let Some(packet) = self.buttons(buttons, now_us) {
            turn.unsent = slave.send(&packet.into()).err();
        }
        if let Some(joined) = self.pairing.next(now_us) {
            let hand = self.hand.step(&self.views(&joined), joined.t_us);
            let posed_us = clock.now_us();
            let seen = joined.views.iter().map(|view| &view.balls);
            let motion = self.sender.packet_of(&hand, seen, joined.t_us, buttons.pressed);
            let mut sent = None;
            match slave.send(&motion.into()) {
                Ok(()) => {
                    let motion = SentMotion {
                        sequence: motion.sequence,
                        capture_us: joined.t_us,
                        ready_us: joined.ready_us,
                        first_us: joined.first_us,
                        joined_us: joined.last_us,
                        posed_us,
                        sent_us: clock.now_us(),
                    };
                    self.delays.sent(&motion);
                    sent = Some(motion);
                }
                Err(error) => turn.unsent = Some(error),
            }
            turn.step = Some(OperatorStep { asked_us: now_us, joined, hand, motion, sent });
        }
        turn.arm = slave.arm_state();
        if let Some(state) = &turn.arm {
            self.delays.arm_state(state);
        }
        turn
    }

    /// Begins with another hand, of these arms: cameras that were moved or taught anew have to be learnt
    /// anew too.
    pub fn set_up(&mut self, arms: Arms) {
        self.hand.set_up(arms);
    }

    /// How long the loop may sleep where nothing comes, microseconds.
    #[must_use]
    pub fn sleep_us(&self, now_us: u64) -> u64 {
        let buttons_us = self.told_us.map_or(now_us, |told_us| told_us + BUTTONS_US);
        let due_us = self.pairing.due_us(now_us).map_or(buttons_us, |us| us.min(buttons_us));
        due_us.saturating_sub(now_us)
    }

    /// How long each stage took.
    #[must_use]
    pub const fn delays(&self) -> &Delays {
        &self.delays
    }

    /// Whether a camera is part of the instants, and what became of what was seen.
    #[must_use]
    pub const fn pairing(&self) -> &Pairing {
        &self.pairing
    }

    /// Observations of which nobody knows when they were made.
    #[must_use]
    pub const fn unplaced(&self) -> u64 {
        self.unplaced
    }

    /// The buttons' packet, where they changed or have not been told for a while.
    fn buttons(&mut self, buttons: Buttons, now_us: u64) -> Option<ButtonsPacket> {
        let fresh = self.told_us.is_some_and(|told_us| now_us.saturating_sub(told_us) < BUTTONS_US);
        if fresh && buttons == self.buttons {
            return None;
        }
        (self.buttons, self.told_us) = (buttons, Some(now_us));
        let Buttons { pressed, stop, resets, press_for, scale } = buttons;
        let (session, sequence) = (self.session, self.told);
        self.told = self.told.wrapping_add(1);
        Some(ButtonsPacket { session, sequence, time_us: now_us, pressed, stop, resets, press_for, scale })
    }

    fn views(&self, joined: &Joined) -> Vec<HandView> {
        let views = joined.views.iter().zip(&self.focal_px);
        views
            .map(|(view, focal_px)| {
                let (width, height) = view.size.unwrap_or(UNKNOWN_SIZE);
                let nominal = CameraModel::nominal(width, height);
                let focal_px = focal_px.unwrap_or(nominal.focal_px);
                HandView { balls: view.balls, camera: CameraModel { focal_px, ..nominal } }
            })
            .collect()
    }
}
