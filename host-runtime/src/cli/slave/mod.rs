//! `tetrad slave`: what came from the operator drives an arm.
//!
//! ```text
//! reader thread: pipe or file --packets--> queue --+
//! terminal: hold-to-run, stop, reset --------------+--> loop at the arm's rate --> robot port
//! ```
//!
//! The loop waits until the next cycle is due, by the port's own beat where it has one; what was missed is
//! not made up for.

mod keyboard;
mod packets;
mod talk;

use super::interrupt::Interrupt;
use super::{make_dir, note, say};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::ArmCsv;
use crate::robot::{self, RobotAddress, RobotError, RobotKind};
use crate::settings::arm::ArmSettings;
use crate::station::{Cycle, EnableThenReset, SlaveStation};
use clap::{Args, ValueEnum};
use keyboard::{Key, Keyboard};
use packets::{Next, Origin, Packets};
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use talk::Talk;
use tetrad_core::arm::port::{PortError, PortStatus};
use tetrad_core::arm::teleop::{Counts, State};

pub(super) const EXAMPLES: &str = "\
Examples:
  Cameras here, a simulated arm here, hold-to-run on this terminal:
    tetrad track --left /dev/video0 --right /dev/video2 ... --packets - | tetrad slave
  What was recorded drives the simulated arm, nobody at the keys:
    tetrad slave --packets motion.bin --hold-to-run sender
  The settings of an arm from a file:
    tetrad slave --config tetrad.toml --packets -

On the terminal: r resets (after the start, a stop or a fault), the space bar moves the arm while it is
held (a terminal tells late that it was let go: 0.2 s after, 0.7 s after a mere tap; a kitty-like one at
once), any other key stops it at once, q ends the program. Where drives cannot tell that their joints are homed
(homing = 'confirm'), h says so.

