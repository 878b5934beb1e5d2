//! A session run through the same pipeline again, and compared with what was recorded.

mod pairs;
mod stations;

use super::compare::{Compared, Comparison};
use super::configuration::Beginning;
use super::error::SessionError;
use super::reader::Reader;
use super::schema::tetrad as msg;
use super::tape::LEFT_OUT;
use crate::output::Stamp;
use crate::pipeline::{HandStep, Step};
use pairs::Pairs;
use stations::Stations;
use tetrad_core::observation::Observations;

/// What was computed anew.
#[derive(Debug)]
pub enum Made<'a> {
    /// A step of a pipeline, and its frames.
    Step(&'a [Stamp], &'a Step),
    /// What one camera of a station saw.
    Seen(usize, Stamp, &'a Observations),
    /// The hand at an instant.
    Hand(Stamp, &'a HandStep),
}

/// What a replay came to.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Outcome {
    /// Kind by kind.
    pub compared: Vec<Compared>,
    /// Pictures that were tracked again.
    pub pictures: u64,
    /// Whether the file ended before its end.
    pub cut: bool,
    /// What else there is to tell.
    pub notes: Vec<String>,
}

impl Outcome {
    /// Whether there was something to compare, and all of it came out the same.
    #[must_use]
    pub fn is_identical(&self) -> bool {
        let counted = self.compared.iter().any(|compared| compared.count > 0);
        counted && self.compared.iter().all(Compared::is_identical)
    }
}

/// Replays a session; `sink` is given everything as it is made.
///
/// # Errors
/// A file that cannot be read on, something in it that cannot be replayed, or what `sink` returned.
pub fn replay<E: From<SessionError>>(
    reader: &mut Reader,
    mut sink: impl FnMut(Made<'_>) -> Result<(), E>,
) -> Result<Outcome, E> {
    let beginning = reader.beginning().clone();
    let refused = |reason: String| SessionError::not_a_session(reader.path(), reason);
    let mut outcome = match beginning.chain {
        msg::Chain::Stations => {
            let mut stations = Stations::new(&beginning).map_err(refused)?;
            while let Some(entry) = reader.next_entry()? {
                stations.take(reader, &entry, &mut sink)?;
            }
            stations.finish()
        }
        msg::Chain::Pairs | msg::Chain::Unknown => {
            let mut pairs = Pairs::new(&beginning).map_err(refused)?;
            while let Some(entry) = reader.next_entry()? {
                pairs.take(reader, &entry, &mut sink)?;
            }
            pairs.finish()
        }
    };
    outcome.cut = reader.cut();
    for (key, count) in reader.end().into_iter().flatten() {
        if let Some(topic) = key.strip_prefix(LEFT_OUT) {
            outcome.notes.push(format!("{count} of {topic} were left out when it was recorded"));
        }
    }
    if reader.version() != env!("CARGO_PKG_VERSION") {
        let (then, now) = (reader.version(), env!("CARGO_PKG_VERSION"));
        outcome.notes.push(format!("recorded by tetrad {then}, replayed by tetrad {now}"));
    }
    Ok(outcome)
}

fn observations_of(names: &[String]) -> Vec<Comparison<msg::Observations>> {
    names.iter().map(|name| Comparison::new(format!("{name} observations"))).collect()
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// Frames that are missing between two numbers, as a camera counts them.
fn missing(last: Option<u32>, number: u32) -> u64 {
    last.map_or(0, |last| u64::from(number.saturating_sub(last).saturating_sub(1)))
}

fn camera(beginning: &Beginning, at: usize, error: impl std::fmt::Display) -> String {
    let name = beginning.cameras.get(at).map_or("?", |camera| camera.name.as_str());
    format!("the {name} camera cannot be tracked: {error}")
}
