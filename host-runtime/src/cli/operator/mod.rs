//! `tetrad operator`: the cameras' observations become the hand's motion, and an arm follows it.
//!
//! ```text
//! link's thread: camera stations --+
//! camera threads: cameras here ----+--observations--> loop --motion, buttons--> slave: a station,
//! terminal: hold-to-run, stop -----+                   ^  |                      or a thread here
//! console: the same ---------------+                   |  +--snapshots, pictures--> console
//!                                                      +---- arm's state, pictures ----+
//! ```
//!
//! Here flags and a file become a run; `run` is the loop, which sleeps until something comes.

mod cameras;
mod hold;
mod leisure;
mod losses;
mod pictures;
mod publish;
mod record;
mod report;
mod run;
mod session;
mod slave;
mod stops;
mod talk;

use super::interrupt::Interrupt;
use super::memory::resident_kb;
use super::same_file::{self, Input};
use super::{make_dir, note, say, tell_aside};
use crate::console::{Console, ConsoleError, Desk, SetUp, ViewKind};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::authority::KeyFiles;
use crate::link::{Doorbell, Link};
use crate::output::ArmRecord;
use crate::robot::canopen::CanopenAddress;
use crate::robot::clock::Clock;
use crate::robot::{RobotAddress, RobotKind};
use crate::settings::Start;
use crate::settings::station::{
    CameraStart, ConsoleSettings, HandCamera, LocalCamera, NetworkSettings, OperatorSettings, SceneCamera,
    SlavePlace, SlaveSettings, StationSettings,
};
use crate::station::Operator;
use crate::station::operator::OperatorConfig;
use cameras::Cameras;
use clap::{Args, ValueEnum};
use hold::Hold;
use record::Record;
use run::{Parts, Run};
use slave::SlaveLine;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tetrad_core::config::HandConfig;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::tracker::HandMode;

pub(super) const EXAMPLES: &str = "\
Examples:
  The stations that tetrad.toml names; hold-to-run on this terminal:
    tetrad operator --config tetrad.toml
  A minute with a simulated arm, nobody at the keys:
    tetrad operator --config tetrad.toml --hold-to-run always --seconds 60 --out out
  The buttons in a browser, where the file has [console]; docs/console.md has its keys:
    tetrad operator --config tetrad.toml --hold-to-run console

On the terminal: r resets (after the start, a stop or a fault), the space bar moves the arm while it is
held, h brings it home while that is held, - and + let the hand lead less far or farther, any other key stops it at
once, q ends the program.

With --out, DIR gets pose.csv and filtered.csv (the hand), arm_state.csv (what the slave says),
sent.csv (when each motion passed the stages here), delays.csv, arm.csv where the arm is here, and the newest
pictures of the slave's cameras, left.jpg and right.jpg, with pictures.csv, which says how old they are and
whether they are stale. With --record, one file has the pictures of the cameras that are here, what was seen, the
hand, the arm and the buttons (docs/sessions.md). docs/stations.md lists the keys of tetrad.toml.";

/// Who holds the button.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum HoldToRun {
    /// The space bar of this terminal.
    Keyboard,
    /// A page of the console, which [console] in the file opens
    Console,
    /// Nobody: it is pressed by itself; with a simulated arm or a dry run only
    Always,
}

/// The flags of `tetrad operator`.
#[derive(Args, Clone, Debug)]
pub(super) struct OperatorArgs {
    /// The station's file
    #[arg(long, value_name = "FILE")]
    config: PathBuf,
    /// Who holds hold-to-run
    #[arg(long, value_enum, default_value_t = HoldToRun::Keyboard)]
    hold_to_run: HoldToRun,
    /// Ends after so many seconds [default: with q, or when it is told to end]
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Where the results go; made if missing
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Keep everything in this session, for `tetrad replay`; an older one of that name is lost
    #[arg(long, value_name = "FILE.mcap")]
    record: Option<PathBuf>,
}

/// The longest run that can be asked for: a day.
const MAX_SECONDS: f64 = 86_400.0;

