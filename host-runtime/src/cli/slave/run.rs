//! The loop of a slave: keys, packets, one cycle of the station, a line for the operator.
//!
//! It waits until the next cycle is due, by the port's own beat where it has one; what was missed is not
//! made up for.

use super::ending;
use super::packets::{Losses, Next, Packets};
use super::talk::Talk;
use crate::cli::interrupt::Interrupt;
use crate::cli::keyboard::{Key, Keyboard, next_scale, scale_words, went_away};
use crate::cli::note;
use crate::exit::{Exit, Failure};
use crate::output::ArmRecord;
use crate::precedence::{Duty, step_forward};
use crate::station::{Cycle, EnableThenReset, Reset, Resetting, SlaveStation};
use std::time::{Duration, Instant};
use tetrad_core::wire::ScaleShare;

/// How long the end of the run waits for the arm to be at rest.
const REST: Duration = Duration::from_secs(3);

/// How long hold-to-run is told to be released before nobody's button is pressed.
const RELEASED: Duration = Duration::from_millis(200);

/// What becomes of hold-to-run and of the packets when no keyboard is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Input {
    /// The arm is being switched on; packets wait.
    Starting,
    Open,
    /// The other end went away.
    Ended,
}

/// A slave at work.
pub(super) struct Run {
    station: SlaveStation,
    packets: Packets,
    talk: Talk,
    record: Option<ArmRecord>,
    keyboard: Option<Keyboard>,
    began: Instant,
    cycle: Duration,
    input: Input,
    /// What the newest packet says of the button.
    sender_pressed: bool,
    /// The share of the scale that the keys have stepped to.
    scale: ScaleShare,
    /// A reset that waits for the arm to be switched on.
    reset: Option<Resetting>,
    last: Option<Cycle>,
    /// How the run ends, where not well.
    worst: Option<(Exit, String)>,
}

/// What is left of a run.
pub(super) struct Ended {
    pub(super) station: SlaveStation,
    /// What came and was dropped.
    pub(super) losses: Losses,
    /// How it ended, where not well.
    pub(super) worst: Option<(Exit, String)>,
}

impl Run {
    /// A slave that has not begun; without a keyboard the packets hold the button.
    pub(super) fn new(
        station: SlaveStation,
        packets: Packets,
        record: Option<ArmRecord>,
        keyboard: Option<Keyboard>,
        cycle: Duration,
    ) -> Self {
        let began = Instant::now();
        Self {
            station,
            packets,
            talk: Talk::new(began),
            record,
            began,
            cycle,
            input: if keyboard.is_some() { Input::Open } else { Input::Starting },
            sender_pressed: false,
            scale: ScaleShare::FULL,
            reset: None,
            keyboard,
            last: None,
            worst: None,
        }
    }

    pub(super) const fn station(&self) -> &SlaveStation {
        &self.station
    }

    /// Gives the terminal back, and what there is to tell.
    pub(super) fn end(self) -> Ended {
        Ended { losses: self.packets.losses(), station: self.station, worst: self.worst }
    }

