//! The lines of the first table: ours beside the paper's, and whether the promise is held.
//!
//! A figure that was not measured is said to be so and breaks the promise it is held against: no
//! failure may look like a good figure.

use crate::report::{Cell, Report, Table};

/// Where the paper says, or Tetrad promises, nothing.
pub(super) const NOTHING: &str = "\u{2013}";

const NOT_HELD: &str = "NOT held";

const NOT_MEASURED: &str = "not measured";

/// One line of the first table.
pub(super) struct Headline {
    pub(super) what: String,
    pub(super) published: &'static str,
    /// What Tetrad promises of `refined`, in words; [`NOTHING`] where nothing is promised.
    pub(super) promised: &'static str,
    pub(super) refined: Told,
    pub(super) paper: Told,
}

impl Headline {
    /// Whether `refined` keeps what is promised.
    fn verdict(&self) -> &'static str {
        match (self.promised, self.refined.holds()) {
            (NOTHING, _) => NOTHING,
            (_, true) => "held",
            (_, false) => NOT_HELD,
        }
    }
}

/// What a figure is promised to keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Bound {
    /// Nothing.
    Free,
    /// At most that.
    Most(f64),
    /// Less than that.
    Under(f64),
    /// Both ends included.
    Between(f64, f64),
}

impl Bound {
    /// Whether it is kept; a figure that is not finite keeps no bound.
    fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Free => true,
                Self::Most(most) => value <= most,
                Self::Under(limit) => value < limit,
                Self::Between(least, most) => (least..=most).contains(&value),
            }
    }
}

/// What one mode came to, in words, and whether all of it keeps to its bounds.
#[derive(Clone, Debug, Default)]
pub(super) struct Told {
    text: String,
    figures: usize,
    missing: usize,
    broken: bool,
    /// Of the frames or balls that ought to be measured.
    share: Option<f64>,
}

impl Told {
    /// Words in the place of figures.
    pub(super) fn words(text: &str) -> Self {
        Self { text: text.to_owned(), figures: 1, ..Self::default() }
    }

    /// Adds a figure with so many decimal places between words.
    pub(super) fn figure(
        mut self,
        (before, after): (&str, &str),
        value: f64,
        places: usize,
        bound: Bound,
    ) -> Self {
        self.figures += 1;
        self.broken |= !bound.holds(value);
        self.text.push_str(before);
        if value.is_finite() {
            self.text.push_str(&format!("{value:.places$}{after}"));
        } else {
            self.missing += 1;
            self.text.push_str(NOT_MEASURED);
        }
        self
    }

    /// Adds words.
    pub(super) fn note(mut self, words: &str) -> Self {
        self.text.push_str(words);
        self
    }

    /// Something went wrong that no figure shows.
    pub(super) fn failed(mut self, words: &str) -> Self {
        self.broken = true;
        self.note(words)
    }

    /// Of the share that was measured; of several the lowest is told.
    pub(super) fn share(mut self, share: f64) -> Self {
        self.broken |= !share.is_finite();
        self.share = Some(largest([-self.share.unwrap_or(1.0), -share]).abs());
        self
    }

    /// Whether every figure is there and within its bound.
    fn holds(&self) -> bool {
        self.figures > 0 && !self.broken
    }

    fn text(&self) -> String {
        let mut text = if self.missing == self.figures { NOT_MEASURED.to_owned() } else { self.text.clone() };
        if let Some(share) = self.share.filter(|share| *share < 1.0) {
            // rounded down: what is not all of them must not read 100 %
            text.push_str(&format!(", {:.1} % measured", (share * 1e3).floor() / 10.0));
        }
        text
    }
}

/// The largest of several figures: not a number if one of them is not finite, or if there is none.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_finite() && b.is_finite() { a.max(b) } else { f64::NAN };
    let largest = values.into_iter().reduce(larger).unwrap_or(f64::NAN);
    if largest.is_finite() { largest } else { f64::NAN }
}

