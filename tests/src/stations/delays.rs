//! How long stages took, from the operator's delays.csv.

use std::path::Path;

/// A stage's 99th percentile, ms.
///
/// # Errors
/// What the file lacks.
pub(super) fn p99_ms(out: &Path, stage: &str) -> Result<f64, String> {
    let file = out.join("delays.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let row =
        text.lines().map(|line| line.split(',').collect::<Vec<_>>()).find(|row| row.first() == Some(&stage));
    let p99_us: Option<f64> = row.and_then(|row| row.get(3)?.parse().ok());
    p99_us.map(|us| us / 1e3).ok_or_else(|| format!("{}: there is no {stage}", file.display()))
}
