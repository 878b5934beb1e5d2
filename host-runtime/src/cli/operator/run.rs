//! The loop of an operator: it sleeps until something comes or is due.

use super::cameras::Cameras;
use super::hold::{Hold, Wish};
use super::leisure::Leisure;
use super::note;
use super::pictures::{self, Pictures};
use super::publish::{Publisher, Scene};
use super::record::Record;
use super::report::{self, Memory};
use super::session;
use super::slave::SlaveLine;
use super::stops::Stops;
use super::talk::{SILENT_US, SLAVE, Talk, log_arm};
use crate::cli::interrupt::Interrupt;
use crate::cli::keyboard::scale_words;
use crate::cli::memory::resident_kb;
use crate::console::{Console, Desk};
use crate::exit::{Exit, Failure};
use crate::link::{Carrier as _, Doorbell, Link, Watch};
use crate::output::OutputError;
use crate::precedence::{Duty, step_forward};
use crate::robot::clock::Clock;
use crate::session::StationTape;
use crate::station::operator::{Buttons, OperatorTurn};
use crate::station::{Operator, SlaveAnnouncement, arm_words};
use std::time::{Duration, Instant};
use tetrad_core::wire::{ArmState, ArmStatePacket, ControllerState};

/// Keys, and whether a button of the console is still told of, are looked at so often while nothing comes.
const KEYS: Duration = Duration::from_millis(10);

/// What is no part of the motion (events, pictures, threads that ended) is looked at so often,
/// microseconds.
const CHORES_US: u64 = 20_000;

/// The memory is warm after a quarter of the run, or after so long, microseconds.
const WARM_US: u64 = 60_000_000;

/// How often the release is told at the end, and how far apart.
const RELEASES: u32 = 3;
const RELEASE_EVERY: Duration = Duration::from_millis(20);

/// What a run is made of.
pub(super) struct Parts {
    pub(super) station: Operator,
    pub(super) cameras: Cameras,
    pub(super) slave: SlaveLine,
    pub(super) hold: Hold,
    pub(super) link: Option<Link>,
    pub(super) bell: Doorbell,
    pub(super) clock: Clock,
    pub(super) record: Option<Record>,
    pub(super) console: Option<(Console, Desk)>,
    /// The session that is recorded.
    pub(super) tape: Option<StationTape>,
    /// The program's memory before it began, kB.
    pub(super) memory: Option<u64>,
}

/// An operator at work.
pub(super) struct Run {
    parts: Parts,
    watch: Watch,
    talk: Talk,
    pictures: Pictures,
    publisher: Option<Publisher>,
    memory: Memory,
    chores_us: u64,
    leisure: Leisure,
    slave_heard_us: Option<u64>,
    stops: Stops,
    arm: Option<ArmStatePacket>,
    /// What a slave of this process came to.
    slave_lines: Vec<(&'static str, String)>,
    /// What the session came to.
    tape_lines: Vec<String>,
}

impl Run {
    pub(super) fn new(parts: Parts) -> Self {
        let watch = parts.bell.watch();
        let mut pictures = Pictures::new(parts.record.as_ref().map(|record| record.dir.as_path()));
        let desk = parts.console.as_ref().map(|(_, desk)| desk);
        if let Some(desk) = desk {
            pictures.show(desk.clone(), parts.cameras.0.len());
        }
        let publisher = desk.cloned().map(Publisher::new);
        let memory = Memory { start: parts.memory, ..Memory::default() };
        Self {
            parts,
            watch,
            talk: Talk::default(),
            pictures,
            publisher,
            memory,
            chores_us: 0,
            leisure: Leisure::default(),
            slave_heard_us: None,
            stops: Stops::default(),
            arm: None,
            slave_lines: Vec::new(),
            tape_lines: Vec::new(),
        }
    }

    pub(super) const fn usage(&self) -> &'static str {
        self.parts.hold.usage()
    }

