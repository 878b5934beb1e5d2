//! A slave on a link: the operator's station drives the arm, somebody at its terminal may stop it.

use super::talk::Talk;
use super::{SlaveArgs, address, open_port, record, report};
use crate::cli::interrupt::Interrupt;
use crate::cli::keyboard::{Key, Keyboard};
use crate::cli::{note, say};
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::{Link, Peer, StationName};
use crate::output::ArmCsv;
use crate::robot::clock::Clock;
use crate::settings::station::{NetworkSettings, StationSettings};
use crate::station::{Cycle, LinkedSlave, SceneCameras, SceneError, SlaveAnnouncement, serve};
use anyhow::anyhow;
use std::io::IsTerminal as _;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tetrad_core::arm::port::PortStatus;

/// How often keys, the link and the port's loss are looked at: cycles may be ten times as many.
const LOOK: Duration = Duration::from_millis(10);

/// How long an arm may not answer before the station ends, so that whatever started it can start it anew;
/// the operator has then been told.
const LOST: Duration = Duration::from_secs(2);

/// Runs the slave of a station's file until it is told to end.
pub(super) fn run(
    args: &SlaveArgs,
    settings: &StationSettings,
    network: &NetworkSettings,
    operator: &StationName,
    seconds: Option<Duration>,
) -> Result<(), Failure> {
    let identity = network.identity().or_exit(Exit::BadArguments)?;
    let address = address(args, &settings.slave.arm);
    let record = record(args)?;
    let (config, port) = open_port(&address, &settings.slave.arm)?;
    let notice = port.notice();
    let clock = Clock::wall();
    let link = network.start(&identity, clock.clone()).or_exit(Exit::DeviceLost)?;
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
    // without a terminal the operator's stop and the port's own are left
    let keyboard = std::io::stdin().is_terminal().then(|| Keyboard::open().ok()).flatten();
    let now = Instant::now();
    let mut watch = Overseer {
        link,
        scene,
        clock: clock.clone(),
        talk: Talk::new(now),
        record,
        keyboard,
        interrupt,
        began: now,
        ends: seconds.map(|seconds| now + seconds),
        looked: now,
        lost_since: None,
        worst: None,
    };
    watch.print(&format!("arm at {address}; moved by the station {operator}{}", watch.usage()));
    if let Some(notice) = notice {
        watch.print(&notice);
    }
    let interrupt = watch.interrupt.clone();
    let cycle_us = config.governor.cycle_us;
    let served =
        serve(&mut slave, cycle_us, &clock, interrupt.flag(), |slave, cycle| watch.each(slave, cycle));
    // the terminal is itself again before the results
    let Overseer { worst, link, scene, .. } = watch;
    let pictures = scene.end();
    report(slave.station(), (0, 0));
    if let Some(line) = slave.trail().line() {
        say(format_args!("arm             {line}"));
    }
    let stats = link.peer(operator).map(|peer| peer.stats());
    drop(link);
    say(format_args!("cycles          of {cycle_us} us, {}", served.lateness));
    if let Some((p50, p99)) = served.written.quantile_us(0.5).zip(served.written.quantile_us(0.99)) {
        say(format_args!("motion          at the port {p50} us (p50), {p99} us (p99) after it came"));
    }
    if let Some(stats) = stats {
        let motion = stats.received.motion;
        say(format_args!("link            {:.1} % of the motion lost on the way", motion.loss() * 100.0));
    }
    let unstopped = |error| (Exit::DeviceLost, format!("the arm could not be stopped at its port: {error}"));
    if let Some(pictures) = pictures {
        say(format_args!("pictures        {pictures}"));
    }
    match worst.or(served.unstopped.map(unstopped)) {
        Some((exit, reason)) => Err(Failure::new(exit, anyhow!("{reason}"))),
        None => Ok(()),
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

/// What is done beside the cycles: keys, lines for whoever reads them, the record.
struct Overseer {
    link: Link,
    scene: SceneCameras,
    clock: Clock,
    talk: Talk,
    record: Option<ArmCsv>,
    keyboard: Option<Keyboard>,
    interrupt: Interrupt,
    began: Instant,
    ends: Option<Instant>,
    looked: Instant,
    lost_since: Option<Instant>,
    worst: Option<(Exit, String)>,
}

impl Overseer {
    fn each(&mut self, slave: &mut LinkedSlave<Peer>, cycle: &Cycle) {
        let now = Instant::now();
        if let Some(reading) = &cycle.reading.joints {
            let at_us = self.clock.now_us().saturating_sub(u64::from(reading.age_us));
            self.scene.arm_is_at(&reading.joints, at_us);
        }
        for line in self.talk.lines(cycle, slave.station().robot().reason(), now) {
            self.print(&line);
        }
        self.write(cycle, now);
        if now.saturating_duration_since(self.looked) < LOOK {
            return;
        }
        self.looked = now;
        for event in self.link.events() {
            self.print(&event.to_string());
        }
        if let Some(refusal) = slave.take_refusal() {
            let reason = slave.station().robot().reason();
            let reason = reason.map_or_else(String::new, |reason| format!(" ({reason})"));
            self.print(&format!("no reset: {refusal}{reason}"));
        }
        for notice in self.scene.take_notices() {
            self.print(&notice);
        }
        self.keys(slave, now);
        self.look_for_loss(slave, cycle, now);
        if self.ends.is_some_and(|ends| now >= ends) {
            self.end();
        }
    }

    fn end(&self) {
        self.interrupt.flag().store(true, Ordering::Relaxed);
    }

    /// Whoever is at the arm may stop it; it is the operator who resets it.
    fn keys(&mut self, slave: &mut LinkedSlave<Peer>, now: Instant) {
        let Some(keyboard) = &mut self.keyboard else { return };
        loop {
            match keyboard.next(now) {
                Ok(Some(Key::Quit)) => break self.end(),
                Ok(Some(Key::Homed)) => slave.confirm_homed(),
                Ok(Some(Key::Stop | Key::Reset)) => slave.stop(),
                Ok(None) => {
                    // the bar too
                    if keyboard.is_held(now) {
                        slave.stop();
                    }
                    return;
                }
                Err(cause) => {
                    // who could stop it is gone
                    let cause = format!("the terminal went away: {cause}");
                    self.worst = Some((Exit::Safety, cause));
                    break self.end();
                }
            }
        }
    }

    fn look_for_loss(&mut self, slave: &LinkedSlave<Peer>, cycle: &Cycle, now: Instant) {
        if cycle.reading.status != PortStatus::Lost {
            self.lost_since = None;
            return;
        }
        let since = *self.lost_since.get_or_insert(now);
        if now.saturating_duration_since(since) >= LOST && self.worst.is_none() {
            let reason = slave.station().robot().reason();
            let reason = reason.unwrap_or_else(|| cycle.reading.status.to_string());
            self.worst = Some((Exit::DeviceLost, format!("the arm is lost ({reason})")));
            self.end();
        }
    }

    fn write(&mut self, cycle: &Cycle, now: Instant) {
        let t_s = now.saturating_duration_since(self.began).as_secs_f64();
        let Some(record) = &mut self.record else { return };
        if let Err(error) = record.write(t_s, cycle) {
            // an arm that moves unrecorded is better than one that stops by surprise
            self.record = None;
            self.print(&format!("{:#}; the run goes on without", anyhow::Error::new(error)));
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
