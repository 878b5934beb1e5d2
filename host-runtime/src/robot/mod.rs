//! The arms that can be driven: what turns joint set-points into motion.
//!
//! | port | file | address |
//! |---|---|---|
//! | nothing but a record | [`dry_run`] | `dry-run:FILE` |
//!
//! [`address`] understands the address, [`open`] opens the port. All of them keep the contract of
//! [`tetrad_core::arm::port`]; [`set_point`] is the part of it that is the same everywhere.

pub mod address;

pub mod clock;

pub mod set_point;

mod start;

pub mod dry_run;

pub use address::{AddressError, RobotAddress};

use dry_run::DryRun;
use std::error::Error;
use tetrad_core::arm::port::RobotPort;
use tetrad_core::config::{PumaConfig, PumaConfigError};

/// A port as the host drives it: it can say more than the microcontroller's.
pub trait Robot: RobotPort<f64> + Send {
    /// Why it stands as it does, in words, beyond the status; `None` where the status says all.
    fn reason(&self) -> Option<String> {
        None
    }

    /// Lines for the end of a run: rates, jitter.
    fn report(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Why a port could not be opened. The address is named by whoever gave it.
#[derive(Debug, thiserror::Error)]
pub enum RobotError {
    /// The arm's own settings cannot be worked with.
    #[error("the arm's settings cannot be worked with")]
    Config(#[from] PumaConfigError),
    /// The address can be read, but asks for what this arm does not do.
    #[error("{address}: {problem}")]
    Option {
        /// The address.
        address: String,
        /// What is wrong, and what would mend it.
        problem: String,
    },
    /// The file or device behind the address cannot be opened or does not answer.
    #[error("cannot open {address}")]
    Open {
        /// The address.
        address: String,
        /// What was met.
        #[source]
        cause: Box<dyn Error + Send + Sync>,
    },
}

/// Opens what is at the address, for this arm. It is not switched on by that.
///
/// # Errors
/// [`RobotError`].
pub fn open(address: &RobotAddress, puma: &PumaConfig) -> Result<Box<dyn Robot>, RobotError> {
    puma.check()?;
    let refused =
        |cause: Box<dyn Error + Send + Sync>| RobotError::Open { address: address.to_string(), cause };
    match address {
        RobotAddress::DryRun(file) => match DryRun::create(file, puma) {
            Ok(port) => Ok(Box::new(port)),
            Err(cause) => Err(refused(cause.into())),
        },
    }
}