    /// Turn after turn until the end, at most for so long.
    pub(super) fn all(&mut self, longest: Option<Duration>, interrupt: &Interrupt) -> Result<(), Failure> {
        step_forward(Duty::Join);
        let began_us = self.parts.clock.now_us();
        let micros = |duration: Duration| u64::try_from(duration.as_micros()).unwrap_or(u64::MAX);
        let end_us = longest.map(|longest| began_us.saturating_add(micros(longest)));
        let warm_us = began_us + longest.map_or(WARM_US, |longest| (micros(longest) / 4).min(WARM_US));
        let ended = loop {
            let now_us = self.parts.clock.now_us();
            if interrupt.asked() || end_us.is_some_and(|end_us| now_us >= end_us) {
                // whoever hangs up asks for the end too
                break self.parts.hold.still_there();
            }
            match self.turn(now_us) {
                Ok(Wish::Quit) => break Ok(()),
                Ok(Wish::Nothing | Wish::Homed | Wish::Scaled(_)) => {}
                Err(failure) => break Err(failure),
            }
            if self.memory.warm.is_none() && now_us >= warm_us {
                self.memory.warm = resident_kb();
            }
            self.sleep();
        };
        let judged = ended.and_then(|()| self.judge());
        self.let_go();
        self.memory.end = resident_kb();
        let slave = self.end_slave();
        let written = self.finish_record().map_err(|error| Failure::new(Exit::Failed, error));
        judged.and(slave).and(written)
    }

    /// Ends a slave of this process, where there is one that has not ended.
    fn end_slave(&mut self) -> Result<(), Failure> {
        let Some(overseen) = self.parts.slave.end()? else { return Ok(()) };
        self.slave_lines = overseen.lines;
        overseen.trouble.map_or(Ok(()), |trouble| Err(trouble.into()))
    }

    /// What came, what is due.
    fn turn(&mut self, now_us: u64) -> Result<Wish, Failure> {
        let wish = self.parts.hold.keys(Instant::now())?;
        if wish == Wish::Homed {
            self.print(if self.parts.slave.confirm_homed() {
                "the arm is told that its joints are homed"
            } else {
                "whether its joints are homed is for somebody at the arm to say: c at the slave's terminal"
            });
        }
        if let Wish::Scaled(scale) = wish {
            self.print(&scale_words(scale));
        }
        let mut came = Vec::new();
        for (at, camera) in self.parts.cameras.0.iter_mut().enumerate() {
            if let Some(observation) = camera.observation() {
                self.parts.station.observe(at, &observation);
                if self.parts.tape.is_some() {
                    came.push((at, observation));
                }
            }
        }
        let buttons = self.buttons(now_us);
        let turn = self.parts.station.step(&self.parts.slave, buttons, &self.parts.clock);
        // what moves the arm has gone before anything is written
        if let Some(tape) = &mut self.parts.tape {
            came.iter().for_each(|(at, observation)| tape.observed(*at, observation));
            tape.buttons(buttons, now_us);
            tape.turn(&turn);
        }
        self.tell(&turn)?;
        let at_leisure = self.leisure.is_now(turn.step.is_some(), now_us);
        if at_leisure && now_us.saturating_sub(self.chores_us) >= CHORES_US {
            self.chores_us = now_us;
            if self.chores(now_us)? {
                return Ok(Wish::Quit);
            }
        }
        if at_leisure || self.publisher.as_ref().is_some_and(Publisher::has_news) {
            self.publish(now_us);
        }
        Ok(wish)
    }

    /// What is pressed; a stop of the console counts wherever the buttons are.
    fn buttons(&mut self, now_us: u64) -> Buttons {
        let buttons = self.parts.hold.buttons(now_us);
        let Some((_, desk)) = &self.parts.console else { return buttons };
        // there the console itself knows which came first
        if self.parts.hold.is_console() {
            buttons
        } else {
            self.stops.with_buttons_elsewhere(buttons, desk, now_us)
        }
    }

    fn publish(&mut self, now_us: u64) {
        let Some(publisher) = &mut self.publisher else { return };
        let Parts { station, cameras, slave, link, tape, .. } = &self.parts;
        let (link, tape, pictures) = (link.as_ref(), tape.as_ref(), &self.pictures);
        let scene = Scene { station, cameras, slave, link, pictures, tape };
        publisher.publish(&scene, now_us);
    }

