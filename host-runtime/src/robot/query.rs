//! The options of an address: `option=value&option=value`.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// What stands behind the question mark, until each option has been [taken](Self::take).
/// Errors are sentences for the user that name the option.
#[derive(Debug)]
pub(crate) struct Query<'a> {
    left: Vec<(&'a str, &'a str)>,
    asked: Vec<&'static str>,
}

impl<'a> Query<'a> {
    /// Splits `text`, which may be empty.
    pub(crate) fn parse(text: &'a str) -> Result<Self, String> {
        let mut left: Vec<(&str, &str)> = Vec::new();
        for pair in text.split('&').filter(|pair| !pair.is_empty()) {
            let Some((key, value)) = pair.split_once('=') else {
                return Err(format!("'{pair}' has no value: write {pair}=..."));
            };
            if left.iter().any(|(known, _)| *known == key) {
                return Err(format!("'{key}' is given twice: leave one out"));
            }
            left.push((key, value));
        }
        Ok(Self { left, asked: Vec::new() })
    }

    /// The value of an option, as it stands there.
    pub(crate) fn take(&mut self, key: &'static str) -> Option<&'a str> {
        self.asked.push(key);
        let place = self.left.iter().position(|(known, _)| *known == key)?;
        Some(self.left.swap_remove(place).1)
    }

    /// The value of an option that is a number in `range`, in `unit` for the message.
    pub(crate) fn number<T>(
        &mut self,
        key: &'static str,
        unit: &str,
        range: RangeInclusive<T>,
    ) -> Result<Option<T>, String>
    where
        T: FromStr + PartialOrd + Display,
    {
        let Some(text) = self.take(key) else { return Ok(None) };
        match text.parse::<T>() {
            Ok(value) if range.contains(&value) => Ok(Some(value)),
            _ => {
                let (least, most) = range.into_inner();
                let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
                Err(format!("'{key}={text}': a number from {least} to {most}{unit} is needed"))
            }
        }
    }

    /// Refuses what nobody asked for.
    pub(crate) fn finish(self) -> Result<(), String> {
        let Some((key, _)) = self.left.first() else { return Ok(()) };
        if self.asked.is_empty() {
            return Err(format!("'{key}' means nothing here: it takes no options"));
        }
        Err(format!("'{key}' means nothing here: the options are {}", self.asked.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_taken_in_any_order() {
        let mut query = Query::parse("b=2.5&a=x&&").unwrap();
        assert_eq!(query.take("a"), Some("x"));
        assert_eq!(query.number("b", "s", 0.0..=3.0), Ok(Some(2.5)));
        assert_eq!(query.number("c", "s", 0.0..=3.0), Ok(None));
        assert_eq!(query.finish(), Ok(()));
    }

    #[test]
    fn what_is_wrong_is_named() {
        assert_eq!(Query::parse("a").unwrap_err(), "'a' has no value: write a=...");
        assert_eq!(Query::parse("a=1&a=2").unwrap_err(), "'a' is given twice: leave one out");
        let mut query = Query::parse("baud=fast&parity=odd").unwrap();
        assert_eq!(
            query.number("baud", "", 300..=115_200).unwrap_err(),
            "'baud=fast': a number from 300 to 115200 is needed"
        );
        assert_eq!(query.finish().unwrap_err(), "'parity' means nothing here: the options are baud");
        assert_eq!(
            Query::parse("x=1").unwrap().finish().unwrap_err(),
            "'x' means nothing here: it takes no options"
        );
        // NaN is in no range
        let mut query = Query::parse("lag=NaN").unwrap();
        assert!(query.number("lag", "ms", 0.0..=1.0).is_err());
    }
}