/// Runs `tetrad operator`.
pub(super) fn run(args: &OperatorArgs) -> Result<(), Failure> {
    let settings = StationSettings::load(&args.config).or_exit(Exit::BadArguments)?;
    let operator = settings.operator.as_ref().ok_or_else(|| no_operator(&settings))?;
    let order = Order {
        station: Some(&settings),
        operator,
        slave: &settings.slave,
        network: settings.network.as_ref(),
        console: settings.console.as_ref(),
        hold: args.hold_to_run,
        longest: longest(args.seconds)?,
        out: args.out.as_deref(),
        record: args.record.as_deref(),
    };
    let interrupt = Interrupt::listen()?;
    tell_aside()?;
    order.carry_out(&interrupt, |console| note(format_args!("console at {}", console.url())))
}

/// How long a run may last.
pub(super) fn longest(seconds: Option<f64>) -> Result<Option<Duration>, Failure> {
    match seconds {
        Some(s) if !(s > 0.0 && s <= MAX_SECONDS) => Err(Failure::bad_arguments(format!(
            "--seconds {s}: a number above 0 and up to {MAX_SECONDS} is needed"
        ))),
        seconds => Ok(seconds.map(Duration::from_secs_f64)),
    }
}

/// An operator's run that is asked for.
pub(super) struct Order<'a> {
    /// The file it is of; `None` for one that no file describes.
    pub(super) station: Option<&'a StationSettings>,
    pub(super) operator: &'a OperatorSettings,
    pub(super) slave: &'a SlaveSettings,
    pub(super) network: Option<&'a NetworkSettings>,
    pub(super) console: Option<&'a ConsoleSettings>,
    pub(super) hold: HoldToRun,
    pub(super) longest: Option<Duration>,
    pub(super) out: Option<&'a Path>,
    /// The session that is recorded.
    pub(super) record: Option<&'a Path>,
}

