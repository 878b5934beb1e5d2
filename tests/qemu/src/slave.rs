//! What an operator and six drives do to a slave, recorded; and what the desktop's slave makes of it.
//!
//! The drives are simulated beside a slave of the desktop, which they answer. A board is then given the very
//! bytes that this one was given, at the very times: firmware/src/board/mps2/slave_tape.rs has the format.

use crate::board::{FAST, Target};
use std::f32::consts::PI;
use std::{fs, io};
use tetrad_core::arm::canopen::{Frame, slcan};
use tetrad_core::arm::puma560::{Drives, Joints};
use tetrad_core::arm::wired::WiredSlave;
use tetrad_core::config::{CanopenConfig, SlaveConfig};
use tetrad_core::hand::state::PoseCovariance;
use tetrad_core::wire::{ButtonsPacket, Decoder, MAX_FRAME_LEN, MotionPacket, Packet, encode};
use tetrad_fixtures::drive::Drive;
use tetrad_fixtures::packets;

/// The session of a slave that is played from a tape.
const SESSION: u32 = 1;

/// From one cycle to the next, and how long before a cycle an operator's packets come, and after it the drives'
/// answers, microseconds.
const CYCLE_US: u64 = 10_000;
const BEFORE_US: u64 = 3_000;
const AFTER_US: u64 = 4_000;

/// From one packet of each kind to the next, microseconds: 50 a second.
const PACKET_US: u64 = 20_000;

/// Where the joints are at first.
const START_DEG: Joints<f64> = [10.0, 45.0, -170.0, 5.0, 50.0, 0.0];

/// Something that comes to the slave, and when, microseconds.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Bytes of the serial line.
    Line(u64, Vec<u8>),
    /// Bytes of a serial line that stands for the bus.
    Bus(u64, Vec<u8>),
    /// A cycle.
    Cycle(u64),
}

/// What a board and the desktop are given.
#[derive(Clone, Debug, PartialEq)]
pub struct SlaveTape {
    /// What comes, in order.
    pub events: Vec<Event>,
}

/// What a slave says: on the serial line, and on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// The arm's states, framed.
    pub line: Vec<u8>,
    /// Frames for the drives, as lines.
    pub bus: Vec<u8>,
}

/// What the operator does from a time on, milliseconds.
#[derive(Clone, Copy, Debug)]
enum Act {
    /// Lets go of the button.
    Release,
    /// Presses it, and moves the hand.
    Press,
    /// Is not heard.
    Silence,
    /// Presses the stop.
    Stop,
    /// Asks for a reset, the button released.
    Reset,
    /// Starts anew, under another session, the button pressed.
    Restart,
}

/// Every state of the law, and what leads from one to the next: a press before the first reset, silence while
/// the hand moves, a press that is held through it, a stop, another operator.
static SCRIPT: [(u64, Act); 17] = [
    (0, Act::Press),
    (300, Act::Release),
    (500, Act::Reset),
    (2_500, Act::Press),
    (4_000, Act::Silence),
    (4_600, Act::Press),
    (5_200, Act::Release),
    (5_500, Act::Press),
    (6_500, Act::Stop),
    (6_700, Act::Release),
    (7_000, Act::Reset),
    (7_800, Act::Press),
    (8_500, Act::Restart),
    (9_000, Act::Release),
    (9_300, Act::Press),
    // a drive has failed
    (11_500, Act::Release),
    (11_800, Act::Reset),
];

/// When the drive of the third joint fails, and what it reports: a following error.
const FAILS_MS: u64 = 10_500;
const FAILS: (usize, u16) = (2, 0x8611);

/// When both lines are disturbed.
const NOISE_MS: u64 = 3_000;

const END_MS: u64 = 13_000;

/// An operator who goes by the script.
#[derive(Debug)]
struct Operator {
    session: u32,
    sequence: u32,
    resets: u32,
    engagements: u32,
    act: Act,
    since_us: u64,
    script: std::slice::Iter<'static, (u64, Act)>,
}

impl Operator {
    fn new() -> Self {
        let script = SCRIPT.iter();
        Self { session: 7, sequence: 0, resets: 0, engagements: 0, act: Act::Release, since_us: 0, script }
    }

    /// The packets that are due.
    fn packets(&mut self, now_us: u64) -> Vec<Packet> {
        let next = self.script.clone().next().filter(|(at_ms, _)| now_us >= at_ms * 1_000);
        if let Some((_, act)) = next {
            self.script.next();
            (self.act, self.since_us) = (*act, now_us);
            match act {
                Act::Press => self.engagements += 1,
                Act::Reset => self.resets += 1,
                Act::Restart => (self.session, self.sequence, self.engagements) = (8, 0, 1),
                Act::Release | Act::Silence | Act::Stop => {}
            }
        }
        if matches!(self.act, Act::Silence) || !now_us.is_multiple_of(PACKET_US) {
            return Vec::new();
        }
        self.sequence += 1;
        let buttons = ButtonsPacket {
            time_us: now_us,
            pressed: matches!(self.act, Act::Press | Act::Restart),
            stop: matches!(self.act, Act::Stop),
            resets: self.resets,
            ..packets::buttons(self.session, self.sequence)
        };
        vec![self.motion(now_us).into(), buttons.into()]
    }

    /// The hand goes to and fro, 6 cm a second and a half, and a little up.
    fn motion(&self, now_us: u64) -> MotionPacket {
        let phase = (now_us - self.since_us) as f32 / 1e6 * 2.0 * PI / 1.5;
        let place_m = [0.06 * phase.sin(), 0.02 * phase.sin(), 0.03 * (1.0 - phase.cos())];
        let covariance = PoseCovariance::identity() * 1e-7_f32;
        MotionPacket {
            capture_us: now_us,
            engagements: self.engagements,
            covariance: Some(covariance.into()),
            ..packets::motion_to(self.session, self.sequence, place_m)
        }
    }
}