    fn tell(&mut self, turn: &OperatorTurn) -> Result<(), Failure> {
        if let Some(step) = &turn.step {
            self.talk.hand(step);
            if let Some(publisher) = &mut self.publisher {
                publisher.hand(step);
            }
            self.write(|record| record.step(step));
        }
        if let Some(state) = &turn.arm {
            self.slave_heard_us = Some(state.received_us);
            let before = self.arm.replace(state.what);
            log_arm(before.as_ref(), &state.what);
            self.parts.hold.hear(&state.what, state.received_us);
            if let Some(publisher) = &mut self.publisher {
                publisher.arm(state);
            }
            for line in self.talk.arm(&state.what, state.received_us) {
                self.print(&line);
            }
            self.write(|record| record.arm(state));
        }
        if let Some(error) = turn.unsent {
            let cause = anyhow::Error::new(error).context("the hand's motion cannot be told");
            return Err(Failure::new(Exit::Failed, cause));
        }
        Ok(())
    }

    /// What can wait a little; whether the run is to end.
    fn chores(&mut self, now_us: u64) -> Result<bool, Failure> {
        let events = self.parts.link.iter().flat_map(Link::events).map(|event| event.to_string());
        let mut lines: Vec<String> = events.collect();
        lines.extend(self.parts.cameras.notices());
        lines.extend(self.parts.slave.notices());
        lines.extend(self.pictures.take(&self.parts.slave, now_us));
        if let Some((_, desk)) = &self.parts.console {
            for (view, picture) in self.parts.cameras.pictures() {
                desk.show(view, pictures::shown(&picture));
            }
        }
        if let Some(arms) = self.parts.console.as_ref().and_then(|(_, desk)| desk.take_arms()) {
            self.parts.station.set_up(arms);
            if let Some(tape) = &self.parts.tape {
                tape.hand_begins(arms, now_us);
            }
            let [mm, ..] = arms.lengths_m().map(|m| m * 1000.0);
            lines.push(format!("set up anew: a frame with arms of {mm:.1} mm"));
        }
        if !self.parts.slave.is_connected() {
            self.parts.hold.slave_gone();
        }
        if let Some(message) = self.parts.slave.configuration() {
            match SlaveAnnouncement::decode(&message) {
                Ok(slave) => {
                    lines.push(format!("the slave's arm is at {}, {} cameras", slave.port, slave.cameras));
                    tracing::info!(
                        port = slave.port,
                        cameras = slave.cameras,
                        scale = slave.scale,
                        "the slave is there"
                    );
                    self.pictures.announced(slave.cameras);
                    if let Some(publisher) = &mut self.publisher {
                        publisher.announced(&slave);
                    }
                    self.parts.hold.announced(&slave)?;
                }
                Err(error) => return Err(Failure::new(Exit::BadArguments, error)),
            }
        }
        let heard = self.parts.cameras.0.iter().map(|camera| (camera.name.as_str(), camera.heard_us));
        let links: Vec<_> = heard.chain([(SLAVE, self.slave_heard_us)]).collect();
        let live = self.talk.live(&links, self.pictures.ages(now_us), now_us);
        if let Some(tape) = &mut self.parts.tape {
            tape.delays(self.parts.station.delays(), now_us);
            lines.iter().chain(&live).for_each(|line| tape.said(line, now_us));
            lines.extend(
                tape.take_failure()
                    .map(|error| format!("{:#}; the run goes on without", anyhow::Error::new(error))),
            );
        }
        for line in &lines {
            self.print(line);
        }
        // the console shows as much all the time
        live.iter().for_each(|line| self.note(line));
        if self.parts.slave.is_over() {
            self.end_slave()?;
            return Err(Failure::new(
                Exit::Failed,
                anyhow::anyhow!("the slave of this process has ended by itself"),
            ));
        }
        let over = self.parts.cameras.over()?;
        if let Some(line) = &over {
            self.print(line);
        }
        Ok(over.is_some())
    }

