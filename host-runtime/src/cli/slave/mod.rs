//! `tetrad slave`: what came from the operator drives an arm.
//!
//! ```text
//! reader thread: pipe or file --packets--> queue --+
//! terminal: hold-to-run, stop, reset --------------+--> loop at the arm's rate --> robot port
//! ```
//!
//! With a file that names an operator, motion and buttons come over the link instead (`linked`), and the
//! terminal is only for whoever stands at the arm.
//!
//! Here flags become settings and a run its results; `run` is the loop, `ending` how it ended.

pub(super) mod ending;
pub(super) mod linked;
mod packets;
mod run;
pub(super) mod talk;

use super::interrupt::Interrupt;
use super::keyboard::Keyboard;
use super::{make_dir, say, tell_aside};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::ArmRecord;
use crate::robot::{self, Robot, RobotAddress, RobotError, RobotKind};
use crate::settings::arm::ArmSettings;
use crate::settings::station::StationSettings;
use crate::station::SlaveStation;
use clap::{Args, ValueEnum};
use packets::{Losses, Origin, Packets};
use run::{Ended, Run};
use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::time::Duration;
use tetrad_core::arm::teleop::Counts;
use tetrad_core::config::SlaveConfig;

pub(super) const EXAMPLES: &str = "\
Examples:
  Cameras here, a simulated arm here, hold-to-run on this terminal:
    tetrad track --left /dev/video0 --right /dev/video2 ... --packets - | tetrad slave
  What was recorded drives the simulated arm, nobody at the keys:
    tetrad slave --packets motion.bin --hold-to-run sender
  The settings of an arm from a file:
    tetrad slave --config tetrad.toml --packets -
  A station: the operator that the file names moves the arm over the network (docs/stations.md):
    tetrad slave --config tetrad.toml

On the terminal: r resets (after the start, a stop or a fault), the space bar moves the arm while it is
held (from its first repeat on, and most terminals tell 0.1 to 0.2 s late that it was let go; a kitty-like
one tells both at once), h brings it home while that is held, - and + let the hand lead less far or farther, any other
key stops it at once, q ends the program. Where drives cannot tell that their joints are homed
(homing = 'confirm'), c says so. At a station's terminal any key stops the arm, c and q are as above, and
it is the operator who resets and holds hold-to-run.

URL is sim: (a simulated PUMA 560), dry-run:FILE (set-points into a CSV file), val2:/dev/ttyUSB0 (a
PUMA's own VAL II controller), canopen:can0 or canopen+slcan:/dev/ttyACM0 (six CiA 402 drives);
docs/arm.md lists their options. With --out, DIR gets arm.csv: state, set-points, joints.";

/// Who holds the button.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum HoldToRun {
    /// The space bar of this terminal.
    Keyboard,
    /// Whether the packets say engaged: with a simulated arm or a dry run only
    Sender,
}

