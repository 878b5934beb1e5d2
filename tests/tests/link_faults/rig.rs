//! An operator's hand, a network with faults, and the slave that is shipped, with a simulated arm behind
//! it. All go by one clock that is set by hand, so a run is the same each time.

use super::outcome::Outcome;
use std::cell::Cell;
use std::rc::Rc;
use tetrad::link::faulty::{Faults, FaultyEnd, pair};
use tetrad::link::inbox::Inbox;
use tetrad::link::{Carrier, Picture, Received};
use tetrad::robot::clock::Clock;
use tetrad::robot::simulated::{SimulatedArm, SimulatedOptions};
use tetrad::station::{LinkedSlave, Unattended};
use tetrad_core::config::SlaveConfig;
use tetrad_core::wire::{ButtonsPacket, EncodeError, MotionPacket, Packet};
use tetrad_fixtures::packets;

const OPERATOR: u32 = 77;
const STRANGER: u32 = 79;
const SLAVE: u32 = 4;

/// One millisecond: what the clock goes by.
const TICK_US: u64 = 1_000;
const FRAME_US: u64 = 16_667;

/// When the hand begins to move (the arm has been switched on and pressed for by then, however long a
/// packet takes) and when it is at rest again.
pub(super) const MOVES_US: u64 = 8_000_000;
pub(super) const RESTS_US: u64 = 16_000_000;

/// When the operator's computer dies or is started again, in the runs in which it is: amid the movement.
pub(super) const HAPPENS_US: u64 = 11_000_000;

/// How long it is away where it is started again: less than a silence takes to be told from a loss.
const AWAY_US: u64 = 200_000;

/// How long a run takes.
pub(super) const END_US: u64 = 26_000_000;

/// The hand goes out and back by so much, metres, once in so many seconds, and in half that to a side.
const AMPLITUDE_M: f64 = 0.1;
const PERIOD_S: f64 = 4.0;

/// Who sends commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Commands {
    /// One operator.
    OfOne,
    /// On the same way come those of a second sender, of another session and with its hand elsewhere.
    OfTwo,
    /// The operator is started again, and goes on as another session.
    StartedAgain,
    /// The operator dies.
    Ending,
}

impl Commands {
    pub(super) const ALL: [Self; 4] = [Self::OfOne, Self::OfTwo, Self::StartedAgain, Self::Ending];

    /// Of which session the operator's packets are, while it is there.
    fn session(self, now_us: u64) -> Option<u32> {
        match self {
            Self::OfOne | Self::OfTwo => Some(OPERATOR),
            Self::StartedAgain if now_us >= HAPPENS_US + AWAY_US => Some(OPERATOR + 1),
            Self::StartedAgain | Self::Ending => (now_us < HAPPENS_US).then_some(OPERATOR),
        }
    }
}

/// Where the hand is: at rest, then smoothly to and fro, then at rest half an amplitude aside.
pub(super) fn hand_m(now_us: u64) -> [f32; 3] {
    let t = now_us.clamp(MOVES_US, RESTS_US) - MOVES_US;
    let phase = t as f64 * 1e-6 / PERIOD_S * std::f64::consts::TAU;
    let x = AMPLITUDE_M / 2.0 * (1.0 - phase.cos());
    let z = AMPLITUDE_M / 4.0 * (1.0 - (phase / 4.0).cos());
    [x as f32, 0.0, z as f32]
}

/// The slave's end of the network. Notes the newest motion when the slave takes it.
pub(super) struct Tap {
    end: FaultyEnd,
    newest: Rc<Cell<Option<Received<MotionPacket>>>>,
}

impl Carrier for Tap {
    fn send(&self, packet: &Packet) -> Result<(), EncodeError> {
        self.end.send(packet)
    }

    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R {
        self.end.with_inbox(look)
    }

    fn motion(&self) -> Option<Received<MotionPacket>> {
        let motion = self.end.motion();
        self.newest.set(motion.or(self.newest.get()));
        motion
    }

