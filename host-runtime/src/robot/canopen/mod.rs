//! Six CiA 402 drives on a CAN bus, in cyclic synchronous position: a PUMA 560, or any arm of that
//! build, with drives of today. docs/canopen.md says how to wire and commission one.
//!
//! | job | file |
//! |---|---|
//! | which bus | `address` |
//! | nodes, cycle, homing, counts | `config` |
//! | frames and their COB-IDs | [`frame`] |
//! | interface of the kernel, serial adapter, memory | [`bus`] |
//! | reading and writing objects | [`sdo`] |
//! | the state machine of a drive | [`cia402`] |
//! | what is written to a drive first | `setup` |
//! | one drive as the master sees it | `node` |
//! | the master: what it makes of frames, what it sends | [`master`] |
//! | why the arm was stopped, in words | `cause` |
//! | the thread that owns the bus | `cycle` |
//! | the robot port | `port` |
//!
//! Everything up to the master knows neither clock nor thread: tests run it through every failure in
//! simulated time.

mod address;

mod config;

pub mod frame;

pub mod bus;

pub mod sdo;

pub mod cia402;

mod setup;

mod cause;

mod node;

pub mod master;

mod cycle;

mod port;

pub use address::CanopenAddress;
pub use cause::{Cause, DriveName, Foreign, Nonsense};
pub use config::{CanopenConfig, CanopenConfigError, Homing};
pub use cycle::Opener;
pub use port::{CanopenError, CanopenPort};

use std::io;
use tetrad_core::config::PumaConfig;

/// Opens the bus at `address` and begins to set up its drives, without voltage on any motor.
///
/// # Errors
/// [`CanopenError`].
pub fn open(
    address: &CanopenAddress,
    puma: &PumaConfig,
    config: &CanopenConfig,
) -> Result<CanopenPort, CanopenError> {
    let address = address.clone();
    CanopenPort::start(Box::new(move || open_bus(&address)), puma, config)
}

fn open_bus(address: &CanopenAddress) -> io::Result<bus::Bus> {
    match address {
        #[cfg(target_os = "linux")]
        CanopenAddress::Interface(name) => bus::open_socket(name),
        #[cfg(not(target_os = "linux"))]
        CanopenAddress::Interface(_) => Err(io::Error::new(
            io::ErrorKind::Unsupported,
            "CAN interfaces of the kernel are Linux's; use an adapter with canopen+slcan:",
        )),
        CanopenAddress::Slcan { path, bitrate, baud } => bus::open_slcan(path, *baud, *bitrate),
    }
}