URL is sim: (a simulated PUMA 560), dry-run:FILE (set-points into a CSV file), val2:/dev/ttyUSB0 (a
PUMA's own VAL II controller), canopen:can0 or canopen+slcan:/dev/ttyACM0 (six CiA 402 drives);
docs/arm.md lists their options. With --out, DIR gets arm.csv: state, set-points, joints.";

/// How long the end of the run waits for the arm to be at rest.
const REST: Duration = Duration::from_secs(3);

/// How long an arm may take to be switched on: one that calibrates itself goes slowly from joint to joint.
const SWITCH_ON: Duration = Duration::from_secs(150);

/// How long a port may take to say that it has begun to switch on.
const BEGIN: Duration = Duration::from_millis(500);

/// How long hold-to-run is told to be released before nobody's button is pressed.
const RELEASED: Duration = Duration::from_millis(200);

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
    /// Motion packets: a file that `tetrad track --packets` wrote, or - for standard input
    #[arg(long, value_name = "FILE", default_value = "-")]
    packets: String,
    /// Who holds hold-to-run
    #[arg(long, value_enum, default_value_t = HoldToRun::Keyboard)]
    hold_to_run: HoldToRun,
    /// Ends after so many seconds [default: at the end of the packets, or with q]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Where arm.csv goes; made if missing
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs `tetrad slave`.
pub(super) fn run(args: &SlaveArgs) -> Result<(), Failure> {
    let settings = settings(args)?;
    let address = args.port.clone().or_else(|| settings.port.clone()).unwrap_or_default();
    if args.hold_to_run == HoldToRun::Sender && address.moves_an_arm() {
        return Err(Failure::bad_arguments(format!(
            "{address} moves an arm: somebody has to hold the button, --hold-to-run sender will not do"
        ))
        .help("leave the flag out and hold the space bar, or try it with --port sim: first"));
    }
    let seconds = match args.seconds {
        Some(s) if !(s > 0.0 && s <= MAX_SECONDS) => {
            return Err(Failure::bad_arguments(format!(
                "--seconds {s}: a number above 0 and up to {MAX_SECONDS} is needed"
            )));
        }
        Some(s) => Some(Duration::from_secs_f64(s)),
        None => None,
    };
    let record = match &args.out {
        Some(dir) => {
            make_dir(dir)?;
            Some(ArmCsv::create(dir).or_exit(Exit::Failed)?)
        }
        None => None,
    };
    let origin = origin(&args.packets);
    if origin == Origin::Pipe && args.hold_to_run == HoldToRun::Keyboard && std::io::stdin().is_terminal() {
        // both would read the same keys, and a stop might go to the wrong one
        return Err(Failure::bad_arguments("standard input is the terminal: no packets come from there")
            .help("pipe `tetrad track --packets -` into it, or give --packets FILE"));
    }
    let packets = Packets::open(&origin)?;
    let mut config = settings.slave;
    if matches!(address.kind(), RobotKind::Canopen(_)) {
        // the limits go at the rate of the drives
        config.governor.cycle_us = settings.canopen.period_us;
    }
    let port = robot::open(&address, &config.puma, &settings.canopen).map_err(not_opened)?;
    config.governor.speed_share = config.governor.speed_share.min(port.speed_share());
    let station = SlaveStation::new(&config, port).or_exit(Exit::BadArguments)?;
    let keyboard = match args.hold_to_run {
        HoldToRun::Keyboard => Some(Keyboard::open().map_err(no_keyboard)?),
        HoldToRun::Sender => None,
    };
    let interrupt = Interrupt::listen()?;
    let began = Instant::now();
    let cycle = Duration::from_micros(u64::from(config.governor.cycle_us));
    let mut run = Run {
        station,
        packets,
        talk: Talk::new(began),
        record,
        began,
        cycle,
        input: if keyboard.is_some() { Input::Open } else { Input::Starting },
        sender_pressed: false,
        reset: None,
        keyboard,
        worst: None,
    };
    run.print(&format!("arm at {address}; {}", run.usage()));
    if let Some(notice) = run.station.robot().notice() {
        run.print(&notice);
    }
    let ended = run.all(seconds.map(|seconds| began + seconds), &interrupt);
    let Run { station, packets, worst, keyboard, .. } = run;
    // the terminal is itself again before the results
    drop(keyboard);
    report(&station, packets.losses());
    ended?;
    match worst {
        Some((exit, reason)) => Err(Failure::new(exit, anyhow::anyhow!("{reason}"))),
        None => Ok(()),
    }
}

/// The longest run that can be asked for: a day.
const MAX_SECONDS: f64 = 86_400.0;

fn settings(args: &SlaveArgs) -> Result<ArmSettings, Failure> {
    args.config.as_deref().map_or_else(
        || Ok(ArmSettings::default()),
        |file: &Path| ArmSettings::load(file).or_exit(Exit::BadArguments),
    )
}

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

/// What becomes of hold-to-run and of the packets when no keyboard is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Input {
    /// The arm is being switched on; packets wait.
    Starting,
    Open,
    /// The other end went away.
    Ended,
}

/// A reset that was asked for.
#[derive(Clone, Copy, Debug)]
struct Reset {
    since: Instant,
    /// The arm was told to switch on.
    told: bool,
}

impl Reset {
    fn asked(now: Instant) -> Self {
        Self { since: now, told: false }
    }
}

struct Run {
    station: SlaveStation,
    packets: Packets,
    talk: Talk,
    record: Option<ArmCsv>,
    keyboard: Option<Keyboard>,
    began: Instant,
    cycle: Duration,
    input: Input,
    /// What the newest packet says of the button.
    sender_pressed: bool,
    /// A reset that waits for the arm to be switched on.
    reset: Option<Reset>,
    /// How the run ends where nobody is there to mend it.
    worst: Option<(Exit, String)>,
}

