//! The demo's slave: a simulated operator, link and PUMA 560, all on the simulated clock.

use crate::exit::{Exit, Failure, OrExit as _};
use crate::output::ArmCsv;
use crate::pipeline::Step;
use crate::robot::clock::Clock;
use crate::robot::simulated::{SimulatedArm, SimulatedOptions};
use crate::station::{Closeness, Cycle, EnableThenReset, Following, MotionSender, SlaveStation, Truth};
use std::collections::VecDeque;
use std::path::Path;
use tetrad_core::arm::teleop::{ArmedReason, Note, State, Status};
use tetrad_core::config::SlaveConfig;
use tetrad_core::geometry::Pose;
use tetrad_core::wire::{Decoder, MotionPacket, Packet};

/// From a picture to its packet at the slave, microseconds: half an exposure, tracking, a local
/// network.
const LINK_US: u64 = 8_000;

/// How long the arm gets to be switched on before the first picture, microseconds.
const SWITCH_ON_US: u64 = 3_000_000;

/// When the operator presses hold-to-run after the first picture, microseconds.
const PRESS_US: u64 = 300_000;

/// The arm and everything before it.
pub(super) struct DemoArm {
    station: SlaveStation,
    config: SlaveConfig,
    clock: Clock,
    sender: MotionSender,
    decoder: Decoder,
    /// What is on its way, and when it arrives.
    in_flight: VecDeque<(u64, MotionPacket)>,
    record: ArmCsv,
    following: Following,
    /// When the next cycle is due.
    due_us: u64,
    /// The pictures of the newest command, on the slave's clock.
    capture_us: u64,
    cycles: u64,
    engaged: u64,
    limited: u64,
    last: Option<Status>,
}

/// What the run came to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ArmSummary {
    /// `None` where nothing was followed.
    pub(super) closeness: Option<Closeness>,
    /// The share of the time after the first picture in which the hand was followed.
    pub(super) engaged: f64,
    /// The share of that in which a limit slowed or turned the arm.
    pub(super) limited: f64,
    /// How it stood at the end.
    pub(super) status: Option<Status>,
}

impl DemoArm {
    /// An arm that has been switched on and waits for the hand; arm.csv goes to `dir`.
    pub(super) fn new(dir: &Path) -> Result<Self, Failure> {
        let config = SlaveConfig::default();
        let clock = Clock::given();
        let options = SimulatedOptions::default();
        let port = SimulatedArm::with_clock(&config.puma, &options, clock.clone()).or_exit(Exit::Failed)?;
        let mut arm = Self {
            station: SlaveStation::new(&config, Box::new(port)).or_exit(Exit::Failed)?,
            config,
            clock,
            sender: MotionSender::new(0),
            decoder: Decoder::new(),
            in_flight: VecDeque::new(),
            record: ArmCsv::create(dir).or_exit(Exit::Failed)?,
            following: Following::default(),
            due_us: 0,
            capture_us: 0,
            cycles: 0,
            engaged: 0,
            limited: 0,
            last: None,
        };
        arm.switch_on()?;
        Ok(arm)
    }

    fn switch_on(&mut self) -> Result<(), Failure> {
        let (mut armed, mut asked) = (false, false);
        while self.due_us < SWITCH_ON_US {
            self.cycle(false)?;
            if !armed {
                match self.station.reset(self.clock.now_us(), !std::mem::replace(&mut asked, true)) {
                    Ok(()) => armed = true,
                    Err(EnableThenReset::SwitchingOn) => {}
                    Err(refusal) => return Err(Failure::new(Exit::Failed, refusal)),
                }
            }
        }
        Ok(())
    }

    /// A frame that was taken at `t_us` of the scene: the arm moves until then, and what was seen goes
    /// on its way.
    pub(super) fn frame(&mut self, t_us: u64, step: &Step) -> Result<(), Failure> {
        let now_us = SWITCH_ON_US + t_us;
        self.run_until(now_us)?;
        let Some(packet) = self.sender.packet(step, now_us, true) else { return Ok(()) };
        // over the wire as anywhere else
        let Ok(frame) = self.sender.frame(packet) else { return Ok(()) };
        for packet in self.decoder.packets(frame) {
            if let Ok(Packet::Motion(packet)) = packet {
                self.in_flight.push_back((now_us + LINK_US, packet));
            }
        }
        Ok(())
    }

    /// What the run came to; `hand` is where the hand truly was at a time of the scene, in the axes of
    /// the first complete frame.
    pub(super) fn summary(&self, hand: impl Fn(f64) -> Truth) -> ArmSummary {
        let share = |part: u64, of: u64| part as f64 / of.max(1) as f64;
        ArmSummary {
            closeness: self.following.closeness(&self.config.teleop.robot_from_hand, hand),
            engaged: share(self.engaged, self.cycles),
            limited: share(self.limited, self.engaged),
            status: self.last,
        }
    }

    fn run_until(&mut self, now_us: u64) -> Result<(), Failure> {
        while self.due_us <= now_us {
            let pressed = self.due_us >= SWITCH_ON_US + PRESS_US && !self.must_let_go();
            self.cycle(pressed)?;
        }
        Ok(())
    }

    /// An operator lets go where the slave asks for it, and presses again.
    const fn must_let_go(&self) -> bool {
        matches!(self.last, Some(Status::Armed(ArmedReason::LetGo(_) | ArmedReason::NewSender)))
    }

    fn cycle(&mut self, pressed: bool) -> Result<(), Failure> {
        let now_us = self.due_us;
        self.due_us += u64::from(self.config.governor.cycle_us);
        self.clock.set(now_us);
        while let Some(&(arrived_us, packet)) = self.in_flight.front().filter(|(at_us, _)| *at_us <= now_us) {
            self.in_flight.pop_front();
            self.capture_us = packet.capture_us;
            // what is refused is counted, and shows in the state
            let _ = self.station.take(&packet, arrived_us);
        }
        self.station.hold_to_run(pressed, now_us);
        let cycle = self.station.cycle(now_us);
        let since_first_s = (now_us as f64 - SWITCH_ON_US as f64) / 1e6;
        if now_us >= SWITCH_ON_US {
            self.record.write(since_first_s, &cycle).or_exit(Exit::Failed)?;
            self.count(since_first_s, &cycle);
        }
        self.last = Some(cycle.step.decision.status);
        Ok(())
    }

    fn count(&mut self, t_s: f64, cycle: &Cycle) {
        let (decision, Some(measured)) = (&cycle.step.decision, &cycle.step.measured) else { return };
        self.cycles += 1;
        if decision.status.state() != State::Engaged {
            return;
        }
        self.engaged += 1;
        self.limited += u64::from(cycle.step.governed.is_some_and(|governed| !governed.limits.is_empty()));
        if decision.notes.contains(Note::Latched) || decision.notes.contains(Note::HandJumped) {
            let capture_s = (self.capture_us as f64 - SWITCH_ON_US as f64) / 1e6;
            self.following.latch(capture_s, truth(measured));
        }
        self.following.sample(t_s, truth(measured));
    }
}

const fn truth(pose: &Pose<f64>) -> Truth {
    (pose.rotation, pose.translation)
}
