//! What the arm did, from the slave's arm.csv.

use std::path::Path;

/// One cycle of the slave.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Seconds.
    pub(super) t_s: f64,
    /// The law's state.
    pub(super) state: String,
    /// How old the newest command was, ms.
    pub(super) age_ms: Option<f64>,
    /// Where the tool was sent, metres.
    pub(super) tool_m: Option<[f64; 3]>,
}

/// Reads it. A line that was being written when the slave was killed is left out.
///
/// # Errors
/// What the file lacks.
pub(super) fn read(out: &Path) -> Result<Vec<Row>, String> {
    let file = out.join("arm.csv");
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut lines = text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n'));
    let header: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = |name: &str| {
        let at = header.iter().position(|column| *column == name);
        at.ok_or_else(|| format!("{}: there is no column {name}", file.display()))
    };
    let (t, state, age) = (column("t")?, column("state")?, column("age_ms")?);
    let tool = [column("x")?, column("y")?, column("z")?];
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |at: usize| fields.get(at).and_then(|field| field.parse::<f64>().ok());
        let [x, y, z] = tool.map(number);
        Some(Row {
            t_s: number(t)?,
            state: (*fields.get(state)?).to_owned(),
            age_ms: number(age),
            tool_m: x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]),
        })
    };
    Ok(lines.filter_map(row).collect())
}

/// The way from one place to another, metres.
pub(super) fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// How far the tool was sent in all, metres.
pub(super) fn way(rows: &[Row]) -> f64 {
    let places: Vec<_> = rows.iter().filter_map(|row| row.tool_m).collect();
    places.windows(2).map(|pair| apart(pair[0], pair[1])).sum()
}

/// The fastest the tool was sent from one cycle to the next, m/s.
pub(super) fn fastest(rows: &[Row]) -> f64 {
    let speed = |pair: &[Row]| {
        let dt = pair[1].t_s - pair[0].t_s;
        // cycles that follow a late one come close to it, and have a whole step all the same
        Some(apart(pair[0].tool_m?, pair[1].tool_m?) / dt.max(CYCLE_S))
    };
    rows.windows(2).filter_map(speed).fold(0.0, f64::max)
}

/// The cycle of the slave that is run here, seconds.
const CYCLE_S: f64 = 0.001;
