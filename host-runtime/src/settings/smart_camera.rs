//! `node:serial:DEVICE?baud=N`: a smart camera on a serial port.

use crate::robot::query::Query;
use std::path::PathBuf;

/// What stands before the device.
const SERIAL: &str = "node:serial:";

/// USB ports take any; a UART of this rate has room for two cameras' packets at 60 a second.
const DEFAULT_BAUD: u32 = 921_600;

/// What any line is asked for.
const BAUDS: std::ops::RangeInclusive<u32> = 300..=12_000_000;

/// Where a smart camera is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialPlace {
    /// The port.
    pub device: PathBuf,
    /// Bits a second.
    pub baud: u32,
}

impl SerialPlace {
    /// What SRC names; `None` where that is no smart camera.
    ///
    /// # Errors
    /// A sentence that says what is wrong with it.
    pub fn of(source: &str) -> Option<Result<Self, String>> {
        source.strip_prefix(SERIAL).map(Self::parse)
    }

    fn parse(text: &str) -> Result<Self, String> {
        let (device, query) = text.split_once('?').unwrap_or((text, ""));
        let mut query = Query::parse(query)?;
        let baud = query.number("baud", "bits a second", BAUDS)?.unwrap_or(DEFAULT_BAUD);
        query.finish()?;
        if device.is_empty() {
            return Err(format!("name the port, as {SERIAL}/dev/ttyACM0"));
        }
        Ok(Self { device: device.into(), baud })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_and_its_rate_are_told_from_other_sources() {
        let place = |device: &str, baud| Some(Ok(SerialPlace { device: device.into(), baud }));
        assert_eq!(SerialPlace::of("node:serial:/dev/ttyACM0"), place("/dev/ttyACM0", DEFAULT_BAUD));
        assert_eq!(SerialPlace::of("node:serial:COM3?baud=115200"), place("COM3", 115_200));
        assert_eq!(SerialPlace::of("node:left"), None);
        for wrong in ["node:serial:", "node:serial:/dev/x?baud=1", "node:serial:/dev/x?speed=9600"] {
            assert!(SerialPlace::of(wrong).is_some_and(|place| place.is_err()), "{wrong}");
        }
    }
}
