//! Which of the four balls are meant: `--balls red,yellow`.

use std::fmt;
use std::str::FromStr;
use tetrad_core::observation::{BALLS, Ball};

/// A non-empty set of balls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BallSet([bool; BALLS]);

impl BallSet {
    /// All four.
    pub const ALL: Self = Self([true; BALLS]);

    /// The set of the balls for which something is known; `None` when there is none.
    pub fn known<T>(slots: &[Option<T>; BALLS]) -> Option<Self> {
        let members = std::array::from_fn(|i| slots[i].is_some());
        members.contains(&true).then_some(Self(members))
    }

    /// Whether the ball is in the set.
    #[must_use]
    pub const fn contains(self, ball: Ball) -> bool {
        self.0[ball.index()]
    }

    /// Whether it is the whole feature frame.
    #[must_use]
    pub fn is_all(self) -> bool {
        self == Self::ALL
    }

    /// The balls in the set, in the paper's order.
    pub fn iter(self) -> impl Iterator<Item = Ball> {
        Ball::ALL.into_iter().filter(move |&ball| self.contains(ball))
    }
}

impl fmt::Display for BallSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, ball) in self.iter().enumerate() {
            write!(f, "{}{}", if i > 0 { "," } else { "" }, ball.name())?;
        }
        Ok(())
    }
}

/// A ball by its name in files and arguments.
///
/// # Errors
/// A sentence that names the four balls there are.
pub fn ball_by_name(name: &str) -> Result<Ball, String> {
    Ball::ALL
        .into_iter()
        .find(|ball| ball.name() == name)
        .ok_or_else(|| format!("there is no ball `{name}`: the balls are red, green, blue and yellow"))
}

impl FromStr for BallSet {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut members = [false; BALLS];
        for name in text.split(',') {
            let ball = ball_by_name(name.trim())?;
            if std::mem::replace(&mut members[ball.index()], true) {
                return Err(format!("{} is named twice", ball.name()));
            }
        }
        Ok(Self(members))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_any_order_make_a_set_in_the_papers_order() {
        let set: BallSet = "yellow, red".parse().unwrap();
        assert_eq!(set.iter().collect::<Vec<_>>(), [Ball::Red, Ball::Yellow]);
        assert_eq!(set.to_string(), "red,yellow");
        assert!(!set.is_all() && "red,green,blue,yellow".parse::<BallSet>().unwrap().is_all());
    }

    #[test]
    fn unknown_repeated_and_empty_names_are_refused() {
        for (text, word) in
            [("pink", "`pink`"), ("red,red", "red is named twice"), ("", "``"), ("red,", "``")]
        {
            let message = text.parse::<BallSet>().unwrap_err();
            assert!(message.contains(word), "{text:?}: {message}");
        }
    }

    #[test]
    fn a_set_of_nothing_does_not_exist() {
        assert_eq!(BallSet::known(&[None::<()>; 4]), None);
        assert_eq!(BallSet::known(&[Some(()), None, None, Some(())]), "red,yellow".parse().ok());
    }
}
