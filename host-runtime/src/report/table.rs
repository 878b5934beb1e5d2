//! A table: a name, columns, rows.

use std::fmt::Write as _;

/// Rows under named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// The CSV file's name without its ending.
    pub name: &'static str,
    /// Above the table on the page.
    pub caption: String,
    /// The columns' names; a unit is part of the name.
    pub columns: Vec<&'static str>,
    /// Each as long as `columns`.
    pub rows: Vec<Vec<Cell>>,
}

/// One field.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A word.
    Text(String),
    /// A number with so many decimal places; one that is not finite is not known.
    Number(f64, usize),
}

impl Cell {
    /// A number with two decimal places.
    #[must_use]
    pub const fn number(value: f64) -> Self {
        Self::Number(value, 2)
    }

    /// A whole number.
    #[must_use]
    pub const fn count(value: usize) -> Self {
        Self::Number(value as f64, 0)
    }

    /// What stands in the field; empty where it is not known.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(value, _) if !value.is_finite() => String::new(),
            // -0 is written as 0
            Self::Number(value, places) => {
                let text = format!("{value:.places$}");
                let nothing = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
                if nothing { text.trim_start_matches('-').to_owned() } else { text }
            }
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl Table {
    /// The table as CSV (RFC 4180), with its header.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = String::new();
        let mut line = |fields: &mut dyn Iterator<Item = String>| {
            for (i, field) in fields.enumerate() {
                let separator = if i > 0 { "," } else { "" };
                // writing to a string does not fail
                let _ = write!(text, "{separator}{}", quoted(&field));
            }
            text.push('\n');
        };
        line(&mut self.columns.iter().map(|&column| column.to_owned()));
        for row in &self.rows {
            line(&mut row.iter().map(Cell::text));
        }
        text
    }
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_need_quotes_get_them_and_unknown_numbers_are_empty() {
        let table = Table {
            name: "a",
            caption: String::new(),
            columns: vec!["what", "mm"],
            rows: vec![
                vec!["line, 0.3 m \"fast\"".into(), Cell::Number(-0.001, 2)],
                vec!["none".into(), Cell::number(f64::NAN)],
                vec!["count".into(), Cell::count(12)],
                vec!["less".into(), Cell::number(-1.5)],
            ],
        };
        assert_eq!(table.csv(), "what,mm\n\"line, 0.3 m \"\"fast\"\"\",0.00\nnone,\ncount,12\nless,-1.50\n");
    }
}
