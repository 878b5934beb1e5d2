//! Random engaging, clutching, dropouts, glitches, stops and losses: the goal never steps further
//! than the hand did, and the arm never moves when it may not. The rules are checked from outside, by
//! what was sent and heard.

use super::network::{Network, Servo, Wander, arrived};
use super::*;
use crate::config::Turning;
use std::vec::Vec;

const TICK_US: u64 = 10_000;
const TICKS: u64 = 200;

/// The newest command that came, and where the hand and the station's latch were, in the world.
#[derive(Clone, Copy)]
struct Heard {
    command: Command,
    hand: Pose<f64>,
    latch: Pose<f64>,
}

/// What the goal may be told from: where it was, with the hand then.
#[derive(Clone, Copy)]
struct Before<T> {
    goal: Pose<T>,
    hand: Pose<f64>,
}

/// What the sequences came upon, so that a rule that is never tried shows.
#[derive(Default, Debug)]
struct Seen {
    engaged: u64,
    held: u64,
    latches: u64,
    jumps: u64,
    stops: u64,
    worst_m: f64,
    worst_rad: f64,
}

struct Play<T> {
    rig: Rig<T>,
    random: Random,
    config: TeleopConfig,
    network: Network,
    servo: Servo,
    wander: Wander,
    riding: bool,
    pedal: bool,
    pedal_dead_until: u64,
    link_dead_until: u64,
    sent: Vec<Heard>,
    under_way: Vec<Command>,
    heard: Option<Heard>,
    before: Option<Before<T>>,
    may_run: bool,
    button: (bool, u64),
}

