//! `sent.csv`: when each motion passed the operator's stages, one row a motion that was sent.

use super::csv::{CsvFile, OutputError};
use crate::station::delays::SentMotion;
use std::path::Path;

/// `sequence,capture,ready,first,joined,posed,sent`: the motion's number; when its instant was, when the last
/// picture that it took was whole in its camera's memory, when the observations of the instant's own picture
/// were here, when those of all cameras were, when the pose was known, when it was handed to the link. Seconds
/// by the operator's clock, as in pose.csv.
#[derive(Debug)]
pub struct SentCsv(CsvFile);

impl SentCsv {
    /// Creates the file in `dir`.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be created.
    pub fn create(dir: &Path) -> Result<Self, OutputError> {
        CsvFile::create(dir, "sent.csv", "sequence,capture,ready,first,joined,posed,sent").map(Self)
    }

    /// Adds a motion.
    ///
    /// # Errors
    /// [`OutputError`] when it cannot be written.
    pub fn write(&mut self, motion: &SentMotion) -> Result<(), OutputError> {
        let SentMotion { capture_us, ready_us, first_us, joined_us, posed_us, sent_us, .. } = *motion;
        self.0.row(|row| {
            row.field(motion.sequence);
            for us in [capture_us, ready_us, first_us, joined_us, posed_us, sent_us] {
                row.time(us as f64 * 1e-6);
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stage_has_a_column_in_seconds() {
        let dir = tempfile::tempdir().unwrap();
        let mut file = SentCsv::create(dir.path()).unwrap();
        let motion = SentMotion {
            sequence: 7,
            capture_us: 1_000_000,
            ready_us: 1_000_001,
            first_us: 1_000_020,
            joined_us: 1_000_300,
            posed_us: 1_004_000,
            sent_us: 1_050_000,
        };
        file.write(&motion).unwrap();
        drop(file);
        let text = std::fs::read_to_string(dir.path().join("sent.csv")).unwrap();
        let row = "7,1.000000,1.000001,1.000020,1.000300,1.004000,1.050000";
        assert_eq!(text.lines().nth(1), Some(row), "{text}");
    }
}