/// The flags of `tetrad slave`.
#[derive(Args, Clone, Debug)]
pub(super) struct SlaveArgs {
    /// The arm, its limits and its port; see docs/arm.md [default: a PUMA 560 at sim:]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// What drives the arm; takes the place of the file's
    #[arg(long, value_name = "URL")]
    port: Option<RobotAddress>,
    /// Motion packets: a file that `tetrad track --packets` wrote, or - for standard input [default: -]
    #[arg(long, value_name = "FILE")]
    packets: Option<String>,
    /// Who holds hold-to-run [default: keyboard]
    #[arg(long, value_enum)]
    hold_to_run: Option<HoldToRun>,
    /// Ends after so many seconds [default: at the end of the packets, or with q]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Where arm.csv goes; made if missing
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `tetrad slave`.
pub(super) fn run(args: &SlaveArgs) -> Result<(), Failure> {
    let seconds = match args.seconds {
        Some(s) if !(s > 0.0 && s <= MAX_SECONDS) => {
            return Err(Failure::bad_arguments(format!(
                "--seconds {s}: a number above 0 and up to {MAX_SECONDS} is needed"
            )));
        }
        Some(s) => Some(Duration::from_secs_f64(s)),
        None => None,
    };
    let Some(file) = &args.config else { return piped(args, &ArmSettings::default(), seconds) };
    let settings = StationSettings::load(file).or_exit(Exit::BadArguments)?;
    match (&settings.slave.operator, &settings.network) {
        (Some(operator), Some(network)) => {
            let flags =
                [("--packets", args.packets.is_some()), ("--hold-to-run", args.hold_to_run.is_some())];
            if let Some((flag, _)) = flags.iter().find(|(_, given)| *given) {
                return Err(Failure::bad_arguments(format!(
                    "{flag} does not go with {}: there the station {operator} moves the arm",
                    file.display()
                ))
                .help("leave the flag out, or take `operator` out of [slave]"));
            }
            linked::run(args, &settings, network, operator, seconds)
        }
        _ => piped(args, &settings.slave.arm, seconds),
    }
}

/// Motion from a pipe or a file.
fn piped(args: &SlaveArgs, settings: &ArmSettings, seconds: Option<Duration>) -> Result<(), Failure> {
    let hold_to_run = args.hold_to_run.unwrap_or(HoldToRun::Keyboard);
    let address = address(args, settings);
    if hold_to_run == HoldToRun::Sender && address.moves_an_arm() {
        return Err(Failure::bad_arguments(format!(
            "{address} moves an arm: somebody has to hold the button, --hold-to-run sender will not do"
        ))
        .help("leave the flag out and hold the space bar, or try it with --port sim: first"));
    }
    let record = record(args)?;
    let origin = origin(args.packets.as_deref().unwrap_or("-"));
    if origin == Origin::Pipe && hold_to_run == HoldToRun::Keyboard && std::io::stdin().is_terminal() {
        // both would read the same keys, and a stop might go to the wrong one
        return Err(Failure::bad_arguments("standard input is the terminal: no packets come from there")
            .help("pipe `tetrad track --packets -` into it, or give --packets FILE"));
    }
    let packets = Packets::open(&origin)?;
    let (config, port) = open_port(&address, settings)?;
    let station = SlaveStation::new(&config, port).or_exit(Exit::BadArguments)?;
    let keyboard = match hold_to_run {
        HoldToRun::Keyboard => Some(Keyboard::open().map_err(no_keyboard)?),
        HoldToRun::Sender => None,
    };
    let interrupt = Interrupt::listen()?;
    tell_aside()?;
    let cycle = Duration::from_micros(u64::from(config.governor.cycle_us));
    let mut run = Run::new(station, packets, record, keyboard, cycle);
    run.print(&format!("arm at {address}; {}", run.usage()));
    if let Some(notice) = run.station().port().notice() {
        run.print(&notice);
    }
    let ended = run.all(seconds, &interrupt);
    // the terminal is itself again before the results
    let Ended { station, losses, worst } = run.end();
    report(&station, losses);
    ended?;
    match worst {
        Some((exit, reason)) => Err(Failure::new(exit, anyhow::anyhow!("{reason}"))),
        None => Ok(()),
    }
}

fn address(args: &SlaveArgs, settings: &ArmSettings) -> RobotAddress {
    args.port.clone().or_else(|| settings.port.clone()).unwrap_or_default()
}

/// Opens what drives the arm, and what the slave has to keep to with it.
pub(super) fn open_port(
    address: &RobotAddress,
    settings: &ArmSettings,
) -> Result<(SlaveConfig, Box<dyn Robot>), Failure> {
    let mut config = settings.slave;
    if matches!(address.kind(), RobotKind::Canopen(_)) {
        // the limits go at the rate of the drives
        config.governor.cycle_us = settings.canopen.period_us;
    }
    let cycle_us = config.governor.cycle_us;
    let port = robot::open(address, &config.puma, &settings.canopen, cycle_us).map_err(not_opened)?;
    config.governor.speed_share = config.governor.speed_share.min(port.speed_share());
    Ok((config, port))
}

fn record(args: &SlaveArgs) -> Result<Option<ArmRecord>, Failure> {
    let Some(dir) = &args.out else { return Ok(None) };
    make_dir(dir)?;
    Ok(Some(ArmRecord::create(dir).or_exit(Exit::Failed)?))
}

/// The longest run that can be asked for: a day.
const MAX_SECONDS: f64 = 86_400.0;

fn origin(packets: &str) -> Origin {
    if packets == "-" { Origin::Pipe } else { Origin::File(PathBuf::from(packets)) }
}

fn not_opened(error: RobotError) -> Failure {
    let exit = match error {
        RobotError::Config(_) | RobotError::Option { .. } => Exit::BadArguments,
        RobotError::Open { .. } => Exit::DeviceLost,
    };
    Failure::new(exit, error)
}

fn no_keyboard(cause: std::io::Error) -> Failure {
    let cause = anyhow::Error::new(cause).context("there is no terminal whose space bar could be held");
    Failure::new(Exit::BadArguments, cause)
        .help("run it from a terminal; with a simulated arm --hold-to-run sender needs none")
}

fn report(station: &SlaveStation, losses: Losses) {
    let Losses { damaged, foreign, impossible, crowded_out, first_foreign } = losses;
    let Counts { taken, missed, old, old_session, another_sender, bad } = station.counts();
    say(format_args!("commands        {taken} taken, {missed} never came or came late"));
    let dropped = [
        (u64::from(old), "old"),
        (u64::from(old_session), "of an old session"),
        (u64::from(another_sender), "of a second sender"),
        (u64::from(bad) + impossible, "with impossible numbers"),
        (damaged, "damaged"),
        (foreign, "not understood"),
        (crowded_out, "for which there was no room"),
    ];
    for (count, what) in dropped.into_iter().filter(|(count, _)| *count > 0) {
        say(format_args!("dropped         {count} {what}"));
    }
    if let Some(error) = first_foreign {
        say(format_args!("                the first not understood: {error}"));
    }
    for line in station.port().report() {
        say(format_args!("arm             {line}"));
    }
}