impl<T: Real> Play<T> {
    fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let scale = if random.chance(0.5) { 1.0 } else { random.within(0.1, 3.0) };
        let turning = match random.bits() % 4 {
            0 => Turning::Locked,
            1 => Turning::Scaled(random.within(0.2, 2.0)),
            _ => Turning::Scaled(1.0),
        };
        let config = TeleopConfig {
            scale,
            turning,
            robot_from_hand: super::super::command::nearest_rotation(&random.rotation(3.0)),
            ..TeleopConfig::default()
        };
        let mut rig = Rig::<T>::new(&config);
        let place =
            Pose { rotation: random.rotation(3.0), translation: random.vector(0.9) + Vector3::z() * 0.8 };
        rig.arm.set_point = of(&place);
        rig.arm.measured = rig.arm.set_point;
        rig.sender = Sender::new(Pose { rotation: random.rotation(3.0), translation: random.vector(0.5) });
        rig.sender.sequence = u32::MAX - (random.bits() % 40) as u32;
        Self {
            rig,
            config,
            network: Network {
                loss: random.within(0.0, 0.5),
                jitter_us: random.within(0.0, 200_000.0) as u64,
                repeats: 0.05,
            },
            servo: Servo { speed: random.within(0.1, 2.0), turn_speed: random.within(0.5, 5.0) },
            wander: Wander::new(random.within(0.0, 1.5), random.within(0.0, 4.0)),
            riding: random.chance(0.5),
            pedal: false,
            pedal_dead_until: 0,
            link_dead_until: 0,
            sent: Vec::new(),
            under_way: Vec::new(),
            heard: None,
            before: None,
            may_run: false,
            button: (false, 0),
            random,
        }
    }

    fn operator(&mut self) {
        let (random, rig) = (&mut self.random, &mut self.rig);
        self.wander.go(&mut rig.sender.hand, 0.01, random);
        if random.chance(0.005) {
            // labels swapped, or a hand that was lost turns up elsewhere
            rig.sender.hand.translation += random.vector(0.3);
            rig.sender.hand.rotation = random.rotation(1.0) * rig.sender.hand.rotation;
        }
        if random.chance(0.03) {
            rig.sender.state = PoseState::ALL[(random.bits() % 6) as usize];
        } else if random.chance(0.3) {
            rig.sender.state = PoseState::Both;
        }
        if rig.sender.engaged {
            rig.sender.engaged = !random.chance(0.02);
        } else if random.chance(0.1) {
            rig.sender.engage();
        }
        if random.chance(0.01) {
            rig.sender.engage();
        }
        self.pedal = if self.pedal { !random.chance(0.01) } else { random.chance(0.1) };
        for dead_until in [&mut self.pedal_dead_until, &mut self.link_dead_until] {
            if random.chance(0.005) {
                *dead_until = rig.now_us + random.within(0.0, 1e6) as u64;
            }
        }
    }

    fn tell(&mut self, pressed: bool, at_us: u64) {
        self.rig.teleop.hold_to_run(pressed, at_us);
        self.button = (pressed, at_us);
    }

    fn deliver(&mut self) {
        for command in arrived(self.rig.now_us, &mut self.under_way) {
            let newer = self
                .heard
                .is_none_or(|heard| (command.sequence.wrapping_sub(heard.command.sequence) as i32) > 0);
            assert_eq!(self.rig.teleop.take(&command).is_ok(), newer);
            if !newer {
                continue;
            }
            let sent = self.sent.iter().rev().find(|sent| sent.command.sequence == command.sequence);
            self.heard = Some(Heard { command, ..*sent.expect("it was sent") });
            if self.riding {
                self.tell(command.engaged, command.received_us);
            }
        }
    }

    fn tick(&mut self, number: u64, seen: &mut Seen) {
        self.rig.wait(TICK_US);
        let now_us = self.rig.now_us;
        self.operator();
        if number.is_multiple_of(3) {
            let command = self.rig.sender.command(now_us);
            let (hand, latch) = (self.rig.sender.hand, self.rig.sender.latch);
            self.sent.push(Heard { command, hand, latch });
            if now_us >= self.link_dead_until {
                self.network.send(command, now_us, &mut self.under_way, &mut self.random);
            }
        }
        self.deliver();
        if !self.riding && now_us >= self.pedal_dead_until {
            self.tell(self.pedal, now_us);
        }
        if self.random.chance(0.005) {
            self.rig.teleop.stop();
            self.may_run = false;
            seen.stops += 1;
        }
        if !self.may_run && self.random.chance(0.2) {
            self.may_run = self.rig.teleop.reset(now_us, &self.rig.arm).is_ok();
            assert!(!self.may_run || !self.button.0);
        }
        let decision = self.rig.teleop.step(now_us, &self.rig.arm);
        match decision.order {
            Order::Follow(goal) => self.check(&goal, &decision, seen),
            Order::Home => panic!("nobody asked for the way home"),
            Order::Stop => seen.held += u64::from(decision.status.state() == State::Hold),
        }
        self.servo.go(&mut self.rig.arm, &decision.order, 0.01);
    }

    fn check(&mut self, goal: &Pose<T>, decision: &Decision<T>, seen: &mut Seen) {
        let now_us = self.rig.now_us;
        let heard = self.heard.expect("nothing is followed before a command has come");
        assert!(self.may_run && self.button.0 && now_us - self.button.1 <= 200_000);
        assert!(now_us - heard.command.received_us <= 100_000 && heard.command.engaged);
        assert!(!matches!(heard.command.state, PoseState::Held | PoseState::Lost));
        assert!(command::is_rotation(&goal.rotation));
        seen.engaged += 1;
        seen.latches += u64::from(decision.notes.contains(Note::Latched));
        seen.jumps += u64::from(decision.notes.contains(Note::HandJumped));

        // what a turn of the hand by a radian may be for the tool; a scaled rotation vector is up to
        // half pi longer across its axis (more towards half a turn: 2.6 rad is 1.35)
        let (scale, turn_scale) = match self.config.turning {
            Turning::Locked => (self.config.scale, 0.0),
            Turning::Scaled(1.0) => (self.config.scale, 1.0),
            Turning::Scaled(k) => (self.config.scale, k * 1.36),
        };
        let now = double(goal);
        let excess = |from: &Pose<f64>, hand: &Pose<f64>| {
            let (metres, radians) = apart(&now, from);
            let (hand_metres, hand_radians) = apart(&heard.hand, hand);
            (metres - hand_metres * scale, radians - hand_radians * turn_scale)
        };
        let set_point = double(&self.rig.arm.set_point);
        let latched = decision.notes.contains(Note::Latched) || decision.notes.contains(Note::HandJumped);
        let (over_m, over_rad) = match self.before {
            Some(before) if !latched => excess(&double(&before.goal), &before.hand),
            // from the set-point, by nothing or by what the hand did since the station latched it
            _ => {
                let still = excess(&set_point, &heard.hand);
                let since_latch = excess(&set_point, &heard.latch);
                let (metres, radians) = apart(&heard.hand, &heard.latch);
                if still.0 < EPSILON && still.1 < EPSILON || metres > 0.15 || radians > 0.6 {
                    still
                } else {
                    since_latch
                }
            }
        };
        assert!(over_m < EPSILON && over_rad < EPSILON, "{over_m} m, {over_rad} rad too far: {decision:?}");
        if !latched {
            seen.worst_m = seen.worst_m.max(over_m);
            seen.worst_rad = seen.worst_rad.max(over_rad);
        }
        self.before = Some(Before { goal: *goal, hand: heard.hand });
    }
}

/// Metres and radians: commands come in single precision, of a hand that is up to some metres from its
/// latch, and places are scaled by up to 3.
const EPSILON: f64 = 1e-6;

fn play<T: Real>(all: u64) -> Seen {
    let mut seen = Seen::default();
    for seed in 0..all {
        let mut play = Play::<T>::new(seed);
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            (0..TICKS).for_each(|number| play.tick(number, &mut seen));
        }));
        if let Err(panic) = result {
            std::eprintln!("seed {seed}");
            std::panic::resume_unwind(panic);
        }
    }
    std::println!("{all} sequences: {seen:?}");
    assert!(seen.engaged > 10 * all && seen.held > 2 * all && seen.latches > all && seen.jumps > all / 20);
    seen
}

#[test]
fn the_goal_never_steps_further_than_the_hand() {
    let seen = play::<f64>(sequences(100_000));
    assert!(seen.stops > 0);
}

#[test]
fn the_same_holds_in_single_precision() {
    play::<f32>(sequences(10_000));
}
