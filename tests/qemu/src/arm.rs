//! The arm's cases as a tape: every row of the repository's table, also those out of reach.

use crate::clip::FORMAT;
use crate::tape::{Event, Mode, Tape};
use tetrad_fixtures::golden::data;
use tetrad_fixtures::puma560::{Row, Table};

/// Each row's pose, to be reached from near its joints; where it has none, from zero.
#[must_use]
pub fn tape() -> Tape {
    let table = Table::read(&data("puma560/cases.csv"));
    let events = table.rows().map(|row| Event::Case(case(&row))).collect();
    Tape { size: (0, 0), format: FORMAT, mode: Mode::Refined, events }
}

/// As [`crate::probes::CASE_BYTES`] says.
fn case(row: &Row<'_>) -> Vec<u8> {
    let near = if row.is("unreachable") { [0.0; 6] } else { row.joints("") };
    let pose = row.pose();
    let angles = near.iter().flat_map(|angle| (*angle as f32).to_le_bytes());
    // a matrix lies column by column
    let by_rows = pose.rotation.transpose();
    let numbers = by_rows.iter().chain(&pose.translation).flat_map(|number| number.to_le_bytes());
    angles.chain(numbers).collect()
}
