//! A slave between two wires: an operator's packets on a serial line, six drives on a CAN bus. What a
//! microcontroller at the arm runs.
//!
//! ```text
//!                motion, buttons                         set-points
//!  serial line ------------------->               ------------------->
//!                                     WiredSlave                        CAN bus
//!              <-------------------               <-------------------
//!                  arm state                       positions, states
//! ```
//!
//! - What came between two cycles counts in the second: of motion and of buttons the newest.
//! - Nothing waits and nothing is queued. Times are arguments, by one clock of this station that only goes
//!   forward.
//! - A serial line has one operator at its other end. Packets of another session are those of one that has
//!   taken its place: the arm comes to rest, and takes a release and a press.

mod admission;

use super::canopen::{CanopenArm, CanopenArmError, Frame};
use super::station::{NoReset, OperatedSlave};
use super::teleop::Counts;
use crate::config::{CanopenConfig, SlaveConfig, SlaveConfigError};
use crate::wire::{ArmStatePacket, ButtonsPacket, MotionPacket, Packet};
use admission::{Admission, Admitted, Kind};
use core::fmt;

#[cfg(test)]
mod tests;

/// Why there is no slave to be had.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WiredSlaveError {
    /// The settings of arm, law or limits.
    Slave(SlaveConfigError),
    /// The settings of the bus.
    Canopen(CanopenArmError),
    /// Set-points and SYNC have to come equally often.
    Cycles {
        /// From one set-point to the next, microseconds.
        slave_us: u32,
        /// From one SYNC to the next, microseconds.
        bus_us: u32,
    },
}

impl fmt::Display for WiredSlaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slave(error) => error.fmt(f),
            Self::Canopen(error) => error.fmt(f),
            Self::Cycles { slave_us, bus_us } => write!(
                f,
                "the slave makes a set-point each {slave_us} us and the bus takes one each {bus_us} us: set both alike"
            ),
        }
    }
}

impl core::error::Error for WiredSlaveError {}

impl From<SlaveConfigError> for WiredSlaveError {
    fn from(error: SlaveConfigError) -> Self {
        Self::Slave(error)
    }
}

impl From<CanopenArmError> for WiredSlaveError {
    fn from(error: CanopenArmError) -> Self {
        Self::Canopen(error)
    }
}

/// Something that came, and when, by this station's clock, microseconds.
type Newest<P> = Option<(P, u64)>;

/// A slave between two wires.
#[derive(Debug)]
pub struct WiredSlave {
    slave: OperatedSlave<f32, CanopenArm>,
    admission: Admission,
    motion: Newest<MotionPacket>,
    buttons: Newest<ButtonsPacket>,
}

impl WiredSlave {
    /// A slave that is stopped, its drives not told anything yet. `session` is what its packets are of:
    /// another each time that it starts.
    ///
    /// # Errors
    /// [`WiredSlaveError`] for a setting that cannot be worked with.
    pub fn new(config: &SlaveConfig, canopen: &CanopenConfig, session: u32) -> Result<Self, WiredSlaveError> {
        let (slave_us, bus_us) = (config.governor.cycle_us, canopen.period_us);
        if slave_us != bus_us {
            return Err(WiredSlaveError::Cycles { slave_us, bus_us });
        }
        let arm = CanopenArm::new(&config.puma, canopen)?;
        Ok(Self {
            slave: OperatedSlave::new(config, arm, session)?,
            admission: Admission::default(),
            motion: None,
            buttons: None,
        })
    }

    /// Takes a packet that came on the serial line at `now_us`. Those that an operator does not send, and
    /// those that came before, are dropped.
    pub fn take(&mut self, packet: &Packet, now_us: u64) {
        let kind = match packet {
            Packet::Motion(_) => Kind::Motion,
            Packet::Buttons(_) => Kind::Buttons,
            _ => return,
        };
        match self.admission.admit(kind, packet.session(), packet.sequence()) {
            None => return,
            Some(Admitted::Next) => {}
            // what the one before has sent is of no use any more
            Some(Admitted::NewSession) => (self.motion, self.buttons) = (None, None),
        }
        match packet {
            Packet::Motion(motion) => self.motion = Some((*motion, now_us)),
            Packet::Buttons(buttons) => self.buttons = Some((*buttons, now_us)),
            _ => {}
        }
    }

    /// Takes a frame that came from the bus at `now_us`.
    pub fn hear(&mut self, frame: &Frame, now_us: u64) {
        self.slave.port_mut().receive(now_us, frame);
    }

    /// One cycle at `now_us`: the frames to send at once, in their order, and the arm's state where it is to
    /// be told.
    pub fn cycle(&mut self, now_us: u64, out: &mut impl Extend<Frame>) -> Option<ArmStatePacket> {
        self.slave.port_mut().begin_cycle(now_us);
        self.slave.begin_cycle(now_us);
        if let Some((motion, received_us)) = self.motion.take() {
            self.slave.take_motion(&motion, received_us);
        }
        if let Some((buttons, received_us)) = self.buttons.take() {
            // of the operator's clock nothing is known: it was told when it came
            self.slave.take_buttons(&buttons, received_us, received_us, now_us);
        }
        let cycle = self.slave.cycle(now_us, || now_us);
        self.slave.port_mut().end_cycle(out);
        let mut told = None;
        self.slave.tell(&cycle, now_us, |state| {
            told = Some(state);
            true
        });
        told
    }

    /// Somebody at the arm stops it.
    pub const fn stop(&mut self) {
        self.slave.stop();
    }

    /// Somebody at the arm vouches for it that every joint is homed.
    pub fn confirm_homed(&mut self) {
        self.slave.port_mut().confirm_homed();
    }

    /// So many bytes of the line to the bus, since it was opened, belong to no frame.
    pub const fn hear_garbage(&mut self, bytes: u64) {
        self.slave.port_mut().hear_garbage(bytes);
    }

    /// Why the operator's last reset was not done, once.
    pub const fn take_refusal(&mut self) -> Option<NoReset> {
        self.slave.take_refusal()
    }

    /// How many motions came, and what became of them.
    #[must_use]
    pub const fn counts(&self) -> Counts {
        self.slave.counts()
    }
}
