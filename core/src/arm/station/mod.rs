//! The slave station around its law, whatever its packets come by and whatever its arm is: the same on the
//! host and on a microcontroller.
//!
//! | job | file |
//! |---|---|
//! | one cycle from what came to what the robot port is told | here |
//! | a reset that goes on until the arm is switched on, or not | `resetting` |
//! | which motion the arm has reached | `settling` |
//! | an operator's packets in, the arm's state out | `operated` |

mod resetting;

mod settling;

mod operated;

pub use operated::{NoReset, OperatedSlave};
pub use resetting::{Reset, Resetting};

use super::port::{PortError, PortStatus, RobotPort};
use super::slave::{ArmReading, PortOrder, Slave, SlaveStep};
use super::teleop::{Command, CommandRefusal, Counts, ResetRefusal};
use crate::config::{SlaveConfig, SlaveConfigError};
use crate::real::Real;
use crate::wire::{MotionPacket, PressFor, ScaleShare};
use core::fmt;

/// A slave with its arm.
pub struct Station<T, P> {
    slave: Slave<T>,
    port: P,
}

/// What came of one cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle<T> {
    /// The law's and the limits' part of it.
    pub step: SlaveStep<T>,
    /// What the port said at its beginning.
    pub reading: ArmReading<T>,
    /// When the joints to go to were known, by the clock the cycle was given.
    pub solved_us: u64,
    /// When they were written to the port, by the same clock; `None` where they were not.
    pub written_us: Option<u64>,
    /// What went wrong at the port; not [`PortError::NotReady`], which its status tells.
    pub port_error: Option<PortError>,
}

/// A reset that was not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnableThenReset {
    /// The arm is being switched on; ask again when it is ready.
    SwitchingOn,
    /// Its joints are not homed; when they are, it is to be reset anew.
    NotHomed,
    /// The port refuses to be enabled.
    Port(PortError),
    /// The law refuses.
    Law(ResetRefusal),
}

impl fmt::Display for EnableThenReset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SwitchingOn => f.write_str("the arm is being switched on"),
            Self::NotHomed => {
                f.write_str("the arm does not know where its joints are; home it, then reset again")
            }
            Self::Port(error) => error.fmt(f),
            Self::Law(refusal) => refusal.fmt(f),
        }
    }
}

impl core::error::Error for EnableThenReset {}

/// Without the port, which may be anything.
impl<T: fmt::Debug, P> fmt::Debug for Station<T, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Station").field("slave", &self.slave).finish_non_exhaustive()
    }
}

impl<T: Real, P: RobotPort<T>> Station<T, P> {
    /// A station that is stopped; the arm is not enabled before the first [reset](Self::reset).
    ///
    /// # Errors
    /// [`SlaveConfigError`] for a setting that cannot be worked with.
    pub fn new(config: &SlaveConfig, port: P) -> Result<Self, SlaveConfigError> {
        Ok(Self { slave: Slave::new(config)?, port })
    }

    /// The arm's port.
    #[must_use]
    pub const fn port(&self) -> &P {
        &self.port
    }

    /// The arm's port, for what only it can do.
    pub const fn port_mut(&mut self) -> &mut P {
        &mut self.port
    }

    /// The law, the limits and the arm's model.
    #[must_use]
    pub const fn slave(&self) -> &Slave<T> {
        &self.slave
    }

