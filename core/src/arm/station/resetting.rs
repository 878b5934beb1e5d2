//! A reset that was asked for and goes on until the arm is switched on, or not.

use super::{EnableThenReset, Station};
use crate::arm::port::{PortError, RobotPort};
use crate::real::Real;

/// How long an arm may take to be switched on, microseconds: one that calibrates itself goes slowly from
/// joint to joint.
const SWITCH_ON_US: u64 = 150_000_000;

/// How long a port may take to say that it has begun to switch on, microseconds.
const BEGIN_US: u64 = 500_000;

/// A reset that was asked for.
#[derive(Clone, Copy, Debug)]
pub struct Resetting {
    since_us: u64,
    /// The arm was told to switch on.
    told: bool,
}

/// What became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reset {
    /// The stop or fault is over.
    Done,
    /// The arm is being switched on; ask again in the next cycle.
    Waits,
    /// It is not done.
    Refused(EnableThenReset),
}

impl Resetting {
    /// Somebody asks for a reset at `now_us`.
    #[must_use]
    pub const fn asked(now_us: u64) -> Self {
        Self { since_us: now_us, told: false }
    }

    /// Goes on with it: the arm is told to switch on once, then waited for.
    pub fn go_on<T: Real, P: RobotPort<T>>(&mut self, station: &mut Station<T, P>, now_us: u64) -> Reset {
        let may_enable = !self.told;
        let told = core::mem::replace(&mut self.told, true);
        let waited_us = now_us.saturating_sub(self.since_us);
        match station.reset(now_us, may_enable) {
            Ok(()) => Reset::Done,
            Err(EnableThenReset::SwitchingOn) if waited_us < SWITCH_ON_US => Reset::Waits,
            // a port that has a thread of its own says a little later that it switches on
            Err(EnableThenReset::NotHomed | EnableThenReset::Port(PortError::NotReady(_)))
                if told && waited_us < BEGIN_US =>
            {
                Reset::Waits
            }
            Err(refusal) => Reset::Refused(refusal),
        }
    }
}
