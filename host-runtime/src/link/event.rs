//! What happens to a link, for a person to read: one line each.

use std::fmt;
use std::net::SocketAddr;

use super::name::StationName;
use super::socket::RECEIVE_BUFFER;

/// Something that happened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// A peer is there.
    Connected {
        /// Who.
        peer: StationName,
        /// From where.
        address: SocketAddr,
    },
    /// A peer that was there is gone; it is waited for, or dialled again.
    Lost {
        /// Who.
        peer: StationName,
        /// Why, in QUIC's words or the peer's.
        reason: String,
    },
    /// A peer does not answer, or refuses. Told once for each reason, and dialled again and again.
    NotReached {
        /// Who.
        peer: StationName,
        /// The address that was dialled.
        address: String,
        /// Why not.
        reason: String,
    },
    /// Less room for what comes than is wanted ([`RECEIVE_BUFFER`]), told once.
    SmallBuffer {
        /// What the system gives, bytes.
        granted: usize,
    },
    /// Somebody was turned away.
    Refused {
        /// From where.
        address: SocketAddr,
        /// Why.
        reason: String,
        /// How many refusals before it were not told, for there were too many, or the same.
        untold: u64,
    },
}

impl fmt::Display for LinkEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connected { peer, address } => write!(f, "link: {peer} is connected ({address})"),
            Self::Lost { peer, reason } => write!(f, "link: {peer} is lost: {reason}"),
            Self::NotReached { peer, address, reason } => {
                write!(f, "link: {peer} is not reached at {address}: {reason}")
            }
            Self::SmallBuffer { granted } => write!(
                f,
                "link: the system keeps {} kB of what comes while this computer is busy, of {} wanted: set \
                 net.core.rmem_max={} (docs/deploy.md)",
                granted / 1024,
                RECEIVE_BUFFER / 1024,
                RECEIVE_BUFFER / 2,
            ),
            Self::Refused { address, reason, untold } => {
                write!(f, "link: {address} is refused: {reason}")?;
                if *untold > 0 {
                    write!(f, " (and {untold} times before, here or elsewhere)")
                } else {
                    Ok(())
                }
            }
        }
    }
}