impl Order<'_> {
    /// Runs it to its end and prints what it came to; `opened` hears of the console once there is one.
    pub(super) fn carry_out(
        &self,
        interrupt: &Interrupt,
        opened: impl FnOnce(&Console),
    ) -> Result<(), Failure> {
        let mut run = self.start(opened)?;
        run.print(run.usage());
        let ended = run.all(self.longest, interrupt);
        // the terminal is itself again before the results
        let lines = run.end();
        lines.iter().for_each(say);
        ended
    }

    fn start(&self, opened: impl FnOnce(&Console)) -> Result<Run, Failure> {
        let memory = resident_kb();
        let operator = self.operator;
        if self.hold == HoldToRun::Console && self.console.is_none() {
            return Err(Failure::bad_arguments("--hold-to-run console: the file has no [console]")
                .help("add [console] with listen = \"127.0.0.1:8080\"; docs/stations.md lists its keys"));
        }
        self.refuse_own_files()?;
        let record = match self.out {
            Some(dir) => {
                make_dir(dir)?;
                self.refuse_results(dir)?;
                Some(Record::create(dir).or_exit(Exit::Failed)?)
            }
            None => None,
        };
        if operator.slave == SlavePlace::Here {
            slave::check_hold(self.slave, self.hold)?;
        }
        let clock = Clock::wall();
        let link = match self.network {
            Some(network) => {
                let identity = network.identity()?;
                Some(network.start(&identity, clock.clone())?)
            }
            None => None,
        };
        let bell = link.as_ref().map_or_else(Doorbell::default, Link::doorbell);
        let session = link.as_ref().map_or_else(super::session, Link::session);
        let station = Operator::new(&config(operator)?, session).or_exit(Exit::BadArguments)?;
        let console = self.console(&clock, &bell)?;
        let desk = console.as_ref().map(|(_, desk)| desk);
        let mut cameras =
            Cameras::open(&operator.cameras, link.as_ref(), session, &clock, &bell, desk.is_some())?;
        let tape = match self.record {
            Some(path) => Some(session::start(path, operator, &cameras, &clock)?),
            None => None,
        };
        cameras.begin(&bell, desk, tape.as_ref())?;
        if let Some(desk) = desk {
            let file = self.station.map(|station| station.file.clone());
            desk.set_up_with(SetUp::new(cameras.to_set_up(&operator.cameras), operator.arm_m, file));
        }
        let slave = match &operator.slave {
            SlavePlace::Here => {
                let arm = self.out.map(ArmRecord::create).transpose().or_exit(Exit::Failed)?;
                SlaveLine::here(self.slave, session, &clock, &bell, arm)?
            }
            SlavePlace::Station(name) => SlaveLine::peer(name, link.as_ref())?,
        };
        let hold = match (self.hold, desk) {
            (HoldToRun::Keyboard, _) => Hold::keyboard()?,
            (HoldToRun::Console, Some(desk)) => Hold::Console(desk.clone()),
            (HoldToRun::Console, None) | (HoldToRun::Always, _) => {
                Hold::always(operator.slave == SlavePlace::Here)
            }
        };
        if let Some((console, _)) = &console {
            opened(console);
        }
        let parts = Parts { station, cameras, slave, hold, link, bell, clock, record, tape, console, memory };
        Ok(Run::new(parts))
    }

    /// A session is not recorded over what the run is made of.
    fn refuse_own_files(&self) -> Result<(), Failure> {
        let Some(record) = self.record else { return Ok(()) };
        let keys: Vec<PathBuf> = self.network.map(key_files).into_iter().flatten().collect();
        let keys = keys.iter().map(|file| Input::new("[station] keys", file));
        same_file::refuse("--record", record, self.inputs().into_iter().chain(keys))
    }

    /// Nor over the run's own results, which two would write at once.
    fn refuse_results(&self, dir: &Path) -> Result<(), Failure> {
        let Some(record) = self.record else { return Ok(()) };
        let results = record::FILES.map(|name| dir.join(name));
        same_file::refuse("--record", record, results.iter().map(|file| Input::new("the result", file)))
    }

    /// What the run reads beside the link's keys, by the paths that it is opened by.
    fn inputs(&self) -> Vec<Input<'_>> {
        let mut inputs = Vec::new();
        if let Some(station) = self.station {
            inputs.push(Input::new("--config", &station.file));
            // not opened here, but its colours are read with the file
            if let Some(own) = &station.camera {
                inputs.extend(camera_files("[camera] source", &own.camera, own.colours.as_deref()));
            }
        }
        for camera in &self.operator.cameras {
            let key = "[[operator.camera]] source";
            match &camera.place {
                HandCamera::Local(local) => {
                    inputs.extend(camera_files(key, local, camera.colours.as_deref()));
                }
                HandCamera::Serial { device, .. } => {
                    inputs.push(Input::new(key, device));
                    let file = camera.colours.as_deref();
                    inputs.extend(file.map(|file| Input::new("[[operator.camera]] colours", file)));
                }
                HandCamera::Station(_) => {}
            }
        }
        inputs.extend(self.console.into_iter().flat_map(console_files));
        if self.operator.slave == SlavePlace::Here {
            inputs.extend(slave_files(self.slave));
        }
        inputs
    }

    /// The console, with a view for each camera.
    fn console(&self, clock: &Clock, bell: &Doorbell) -> Result<Option<(Console, Desk)>, Failure> {
        let Some(settings) = self.console else { return Ok(None) };
        let mut settings = settings.clone();
        settings.sessions = settings.sessions.take().or_else(|| Some(folder_of(self.record?)));
        let hands = self.operator.cameras.iter().map(|camera| (cameras::name(camera), ViewKind::Hand));
        // another station tells how many it has when it is there
        let eyes = match &self.operator.slave {
            SlavePlace::Here => self.slave.cameras.len(),
            SlavePlace::Station(_) => pictures::EYES.len(),
        };
        let eyes = pictures::EYES.into_iter().take(eyes);
        let eyes = eyes.map(|eye| (format!("{eye} eye"), ViewKind::Eye));
        let drives = self.hold == HoldToRun::Console;
        let desk = Desk::new(drives, hands.chain(eyes).collect(), clock.clone(), bell.clone());
        let station = self.station.cloned();
        desk.check_by(Box::new(move || super::check::checklist(station.as_ref())));
        let console = Console::start(&settings, desk.clone()).map_err(|error| {
            let exit = match &error {
                ConsoleError::Listen(..) => Exit::DeviceLost,
                ConsoleError::Thread(_) => Exit::Failed,
                ConsoleError::Files(_) => Exit::BadArguments,
            };
            Failure::new(exit, anyhow::Error::new(error).context("there is no console"))
        })?;
        Ok(Some((console, desk)))
    }
}

