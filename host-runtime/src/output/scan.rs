//! The horizontal scan through a ball as CSV: figures 1, 2 and 5 of the paper.

use super::csv::{CsvFile, OutputError};
use std::path::Path;
use tetrad_core::vision::learn::HorizontalScan;

/// `x,r,g,b,v,d,m,threshold,border`: one row a column of the picture; components, V and D from 0 to
/// 1, M and the threshold of eq. 1 from -1 to 1; border is `first` or `last` at the ball's matched
/// ends in that row.
#[derive(Debug)]
pub struct ScanCsv;

impl ScanCsv {
    /// Writes a scan to `dir/name`.
    ///
    /// # Errors
    /// [`OutputError`] naming the file.
    pub fn write<const N: usize>(
        dir: &Path,
        name: &str,
        scan: &HorizontalScan<N>,
    ) -> Result<(), OutputError> {
        let mut csv = CsvFile::create(dir, name, "x,r,g,b,v,d,m,threshold,border")?;
        for column in &scan.columns {
            csv.row(|row| {
                row.field(column.x);
                for value in [column.r, column.g, column.b, column.v, column.d, column.m, scan.threshold] {
                    row.number(value);
                }
                let x = i32::from(column.x);
                row.field(match scan.borders {
                    Some((first, _)) if x == i32::from(first) => "first",
                    Some((_, last)) if x == i32::from(last) => "last",
                    _ => "",
                });
            })?;
        }
        Ok(())
    }
}
