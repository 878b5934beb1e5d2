//! What is written to a drive before it may move: PDOs, mode of operation, who watches whom.

use super::cia402::CYCLIC_SYNCHRONOUS_POSITION;
use super::frame::{RPDO1, TPDO1};
use super::sdo::{Object, Request};
use crate::config::CanopenConfig;

/// Low half of 0x1000 for a drive of CiA 402.
pub(super) const DEVICE_PROFILE_402: u32 = 402;

/// What the drive did wrong last (CiA 402).
pub(super) const ERROR_CODE: Object = object(0x603F, 0);

const DEVICE_TYPE: Object = object(0x1000, 0);
const VENDOR: Object = object(0x1018, 1);
const MODE_DISPLAY: Object = object(0x6061, 0);

/// Bit 31 of a PDO's COB-ID: it does not exist.
const INVALID: u32 = 1 << 31;
/// Bit 30 of a TPDO's COB-ID: it is not sent on remote request, which few drives do.
const NO_REMOTE: u32 = 1 << 30;

/// Reaction to the loss of the master (0x6007): quick stop.
const ON_LOSS_QUICK_STOP: u32 = 3;

/// Room for every step.
const STEPS: usize = 28;

/// The steps of a drive's set-up, in their order.
pub(super) type Steps = heapless::Vec<Step, STEPS>;

/// A step of the set-up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// It must be written.
    Write(Request),
    /// It is written where the drive has it.
    Try(Request),
    /// The device type must be a drive's.
    DeviceType,
    /// The vendor must be this one.
    Vendor(u32),
    /// The mode of operation must show, after some time.
    Mode,
}

impl Step {
    /// What is asked of the drive.
    pub(super) const fn request(&self) -> Request {
        match self {
            Self::Write(request) | Self::Try(request) => *request,
            Self::DeviceType => Request::Read(DEVICE_TYPE),
            Self::Vendor(_) => Request::Read(VENDOR),
            Self::Mode => Request::Read(MODE_DISPLAY),
        }
    }

    /// The object it is about.
    pub(super) const fn object(&self) -> Object {
        match self.request() {
            Request::Read(object) | Request::Write { object, .. } => object,
        }
    }
}

const fn object(index: u16, sub: u8) -> Object {
    Object { index, sub }
}

const fn write(index: u16, sub: u8, value: u32, bytes: u8) -> Request {
    Request::Write { object: object(index, sub), value, bytes }
}

/// The steps for `node`, in their order.
pub(super) fn steps(config: &CanopenConfig, node: u8) -> Steps {
    let mut steps = Steps::new();
    let mut then = |more: &[Step]| {
        for step in more {
            // there is room for all: a test counts them
            let _ = steps.push(*step);
        }
    };
    then(&[Step::DeviceType]);
    if let Some(vendor) = config.vendor {
        then(&[Step::Vendor(vendor)]);
    }
    // who watches whom
    let master = u32::from(config.master) << 16 | u32::from(config.heartbeat_timeout_ms);
    then(&[
        Step::Write(write(0x1017, 0, u32::from(config.heartbeat_ms), 2)),
        Step::Try(write(0x1016, 1, master, 4)),
        Step::Try(write(0x6007, 0, ON_LOSS_QUICK_STOP, 2)),
    ]);
    // the cycle
    let milliseconds = config.period_us / 1_000;
    let thousandths = u32::from((-3i8).cast_unsigned());
    then(&[
        Step::Try(write(0x1006, 0, config.period_us, 4)),
        Step::Try(write(0x60C2, 1, milliseconds, 1)),
        Step::Try(write(0x60C2, 2, thousandths, 1)),
    ]);
    // RPDO1: controlword and target; TPDO1: statusword and position; both with each SYNC
    then(&map(0x1400, 0x1600, u32::from(RPDO1) + u32::from(node), 0, [0x6040_0010, 0x607A_0020]));
    then(&map(0x1800, 0x1A00, u32::from(TPDO1) + u32::from(node), NO_REMOTE, [0x6041_0010, 0x6064_0020]));
    // what else the drive would send of itself
    for (other, function) in [(1, 0x280), (2, 0x380), (3, 0x480)] {
        let id = function + u32::from(node);
        then(&[Step::Try(write(0x1800 + other, 1, INVALID | NO_REMOTE | id, 4))]);
    }
    then(&[Step::Write(write(0x6060, 0, u32::from(CYCLIC_SYNCHRONOUS_POSITION), 1)), Step::Mode]);
    steps
}

/// The order that CiA 301 asks for: off, empty, filled, on.
fn map(communication: u16, mapping: u16, id: u32, flags: u32, entries: [u32; 2]) -> [Step; 7] {
    let [first, second] = entries;
    [
        write(communication, 1, INVALID | flags | id, 4),
        write(mapping, 0, 0, 1),
        write(mapping, 1, first, 4),
        write(mapping, 2, second, 4),
        write(mapping, 0, 2, 1),
        // synchronous, every SYNC
        write(communication, 2, 1, 1),
        write(communication, 1, flags | id, 4),
    ]
    .map(Step::Write)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::borrow::ToOwned as _;
    use std::format;
    use std::string::String;
    use std::vec::Vec;

    #[test]
    fn there_is_room_for_every_step() {
        let config = CanopenConfig { vendor: Some(1), ..CanopenConfig::default() };
        let with_vendor = steps(&config, 5).len();
        assert_eq!(with_vendor, steps(&CanopenConfig::default(), 5).len() + 1);
        assert!(with_vendor < STEPS, "the last may have been left out: {with_vendor}");
    }

    #[test]
    fn pdos_are_mapped_in_the_order_of_the_standard() {
        let steps = steps(&CanopenConfig::default(), 5);
        let written = |step: &Step| match step.request() {
            Request::Write { object, value, bytes } => Some(format!("{object}={value:#x}/{bytes}")),
            Request::Read(_) => None,
        };
        let lines: Vec<String> = steps.iter().filter_map(written).collect();
        let rpdo = [
            "0x1400:01=0x80000205/4",
            "0x1600:00=0x0/1",
            "0x1600:01=0x60400010/4",
            "0x1600:02=0x607a0020/4",
            "0x1600:00=0x2/1",
            "0x1400:02=0x1/1",
            "0x1400:01=0x205/4",
        ];
        assert!(lines.windows(rpdo.len()).any(|window| window == rpdo), "{lines:#?}");
        assert!(lines.contains(&"0x1800:01=0x40000185/4".to_owned()));
        assert!(lines.contains(&"0x1016:01=0x7f00c8/4".to_owned()));
        assert!(
            lines.contains(&"0x60c2:01=0xa/1".to_owned()) && lines.contains(&"0x60c2:02=0xfd/1".to_owned())
        );
        assert_eq!(steps.last(), Some(&Step::Mode));
    }
}
