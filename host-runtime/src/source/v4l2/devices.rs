//! Asking a device node what it is, without starting it.

use std::{io, path::Path};

use super::{
    device::{Device, Identity},
    ioctl::{self, Kernel},
    negotiate::offers,
};

/// What a device node answered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Probed {
    /// The camera's name.
    pub card: String,
    /// The driver's name.
    pub driver: String,
    /// Where the driver says it is plugged in.
    pub bus: String,
    /// Whether this node gives pictures; cameras have others, for metadata.
    pub captures: bool,
    /// Its pixel formats and the sizes they come in, one line for those with the same sizes.
    pub formats: Vec<String>,
}

/// Asks the node at `path`.
///
/// # Errors
/// What opening it or asking it failed with.
pub fn probe(path: &Path) -> io::Result<Probed> {
    ask(&mut Kernel::open(path)?)
}

pub(super) fn ask(device: &mut impl Device) -> io::Result<Probed> {
    let Identity { card, driver, bus, captures, .. } = device.identity()?;
    let formats = if captures {
        let offered = device.formats()?;
        offers(device, &offered)
    } else {
        Vec::new()
    };
    Ok(Probed { card, driver, bus, captures, formats })
}

/// Whether this process may read and write a device. Opening it to find out would do something: a
/// serial port toggles its control lines, which resets many boards.
#[must_use]
pub fn may_use(path: &Path) -> bool {
    ioctl::may_use(path)
}
