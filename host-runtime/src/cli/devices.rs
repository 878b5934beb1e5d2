//! `tetrad devices`: what is plugged in and could be used.
//!
//! Cameras are asked what they offer; serial ports and CAN interfaces are only looked up in /sys,
//! since opening a serial port resets many of the boards behind one.

mod sysfs;
#[cfg(test)]
mod tests;

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use crate::exit::Failure;
use sysfs::{Entry, Place};

pub(super) const EXAMPLES: &str = "\
Examples:
  tetrad devices
  tetrad track --left /dev/video0 --right /dev/video2 ...   with the names it lists
Names under /dev/v4l/by-id and /dev/serial/by-id stay the same when devices are plugged in elsewhere
or in another order.";

/// ARPHRD_CAN of linux/if_arp.h, as /sys/class/net/*/type has it.
const TYPE_CAN: &str = "280";

/// IFF_UP of linux/if.h.
const FLAG_UP: u32 = 1;

/// The largest transfer unit of classic CAN; CAN FD has 72.
const MTU_CLASSIC: u32 = 16;

/// Where a machine keeps what it knows of its devices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Roots {
    /// /sys
    pub sys: PathBuf,
    /// /dev
    pub dev: PathBuf,
}

impl Roots {
    /// This machine's.
    #[must_use]
    pub fn system() -> Self {
        Self { sys: PathBuf::from("/sys"), dev: PathBuf::from("/dev") }
    }
}

/// What a camera's device node answers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Whether it gives pictures; cameras have other nodes as well, for metadata.
    pub captures: bool,
    /// Its pixel formats with their sizes.
    pub formats: Vec<String>,
}

/// The questions that /sys cannot answer.
pub trait Ask {
    /// Asks a camera's node what it offers.
    ///
    /// # Errors
    /// What opening or asking it failed with.
    fn camera(&self, node: &Path) -> io::Result<Answer>;

    /// Whether this process may read and write the device.
    fn may_use(&self, node: &Path) -> bool;
}

/// Everything found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Devices {
    /// Cameras, by number.
    pub cameras: Vec<Camera>,
    /// Serial ports with something behind them.
    pub serial_ports: Vec<SerialPort>,
    /// CAN interfaces, real and virtual.
    pub can_interfaces: Vec<CanInterface>,
}

/// A camera, or a node that may be one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Camera {
    /// Its node, as SRC takes it.
    pub node: PathBuf,
    /// A name that stays the same, when there is one.
    pub stable: Option<PathBuf>,
    /// Its name.
    pub card: String,
    /// Where it is plugged in.
    pub place: Place,
    /// Its formats, or why they are not known.
    pub formats: Result<Vec<String>, String>,
}

/// A serial port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialPort {
    /// Its node.
    pub node: PathBuf,
    /// A name that stays the same, when there is one.
    pub stable: Option<PathBuf>,
    /// What is plugged in, when it tells.
    pub product: Option<String>,
    /// Where it is plugged in.
    pub place: Place,
    /// Whether this process may open it.
    pub usable: bool,
}

/// A CAN interface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanInterface {
    /// Its name.
    pub name: String,
    /// Whether it is up.
    pub up: bool,
    /// Whether it is set up for CAN FD.
    pub fd: bool,
    /// Where it is plugged in.
    pub place: Place,
}

/// Looks for devices under `roots`.
#[must_use]
pub fn devices(roots: &Roots, ask: &dyn Ask) -> Devices {
    let class = |name: &str| sysfs::entries(&roots.sys.join("class").join(name));
    Devices {
        cameras: class("video4linux").iter().filter_map(|entry| camera(roots, entry, ask)).collect(),
        serial_ports: class("tty").iter().filter_map(|entry| serial_port(roots, entry, ask)).collect(),
        can_interfaces: class("net").iter().filter_map(|entry| can_interface(roots, entry)).collect(),
    }
}

fn camera(roots: &Roots, entry: &Entry, ask: &dyn Ask) -> Option<Camera> {
    if !entry.name.starts_with("video") {
        return None;
    }
    let node = roots.dev.join(&entry.name);
    let formats = match ask.camera(&node) {
        Ok(Answer { captures: false, .. }) => return None,
        Ok(Answer { formats, .. }) => Ok(formats),
        // A camera's further nodes, which could not be asked either, are no news.
        Err(_) if entry.text("index").is_some_and(|index| index != "0") => return None,
        Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Err(
            "no permission: add your user to the group 'video' (`sudo usermod -aG video $USER`) and log in again"
                .to_owned(),
        ),
        Err(error) => Err(format!("does not answer: {error}")),
    };
    Some(Camera {
        stable: sysfs::stable_name(&roots.dev.join("v4l/by-id"), &node),
        card: entry.text("name").unwrap_or_else(|| "unnamed".to_owned()),
        place: entry.place(&roots.sys),
        node,
        formats,
    })
}

