//! Where the bus is: `canopen:can0` or `canopen+slcan:/dev/ttyACM0?bitrate=1000000&baud=115200`.

use crate::robot::query::Query;
use std::fmt;
use std::str::FromStr;

/// Bit/s of the bus where the address names none.
const DEFAULT_BITRATE: u32 = 1_000_000;
/// Speed of the serial line where the address names none; USB adapters do not mind it.
const DEFAULT_BAUD: u32 = 115_200;

/// Where the bus is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CanopenAddress {
    /// A CAN interface of the kernel.
    Interface(String),
    /// An adapter on a serial port that speaks the Lawicel protocol.
    Slcan {
        /// The serial port.
        path: String,
        /// Bit/s of the bus.
        bitrate: u32,
        /// Baud of the serial line.
        baud: u32,
    },
}

impl FromStr for CanopenAddress {
    /// What is wrong, and what would mend it; without the address.
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let (place, options) = rest.split_once('?').unwrap_or((rest, ""));
        match (kind, place) {
            ("canopen", "") => Err("name the CAN interface, as in canopen:can0".to_owned()),
            ("canopen", interface) if options.is_empty() => Ok(Self::Interface(interface.to_owned())),
            ("canopen", _) => Err("a CAN interface has no options: `ip link` sets its bit rate".to_owned()),
            ("canopen+slcan", "") => Err("name the serial port, as in canopen+slcan:/dev/ttyACM0".to_owned()),
            ("canopen+slcan", path) => {
                let mut query = Query::parse(options)?;
                let bitrate = query.number("bitrate", "bit/s", 10_000..=1_000_000)?;
                let baud = query.number("baud", "baud", 9_600..=12_000_000)?;
                query.finish()?;
                Ok(Self::Slcan {
                    path: path.to_owned(),
                    bitrate: bitrate.unwrap_or(DEFAULT_BITRATE),
                    baud: baud.unwrap_or(DEFAULT_BAUD),
                })
            }
            _ => Err("this is no CANopen bus: give canopen:can0 or canopen+slcan:/dev/ttyACM0".to_owned()),
        }
    }
}

impl fmt::Display for CanopenAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interface(name) => write!(f, "canopen:{name}"),
            Self::Slcan { path, bitrate, baud } => {
                write!(f, "canopen+slcan:{path}?bitrate={bitrate}&baud={baud}")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_understood_and_written_back() {
        let slcan = |bitrate, baud| CanopenAddress::Slcan { path: "/dev/ttyACM0".to_owned(), bitrate, baud };
        let table = [
            ("canopen:can0", CanopenAddress::Interface("can0".to_owned())),
            ("canopen+slcan:/dev/ttyACM0", slcan(1_000_000, 115_200)),
            ("canopen+slcan:/dev/ttyACM0?bitrate=500000", slcan(500_000, 115_200)),
            ("canopen+slcan:/dev/ttyACM0?baud=3000000&bitrate=250000", slcan(250_000, 3_000_000)),
        ];
        for (text, address) in table {
            assert_eq!(text.parse(), Ok(address.clone()), "{text}");
            assert_eq!(address.to_string().parse(), Ok(address), "{text}");
        }
    }

    #[test]
    fn what_is_no_address_says_what_would_be() {
        let problem = |text: &str| text.parse::<CanopenAddress>().unwrap_err();
        assert!(problem("canopen:").contains("canopen:can0"));
        assert!(problem("canopen:can0?bitrate=1").contains("ip link"));
        assert!(problem("canopen+slcan:").contains("/dev/ttyACM0"));
        assert!(problem("canopen+slcan:/dev/x?speed=3").contains("speed"));
        assert!(problem("canopen+slcan:/dev/x?baud=fast").contains("a number from"));
        assert!(problem("socketcan:can0").contains("no CANopen bus"));
    }
}
