//! Six CiA 402 drives on a CAN bus, in cyclic synchronous position: a PUMA 560, or any arm of that
//! build, with drives of today. docs/canopen.md says how to wire and commission one.
//!
//! | job | file |
//! |---|---|
//! | which bus | `address` |
//! | interface of the kernel, serial adapter, memory | [`bus`] |
//! | the thread that owns the bus | `cycle` |
//! | the robot port | `port` |
//!
//! Frames, drives and their master are [core's](tetrad_core::arm::canopen): a microcontroller has the same.

mod address;

pub mod bus;

mod cycle;

mod port;

pub use address::CanopenAddress;
pub use cycle::Opener;
pub use port::{CanopenError, CanopenPort};

use std::io;
use tetrad_core::config::{CanopenConfig, PumaConfig};

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

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::config::{DrivesConfig, Homing};

    #[test]
    fn the_settings_are_written_as_toml() {
        let text = "nodes = [11, 12, 13, 14, 15, 16]\nhoming = { status-bit = 14 }\nvendor = 0x1F\n";
        let read: CanopenConfig = toml::from_str(text).unwrap();
        assert_eq!(read.nodes[5], 16);
        assert_eq!((read.homing, read.vendor), (Homing::StatusBit(14), Some(31)));
        assert_eq!(read.drives(), DrivesConfig::default());
        assert_eq!(toml::from_str::<CanopenConfig>("homing = 'confirm'").unwrap().homing, Homing::Confirm);
        assert!(toml::from_str::<CanopenConfig>("node = 3").is_err());
    }
}