/// The first table.
pub(super) fn table(headlines: &[Headline]) -> Table {
    let row = |line: &Headline| -> Vec<Cell> {
        let (refined, paper) = (line.refined.text(), line.paper.text());
        let (published, promised) = (line.published, line.promised);
        vec![
            line.what.as_str().into(),
            published.into(),
            refined.into(),
            promised.into(),
            line.verdict().into(),
            paper.into(),
        ]
    };
    Table {
        name: "headlines",
        caption: "In short: ours beside the paper's".to_owned(),
        columns: vec!["what", "the paper, published", "refined", "promised", "promise", "paper mode"],
        rows: headlines.iter().map(row).collect(),
    }
}

/// What the promises of a report that are not held are about.
#[must_use]
pub fn broken_promises(report: &Report) -> Vec<String> {
    let broken = |row: &&Vec<Cell>| row.iter().any(|cell| cell.text() == NOT_HELD);
    let rows = report.headlines.rows.iter().filter(broken);
    rows.filter_map(|row| row.first()).map(|cell| cell.text().to_string()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(refined: Told, promised: &'static str) -> Headline {
        Headline { what: "a".to_owned(), published: NOTHING, promised, refined, paper: Told::words("b") }
    }

    fn px(value: f64, bound: Bound) -> Told {
        Told::default().figure(("", " px"), value, 2, bound)
    }

    #[test]
    fn the_largest_of_figures_with_a_missing_one_is_missing() {
        assert_eq!(largest([0.1, 0.3, 0.2]), 0.3);
        for values in
            [vec![], vec![f64::NAN], vec![f64::NAN, 1.0], vec![1.0, f64::INFINITY, 2.0], vec![1.0, f64::NAN]]
        {
            assert!(largest(values.iter().copied()).is_nan(), "{values:?}");
        }
        assert!(largest([f64::INFINITY]).is_nan());
    }

    #[test]
    fn a_promise_is_held_by_every_figure_or_not() {
        let verdict = |told| line(told, "under 0.3 px").verdict();
        assert_eq!(verdict(px(0.2, Bound::Under(0.3))), "held");
        assert_eq!(verdict(px(0.3, Bound::Most(0.3))), "held");
        assert_eq!(verdict(px(0.3, Bound::Under(0.3))), "NOT held");
        assert_eq!(verdict(px(0.6, Bound::Between(0.7, 1.4))), "NOT held");
        assert_eq!(verdict(px(0.1, Bound::Most(0.3)).figure(("", ""), 0.5, 1, Bound::Most(0.4))), "NOT held");
        assert_eq!(verdict(px(0.2, Bound::Under(0.3)).failed(", one lost")), "NOT held");
        assert_eq!(verdict(Told::default()), "NOT held");
        assert_eq!(line(px(9.0, Bound::Free), NOTHING).verdict(), NOTHING);
    }

    #[test]
    fn a_missing_figure_is_called_so_and_breaks_the_promise() {
        for value in [f64::NAN, f64::INFINITY] {
            let told = px(value, Bound::Free);
            assert_eq!(told.text(), "not measured");
            assert_eq!(line(told, "0.3 px").verdict(), "NOT held");
        }
        let half = px(0.1, Bound::Free).figure((", at most ", ""), f64::NAN, 2, Bound::Free);
        assert_eq!(half.text(), "0.10 px, at most not measured");
        assert!(!half.holds());
    }

    #[test]
    fn the_share_is_told_below_all_and_never_rounded_up_to_all() {
        let told = |share| px(0.1, Bound::Free).share(share);
        assert_eq!(told(1.0).text(), "0.10 px");
        assert_eq!(told(0.9999).text(), "0.10 px, 99.9 % measured");
        assert_eq!(told(0.5).share(0.75).text(), "0.10 px, 50.0 % measured");
        assert_eq!(px(f64::NAN, Bound::Free).share(0.0).text(), "not measured, 0.0 % measured");
        assert!(!told(f64::NAN).holds());
    }
}
