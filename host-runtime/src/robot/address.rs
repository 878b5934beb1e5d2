//! The address of an arm, as `--port` and `[slave] port` give it: `KIND:WHERE?option=value&...`.

use super::canopen::CanopenAddress;
use super::simulated::SimulatedOptions;
use super::val2;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// What may be given, for messages.
const KNOWN: &str = "sim:, dry-run:FILE, val2:DEVICE, canopen:can0 or canopen+slcan:DEVICE";

/// Where an arm is, understood but not opened.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotAddress {
    text: String,
    kind: RobotKind,
}

/// What is there.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotKind {
    /// `sim:` or `sim:?seed=1&...`: a simulated arm.
    Simulated(SimulatedOptions),
    /// `dry-run:FILE`: no arm, set-points go to a CSV file.
    DryRun(PathBuf),
    /// `val2:DEVICE?...`: a VAL II terminal; device and settings as [`val2::parse`] takes them.
    Val2(String),
    /// `canopen:INTERFACE` or `canopen+slcan:DEVICE?...`: drives on a CAN bus.
    Canopen(CanopenAddress),
}

/// Why an address cannot be understood.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{address}: {problem}")]
pub struct AddressError {
    /// The address.
    pub address: String,
    /// What is wrong, and what would mend it.
    pub problem: String,
}

impl RobotAddress {
    /// What is there.
    #[must_use]
    pub const fn kind(&self) -> &RobotKind {
        &self.kind
    }

    /// Whether something could be hurt by what is there.
    #[must_use]
    pub const fn moves_an_arm(&self) -> bool {
        !matches!(self.kind, RobotKind::Simulated(_) | RobotKind::DryRun(_))
    }
}

/// `sim:`, so that everything runs without an arm.
impl Default for RobotAddress {
    fn default() -> Self {
        Self { text: "sim:".to_owned(), kind: RobotKind::Simulated(SimulatedOptions::default()) }
    }
}

impl FromStr for RobotAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        match understand(text) {
            Ok(kind) => Ok(Self { text: text.to_owned(), kind }),
            Err(problem) => Err(AddressError { address: text.to_owned(), problem }),
        }
    }
}

/// As it was given.
impl fmt::Display for RobotAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn understand(text: &str) -> Result<RobotKind, String> {
    let Some((kind, rest)) = text.split_once(':') else {
        return Err(format!("this is no arm's address: give {KNOWN}"));
    };
    let (place, query) = rest.split_once('?').unwrap_or((rest, ""));
    match kind {
        "sim" if place.is_empty() => SimulatedOptions::parse(query).map(RobotKind::Simulated),
        "sim" => Err(format!(
            "'{place}' means nothing here: options stand behind a question mark, as in sim:?seed=1"
        )),
        // a file's name may have a question mark in it
        "dry-run" if rest.is_empty() => Err("name the file, as in dry-run:set-points.csv".to_owned()),
        "dry-run" => Ok(RobotKind::DryRun(PathBuf::from(rest))),
        "val2" => match val2::parse(rest, &val2::Val2Config::default()) {
            Ok(_) => Ok(RobotKind::Val2(rest.to_owned())),
            Err(error) => Err(error.to_string()),
        },
        "canopen" | "canopen+slcan" => text.parse().map(RobotKind::Canopen),
        _ => Err(format!("'{kind}' is no kind of arm: give {KNOWN}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(address: &str) -> String {
        address.parse::<RobotAddress>().unwrap_err().to_string()
    }

    #[test]
    fn a_simulated_arm_is_the_default() {
        assert_eq!("sim:".parse(), Ok(RobotAddress::default()));
        let address: RobotAddress = "sim:?seed=3&noise=off".parse().unwrap();
        assert_eq!(address.to_string(), "sim:?seed=3&noise=off");
        let options = SimulatedOptions { seed: 3, noise_counts: 0.0, ..SimulatedOptions::default() };
        assert_eq!(address.kind(), &RobotKind::Simulated(options));
    }

    #[test]
    fn a_file_for_a_dry_run_may_have_any_name() {
        for file in ["a.csv", "/tmp/a b?c=d.csv", "c:/x.csv"] {
            let address: RobotAddress = format!("dry-run:{file}").parse().unwrap();
            assert_eq!(address.kind(), &RobotKind::DryRun(PathBuf::from(file)));
            assert_eq!(address.to_string(), format!("dry-run:{file}"));
        }
    }

    #[test]
    fn a_terminal_may_have_settings_that_there_are() {
        let address: RobotAddress = "val2:/dev/ttyUSB0?baud=9600".parse().unwrap();
        assert_eq!(address.kind(), &RobotKind::Val2("/dev/ttyUSB0?baud=9600".to_owned()));
        assert!(problem("val2:/dev/ttyUSB0?speed=fast").contains("percent"));
        assert!(problem("val2:").contains("name the serial port"));
    }

    #[test]
    fn a_can_bus_may_be_an_interface_or_an_adapter() {
        for text in ["canopen:can0", "canopen+slcan:/dev/ttyACM0?bitrate=500000"] {
            let address: RobotAddress = text.parse().unwrap();
            assert_eq!(address.kind(), &RobotKind::Canopen(text.parse().unwrap()));
            assert_eq!(address.to_string(), text);
            assert!(address.moves_an_arm());
        }
        assert!(problem("canopen:").contains("name the CAN interface"));
    }

    #[test]
    fn what_is_no_address_says_what_would_be() {
        assert_eq!(problem("puma"), format!("puma: this is no arm's address: give {KNOWN}"));
        assert_eq!(problem("val3:x"), format!("val3:x: 'val3' is no kind of arm: give {KNOWN}"));
        assert_eq!(problem("dry-run:"), "dry-run:: name the file, as in dry-run:set-points.csv");
        let text =
            "sim:puma: 'puma' means nothing here: options stand behind a question mark, as in sim:?seed=1";
        assert_eq!(problem("sim:puma"), text);
        let text = "sim:?lag_ms=1: 'lag_ms=1': a number from 10 to 500 ms is needed";
        assert_eq!(problem("sim:?lag_ms=1"), text);
    }
}
