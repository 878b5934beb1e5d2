//! A slave on a link: the operator's station drives the arm, somebody at its terminal may stop it.

use super::ending;
use super::packets::Losses;
use super::talk::Talk;
use super::{SlaveArgs, address, open_port, record, report};
use crate::cli::interrupt::Interrupt;
use crate::cli::keyboard::{Key, Keyboard, went_away};
use crate::cli::{note, say, tell_aside};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::{Link, Peer, StationName};
use crate::robot::clock::Clock;
use crate::settings::station::{NetworkSettings, StationSettings};
use crate::station::{Cycle, LinkedSlave, Overseer, SceneCameras, SceneError, SlaveAnnouncement};
use std::io::IsTerminal as _;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// How often keys and the link are looked at: cycles may be ten times as many.
const LOOK: Duration = Duration::from_millis(10);

/// Runs the slave of a station's file until it is told to end.
pub(super) fn run(
    args: &SlaveArgs,
    settings: &StationSettings,
    network: &NetworkSettings,
    operator: &StationName,
    seconds: Option<Duration>,
) -> Result<(), Failure> {
    let identity = network.identity()?;
    let address = address(args, &settings.slave.arm);
    let record = record(args)?;
    let (config, port) = open_port(&address, &settings.slave.arm)?;
    let notice = port.notice();
    let clock = Clock::wall();
    let link = network.start(&identity, clock.clone())?;
    let peer = link.peer(operator).ok_or_else(|| {
        // the file was checked: its operator is one of its peers
        Failure::bad_arguments(format!("no [[peer]] is called `{operator}`"))
    })?;
    let cameras = &settings.slave.cameras;
    let scene = SceneCameras::start(cameras, &config.puma, &peer, link.session(), &clock);
    let scene = scene.map_err(no_scene)?;
    let cameras = u8::try_from(cameras.len()).unwrap_or(u8::MAX);
    let told = SlaveAnnouncement::new(&address, &config, cameras).encode().or_exit(Exit::Failed)?;
    peer.set_configuration(&told).or_exit(Exit::Failed)?;
    let mut slave = LinkedSlave::new(&config, port, peer, link.session()).or_exit(Exit::BadArguments)?;

    let interrupt = Interrupt::listen()?;
    tell_aside()?;
    // without a terminal the operator's stop and the port's own are left
    let keyboard = std::io::stdin().is_terminal().then(|| Keyboard::open().ok()).flatten();
    let now = Instant::now();
    let overseer = Overseer::new(scene, record, &clock);
    let mut desk = Desk {
        link,
        talk: Talk::new(now),
        keyboard,
        interrupt,
        ends: seconds.map(|seconds| now + seconds),
        looked: now,
        terminal_lost: None,
        before_end: None,
    };
    desk.print(&format!("arm at {address}; moved by the station {operator}{}", desk.usage()));
    if let Some(notice) = notice {
        desk.print(&notice);
    }
    let interrupt = desk.interrupt.clone();
    let cycle_us = config.governor.cycle_us;
    let each = |slave: &mut LinkedSlave<Peer>, cycle: &Cycle, lines| desk.each(slave, cycle, lines);
    let overseen = overseer.serve(&mut slave, cycle_us, interrupt.flag(), each);
    // the terminal is itself again before the results
    let Desk { mut terminal_lost, before_end, link, keyboard, .. } = desk;
    if let Some(mut keyboard) = keyboard {
        // whoever hangs up asks for the end too
        terminal_lost = terminal_lost.or(keyboard.still_there().err());
    }
    report(slave.station(), Losses::default());
    for (label, line) in overseen.lines {
        say(format_args!("{label:<15} {line}"));
    }
    if let Some(peer) = link.peer(operator) {
        let motion = peer.stats().received.motion;
        say(format_args!("link            {:.1} % of the motion lost on the way", motion.loss() * 100.0));
    }
    drop(link);
    let standing = || ending::standing(&before_end?, slave.station().port().reason());
    match (terminal_lost, overseen.trouble) {
        (Some(cause), _) => Err(went_away(cause)),
        (None, Some(trouble)) => Err(trouble.into()),
        (None, None) => match standing() {
            Some((exit, words)) => Err(Failure::new(exit, anyhow::anyhow!(words))),
            None => Ok(()),
        },
    }
}

pub(in crate::cli) fn no_scene(error: SceneError) -> Failure {
    let exit = match &error {
        SceneError::Source(_, error) => error.exit(),
        SceneError::Arm(_) => Exit::BadArguments,
        SceneError::Thread(_) => Exit::Failed,
    };
    Failure::new(exit, error)
}

/// What only this kind of slave has beside its cycles: a terminal at the arm, and the link's events.
struct Desk {
    link: Link,
    talk: Talk,
    keyboard: Option<Keyboard>,
    interrupt: Interrupt,
    ends: Option<Instant>,
    looked: Instant,
    /// Who could stop the arm here is gone.
    terminal_lost: Option<std::io::Error>,
    /// The newest cycle before the run was told to end.
    before_end: Option<Cycle>,
}

impl Desk {
    fn each(&mut self, slave: &mut LinkedSlave<Peer>, cycle: &Cycle, lines: Vec<String>) {
        let now = Instant::now();
        if !self.interrupt.asked() {
            self.before_end = Some(*cycle);
        }
        for line in self.talk.lines(cycle, slave.station().port().reason(), now) {
            self.print(&line);
        }
        lines.iter().for_each(|line| self.print(line));
        if now.saturating_duration_since(self.looked) < LOOK {
            return;
        }
        self.looked = now;
        for event in self.link.events() {
            self.print(&event.to_string());
        }
        self.keys(slave);
        if self.ends.is_some_and(|ends| now >= ends) {
            self.end();
        }
    }

    fn end(&self) {
        self.interrupt.flag().store(true, Ordering::Relaxed);
    }

    /// Whoever is at the arm may stop it; it is the operator who resets it.
    fn keys(&mut self, slave: &mut LinkedSlave<Peer>) {
        let Some(keyboard) = &mut self.keyboard else { return };
        loop {
            match keyboard.next() {
                Ok(Some(Key::Quit)) => break self.end(),
                Ok(Some(Key::Homed)) => slave.confirm_homed(),
                Ok(Some(Key::Stop | Key::Reset | Key::Finer | Key::Coarser)) => slave.stop(),
                Ok(None) => {
                    // the bar too
                    if keyboard.take_strike() {
                        slave.stop();
                    }
                    return;
                }
                Err(cause) => {
                    self.terminal_lost = Some(cause);
                    break self.end();
                }
            }
        }
    }

    const fn usage(&self) -> &'static str {
        if self.keyboard.is_some() { "; any key stops it, q ends" } else { "" }
    }

    /// A line; in raw mode a terminal does not go back to its margin by itself.
    fn print(&self, line: &str) {
        if self.keyboard.is_some() {
            note(format_args!("{}\r", line.replace('\n', "\r\n")));
        } else {
            note(line);
        }
    }
}
