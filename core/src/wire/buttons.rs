//! The operator's buttons: what no camera sees.

use super::packet::{BYTE, MAX_U32, MAX_U64};
use serde::{Deserialize, Serialize};

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
}

impl ButtonsPacket {
    /// The most bytes the fields take.
    pub const MAX_LEN: usize = 2 * MAX_U32 + MAX_U64 + 2 * BYTE + MAX_U32;
}