impl Run {
    fn usage(&self) -> &'static str {
        match self.keyboard {
            Some(_) => "r resets, hold the space bar to move, any other key stops, q ends",
            None => "the packets hold the button",
        }
    }

    /// Every cycle until the end.
    fn all(&mut self, end: Option<Instant>, interrupt: &Interrupt) -> Result<(), Failure> {
        let mut due = self.began;
        if self.keyboard.is_none() {
            self.reset = Some(Reset::asked(self.began));
        }
        loop {
            let now = Instant::now();
            let over = end.is_some_and(|end| now >= end) || interrupt.asked();
            if over || self.keys(now)? || self.is_done() {
                return self.shut_down();
            }
            self.arrivals()?;
            self.try_reset(now);
            let cycle = self.station.cycle(self.micros(Instant::now()));
            self.tell(&cycle, Instant::now());
            self.write(&cycle)?;
            if self.keyboard.is_none() && self.note_worst(&cycle) {
                return self.shut_down();
            }
            due = next_due(due, self.cycle, Instant::now());
            self.station.pace(due);
            // a port's own beat may be ahead of this clock
            due = due.min(Instant::now());
        }
    }

    fn micros(&self, at: Instant) -> u64 {
        // the law's clock may not begin at 0, so that a moment before it can be told
        1_000_000 + at.saturating_duration_since(self.began).as_micros() as u64
    }

    /// What the operator did; whether the program is to end.
    fn keys(&mut self, now: Instant) -> Result<bool, Failure> {
        let now_us = self.micros(now);
        let Some(keyboard) = &mut self.keyboard else {
            let pressed = self.input == Input::Open && self.sender_pressed;
            self.station.hold_to_run(pressed, now_us);
            return Ok(false);
        };
        loop {
            match keyboard.next(now) {
                Ok(Some(Key::Quit)) => return Ok(true),
                Ok(Some(Key::Stop)) => {
                    self.station.stop();
                    self.reset = None;
                }
                Ok(Some(Key::Homed)) => self.station.confirm_homed(),
                Ok(Some(Key::Reset)) => self.reset = Some(Reset::asked(now)),
                Ok(None) => break,
                Err(cause) => {
                    self.shut_down()?;
                    let cause = anyhow::Error::new(cause).context("the terminal went away");
                    return Err(Failure::new(Exit::Safety, cause));
                }
            }
        }
        let held = keyboard.is_held(now);
        self.station.hold_to_run(held, now_us);
        Ok(false)
    }

    /// Takes every packet that has come.
    fn arrivals(&mut self) -> Result<(), Failure> {
        if self.input == Input::Starting {
            return Ok(());
        }
        loop {
            match self.packets.next() {
                Next::Packet(arrival) => {
                    let received_us = self.micros(arrival.at);
                    // what is refused is counted, and told with the state that it leads to
                    if self.station.take(&arrival.packet, received_us).is_ok() {
                        self.sender_pressed = arrival.packet.engaged;
                    }
                }
                Next::Nothing => return Ok(()),
                Next::Ended(None) => {
                    if self.input != Input::Ended && self.keyboard.is_some() {
                        self.print("no more packets will come; q ends");
                    }
                    self.input = Input::Ended;
                    return Ok(());
                }
                Next::Ended(Some(cause)) => {
                    self.shut_down()?;
                    let cause = anyhow::Error::new(cause).context("the packets cannot be read");
                    return Err(Failure::new(Exit::DeviceLost, cause));
                }
            }
        }
    }

    /// A reset that was asked for, as soon as the arm is switched on.
    fn try_reset(&mut self, now: Instant) {
        let Some(Reset { since, told }) = self.reset else { return };
        let outcome = self.station.reset(self.micros(now), !told);
        self.reset = Some(Reset { since, told: true });
        match outcome {
            Ok(()) => {
                self.reset = None;
                self.packets.begin();
                if self.input == Input::Starting {
                    self.input = Input::Open;
                }
            }
            Err(EnableThenReset::SwitchingOn) if now < since + SWITCH_ON => {}
            // a port that has a thread of its own says a little later that it switches on
            Err(EnableThenReset::NotHomed | EnableThenReset::Port(PortError::NotReady(_)))
                if told && now < since + BEGIN => {}
            // the button has to be heard first
            Err(EnableThenReset::Law(_)) if self.keyboard.is_none() && now < self.began + RELEASED => {}
            Err(refusal) => {
                self.reset = None;
                let reason = self.station.robot().reason();
                let reason = reason.map_or_else(String::new, |reason| format!(" ({reason})"));
                self.print(&format!("no reset: {refusal}{reason}"));
                if self.keyboard.is_none() {
                    self.worst = Some((Exit::DeviceLost, refusal.to_string()));
                }
            }
        }
    }

    /// Whether a run without a keyboard has nothing left to do.
    fn is_done(&self) -> bool {
        self.keyboard.is_none() && (self.input == Input::Ended || self.worst.is_some())
    }

    /// Without anybody to reset it, a fault ends the run; whether it did.
    fn note_worst(&mut self, cycle: &Cycle) -> bool {
        let status = cycle.step.decision.status;
        if self.input == Input::Starting || !matches!(status.state(), State::Stopped | State::Fault) {
            return false;
        }
        let exit = if cycle.reading.status == PortStatus::Lost { Exit::DeviceLost } else { Exit::Safety };
        let reason = self.station.robot().reason().unwrap_or_else(|| cycle.reading.status.to_string());
        self.worst = Some((exit, format!("{status} ({reason})")));
        true
    }

    /// Brings the arm to rest within its limits, then stops it at its port.
    fn shut_down(&mut self) -> Result<(), Failure> {
        self.station.stop();
        let began = Instant::now();
        let mut due = began;
        while began.elapsed() < REST {
            let cycle = self.station.cycle(self.micros(Instant::now()));
            self.write(&cycle)?;
            if cycle.step.governed.is_none_or(|governed| governed.at_rest) {
                break;
            }
            due = next_due(due, self.cycle, Instant::now());
            self.station.pace(due);
            // a port's own beat may be ahead of this clock
            due = due.min(Instant::now());
        }
        if let Err(error) = self.station.shut_down() {
            self.print(&format!("the arm could not be stopped at its port: {error}"));
        }
        Ok(())
    }

    fn tell(&mut self, cycle: &Cycle, now: Instant) {
        for line in self.talk.lines(cycle, self.station.robot().reason(), now) {
            self.print(&line);
        }
    }

    fn write(&mut self, cycle: &Cycle) -> Result<(), Failure> {
        let t_s = self.began.elapsed().as_secs_f64();
        let Some(record) = &mut self.record else { return Ok(()) };
        if let Err(error) = record.write(t_s, cycle) {
            // an arm that moves unrecorded is better than one that stops by surprise
            self.record = None;
            self.print(&format!("{:#}; the run goes on without", anyhow::Error::new(error)));
        }
        Ok(())
    }

    /// A line for the operator; in raw mode a terminal does not go back to its margin by itself.
    fn print(&self, line: &str) {
        if self.keyboard.is_some() {
            let text = line.replace('\n', "\r\n");
            note(format_args!("{text}\r"));
        } else {
            note(line);
        }
    }
}

/// When the next cycle is due: the one after `due` or, where that is over, from now on.
fn next_due(due: Instant, cycle: Duration, now: Instant) -> Instant {
    let next = due + cycle;
    if next < now { now } else { next }
}

fn report(station: &SlaveStation, (damaged, crowded_out): (u64, u64)) {
    let Counts { taken, missed, old, old_session, another_sender, bad } = station.counts();
    say(format_args!("commands        {taken} taken, {missed} never came or came late"));
    let dropped = [
        (u64::from(old), "old"),
        (u64::from(old_session), "of an old session"),
        (u64::from(another_sender), "of a second sender"),
        (u64::from(bad), "with impossible numbers"),
        (damaged, "damaged"),
        (crowded_out, "for which there was no room"),
    ];
    for (count, what) in dropped.into_iter().filter(|(count, _)| *count > 0) {
        say(format_args!("dropped         {count} {what}"));
    }
    for line in station.robot().report() {
        say(format_args!("arm             {line}"));
    }
}
