//! A network that loses, delays, repeats and reorders; and what arrives in the end.

use super::*;
use std::vec::Vec;

/// What may happen to a command on its way.
#[derive(Clone, Copy)]
pub(in crate::arm) struct Network {
    pub(in crate::arm) loss: f64,
    /// A command takes from nothing to this long, microseconds.
    pub(in crate::arm) jitter_us: u64,
    pub(in crate::arm) repeats: f64,
}

impl Network {
    /// Show 5: 30 % lost, 200 ms of jitter, so that they overtake one another.
    pub(in crate::arm) const BAD: Self = Self { loss: 0.3, jitter_us: 200_000, repeats: 0.1 };

    /// Puts a command sent now on its way.
    pub(in crate::arm) fn send(
        &self,
        command: Command,
        now_us: u64,
        under_way: &mut Vec<Command>,
        random: &mut Random,
    ) {
        let copies = if random.chance(self.repeats) { 2 } else { 1 };
        for _ in 0..copies {
            let received_us = now_us + (random.within(0.0, 1.0) * self.jitter_us as f64) as u64;
            if !random.chance(self.loss) {
                under_way.push(Command { received_us, ..command });
            }
        }
    }
}

/// Those that have come by now, in the order in which they came.
pub(in crate::arm) fn arrived(now_us: u64, under_way: &mut Vec<Command>) -> Vec<Command> {
    let mut come: Vec<Command> = under_way.iter().filter(|c| c.received_us <= now_us).copied().collect();
    under_way.retain(|c| c.received_us > now_us);
    come.sort_by_key(|c| c.received_us);
    come
}

/// A smooth random way: speeds that change now and then.
pub(in crate::arm) struct Wander {
    velocity: Vector3<f64>,
    turn: Vector3<f64>,
    speed: f64,
    turn_speed: f64,
}

impl Wander {
    pub(in crate::arm) fn new(speed: f64, turn_speed: f64) -> Self {
        Self { velocity: Vector3::zeros(), turn: Vector3::zeros(), speed, turn_speed }
    }

    pub(in crate::arm) fn go(&mut self, hand: &mut Pose<f64>, dt: f64, random: &mut Random) {
        if random.chance(2.0 * dt) || self.velocity == Vector3::zeros() {
            self.velocity = random.vector(self.speed / 3f64.sqrt());
            self.turn = random.vector(self.turn_speed / 3f64.sqrt());
        }
        hand.translation += self.velocity * dt;
        hand.rotation = so3::exp(&(self.turn * dt)) * hand.rotation;
    }
}

/// An arm that goes to the goal at no more than its speeds.
pub(in crate::arm) struct Servo {
    pub(in crate::arm) speed: f64,
    pub(in crate::arm) turn_speed: f64,
}

impl Servo {
    pub(in crate::arm) fn go<T: Real>(&self, arm: &mut ArmView<T>, order: &Order<T>, dt: f64) {
        let Some(goal) = order.goal().map(double) else { return };
        let mut now = double(&arm.set_point);
        let (metres, radians) = apart(&goal, &now);
        let share = |way: f64, most: f64| if way > most { most / way } else { 1.0 };
        let (go, turn) = (share(metres, self.speed * dt), share(radians, self.turn_speed * dt));
        if go == 1.0 && turn == 1.0 {
            arm.set_point = *order.goal().unwrap();
        } else {
            now.translation += (goal.translation - now.translation) * go;
            now.rotation =
                so3::exp(&(so3::log(&(goal.rotation * now.rotation.transpose())) * turn)) * now.rotation;
            arm.set_point = of(&now);
        }
        arm.measured = arm.set_point;
    }
}

/// Where the goal ends after a random way of the hand through a network, the step of the arm, and
/// where the hand's way leads without one.
pub(in crate::arm) struct Ends<T> {
    pub(in crate::arm) goal: Pose<T>,
    pub(in crate::arm) commanded: Pose<f64>,
    pub(in crate::arm) counts: Counts,
    pub(in crate::arm) held: bool,
}

