//! timestamps.csv: when each picture of a folder was taken.
//!
//! ```text
//! frame,t
//! 0060,2.000
//! 0062,2.067
//! ```
//!
//! `frame` is the picture's file name without its extension, or its frame number; `t` is seconds.
//! Rows of pictures that are not there are passed over (a thinned-out folder keeps its list);
//! a picture without a row is an error, and so is time that does not increase.

use std::{collections::HashMap, path::Path};

use super::SourceError;
use crate::text_file;

/// The file's name inside the folder.
pub(super) const FILE_NAME: &str = "timestamps.csv";

/// The largest there may be, bytes: days of pictures.
const LARGEST: u64 = 256 * 1024 * 1024;

/// How many missing rows a message lists before it counts the rest.
const LISTED: usize = 5;

/// A time and the line it stands on.
#[derive(Clone, Copy)]
struct Row {
    t_s: f64,
    line: usize,
}

/// Reads the times of the pictures with these stems and numbers, in that order; `None` when the
/// folder has no such file.
pub(super) fn read<'a>(
    folder: &Path,
    pictures: impl Iterator<Item = (&'a str, u64)>,
) -> Result<Option<Vec<f64>>, SourceError> {
    let path = folder.join(FILE_NAME);
    let text = match text_file::read_within(&path, LARGEST) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(SourceError::input(&path, format!("cannot be read: {error}"))),
    };
    let rows = parse(&text).map_err(|reason| SourceError::input(&path, reason))?;
    times(&rows, pictures).map(Some).map_err(|reason| SourceError::input(&path, reason))
}

fn parse(text: &str) -> Result<HashMap<&str, Row>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().map_or("", |(_, line)| line.trim());
    if header.split(',').map(str::trim).ne(["frame", "t"]) {
        return Err(format!("the first line is '{header}': it must be 'frame,t'"));
    }
    let mut rows = HashMap::new();
    for (index, text) in lines {
        let line = index + 1;
        let Some((frame, t)) = text.split_once(',') else {
            return Err(format!("line {line}: '{text}' is not 'frame,t'"));
        };
        let (frame, t) = (frame.trim(), t.trim());
        let t_s: f64 = t.parse().map_err(|_| format!("line {line}: '{t}' is no time in seconds"))?;
        if !t_s.is_finite() || t_s < 0.0 {
            return Err(format!(
                "line {line}: the time of frame {frame} is {t}: it must be a finite number of seconds from 0 on"
            ));
        }
        if let Some(first) = rows.insert(frame, Row { t_s, line }) {
            return Err(format!("line {line}: frame {frame} has a time already, on line {}", first.line));
        }
    }
    Ok(rows)
}

fn times<'a>(
    rows: &HashMap<&str, Row>,
    pictures: impl Iterator<Item = (&'a str, u64)>,
) -> Result<Vec<f64>, String> {
    // `frame` may be a number written with other leading zeros than the file name has.
    let by_number: HashMap<u64, Row> =
        rows.iter().filter_map(|(frame, row)| Some((frame.parse().ok()?, *row))).collect();
    let mut times = Vec::new();
    let mut missing = Vec::new();
    let mut previous: Option<(&str, f64)> = None;
    for (stem, number) in pictures {
        let Some(row) = rows.get(stem).or_else(|| by_number.get(&number)) else {
            missing.push(stem);
            continue;
        };
        if let Some((before, t_before)) = previous
            && row.t_s <= t_before
        {
            return Err(format!(
                "line {}: frame {stem} is at {} s, not after frame {before} at {t_before} s: times must increase from picture to picture",
                row.line, row.t_s
            ));
        }
        previous = Some((stem, row.t_s));
        times.push(row.t_s);
    }
    if missing.is_empty() {
        return Ok(times);
    }
    let listed = missing.iter().take(LISTED).copied().collect::<Vec<_>>().join(", ");
    let rest = missing.len().saturating_sub(LISTED);
    let more = if rest == 0 { String::new() } else { format!(" and {rest} more") };
    Err(format!(
        "no row for {listed}{more}: every picture needs one, or remove the file to go by frame numbers"
    ))
}
