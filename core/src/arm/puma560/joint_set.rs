//! Some of the six joints.

use crate::config::JOINTS;
use core::fmt;

/// Some of the six joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointSet(u8);

impl JointSet {
    /// None of them.
    pub const EMPTY: Self = Self(0);

    /// The set with joint `number` (from 1) in it; the same set where there is no such joint.
    #[must_use]
    pub const fn with(self, number: usize) -> Self {
        if number >= 1 && number <= JOINTS { Self(self.0 | 1 << (number - 1)) } else { self }
    }

    /// The joints for which `flags` is true, from base to wrist.
    #[must_use]
    pub fn from_flags(flags: [bool; JOINTS]) -> Self {
        (1..).zip(flags).filter(|(_, flag)| *flag).fold(Self::EMPTY, |set, (number, _)| set.with(number))
    }

    /// Whether no joint is in it.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether joint `number` (from 1) is in it.
    #[must_use]
    pub const fn contains(self, number: usize) -> bool {
        let other = Self::EMPTY.with(number).0;
        other != 0 && self.0 & other == other
    }

    /// The numbers (from 1) of the joints in it, from base to wrist.
    pub fn numbers(self) -> impl Iterator<Item = usize> {
        (1..=JOINTS).filter(move |&number| self.contains(number))
    }
}

/// `joint 2`, `joints 2, 4`, `no joint`.
impl fmt::Display for JointSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0.count_ones() {
            0 => return f.write_str("no joint"),
            1 => "joint ",
            _ => "joints ",
        })?;
        for (place, number) in self.numbers().enumerate() {
            if place > 0 {
                f.write_str(", ")?;
            }
            write!(f, "{number}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn a_set_names_its_joints() {
        let set = JointSet::from_flags([false, true, false, true, false, false]);
        assert!(set.contains(2) && set.contains(4) && !set.contains(1) && !set.contains(0));
        assert_eq!(set.to_string(), "joints 2, 4");
        assert_eq!(JointSet::EMPTY.with(6).to_string(), "joint 6");
        assert_eq!(JointSet::EMPTY.with(7).to_string(), "no joint");
    }
}
