//! The command line: one file a subcommand. Commands print results; errors go up to `main`.

mod demo;
pub mod devices;
mod interrupt;
mod learn;
mod progress;
mod track;

use crate::exit::{Exit, Failure, OrExit as _};
use crate::settings::TrackArgs;
use anyhow::Context as _;
use clap::{Parser, Subcommand};
use std::fmt::Display;
use std::io::{self, Write as _};
use std::path::Path;

const AFTER_HELP: &str = "\
SRC is /dev/videoN, a folder of numbered PNG or JPEG frames (with an optional timestamps.csv:
frame,t), a .y4m file, or sim:NAME.

Exit codes: 0 done, 1 failed, 2 bad arguments or configuration, 3 device or link lost,
4 stopped by a safety rule.";

/// Four coloured balls before two ordinary cameras become six degrees of freedom.
#[derive(Debug, Parser)]
#[command(name = "tetrad", version, after_help = AFTER_HELP, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulated cameras and hand: learn, track and compare with the truth
    #[command(after_help = demo::EXAMPLES)]
    Demo(demo::DemoArgs),
    /// List cameras, serial ports and CAN interfaces
    #[command(after_help = devices::EXAMPLES)]
    Devices,
    /// Teach the balls' colours as one camera sees them
    #[command(after_help = learn::EXAMPLES)]
    Learn(learn::LearnArgs),
    /// Track the balls in one or two cameras and write what was seen
    #[command(after_help = track::EXAMPLES)]
    Track(TrackArgs),
}

/// Runs what was asked for.
///
/// # Errors
/// [`Failure`] with the exit code and the message to print.
pub fn run(cli: Cli) -> Result<(), Failure> {
    match cli.command {
        Command::Demo(args) => demo::run(&args),
        Command::Devices => devices::run(),
        Command::Learn(args) => learn::run(&args),
        Command::Track(args) => track::run(args),
    }
}

/// Makes the directory results go to, and those above it.
fn make_dir(dir: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(dir)
        .with_context(|| format!("cannot make the directory {}", dir.display()))
        .or_exit(Exit::BadArguments)
}

/// Prints a result. A reader that went away (`tetrad ... | head`) is no error.
fn say(text: impl Display) {
    let _ = writeln!(io::stdout(), "{text}");
}

/// Tells the user something beside the results.
fn note(text: impl Display) {
    let _ = writeln!(io::stderr(), "{text}");
}