    pub(super) fn usage(&self) -> &'static str {
        match self.keyboard {
            Some(_) => {
                "r resets, hold the space bar to move, h to go home, - and + for the scale, any other key stops, q ends"
            }
            None => "the packets hold the button",
        }
    }

    /// Every cycle until the end, at most for so long.
    pub(super) fn all(&mut self, longest: Option<Duration>, interrupt: &Interrupt) -> Result<(), Failure> {
        step_forward(Duty::Drive);
        let end = longest.map(|longest| self.began + longest);
        let mut due = self.began;
        if self.keyboard.is_none() {
            self.reset = Some(Resetting::asked(self.micros(self.began)));
        }
        loop {
            let now = Instant::now();
            let over = end.is_some_and(|end| now >= end) || interrupt.asked();
            if over || self.keys(now)? || self.is_done() {
                self.shut_down()?;
                // whoever hangs up asks for the end too
                let still_there = self.keyboard.as_mut().map_or(Ok(()), Keyboard::still_there);
                return still_there.map_err(went_away);
            }
            self.arrivals()?;
            self.try_reset(now);
            let cycle = self.station.cycle(self.micros(Instant::now()));
            self.tell(&cycle, Instant::now());
            self.write(&cycle);
            self.last = Some(cycle);
            if self.keyboard.is_none() && self.note_worst(&cycle) {
                return self.shut_down();
            }
            due = next_due(due, self.cycle, Instant::now());
            self.station.port_mut().pace(due);
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
        let mut scaled = false;
        loop {
            match keyboard.next() {
                Ok(Some(Key::Quit)) => return Ok(true),
                Ok(Some(Key::Stop)) => {
                    self.station.stop();
                    self.reset = None;
                }
                Ok(Some(Key::Homed)) => self.station.port_mut().confirm_homed(),
                Ok(Some(key @ (Key::Finer | Key::Coarser))) => {
                    self.scale = next_scale(self.scale, key);
                    scaled = true;
                }
                Ok(Some(Key::Reset)) => self.reset = Some(Resetting::asked(now_us)),
                Ok(None) => break,
                Err(cause) => {
                    self.shut_down()?;
                    return Err(went_away(cause));
                }
            }
        }
        let held = keyboard.is_held(now);
        self.station.press_is_for(keyboard.held_for(), self.scale);
        self.station.hold_to_run(held, now_us);
        if scaled {
            self.print(&scale_words(self.scale));
        }
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
        let now_us = self.micros(now);
        let Some(reset) = &mut self.reset else { return };
        match reset.go_on(&mut self.station, now_us) {
            Reset::Done => {
                self.reset = None;
                self.packets.begin();
                if self.input == Input::Starting {
                    self.input = Input::Open;
                }
            }
            Reset::Waits => {}
            // the button has to be heard first
            Reset::Refused(EnableThenReset::Law(_))
                if self.keyboard.is_none() && now < self.began + RELEASED => {}
            Reset::Refused(refusal) => {
                self.reset = None;
                let reason = self.station.port().reason();
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
        if self.input != Input::Starting {
            self.judge(cycle);
        }
        self.worst.is_some()
    }

    fn judge(&mut self, cycle: &Cycle) {
        if self.worst.is_none() {
            self.worst = ending::standing(cycle, self.station.port().reason());
        }
    }

    /// Brings the arm to rest within its limits, then stops it at its port, and judges how it stands.
    fn shut_down(&mut self) -> Result<(), Failure> {
        if let Some(last) = self.last {
            self.judge(&last);
        }
        self.station.stop();
        let began = Instant::now();
        let mut due = began;
        while began.elapsed() < REST {
            let cycle = self.station.cycle(self.micros(Instant::now()));
            self.write(&cycle);
            self.judge(&cycle);
            if cycle.step.governed.is_none_or(|governed| governed.at_rest) {
                break;
            }
            due = next_due(due, self.cycle, Instant::now());
            self.station.port_mut().pace(due);
            // a port's own beat may be ahead of this clock
            due = due.min(Instant::now());
        }
        if let Err(error) = self.station.shut_down() {
            let (exit, words) = ending::unstopped(error);
            self.print(&words);
            self.worst.get_or_insert((exit, words));
        }
        if let Some(line) = self.record.as_mut().and_then(ArmRecord::end) {
            self.print(&line);
        }
        Ok(())
    }

    fn tell(&mut self, cycle: &Cycle, now: Instant) {
        for line in self.talk.lines(cycle, self.station.port().reason(), now) {
            self.print(&line);
        }
    }

    fn write(&mut self, cycle: &Cycle) {
        let t_s = self.began.elapsed().as_secs_f64();
        let Some(record) = &mut self.record else { return };
        if let Err(error) = record.write(t_s, cycle) {
            // an arm that moves unrecorded is better than one that stops by surprise
            self.record = None;
            self.print(&format!("{:#}; the run goes on without", anyhow::Error::new(error)));
        }
    }

    /// A line for the operator; in raw mode a terminal does not go back to its margin by itself.
    pub(super) fn print(&self, line: &str) {
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