    fn send_picture(&self, picture: Picture) {
        self.end.send_picture(picture);
    }

    fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        self.end.picture(camera)
    }

    fn tell_configuration(&self, configuration: &[u8]) {
        self.end.tell_configuration(configuration);
    }

    fn configuration(&self) -> Option<Vec<u8>> {
        self.end.configuration()
    }
}

/// The operator: a button that follows from what the arm says, and a hand that follows from the time.
struct Operator {
    end: FaultyEnd,
    button: Unattended,
    session: u32,
    sequence: u32,
}

impl Operator {
    fn frame(&mut self, session: u32, now_us: u64) {
        if self.session != session {
            // another process: it knows of nothing
            (self.session, self.sequence, self.button) = (session, 0, Unattended::default());
        }
        self.sequence += 1;
        let buttons = self.button.buttons(now_us);
        let packet = ButtonsPacket {
            time_us: now_us,
            pressed: buttons.pressed,
            stop: buttons.stop,
            resets: buttons.resets,
            ..packets::buttons(session, self.sequence)
        };
        self.send(hand_m(now_us), buttons.pressed, now_us);
        self.end.send(&packet.into()).expect("sound");
    }

    /// Another one's hand, mirrored and far away, its button pressed.
    fn stranger(&self, now_us: u64) {
        let [x, y, z] = hand_m(now_us);
        let motion = packets::motion_to(STRANGER, self.sequence, [0.3 - x, 0.2 + y, -z]);
        let buttons = ButtonsPacket { pressed: true, ..packets::buttons(STRANGER, self.sequence) };
        self.end.send(&MotionPacket { capture_us: now_us, ..motion }.into()).expect("sound");
        self.end.send(&buttons.into()).expect("sound");
    }

    fn send(&self, place_m: [f32; 3], engaged: bool, now_us: u64) {
        let motion = packets::motion_to(self.session, self.sequence, place_m);
        let motion = MotionPacket { capture_us: now_us, engaged, ..motion };
        self.end.send(&motion.into()).expect("sound");
    }
}

/// Runs it from the start of the slave to [`END_US`]; the same faults both ways.
pub(super) fn run(seed: u64, faults: Faults, commands: Commands) -> Outcome {
    let config = SlaveConfig::default();
    let clock = Clock::given();
    let arm = SimulatedArm::with_clock(&config.puma, &SimulatedOptions::default(), clock.clone());
    let [operator, end] = pair(seed, [faults; 2], &clock);
    operator.begin(SLAVE).expect("no session has ended");
    end.begin(OPERATOR).expect("no session has ended");
    let newest = Rc::default();
    let tap = Tap { end: end.clone(), newest: Rc::clone(&newest) };
    let mut slave = LinkedSlave::new(&config, Box::new(arm.expect("sound")), tap, SLAVE).expect("sound");
    let mut operator =
        Operator { end: operator, button: Unattended::default(), session: OPERATOR, sequence: 0 };
    let mut outcome = Outcome::new(&config);
    let cycle_us = u64::from(config.governor.cycle_us);
    let mut frame_us = 0;
    for now_us in (0..END_US).step_by(usize::try_from(TICK_US).expect("small")) {
        clock.set(now_us);
        if let Some(session) = commands.session(now_us) {
            if let Some(state) = operator.end.arm_state() {
                operator.button.hear(&state.what, now_us);
            }
            if now_us >= frame_us {
                frame_us += FRAME_US;
                // the link says so before it lets anything of it through
                end.begin(session).expect("it has not ended");
                operator.frame(session, now_us);
                if commands == Commands::OfTwo {
                    operator.stranger(now_us);
                }
            }
        }
        if now_us % cycle_us == 0 {
            let cycle = slave.cycle(&clock);
            outcome.cycle(&cycle, newest.get(), now_us);
        }
    }
    outcome.second_senders = slave.counts().another_sender;
    outcome
}
