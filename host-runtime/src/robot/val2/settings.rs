//! `val2:DEVICE?name=value&...`: what can be set.

use std::path::PathBuf;
use std::time::Duration;

use crate::robot::query::Query;

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

/// What is wrong with an address, and what would mend it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Val2AddressError(String);

/// Takes an address apart: the device, and `base` with the settings that the address has.
///
/// # Errors
/// [`Val2AddressError`].
pub fn parse(address: &str, base: &Val2Config) -> Result<(String, Val2Config), Val2AddressError> {
    let rest = address.strip_prefix("val2:").unwrap_or(address);
    let (device, query) = rest.split_once('?').unwrap_or((rest, ""));
    if device.is_empty() {
        let mend = "name the serial port, as in val2:/dev/ttyUSB0 (`tetrad devices` lists them)";
        return Err(Val2AddressError(mend.to_owned()));
    }
    let config = settings(query, base).map_err(Val2AddressError)?;
    Ok((device.to_owned(), config))
}

fn settings(query: &str, base: &Val2Config) -> Result<Val2Config, String> {
    let mut query = Query::parse(query)?;
    let mut config = base.clone();
    if let Some(baud) = query.number("baud", "bits a second", 300..=115_200)? {
        config.baud = baud;
    }
    if let Some(speed) = query.number("speed", "percent of the controller's normal speed", 1..=100)? {
        config.speed = speed;
    }
    match query.take("dialect") {
        None => {}
        Some("point") => config.dialect = Dialect::Point,
        Some("ppoint") => config.dialect = Dialect::PPoint,
        Some(other) => return Err(format!("'dialect={other}': it is point (every VAL) or ppoint (V+)")),
    }
    let mut time = |name, range, field: &mut Duration| -> Result<(), String> {
        if let Some(ms) = query.number(name, "ms", range)? {
            *field = Duration::from_millis(ms);
        }
        Ok(())
    };
    time("where", 100..=60_000, &mut config.where_period)?;
    time("timeout", 200..=60_000, &mut config.timeout)?;
    time("watchdog", 50..=10_000, &mut config.watchdog)?;
    match query.take("calibrate") {
        None => {}
        Some("yes") => config.calibrate = true,
        Some("no") => config.calibrate = false,
        Some(other) => return Err(format!("'calibrate={other}': it is yes or no; yes moves the arm")),
    }
    match query.take("log") {
        None => {}
        Some("") => return Err("'log=': name the file".to_owned()),
        Some(path) => config.log = Some(PathBuf::from(path)),
    }
    query.finish()?;
    Ok(config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_says_what_differs() {
        let base = Val2Config::default();
        assert_eq!(parse("val2:/dev/ttyS0", &base), Ok(("/dev/ttyS0".to_owned(), base.clone())));
        let text = "/dev/x?baud=19200&speed=10&dialect=ppoint&where=250&timeout=300&watchdog=100&calibrate=yes&log=a.txt";
        let (device, config) = parse(text, &base).unwrap();
        let expected = Val2Config {
            baud: 19_200,
            speed: 10,
            dialect: Dialect::PPoint,
            where_period: Duration::from_millis(250),
            timeout: Duration::from_millis(300),
            watchdog: Duration::from_millis(100),
            calibrate: true,
            log: Some(PathBuf::from("a.txt")),
        };
        assert_eq!((device.as_str(), config), ("/dev/x", expected));
    }

    #[test]
    fn what_cannot_be_is_named_with_what_can() {
        let said = |address| parse(address, &Val2Config::default()).unwrap_err().to_string();
        assert!(said("val2:").starts_with("name the serial port"), "{}", said("val2:"));
        assert!(said("val2:/dev/x?spede=3").starts_with("'spede' means nothing here: the options are baud"));
        let text = "'speed=0': a number from 1 to 100 percent of the controller's normal speed is needed";
        assert_eq!(said("/dev/x?speed=0"), text);
        assert!(said("/dev/x?speed=101").contains("1 to 100"));
        assert!(said("/dev/x?baud=fast").contains("300 to 115200"));
        assert!(said("/dev/x?dialect=val3").contains("ppoint (V+)"));
        assert!(said("/dev/x?calibrate=now").contains("moves the arm"));
        assert!(said("/dev/x?log=").contains("name the file"));
    }
}
