//! `delays.csv`: how long each stage from a picture to the arm took.

use super::csv::{CsvFile, OutputError};
use crate::station::delays::{Delays, Stage};
use std::path::Path;

/// Writes `stage,count,p50_us,p99_us,max_us`, one row for each stage; those that were never measured have
/// a count of 0 and empty fields.
///
/// # Errors
/// [`OutputError`] when it cannot be written.
pub fn write_delays(dir: &Path, delays: &Delays) -> Result<(), OutputError> {
    let mut csv = CsvFile::create(dir, "delays.csv", "stage,count,p50_us,p99_us,max_us")?;
    for stage in Stage::ALL {
        csv.row(|row| {
            row.field(stage.name());
            match delays.of(stage) {
                Some(spread) => {
                    row.field(spread.count).field(spread.p50_us).field(spread.p99_us).field(spread.max_us)
                }
                None => row.field(0).empty().empty().empty(),
            };
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_has_a_row() {
        let dir = tempfile::tempdir().unwrap();
        write_delays(dir.path(), &Delays::new(1)).unwrap();
        let text = std::fs::read_to_string(dir.path().join("delays.csv")).unwrap();
        assert_eq!(text.lines().count(), 1 + Stage::ALL.len());
        assert_eq!(text.lines().nth(1), Some("capture to picture ready,0,,,"));
    }
}
