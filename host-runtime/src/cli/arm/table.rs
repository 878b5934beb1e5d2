//! A CSV table that is read by the names of its columns.

use crate::exit::Exit;
use csv::{ByteRecord, Reader, StringRecord};
use std::io::{self, Read, Write};
use tetrad_core::geometry::Pose;

/// The columns of a pose: place, then rotation row by row.
pub(super) const POSE: [&str; 12] =
    ["x", "y", "z", "r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33"];

/// The columns of the joints.
pub(super) const JOINTS: [&str; 6] = ["q1", "q2", "q3", "q4", "q5", "q6"];

/// What is wrong with a table, by line and column.
#[derive(Debug, thiserror::Error)]
pub(super) enum TableError {
    #[error("nothing came on standard input: a header line with {0} is needed")]
    Empty(String),
    #[error("standard input, line {line}: no column {missing}: add it to {present}{help}")]
    Missing { line: u64, missing: String, present: String, help: &'static str },
    #[error("standard input, line {line}: two columns are called {name}: rename one")]
    Twice { line: u64, name: String },
    #[error(
        "standard input, line {line}: there is a column {name} already, which is to be added: rename it or leave it out"
    )]
    There { line: u64, name: String },
    #[error(
        "standard input, line {line}: {fields} fields, but the header has {columns}: each row needs as many"
    )]
    Fields { line: u64, fields: u64, columns: u64 },
    #[error(
        "standard input, line {line}, column {column}: '{text}' is no finite number: write one such as -0.5 or 1.2e-3"
    )]
    Number { line: u64, column: &'static str, text: String },
    #[error(
        "standard input, line {line}, column {column}: '{text}' cannot be meant: write {unit}, from -{most} to {most}"
    )]
    Beyond { line: u64, column: &'static str, text: String, most: f64, unit: &'static str },
    #[error("standard input, line {line}: {problem}")]
    Row { line: u64, problem: String },
    #[error("standard input, line {line}: this is not UTF-8 text: save the table as UTF-8 CSV")]
    Text { line: u64 },
    #[error("cannot read standard input")]
    Unread(#[source] csv::Error),
    #[error("cannot write to standard output")]
    Unwritten(#[source] io::Error),
}

impl TableError {
    /// How the process ends by it.
    pub(super) fn exit(&self) -> Exit {
        match self {
            Self::Unread(_) | Self::Unwritten(_) => Exit::Failed,
            _ => Exit::BadArguments,
        }
    }
}

/// The table.
pub(super) struct Table<R, const N: usize> {
    reader: Reader<R>,
    names: [&'static str; N],
    places: [usize; N],
    header: StringRecord,
    record: StringRecord,
}

impl<R: Read, const N: usize> Table<R, N> {
    /// Reads the header, which must have the columns `names`, each once, in any order.
    pub(super) fn open(input: R, names: [&'static str; N]) -> Result<Self, TableError> {
        let mut reader = Reader::from_reader(input);
        let header = reader.headers().map_err(understood)?.clone();
        if header.is_empty() {
            return Err(TableError::Empty(names.join(",")));
        }
        let line = header.position().map_or(1, csv::Position::line);
        let places = names.map(|name| position(&header, name));
        let missing: Vec<&str> =
            names.iter().zip(&places).filter(|(_, place)| place.is_none()).map(|(name, _)| *name).collect();
        if !missing.is_empty() {
            let present = header.iter().collect::<Vec<_>>().join(", ");
            let other = present.contains([';', '\t']);
            let present = cut(&present);
            let help = if other { " (columns are told apart by commas)" } else { "" };
            return Err(TableError::Missing { line, missing: missing.join(", "), present, help });
        }
        for name in names {
            if header.iter().filter(|column| column.trim() == name).count() > 1 {
                return Err(TableError::Twice { line, name: name.to_owned() });
            }
        }
        // none is missing
        let places = places.map(Option::unwrap_or_default);
        Ok(Self { reader, names, places, header, record: StringRecord::new() })
    }

    /// The names of all columns, as they stand there.
    pub(super) fn header(&self) -> &StringRecord {
        &self.header
    }

    /// Refuses a column of one of these names.
    pub(super) fn refuse(&self, names: &[&str]) -> Result<(), TableError> {
        let line = self.header.position().map_or(1, csv::Position::line);
        match names.iter().find(|name| position(&self.header, name).is_some()) {
            Some(name) => Err(TableError::There { line, name: (*name).to_owned() }),
            None => Ok(()),
        }
    }

    /// Where another column is, if there is one.
    pub(super) fn place(&self, name: &str) -> Option<usize> {
        position(&self.header, name)
    }

    /// Goes on to the next row; false at the end.
    pub(super) fn advance(&mut self) -> Result<bool, TableError> {
        self.reader.read_record(&mut self.record).map_err(understood)
    }

    /// The row as it stands there.
    pub(super) fn record(&self) -> &StringRecord {
        &self.record
    }

    /// A problem with the whole row.
    pub(super) fn problem(&self, problem: impl ToString) -> TableError {
        TableError::Row { line: self.line(), problem: problem.to_string() }
    }

    /// The row's numbers, in the order of the names; `None` where all of them are empty.
    pub(super) fn numbers(&self) -> Result<Option<[f64; N]>, TableError> {
        let texts = self.places.map(|place| self.record.get(place).unwrap_or_default().trim());
        if texts.iter().all(|text| text.is_empty()) {
            return Ok(None);
        }
        let mut numbers = [0.0; N];
        for (number, (text, column)) in numbers.iter_mut().zip(texts.iter().zip(self.names)) {
            *number = text
                .parse()
                .ok()
                .filter(|number: &f64| number.is_finite())
                .ok_or_else(|| TableError::Number { line: self.line(), column, text: cut(text) })?;
        }
        Ok(Some(numbers))
    }

    /// Refuses numbers beyond what can be meant. They are the row's first ones, in the order of the names.
    pub(super) fn refuse_beyond(
        &self,
        most: f64,
        unit: &'static str,
        numbers: &[f64],
    ) -> Result<(), TableError> {
        let columns = self.names.iter().zip(&self.places).zip(numbers);
        match columns.into_iter().find(|(_, number)| number.abs() > most) {
            Some(((column, place), _)) => Err(TableError::Beyond {
                line: self.line(),
                column,
                text: cut(self.record.get(*place).unwrap_or_default().trim()),
                most,
                unit,
            }),
            None => Ok(()),
        }
    }

    fn line(&self) -> u64 {
        self.record.position().map_or(0, csv::Position::line)
    }
}

/// The most characters of a table that a message repeats.
const REPEATED: usize = 200;

/// What a message repeats of a table: all of it, or its beginning.
fn cut(text: &str) -> String {
    match text.char_indices().nth(REPEATED) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

fn position(header: &StringRecord, name: &str) -> Option<usize> {
    header.iter().position(|column| column.trim() == name)
}

fn understood(error: csv::Error) -> TableError {
    let line = |position: &Option<csv::Position>| position.as_ref().map_or(0, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            TableError::Fields { line: line(pos), fields: *len, columns: *expected_len }
        }
        csv::ErrorKind::Utf8 { pos, .. } => TableError::Text { line: line(pos) },
        _ => TableError::Unread(error),
    }
}

/// A table on its way out, a row at a time.
pub(super) struct Output<W: Write> {
    writer: csv::Writer<W>,
    row: ByteRecord,
}

impl<W: Write> Output<W> {
    pub(super) fn new(output: W) -> Self {
        Self { writer: csv::Writer::from_writer(output), row: ByteRecord::new() }
    }

    /// The next field as it stands.
    pub(super) fn field(&mut self, text: &str) -> &mut Self {
        self.row.push_field(text.as_bytes());
        self
    }

    pub(super) fn fields<'a>(&mut self, texts: impl IntoIterator<Item = &'a str>) -> &mut Self {
        for text in texts {
            self.field(text);
        }
        self
    }

    /// Numbers with the digits that they need to read back the same.
    pub(super) fn numbers(&mut self, numbers: &[f64]) -> &mut Self {
        for number in numbers {
            // -0 is written as 0, and what is next to 0 without its zeros
            let number = number + 0.0;
            let text =
                if number.abs() < 1e-5 && number != 0.0 { format!("{number:e}") } else { number.to_string() };
            self.field(&text);
        }
        self
    }

    /// Ends the row.
    pub(super) fn end(&mut self) -> Result<(), TableError> {
        let written = self.writer.write_byte_record(&self.row);
        self.row.clear();
        written.map_err(|error| TableError::Unwritten(error.into()))
    }

    /// Hands out what was written.
    pub(super) fn flush(&mut self) -> Result<(), TableError> {
        self.writer.flush().map_err(TableError::Unwritten)
    }
}

/// The numbers of a pose in the order of [`POSE`].
pub(super) fn numbers_of(pose: &Pose<f64>) -> [f64; 12] {
    let [x, y, z] = pose.translation.into();
    let r = |row, column| pose.rotation[(row, column)];
    [x, y, z, r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)]
}

/// A pose from its numbers in the order of [`POSE`].
pub(super) fn pose_of([x, y, z, rotation @ ..]: [f64; 12]) -> Pose<f64> {
    Pose {
        translation: nalgebra::Vector3::new(x, y, z),
        rotation: nalgebra::Matrix3::from_row_slice(&rotation),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_repeats_no_more_of_a_table_than_can_be_read() {
        let header = "é".repeat(3_000_000);
        let Err(error) = Table::open(header.as_bytes(), JOINTS) else { panic!("taken") };
        let text = error.to_string();
        assert!(text.contains("éé...") && text.len() < 1_000, "{} bytes", text.len());
        let table = format!("q1,q2,q3,q4,q5,q6\n{},0,0,0,0,0\n", "9x".repeat(1_000_000));
        let mut table = Table::open(table.as_bytes(), JOINTS).unwrap();
        assert!(table.advance().unwrap());
        assert!(table.numbers().unwrap_err().to_string().len() < 1_000);
    }
}
