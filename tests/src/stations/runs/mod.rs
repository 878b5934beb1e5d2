//! The runs: what is started, what is done to it, and what has to be true of it.

mod deaths;
mod flood;
mod page;
mod plain;
mod strangers;

use super::cell::Cell;
use std::time::Duration;

/// How long the four may take to find each other.
const FIND: Duration = Duration::from_secs(15);

/// The tool is steered to half a metre a second, and in the worst drive goes two fifths beyond.
const FASTEST_M_S: f64 = 0.7;

/// A run.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// What it is called.
    pub name: &'static str,
    /// What it shows.
    pub shows: &'static str,
    run: fn(&Cell, Duration) -> Result<String, String>,
}

/// Every run.
pub const RUNS: &[Run] = &[
    Run {
        name: "plain",
        shows: "the arm follows the hand through four processes; delays, losses, memory",
        run: plain::run,
    },
    Run {
        name: "strangers",
        shows: "who has no certificate of a named peer gets nothing, and a line in the log",
        run: strangers::run,
    },
    Run { name: "flood", shows: "garbage on the slave's port does not delay motion", run: flood::run },
    Run {
        name: "page",
        shows: "what the drive page costs with two cameras, and that it does not delay motion",
        run: page::run,
    },
    Run {
        name: "deaths",
        shows: "operator and camera are killed or silent and come back: the arm stops, then follows",
        run: deaths::run,
    },
];

impl Run {
    /// Runs it; what it prints.
    ///
    /// # Errors
    /// What was not as it has to be.
    pub fn run(&self, cell: &Cell, length: Duration) -> Result<String, String> {
        (self.run)(cell, length)
    }
}
