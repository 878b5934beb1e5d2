//! Asking a device node what it is, without starting it.

use std::{io, path::Path};

use super::{
    device::{Device, Identity},
    ioctl::{self, Kernel},
    negotiate::offer,
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
    /// Its pixel formats, each with the sizes it comes in.
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
    let mut formats = Vec::new();
    if captures {
        for fourcc in device.formats()? {
            // A driver need not list sizes.
            let sizes = device.sizes(fourcc).unwrap_or_default();
            formats.push(offer(fourcc, &sizes));
        }
    }
    Ok(Probed { card, driver, bus, captures, formats })
}

/// Whether this process may read and write a device. Opening it to find out would do something: a
/// serial port toggles its control lines, which resets many boards.
#[must_use]
pub fn may_use(path: &Path) -> bool {
    ioctl::may_use(path)
}