    /// Whether all is well at the end. A stop that somebody asked for is no failure where somebody holds
    /// the keys; nobody's run is to end in one.
    fn judge(&self) -> Result<(), Failure> {
        let not_there = |words: String| {
            let failure = Failure::new(Exit::DeviceLost, anyhow::anyhow!(words));
            failure.help("look at its own messages, and at its cable")
        };
        let heard = self.arm.as_ref().zip(self.slave_heard_us).filter(|_| self.parts.slave.is_connected());
        let Some((arm, heard_us)) = heard else {
            return Err(not_there("the slave is not there at the end of the run".to_owned()));
        };
        let silent_us = self.parts.clock.now_us().saturating_sub(heard_us);
        if silent_us > SILENT_US {
            let seconds = silent_us as f64 * 1e-6;
            let words = format!("the slave has said nothing in the last {seconds:.1} s of the run");
            return Err(not_there(words));
        }
        let asked = self.parts.hold.is_attended() && arm_words::is_asked(arm);
        if asked || !matches!(arm.state, ArmState::Stopped | ArmState::Fault) {
            return Ok(());
        }
        let exit = if arm.controller == ControllerState::Lost { Exit::DeviceLost } else { Exit::Safety };
        let words = arm_words::standing(arm);
        Err(Failure::new(exit, anyhow::anyhow!("the arm stands at the end of the run: {words}")))
    }

    /// The button is let go, and the slave hears of it.
    fn let_go(&mut self) {
        let buttons = self.parts.hold.buttons(self.parts.clock.now_us());
        let released = Buttons { pressed: false, stop: false, ..buttons };
        for _ in 0..RELEASES {
            // what cannot be sent any more is not pressed either
            let _ = self.parts.station.step(&self.parts.slave, released, &self.parts.clock);
            std::thread::sleep(RELEASE_EVERY);
        }
    }

    fn finish_record(&mut self) -> Result<(), OutputError> {
        if let Some(tape) = self.parts.tape.take() {
            self.tape_lines = session::lines(&tape.finish());
        }
        self.pictures.end(self.parts.clock.now_us())?;
        let Some(record) = &mut self.parts.record else { return Ok(()) };
        let lost = record.end(self.parts.station.delays())?;
        if lost > 0 {
            self.print(&format!("the record lacks {lost} rows: the disk was too slow"));
        }
        Ok(())
    }

    fn sleep(&mut self) {
        let mut at_most = Duration::from_micros(self.parts.station.sleep_us(self.parts.clock.now_us()));
        if self.parts.hold.is_attended() {
            at_most = at_most.min(KEYS);
        }
        self.watch.wait(at_most);
    }

    fn write(&mut self, write: impl FnOnce(&mut Record) -> Result<(), OutputError>) {
        let Some(record) = &mut self.parts.record else { return };
        if let Err(error) = write(record) {
            // an arm that moves unrecorded is better than one that stops by surprise
            self.parts.record = None;
            self.print(&format!("{:#}; the run goes on without", anyhow::Error::new(error)));
        }
    }

    /// A line for the operator; in raw mode a terminal does not go back to its margin by itself.
    pub(super) fn print(&mut self, line: &str) {
        if let Some(publisher) = &mut self.publisher {
            publisher.line(line);
        }
        self.note(line);
    }

    fn note(&self, line: &str) {
        if self.parts.hold.is_keyboard() {
            let text = line.replace('\n', "\r\n");
            note(format_args!("{text}\r"));
        } else {
            note(line);
        }
    }

    /// Gives the terminal and the devices back; what there is to tell.
    pub(super) fn end(self) -> Vec<String> {
        let Parts { station, cameras, slave, link, .. } = &self.parts;
        let mut lines = report::lines(station, cameras, slave, link.as_ref(), &self.pictures, self.memory);
        lines.extend(self.tape_lines.iter().cloned());
        lines.extend(self.slave_lines.iter().map(|(label, line)| format!("{label:<15} {line}")));
        lines
    }
}