    /// How many commands came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.slave.counts()
    }

    /// Takes a packet that came at `received_us` of the station's clock.
    ///
    /// # Errors
    /// [`CommandRefusal`]; the command is dropped and counted.
    pub fn take(&mut self, packet: &MotionPacket, received_us: u64) -> Result<(), CommandRefusal> {
        self.slave.take(&Command::new(packet, received_us))
    }

    /// The operator has ended, and another may have begun: the arm comes to rest, and takes a release and
    /// a press.
    pub fn end_sender(&mut self) {
        self.slave.end_sender();
    }

    /// Takes what the operator's press is for, before the button itself.
    pub fn press_is_for(&mut self, press_for: PressFor, scale: ScaleShare) {
        self.slave.press_is_for(press_for, scale);
    }

    /// Takes the state of the operator's button; to be told again and again.
    pub fn hold_to_run(&mut self, pressed: bool, received_us: u64) {
        self.slave.hold_to_run(pressed, received_us);
    }

    /// Stops the arm until it is reset: at once to rest within its limits.
    pub const fn stop(&mut self) {
        self.slave.stop();
    }

    /// [Stops](Self::stop) the arm because the station ends.
    pub const fn end(&mut self) {
        self.slave.end();
    }

    /// Ends a stop or a fault and, where that is needed and `may_enable` says so, has the arm switched
    /// on. Nothing moves before the next press.
    ///
    /// Whoever waits for an arm that is being switched on asks again without `may_enable`: power comes
    /// on when somebody asks for it, not when whatever was in the way is over.
    ///
    /// # Errors
    /// [`EnableThenReset`]; where the arm is being switched on it is to be asked again.
    pub fn reset(&mut self, now_us: u64, may_enable: bool) -> Result<(), EnableThenReset> {
        if may_enable && !matches!(self.port.status(), PortStatus::Ready | PortStatus::Enabling) {
            self.port.enable().map_err(EnableThenReset::Port)?;
        }
        match self.port.status() {
            PortStatus::Ready => {}
            PortStatus::Enabling => return Err(EnableThenReset::SwitchingOn),
            PortStatus::NotHomed if !may_enable => return Err(EnableThenReset::NotHomed),
            // what was asked for has not begun
            _ if may_enable => return Err(EnableThenReset::SwitchingOn),
            // or is over
            status => return Err(EnableThenReset::Port(PortError::NotReady(status))),
        }
        let reading = self.read().0;
        self.slave.reset(now_us, &reading).map_err(EnableThenReset::Law)
    }

    /// One cycle, at the rate of the limits' configuration.
    pub fn cycle(&mut self, now_us: u64) -> Cycle<T> {
        self.cycle_by(now_us, || now_us)
    }

    /// One cycle at `now_us` that tells by a clock when its stages were done.
    pub fn cycle_by(&mut self, now_us: u64, clock: impl Fn() -> u64) -> Cycle<T> {
        let (reading, unread) = self.read();
        let step = self.slave.step(now_us, &reading);
        let solved_us = clock();
        let mut written_us = None;
        let told = match &step.order {
            PortOrder::Write(joints) => {
                let told = self.port.write_set_point(joints);
                written_us = told.is_ok().then(&clock);
                told
            }
            PortOrder::Stop => self.port.stop(),
            PortOrder::Nothing => Ok(()),
        };
        let untold = told.err().filter(|error| !matches!(error, PortError::NotReady(_)));
        if untold.is_some_and(is_refused_set_point) {
            // the limits and the port disagree on what the arm can do: nobody knows where it would go
            let _ = self.port.stop();
            self.slave.stop_refused();
        }
        Cycle { step, reading, solved_us, written_us, port_error: untold.or(unread) }
    }

    /// Stops the arm at its port too, as at the end of a run.
    ///
    /// # Errors
    /// [`PortError`] where the port cannot be told.
    pub fn shut_down(&mut self) -> Result<(), PortError> {
        self.slave.end();
        self.port.stop()
    }

    fn read(&mut self) -> (ArmReading<T>, Option<PortError>) {
        let status = self.port.status();
        match self.port.read_joints() {
            Ok(joints) => (ArmReading { joints: Some(joints), status }, None),
            Err(error) => {
                let expected = matches!(error, PortError::NotMeasured | PortError::NotReady(_));
                (ArmReading { joints: None, status }, Some(error).filter(|_| !expected))
            }
        }
    }
}

const fn is_refused_set_point(error: PortError) -> bool {
    matches!(error, PortError::NotFinite(_) | PortError::OutOfRange(_) | PortError::TooFar(_))
}