fn serial_port(roots: &Roots, entry: &Entry, ask: &dyn Ask) -> Option<SerialPort> {
    if !entry.path.join("device").exists() {
        return None;
    }
    let plugged = entry.name.starts_with("ttyUSB") || entry.name.starts_with("ttyACM");
    // The kernel keeps nodes for ports that the machine could have: without a chip their type is 0.
    let built_in = entry.text("type").is_some_and(|kind| kind != "0");
    if !plugged && !built_in {
        return None;
    }
    let node = roots.dev.join(&entry.name);
    let mut place = entry.place(&roots.sys);
    if place.usb_port.is_none() {
        // On newer kernels this is "port" for every built-in port: no news.
        place.driver = None;
    }
    Some(SerialPort {
        stable: sysfs::stable_name(&roots.dev.join("serial/by-id"), &node),
        product: place.product.clone(),
        usable: ask.may_use(&node),
        place,
        node,
    })
}

fn can_interface(roots: &Roots, entry: &Entry) -> Option<CanInterface> {
    if entry.text("type").as_deref() != Some(TYPE_CAN) {
        return None;
    }
    let flags =
        entry.text("flags").and_then(|text| u32::from_str_radix(text.trim_start_matches("0x"), 16).ok());
    let mtu = entry.text("mtu").and_then(|text| text.parse::<u32>().ok());
    Some(CanInterface {
        up: flags.is_some_and(|flags| flags & FLAG_UP != 0),
        fd: mtu.is_some_and(|mtu| mtu > MTU_CLASSIC),
        place: entry.place(&roots.sys),
        name: entry.name.clone(),
    })
}

impl fmt::Display for Devices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        section(f, "Cameras", &self.cameras, "plug one in; in a container, hand /dev/video* in")?;
        section(f, "\nSerial ports", &self.serial_ports, "plug an adapter in")?;
        let mend = "plug an adapter in, or make a virtual one: `sudo ip link add vcan0 type vcan`";
        section(f, "\nCAN interfaces", &self.can_interfaces, mend)
    }
}

fn section<T: fmt::Display>(f: &mut fmt::Formatter<'_>, title: &str, found: &[T], mend: &str) -> fmt::Result {
    writeln!(f, "{title}:")?;
    if found.is_empty() {
        return writeln!(f, "  none ({mend})");
    }
    found.iter().try_for_each(|device| writeln!(f, "  {device}"))
}

impl fmt::Display for Camera {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}  {}{}", self.node.display(), self.card, self.place)?;
        if let Some(stable) = &self.stable {
            write!(f, "\n      {}", stable.display())?;
        }
        match &self.formats {
            Ok(formats) => formats.iter().try_for_each(|format| write!(f, "\n      {format}")),
            Err(reason) => write!(f, "\n      {reason}"),
        }
    }
}

impl fmt::Display for SerialPort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let product = self.product.as_deref().unwrap_or("serial port");
        write!(f, "{}  {product}{}", self.node.display(), self.place)?;
        if let Some(stable) = &self.stable {
            write!(f, "\n      {}", stable.display())?;
        }
        if !self.usable {
            write!(
                f,
                "\n      no permission: add your user to the group 'dialout' (`sudo usermod -aG dialout $USER`) and log in again"
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for CanInterface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.fd { "CAN FD" } else { "CAN" };
        write!(f, "{}  {kind}, {}{}", self.name, if self.up { "up" } else { "down" }, self.place)?;
        if !self.up {
            // Virtual interfaces have no bit rate to set.
            let rate = if self.place.driver.is_some() { " type can bitrate 1000000" } else { "" };
            write!(f, "\n      bring it up with `sudo ip link set {} up{rate}`", self.name)?;
        }
        Ok(())
    }
}

/// Asks the devices of this machine.
struct System;

#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
impl Ask for System {
    fn camera(&self, node: &Path) -> io::Result<Answer> {
        let probed = crate::source::v4l2::devices::probe(node)?;
        Ok(Answer { captures: probed.captures, formats: probed.formats })
    }

    fn may_use(&self, node: &Path) -> bool {
        crate::source::v4l2::devices::may_use(node)
    }
}

#[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
impl Ask for System {
    fn camera(&self, _node: &Path) -> io::Result<Answer> {
        Err(io::ErrorKind::Unsupported.into())
    }

    fn may_use(&self, _node: &Path) -> bool {
        true
    }
}

/// Lists the devices of this machine.
pub(super) fn run() -> Result<(), Failure> {
    super::say(listed());
    Ok(())
}

/// The devices of this machine, as a list to be read.
pub(super) fn listed() -> String {
    devices(&Roots::system(), &System).to_string().trim_end().to_owned()
}
