//! What stations are called: in configurations, and in their certificates.

use std::fmt;
use std::str::FromStr;

/// The most characters of a name: a DNS label's, for certificates carry it as one.
const MAX_LEN: usize = 63;

/// What the authority's own files are called; no station may be.
pub(super) const AUTHORITY: &str = "authority";

/// A station's name: lower-case letters, digits and hyphens, a letter first.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct StationName(String);

/// Why a text is no station's name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is no name for a station: take 1 to {MAX_LEN} lower-case letters, digits or hyphens, a letter first, no hyphen last, and not `{AUTHORITY}`"
)]
pub struct BadName(String);

impl StationName {
    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for StationName {
    type Err = BadName;

    fn from_str(text: &str) -> Result<Self, BadName> {
        let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let sound = text.len() <= MAX_LEN
            && text.starts_with(|c: char| c.is_ascii_lowercase())
            && !text.ends_with('-')
            && text.chars().all(letters)
            && text != AUTHORITY;
        if sound { Ok(Self(text.to_owned())) } else { Err(BadName(text.to_owned())) }
    }
}

impl fmt::Display for StationName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_dns_labels() {
        let long = "a".repeat(MAX_LEN);
        for good in ["slave", "camera-left", "c2", "a", &long] {
            assert_eq!(good.parse::<StationName>().unwrap().as_str(), good);
        }
        let longer = "a".repeat(MAX_LEN + 1);
        let bad = ["", "Slave", "2c", "-a", "a-", "a.b", "a b", "../a", "é", "authority", "*", &longer];
        for bad in bad {
            let refused = bad.parse::<StationName>().unwrap_err().to_string();
            assert!(refused.contains(&format!("`{bad}`")), "{refused}");
        }
    }
}