/// A camera of this computer: its source, which `key` names, and what its balls are first known by.
fn camera_files<'a>(
    key: &'a str,
    local: &'a LocalCamera,
    colours: Option<&'a Path>,
) -> impl Iterator<Item = Input<'a>> {
    let scene = match &local.start {
        CameraStart::Given(Start::Seeds { file, .. }) => Some(Input::new("the scene", Path::new(file))),
        CameraStart::Given(Start::Colours(_)) | CameraStart::OfScene => None,
    };
    let colours = colours.map(|file| Input::new("the colours", file));
    Input::source(key, &local.source).into_iter().chain(scene).chain(colours)
}

/// What lets into the console.
fn console_files(console: &ConsoleSettings) -> impl Iterator<Item = Input<'_>> {
    let tls = console.tls.as_ref();
    let files = [
        ("[console] token_file", console.token_file.as_deref()),
        ("[console] certificate", tls.map(|tls| tls.certificate.as_path())),
        ("[console] key", tls.map(|tls| tls.key.as_path())),
    ];
    files.into_iter().filter_map(|(key, file)| Some(Input::new(key, file?)))
}

/// A slave of this computer: where its arm is, which a session must not be written to either, and what looks
/// at its scene.
fn slave_files(slave: &SlaveSettings) -> impl Iterator<Item = Input<'_>> {
    let port = match slave.arm.port.as_ref().map(RobotAddress::kind) {
        Some(RobotKind::DryRun(file)) => Some(file.as_path()),
        Some(RobotKind::Val2(place)) => place.split('?').next().map(Path::new),
        Some(RobotKind::Canopen(CanopenAddress::Slcan { path, .. })) => Some(Path::new(path)),
        Some(RobotKind::Canopen(CanopenAddress::Interface(_)) | RobotKind::Simulated(_)) | None => None,
    };
    let cameras = slave.cameras.iter().filter_map(|camera| match &camera.place {
        SceneCamera::Source(source) => Input::source("[[slave.camera]] source", source),
        SceneCamera::SimulatedArm => None,
    });
    port.map(|file| Input::new("[slave] port", file)).into_iter().chain(cameras)
}

/// What says who this station is, and the authority's key where it was left beside it: nothing is worse to
/// lose.
fn key_files(network: &NetworkSettings) -> [PathBuf; 4] {
    let own = KeyFiles::of_station(&network.keys, &network.name);
    let authority = KeyFiles::of_authority(&network.keys);
    [own.certificate, own.key, authority.certificate, authority.key]
}

/// The folder that a file lies in.
fn folder_of(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or_else(|| Path::new(".")).to_owned()
}

fn no_operator(settings: &StationSettings) -> Failure {
    Failure::bad_arguments(format!(
        "{}: there is no [operator], and an operator station needs it",
        settings.file.display()
    ))
    .help("docs/stations.md has a whole file for each station")
}

fn config(settings: &OperatorSettings) -> Result<OperatorConfig, Failure> {
    let arms = Arms::equal(settings.arm_m).map_err(|refusal| {
        Failure::new(
            Exit::BadArguments,
            anyhow::Error::new(refusal).context("[operator] arm_mm cannot be worked with"),
        )
    })?;
    Ok(OperatorConfig {
        arms,
        mode: HandMode::Refined,
        hand: HandConfig::default(),
        filter: settings.filter,
        focal_px: settings.cameras.iter().map(|camera| camera.focal_px).collect(),
    })
}
