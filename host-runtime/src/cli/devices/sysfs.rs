//! Reading /sys/class.

use std::{
    fmt, fs,
    path::{Path, PathBuf},
};

use crate::source::natural_order;

/// One directory of a class: a device as the kernel knows it.
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) path: PathBuf,
}

/// Where a device is plugged in and what drives it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The driver's name.
    pub driver: Option<String>,
    /// The USB port: bus, then the port of each hub on the way (`1-2.3`).
    pub usb_port: Option<String>,
    /// The USB device's own name.
    pub product: Option<String>,
    /// The USB device's serial number.
    pub serial: Option<String>,
}

/// The devices of a class in natural order; none when there is no such class.
pub(super) fn entries(class: &Path) -> Vec<Entry> {
    let Ok(found) = fs::read_dir(class) else { return Vec::new() };
    let mut entries: Vec<Entry> = found
        .flatten()
        .filter_map(|entry| Some(Entry { name: entry.file_name().into_string().ok()?, path: entry.path() }))
        .collect();
    entries.sort_by(|a, b| natural_order(&a.name, &b.name));
    entries
}

impl Entry {
    /// The text of an attribute, when there is one and it says anything.
    pub(super) fn text(&self, attribute: &str) -> Option<String> {
        text(&self.path.join(attribute))
    }

    /// Looks from the device upwards, but not out of `sys`, for its driver and its USB device.
    pub(super) fn place(&self, sys: &Path) -> Place {
        let Ok(device) = fs::canonicalize(self.path.join("device")) else { return Place::default() };
        let sys = fs::canonicalize(sys).unwrap_or_else(|_| sys.to_owned());
        let driver = fs::canonicalize(device.join("driver"))
            .ok()
            .and_then(|driver| Some(driver.file_name()?.to_str()?.to_owned()));
        let usb = device
            .ancestors()
            .take_while(|directory| directory.starts_with(&sys))
            // Only a USB device (not its interfaces, nor the bus above) has a vendor's number.
            .find(|directory| directory.join("idVendor").exists());
        Place {
            driver,
            usb_port: usb.and_then(|usb| Some(usb.file_name()?.to_str()?.to_owned())),
            product: usb.and_then(|usb| text(&usb.join("product"))),
            serial: usb.and_then(|usb| text(&usb.join("serial"))),
        }
    }
}

fn text(file: &Path) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let text = text.trim();
    (!text.is_empty()).then(|| text.to_owned())
}

/// The link in `folder` that leads to `node`.
pub(super) fn stable_name(folder: &Path, node: &Path) -> Option<PathBuf> {
    let node = fs::canonicalize(node).ok()?;
    entries(folder)
        .into_iter()
        .map(|entry| entry.path)
        .find(|link| fs::canonicalize(link).is_ok_and(|target| target == node))
}

impl fmt::Display for Place {
    /// `, USB port 1-2, serial 1234, driver uvcvideo`, as far as it is known.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (what, value) in
            [("USB port", &self.usb_port), ("serial", &self.serial), ("driver", &self.driver)]
        {
            if let Some(value) = value {
                write!(f, ", {what} {value}")?;
            }
        }
        Ok(())
    }
}
