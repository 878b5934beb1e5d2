//! The address of an arm, as `--port` and `[slave] port` give it: `KIND:WHERE?option=value&...`.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// What may be given, for messages.
const KNOWN: &str = "dry-run:FILE";

/// Where an arm is.
#[derive(Clone, Debug, PartialEq)]
pub enum RobotAddress {
    /// `dry-run:FILE`: no arm, set-points go to a CSV file.
    DryRun(PathBuf),
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

impl FromStr for RobotAddress {
    type Err = AddressError;

    fn from_str(text: &str) -> Result<Self, AddressError> {
        let wrong = |problem: String| AddressError { address: text.to_owned(), problem };
        let Some((kind, rest)) = text.split_once(':') else {
            return Err(wrong(format!("this is no arm's address: give {KNOWN}")));
        };
        match kind {
            "dry-run" if rest.is_empty() => Err(wrong("name the file: dry-run:set-points.csv".to_owned())),
            "dry-run" => Ok(Self::DryRun(PathBuf::from(rest))),
            _ => Err(wrong(format!("'{kind}' is no kind of arm: give {KNOWN}"))),
        }
    }
}

/// As it was given, or so that it means the same.
impl fmt::Display for RobotAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DryRun(file) => write!(f, "dry-run:{}", file.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(address: &str) -> String {
        address.parse::<RobotAddress>().unwrap_err().to_string()
    }

    #[test]
    fn a_file_for_a_dry_run_may_have_any_name() {
        for file in ["a.csv", "/tmp/a b?c=d.csv", "c:/x.csv"] {
            let address: RobotAddress = format!("dry-run:{file}").parse().unwrap();
            assert_eq!(address, RobotAddress::DryRun(PathBuf::from(file)));
            assert_eq!(address.to_string(), format!("dry-run:{file}"));
        }
    }

    #[test]
    fn what_is_no_address_says_what_would_be() {
        assert_eq!(problem("puma"), format!("puma: this is no arm's address: give {KNOWN}"));
        assert_eq!(problem("val3:x"), format!("val3:x: 'val3' is no kind of arm: give {KNOWN}"));
        assert_eq!(problem("dry-run:"), "dry-run:: name the file: dry-run:set-points.csv");
    }
}
