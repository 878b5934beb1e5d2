//! The operator's buttons: what no camera sees.

use super::BadValue;
use super::packet::{BYTE, MAX_U32, MAX_U64};
use serde::{Deserialize, Serialize};

/// What a press of hold-to-run is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PressFor {
    /// The arm follows the hand.
    #[default]
    Follow,
    /// The arm goes home, whatever the hand does.
    Home,
}

impl PressFor {
    /// Each of them, in the order of their numbers.
    pub const ALL: [Self; 2] = [Self::Follow, Self::Home];
}

/// The share of the slave's own scale by which places of the hand are followed, in percent: 1 to 100. The
/// operator can make the arm's way finer than the slave allows, and never coarser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScaleShare(u8);

impl ScaleShare {
    /// The slave's own scale.
    pub const FULL: Self = Self(100);

    /// So many percent; `None` where that is none or more than all.
    #[must_use]
    pub const fn from_percent(percent: u8) -> Option<Self> {
        let share = Self(percent);
        if share.is_valid() { Some(share) } else { None }
    }

    /// 1 to 100.
    #[must_use]
    pub const fn percent(self) -> u8 {
        self.0
    }

    /// What came over a wire may be anything.
    const fn is_valid(self) -> bool {
        matches!(self.0, 1..=100)
    }
}

impl Default for ScaleShare {
    fn default() -> Self {
        Self::FULL
    }
}

/// The state of the operator's buttons. It is sent again and again while nothing changes, so that
/// silence means a broken link, and tells states and counts rather than events, so that a lost packet
/// loses nothing and one that comes twice does nothing twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ButtonsPacket {
    /// Chosen anew each time the sender starts, so that old packets are not taken for new ones.
    pub session: u32,
    /// Counts the packets from 0, and wraps.
    pub sequence: u32,
    /// When the buttons were read, on the sender's clock, microseconds.
    pub time_us: u64,
    /// Hold-to-run is pressed.
    pub pressed: bool,
    /// Stop is pressed: the arm stops and stays so until it is reset.
    pub stop: bool,
    /// Counts the resets that were asked for, and wraps. Where it differs from the last packet's of
    /// the session, a reset is asked for; the first packet of a session asks for none.
    pub resets: u32,
    /// What the press is for. A press that goes on for something else has ended.
    pub press_for: PressFor,
    /// By how much of the slave's scale the hand is followed. It counts from a press on.
    pub scale: ScaleShare,
}

impl ButtonsPacket {
    /// The most bytes the fields take.
    pub const MAX_LEN: usize = 2 * MAX_U32 + MAX_U64 + 2 * BYTE + MAX_U32 + 2 * BYTE;

    pub(super) const fn check(&self) -> Result<(), BadValue> {
        if self.scale.is_valid() { Ok(()) } else { Err(BadValue::NotAShare) }
    }
}