/// A slave of the desktop that is given what is on a tape.
#[derive(Debug)]
struct Player {
    slave: WiredSlave,
    line: Decoder,
    bus: slcan::Decoder,
    said: Said,
}

impl Player {
    fn new() -> Self {
        let slave = WiredSlave::new(&SlaveConfig::default(), &CanopenConfig::default(), SESSION);
        let slave = slave.expect("core's own settings");
        let said = Said { line: vec![0], bus: Vec::new() };
        Self { slave, line: Decoder::new(), bus: slcan::Decoder::new(), said }
    }

    /// The frames that the slave sends because of it.
    fn play(&mut self, event: &Event) -> Vec<Frame> {
        let mut sent: Vec<Frame> = Vec::new();
        match event {
            Event::Line(now_us, bytes) => {
                for packet in self.line.packets(bytes).flatten() {
                    self.slave.take(&packet, *now_us);
                }
            }
            Event::Bus(now_us, bytes) => {
                for byte in bytes {
                    if let Some(slcan::Line::Frame(frame)) = self.bus.push(*byte) {
                        self.slave.hear(&frame, *now_us);
                    }
                }
            }
            Event::Cycle(now_us) => {
                let state = self.slave.cycle(*now_us, &mut sent);
                self.said.bus.extend(sent.iter().flat_map(slcan::encode));
                self.said.line.extend(state.into_iter().flat_map(|state| framed(&state.into())));
            }
        }
        sent
    }
}

fn framed(packet: &Packet) -> Vec<u8> {
    let mut frame = [0; MAX_FRAME_LEN];
    let length = encode(packet, &mut frame).expect("numbers that may be sent");
    frame[..length].to_vec()
}

impl SlaveTape {
    /// What an operator who goes by the script and six drives, one of which fails, do to a slave.
    ///
    /// # Panics
    /// When core's own settings are refused.
    #[must_use]
    pub fn recorded() -> Self {
        let config = CanopenConfig::default();
        let motors = Drives::new(&config.drives()).expect("core's own settings");
        let start = motors.counts(&START_DEG.map(f64::to_radians)).expect("joints that can be counted");
        let mut drives: Vec<Drive> =
            config.nodes.iter().zip(start).map(|(node, at)| Drive::new(*node, at)).collect();
        let (mut player, mut operator, mut events) = (Player::new(), Operator::new(), Vec::new());
        for now_us in (1..=END_MS * 1_000 / CYCLE_US).map(|cycle| cycle * CYCLE_US) {
            let now_ms = now_us / 1_000;
            let mut line: Vec<u8> = operator.packets(now_us).iter().flat_map(framed).collect();
            let mut answers = Vec::new();
            let mut bus = Vec::new();
            if now_ms == NOISE_MS {
                // a frame that is cut, and what is no frame at all
                line.truncate(line.len() / 3);
                line.extend((0..=255).rev());
                bus.extend(*b"noise\rt20");
            }
            if now_ms == FAILS_MS {
                drives[FAILS.0].fail(FAILS.1, &mut answers);
            }
            let mut then = |event: Event| {
                let sent = player.play(&event);
                events.push(event);
                sent
            };
            if !line.is_empty() {
                then(Event::Line(now_us - BEFORE_US, line));
            }
            let sent = then(Event::Cycle(now_us));
            for drive in &mut drives {
                sent.iter().for_each(|frame| drive.receive(frame, &mut answers));
                drive.tick(now_us, &mut answers);
            }
            bus.extend(answers.iter().flat_map(slcan::encode));
            if !bus.is_empty() {
                then(Event::Bus(now_us + AFTER_US, bus));
            }
        }
        Self { events }
    }

    /// The file's bytes.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = b"TETRADS1".to_vec();
        for event in &self.events {
            let (kind, at_us, content) = match event {
                Event::Line(at_us, content) => (1_u32, *at_us, &content[..]),
                Event::Bus(at_us, content) => (2, *at_us, &content[..]),
                Event::Cycle(at_us) => (3, *at_us, &[][..]),
            };
            bytes.extend(kind.to_le_bytes());
            bytes.extend((content.len() as u32).to_le_bytes());
            bytes.extend(at_us.to_le_bytes());
            bytes.extend(content);
        }
        bytes
    }

    /// What the desktop's slave makes of it.
    #[must_use]
    pub fn on_the_desktop(&self) -> Said {
        let mut player = Player::new();
        for event in &self.events {
            player.play(event);
        }
        player.said
    }

    /// What a board's slave makes of it.
    ///
    /// # Errors
    /// As [`Target::run`].
    pub fn on_a_board(&self, target: Target) -> io::Result<Said> {
        let folder = tempfile::tempdir()?;
        fs::write(folder.path().join("tetrad.tape"), self.bytes())?;
        target.run("mps2-slave", folder.path(), FAST)?;
        let read = |name| fs::read(folder.path().join(name));
        Ok(Said { line: read("line")?, bus: read("bus")? })
    }
}

/// The frames of a bus's lines.
#[must_use]
pub fn frames(bus: &[u8]) -> Vec<Frame> {
    let mut decoder = slcan::Decoder::new();
    let lines = bus.iter().filter_map(|byte| decoder.push(*byte));
    lines.filter_map(|line| if let slcan::Line::Frame(frame) = line { Some(frame) } else { None }).collect()
}
