//! `val2:DEVICE?name=value&...`: what can be set.

use std::path::PathBuf;
use std::time::Duration;

/// How a joint point is defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dialect {
    /// `POINT #P` and its questions: every VAL.
    Point,
    /// `DO SET #P=#PPOINT(...)`: V+, in a third of the time.
    PPoint,
}

/// How the controller is spoken to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Val2Config {
    /// `baud`: the line's speed, bits a second.
    pub baud: u32,
    /// `speed`: what the controller is told by SPEED, percent of its normal speed, 1 to 100. Low by
    /// default: a stop waits for the move under way.
    pub speed: u8,
    /// `dialect`: `point` or `ppoint`.
    pub dialect: Dialect,
    /// `where`: how often the joints are read, milliseconds. A reading takes a quarter of a second of
    /// the line at 9600 baud.
    pub where_period: Duration,
    /// `timeout`: how long an answer may take, milliseconds.
    pub timeout: Duration,
    /// `watchdog`: how long an arm that was given a set-point may be without the next, milliseconds.
    pub watchdog: Duration,
    /// `calibrate`: whether an arm that is not calibrated is calibrated by enabling it. It moves.
    pub calibrate: bool,
    /// `log`: a file that everything sent and received is added to.
    pub log: Option<PathBuf>,
}

impl Default for Val2Config {
    fn default() -> Self {
        Self {
            baud: 9600,
            speed: 30,
            dialect: Dialect::Point,
            where_period: Duration::from_millis(1000),
            timeout: Duration::from_millis(2000),
            watchdog: Duration::from_millis(500),
            calibrate: false,
            log: None,
        }
    }
}

/// What is wrong with an address.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Val2AddressError {
    /// No device.
    #[error("no device; write val2:/dev/ttyUSB0, say (`tetrad devices` lists serial ports)")]
    NoDevice,
    /// A setting that there is not.
    #[error(
        "{0}: no such setting of val2; there are baud, speed, dialect, where, timeout, watchdog, calibrate and log"
    )]
    Unknown(String),
    /// A value that it cannot have.
    #[error("{name}={value}: {name} is {wanted}")]
    Value {
        /// The setting.
        name: &'static str,
        /// What was given.
        value: String,
        /// What it may be.
        wanted: &'static str,
    },
}

/// Takes an address apart: the device, and `base` with the settings that the address has.
///
/// # Errors
/// [`Val2AddressError`].
pub fn parse(address: &str, base: &Val2Config) -> Result<(String, Val2Config), Val2AddressError> {
    let rest = address.strip_prefix("val2:").unwrap_or(address);
    let (device, query) = rest.split_once('?').unwrap_or((rest, ""));
    if device.is_empty() {
        return Err(Val2AddressError::NoDevice);
    }
    let mut config = base.clone();
    for setting in query.split('&').filter(|setting| !setting.is_empty()) {
        let (name, value) = setting.split_once('=').unwrap_or((setting, ""));
        set(&mut config, name, value)?;
    }
    Ok((device.to_owned(), config))
}

fn set(config: &mut Val2Config, name: &str, value: &str) -> Result<(), Val2AddressError> {
    let wrong = |name, wanted| Val2AddressError::Value { name, value: value.to_owned(), wanted };
    let whole = |name, wanted, least: u32, most: u32| {
        let number = value.parse().ok().filter(|number| (least..=most).contains(number));
        number.ok_or_else(|| wrong(name, wanted))
    };
    let time = |name, wanted, least, most| {
        whole(name, wanted, least, most).map(|ms| Duration::from_millis(u64::from(ms)))
    };
    match name {
        "baud" => config.baud = whole("baud", "bits a second, 300 to 115200", 300, 115_200)?,
        "speed" => {
            let wanted = "percent of the controller's normal speed, 1 to 100";
            config.speed =
                u8::try_from(whole("speed", wanted, 1, 100)?).map_err(|_| wrong("speed", wanted))?;
        }
        "dialect" => {
            config.dialect = match value {
                "point" => Dialect::Point,
                "ppoint" => Dialect::PPoint,
                _ => return Err(wrong("dialect", "point (every VAL) or ppoint (V+)")),
            }
        }
        "where" => config.where_period = time("where", "milliseconds, 100 to 60000", 100, 60_000)?,
        "timeout" => config.timeout = time("timeout", "milliseconds, 200 to 60000", 200, 60_000)?,
        "watchdog" => config.watchdog = time("watchdog", "milliseconds, 50 to 10000", 50, 10_000)?,
        "calibrate" => {
            config.calibrate = match value {
                "yes" => true,
                "no" => false,
                _ => return Err(wrong("calibrate", "yes or no; yes moves the arm")),
            }
        }
        "log" if !value.is_empty() => config.log = Some(PathBuf::from(value)),
        "log" => return Err(wrong("log", "the name of a file")),
        _ => return Err(Val2AddressError::Unknown(name.to_owned())),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_says_what_differs() {
        let base = Val2Config::default();
        assert_eq!(parse("val2:/dev/ttyS0", &base), Ok(("/dev/ttyS0".to_owned(), base.clone())));
        let (device, config) =
            parse("/dev/x?baud=19200&speed=10&dialect=ppoint&where=250&calibrate=yes&log=a.txt", &base)
                .unwrap();
        let expected = Val2Config {
            baud: 19_200,
            speed: 10,
            dialect: Dialect::PPoint,
            where_period: Duration::from_millis(250),
            calibrate: true,
            log: Some(PathBuf::from("a.txt")),
            ..base
        };
        assert_eq!((device.as_str(), config), ("/dev/x", expected));
    }

    #[test]
    fn what_cannot_be_is_named_with_what_can() {
        let said = |address| parse(address, &Val2Config::default()).unwrap_err().to_string();
        assert!(said("val2:").contains("no device"), "{}", said("val2:"));
        assert!(said("val2:/dev/x?spede=3").starts_with("spede: no such setting"));
        assert_eq!(
            said("/dev/x?speed=0"),
            "speed=0: speed is percent of the controller's normal speed, 1 to 100"
        );
        assert!(said("/dev/x?speed=101").contains("1 to 100"));
        assert!(said("/dev/x?baud=fast").contains("300 to 115200"));
        assert!(said("/dev/x?dialect=val3").contains("ppoint"));
        assert!(said("/dev/x?calibrate").contains("moves the arm"));
        assert!(said("/dev/x?log=").contains("name of a file"));
    }
}
