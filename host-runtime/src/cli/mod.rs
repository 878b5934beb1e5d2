//! The command line: one file a subcommand. Commands print results; errors go up to `main`.

mod arm;
mod camera;
mod check;
mod demo;
pub mod devices;
mod evaluate;
mod interrupt;
mod keyboard;
mod keys;
mod learn;
mod logs;
mod memory;
mod notes;
mod operator;
mod progress;
mod record;
mod replay;
mod same_file;
mod slave;
mod track;

use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::Summary;
use crate::settings::TrackArgs;
use clap::{Parser, Subcommand};
use notes::{note, tell_aside};
use std::fmt::Display;
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

/// Why a result could not be printed.
static UNPRINTED: OnceLock<io::Error> = OnceLock::new();

const AFTER_HELP: &str = "\
SRC is /dev/videoN, a folder of numbered PNG or JPEG frames (with an optional timestamps.csv:
frame,t), a .y4m file, a session recorded as .mcap, or sim:NAME.

Exit codes: 0 done, 1 failed, 2 bad arguments or configuration, 3 device or link lost,
4 stopped by a safety rule.";

/// Four coloured balls before two ordinary cameras become six degrees of freedom.
#[derive(Debug, Parser)]
#[command(name = "tetrad", version, after_help = AFTER_HELP, max_term_width = 100)]
pub struct Cli {
    /// Log what happens on standard error: error, warn, info, debug, trace or off, or TARGET=LEVEL,...
    /// [default: what RUST_LOG says, else off]
    #[arg(long, global = true, value_name = "LEVEL")]
    log: Option<String>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// The arm's kinematics, CSV in and CSV out
    #[command(after_help = arm::EXAMPLES)]
    Arm(arm::ArmArgs),
    /// A camera station: one camera, tracked where it is, for the operator
    #[command(after_help = camera::EXAMPLES)]
    Camera(camera::CameraArgs),
    /// Say what a station's file means, or what is wrong with it; nothing is opened, nothing moves
    #[command(after_help = check::EXAMPLES)]
    Check(check::CheckArgs),
    /// Simulated cameras and hand: learn, track and compare with the truth
    #[command(after_help = demo::EXAMPLES)]
    Demo(demo::DemoArgs),
    /// List cameras, serial ports and CAN interfaces
    #[command(after_help = devices::EXAMPLES)]
    Devices,
    /// Measure both modes as section 5 of the paper does, and report
    #[command(after_help = evaluate::EXAMPLES)]
    Evaluate(evaluate::EvaluateArgs),
    /// Make the authority, certificates and keys by which stations know each other
    #[command(after_help = keys::EXAMPLES)]
    Keys(keys::KeysArgs),
    /// Teach the balls' colours as one camera sees them
    #[command(after_help = learn::EXAMPLES)]
    Learn(learn::LearnArgs),
    /// Join the cameras' observations, send the hand's motion to the slave
    #[command(after_help = operator::EXAMPLES)]
    Operator(operator::OperatorArgs),
    /// Track as `track` does, and keep everything in one MCAP file
    #[command(after_help = record::EXAMPLES)]
    Record(record::RecordArgs),
    /// Run a recorded session through the same pipeline, and say whether the same came out
    #[command(after_help = replay::EXAMPLES)]
    Replay(replay::ReplayArgs),
    /// Drive an arm by what a station or `tetrad track --packets` sends
    #[command(after_help = slave::EXAMPLES)]
    Slave(slave::SlaveArgs),
    /// Track the balls in one or two cameras and write what was seen
    #[command(after_help = track::EXAMPLES)]
    Track(TrackArgs),
}

/// Runs what was asked for.
///
/// # Errors
/// [`Failure`] with the exit code and the message to print.
pub fn run(cli: Cli) -> Result<(), Failure> {
    logs::start(cli.log.as_deref())?;
    let done = match cli.command {
        Command::Arm(args) => arm::run(&args),
        Command::Camera(args) => camera::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Demo(args) => demo::run(&args),
        Command::Devices => devices::run(),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Keys(args) => keys::run(&args),
        Command::Learn(args) => learn::run(&args),
        Command::Operator(args) => operator::run(&args),
        Command::Record(args) => record::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Slave(args) => slave::run(&args),
        Command::Track(args) => track::run(args),
    };
    notes::flush();
    done.and_then(|()| printed())
}

/// Makes the directory results go to, and those above it.
fn make_dir(dir: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(dir).map_err(|cause| {
        let cause = anyhow::Error::new(cause).context(format!("cannot make the directory {}", dir.display()));
        Failure::new(Exit::BadArguments, cause).help(
            "--out names a folder that is there or can be made: give one you may write to, such as ./out",
        )
    })
}

/// Makes the directory of a run; the summary of an earlier one goes at once, so that it never stands
/// for a run that ended before it had its own.
fn make_results_dir(dir: &Path) -> Result<(), Failure> {
    make_dir(dir)?;
    Summary::remove(dir).or_exit(Exit::Failed)
}

/// Prints a result. A reader that went away (`tetrad ... | head`) is no error; a disk that is full is
/// one, and [`printed`] tells of it at the end.
fn say(text: impl Display) {
    // what was told before stands before it
    notes::flush();
    if let Err(error) = writeln!(io::stdout(), "{text}")
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        // only the first is of interest
        let _ = UNPRINTED.set(error);
    }
}

/// Fails when a result could not be printed.
fn printed() -> Result<(), Failure> {
    // results that were buffered reach the file only here
    let flushed = io::stdout().flush();
    let failed = |cause: &io::Error| {
        Failure::new(Exit::Failed, anyhow::anyhow!("{cause}").context("cannot write to standard output"))
    };
    match (UNPRINTED.get(), flushed) {
        (Some(cause), _) => Err(failed(cause)),
        (None, Err(cause)) if cause.kind() != io::ErrorKind::BrokenPipe => Err(failed(&cause)),
        _ => Ok(()),
    }
}

/// A number that no earlier run is likely to have had.
fn session() -> u32 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    since.subsec_nanos() ^ (since.as_secs() as u32).rotate_left(8) ^ std::process::id().rotate_left(20)
}