/// Two seconds of a hand at up to 0.25 m/s and 0.8 rad/s, then a second at rest. The button comes
/// over a wire of its own, or with the commands.
pub(in crate::arm) fn through<T: Real>(
    config: &TeleopConfig,
    network: Network,
    seed: u64,
    turn_speed: f64,
    servo: &Servo,
) -> Ends<T> {
    const TICK_US: u64 = 10_000;
    let mut random = Random::new(seed);
    let mut wander = Wander::new(0.25, turn_speed);
    let riding = random.chance(0.5);
    let mut rig = Rig::<T>::armed(config);
    rig.sender = Sender::new(Pose { rotation: random.rotation(3.0), translation: random.vector(0.5) });
    rig.sender.sequence = (random.bits() >> 32) as u32;
    rig.teleop.inbox = Inbox::new();
    let start = double(&rig.arm.set_point);
    let mut fates = Random::new(seed ^ 0xFA7E);
    let (mut under_way, mut goal, mut held) = (Vec::new(), rig.arm.set_point, false);
    let begun_us = rig.now_us;
    let mut frame_us = begun_us;
    while rig.now_us < begun_us + 3_500_000 {
        rig.wait(TICK_US);
        let since_us = rig.now_us - begun_us;
        if since_us < 2_500_000 {
            wander.go(&mut rig.sender.hand, 0.01, &mut random);
        }
        if rig.now_us >= frame_us + FRAME_US {
            frame_us += FRAME_US;
            if !rig.sender.engaged && since_us > 500_000 {
                rig.sender.engage();
            }
            let command = rig.sender.command(frame_us);
            network.send(command, rig.now_us, &mut under_way, &mut fates);
        }
        for command in arrived(rig.now_us, &mut under_way) {
            let taken = rig.teleop.take(&command).is_ok();
            if taken && riding {
                rig.teleop.hold_to_run(command.engaged, command.received_us);
            }
        }
        if !riding {
            rig.button(rig.sender.engaged);
        }
        let decision = rig.teleop.step(rig.now_us, &rig.arm);
        if let Some(next) = decision.order.goal() {
            goal = *next;
        }
        held |= decision.status.state() == State::Hold;
        servo.go(&mut rig.arm, &decision.order, 0.01);
    }
    let moved = rig.sender.latch.inverse().compose(&rig.sender.hand);
    let commanded = Pose {
        translation: start.translation + moved.translation,
        rotation: moved.rotation * start.rotation,
    };
    Ends { goal, commanded, counts: rig.teleop.counts(), held }
}

pub(in crate::arm) const PERFECT: Network = Network { loss: 0.0, jitter_us: 0, repeats: 0.0 };

const SLOW_ARM: Servo = Servo { speed: 0.5, turn_speed: 2.0 };

#[test]
fn a_bad_network_loses_no_motion() {
    let config = TeleopConfig::default();
    let (mut missed, mut old, mut held) = (0, 0, 0);
    let all = sequences(10_000);
    for seed in 0..all {
        let lossy = through::<f64>(&config, Network::BAD, seed, 0.8, &SLOW_ARM);
        let (metres, radians) = apart(&lossy.goal, &lossy.commanded);
        assert!(metres < 1e-6 && radians < 1e-6, "seed {seed}: {metres} m, {radians} rad");
        if seed % 10 == 0 {
            let perfect = through::<f64>(&config, PERFECT, seed, 0.8, &SLOW_ARM);
            assert_eq!(lossy.goal, perfect.goal, "seed {seed}");
            assert_eq!((perfect.counts.missed, perfect.counts.old, perfect.held), (0, 0, false));
        }
        missed += lossy.counts.missed;
        old += lossy.counts.old;
        held += u64::from(lossy.held);
    }
    std::println!(
        "{all} ways: {missed} commands missed, {old} of them or repeats came late, {held} ways with a hold"
    );
    // the network did what it is there for
    assert!(u64::from(missed) > 30 * all && u64::from(old) > 10 * all && held > all / 2);
}

#[test]
fn the_same_holds_in_single_precision() {
    for seed in 0..sequences(2_000) {
        let lossy = through::<f32>(&TeleopConfig::default(), Network::BAD, seed, 0.8, &SLOW_ARM);
        let (metres, radians) = apart(&double(&lossy.goal), &lossy.commanded);
        assert!(metres < 1e-6 && radians < 2e-6, "seed {seed}: {metres} m, {radians} rad");
    }
}
