//! Promise: whatever the network does, the arm follows or stops; it never jumps. A hand moves an arm over
//! a link with faults, on simulated time, and the table of what came of it is compared with
//! tests/snapshots/link_faults.txt.
//!
//! `TETRAD_BLESS=1 cargo test -p tetrad-tests --test link_faults` rewrites it: read the difference.

use std::fmt::Write as _;
use tetrad::link::Carrier as _;
use tetrad::link::faulty::{Faults, FaultyEnd, pair};
use tetrad::robot::clock::Clock;
use tetrad_core::arm::port::{JointReading, PortStatus};
use tetrad_core::arm::slave::{ArmReading, PortOrder, Slave};
use tetrad_core::arm::teleop::{Command, Order, State};
use tetrad_core::config::{JOINTS, SlaveConfig};
use tetrad_core::hand::state::PoseState;
use tetrad_core::wire::{ButtonsPacket, MotionPacket, Transform};
use tetrad_fixtures::golden;

/// Rows and columns of the table.
const LOSS: [f64; 5] = [0.0, 0.1, 0.2, 0.3, 0.5];
const DELAY_MS: [u64; 5] = [0, 20, 100, 300, 1000];

const SESSION: u32 = 77;
const FRAME_US: u64 = 16_667;
const START_DEG: [f64; JOINTS] = [10.0, 45.0, -170.0, 5.0, 50.0, 0.0];

/// When the hand begins to move, when it is at rest again, and when the operator's computer dies in the
/// runs that measure the stop: in the middle of the movement.
const MOVES_US: u64 = 4_000_000;
const RESTS_US: u64 = 12_000_000;
const DIES_US: u64 = 7_000_000;

/// How long a run takes, microseconds.
const END_US: u64 = 18_000_000;

/// The hand goes out and back by so much, metres, once in so many seconds.
const AMPLITUDE_M: f64 = 0.1;
const PERIOD_S: f64 = 4.0;

/// An operator whose hand moves as it is told by the time.
struct Operator {
    link: FaultyEnd,
    sequence: u32,
    /// Told apart by presses.
    engagements: u32,
    pressed: bool,
    next_us: u64,
}

impl Operator {
    /// Where the hand is: at rest, then smoothly to and fro, then at rest a quarter of the way out.
    fn hand(now_us: u64) -> [f32; 3] {
        let t = now_us.clamp(MOVES_US, RESTS_US) - MOVES_US;
        let phase = t as f64 * 1e-6 / PERIOD_S * std::f64::consts::TAU;
        let x = AMPLITUDE_M / 2.0 * (1.0 - phase.cos());
        let z = AMPLITUDE_M / 4.0 * (1.0 - (phase / 4.0).cos());
        [x as f32, 0.0, z as f32]
    }

    fn cycle(&mut self, now_us: u64) {
        if now_us < self.next_us {
            return;
        }
        self.next_us += FRAME_US;
        self.sequence += 1;
        let motion = MotionPacket {
            session: SESSION,
            sequence: self.sequence,
            capture_us: now_us,
            engaged: self.pressed,
            engagements: self.engagements,
            state: PoseState::Both,
            spans: 1,
            views: 2,
            seen_in: [2; 4],
            residual_px: 0.1,
            increment: Transform::IDENTITY,
            since_engage: Transform { translation: Self::hand(now_us), ..Transform::IDENTITY },
            covariance: None,
        };
        self.link.send(&motion.into()).expect("sound");
        let buttons = ButtonsPacket {
            session: SESSION,
            sequence: self.sequence,
            time_us: now_us,
            pressed: self.pressed,
            stop: false,
            resets: 0,
        };
        self.link.send(&buttons.into()).expect("sound");
    }
}

/// What came of a run.
#[derive(Clone, Debug, Default)]
struct Outcome {
    /// The tool's place in each cycle, metres.
    tool: Vec<[f64; 3]>,
    /// When the last command came, when the hand was last followed, and when the arm last moved, by the
    /// slave's clock, microseconds.
    heard_us: u64,
    followed_us: u64,
    moved_us: u64,
    /// The largest difference of two set-points of a joint in a row, of what its speed allows.
    fastest: f64,
    /// Cycles in which the hand was followed, of those in which it moved.
    followed: usize,
    state: Option<State>,
}

fn run(seed: u64, faults: Faults, dies: bool) -> Outcome {
    let config = SlaveConfig::default();
    let clock = Clock::given();
    let [operator, slave_end] = pair(seed, [faults, Faults::default()], &clock);
    slave_end.begin(SESSION).expect("no session has ended");
    let mut operator = Operator { link: operator, sequence: 0, engagements: 1, pressed: false, next_us: 0 };
    let mut slave = Slave::<f64>::new(&config).expect("the defaults are sound");
    let mut joints = START_DEG.map(f64::to_radians);
    let cycle_us = u64::from(config.governor.cycle_us);
    let (mut outcome, mut armed) = (Outcome::default(), false);

    for now_us in (0..END_US).step_by(cycle_us as usize) {
        clock.set(now_us);
        // pressed once the slave must have heard that it is not
        if now_us >= 3_000_000 && !operator.pressed {
            (operator.pressed, operator.engagements) = (true, 2);
        }
        if !(dies && now_us >= DIES_US) {
            operator.cycle(now_us);
        }
        if let Some(motion) = slave_end.motion() {
            outcome.heard_us = motion.received_us;
            // what the law thinks of it is seen in what it orders
            let _ = slave.take(&Command::new(&motion.what, motion.received_us));
        }
        if let Some(buttons) = slave_end.buttons() {
            slave.hold_to_run(buttons.what.pressed, buttons.received_us);
        }
        let reading =
            ArmReading { joints: Some(JointReading { joints, age_us: 0 }), status: PortStatus::Ready };
        armed = armed || slave.reset(now_us, &reading).is_ok();
        let step = slave.step(now_us, &reading);
        if let PortOrder::Write(set_point) = step.order {
            let limits = &slave.arm().config().joints;
            for ((before, after), limit) in joints.iter().zip(&set_point).zip(limits) {
                let most = limit.max_speed_rad_s * cycle_us as f64 * 1e-6;
                outcome.fastest = outcome.fastest.max((after - before).abs() / most);
            }
            joints = set_point;
        }
        let tool = slave.arm().forward(&joints).translation;
        outcome.tool.push([tool.x, tool.y, tool.z]);
        let follows = matches!(step.decision.order, Order::Follow(_));
        outcome.followed += usize::from(follows && (MOVES_US..RESTS_US).contains(&now_us));
        if follows {
            outcome.followed_us = now_us;
        }
        if step.governed.is_some_and(|governed| !governed.at_rest) {
            outcome.moved_us = now_us;
        }
        outcome.state = Some(step.decision.status.state());
    }
    outcome
}

fn faults(loss: f64, delay_ms: u64) -> Faults {
    Faults {
        loss,
        delay_us: delay_ms * 1_000,
        jitter_us: 10_000,
        duplication: 0.05,
        corruption: 0.0,
        replay: 0.05,
        cut: None,
    }
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The arm over a link without faults.
fn reference() -> Outcome {
    run(1, Faults::default(), false)
}

#[test]
fn the_fault_table() -> Result<(), Box<dyn std::error::Error>> {
    let reference = reference();
    let mut table = String::from(
        "A hand moves an arm over a link that loses and delays packets (and doubles 5 % of them, plays 5 %\n\
         again a second later, and adds up to 10 ms to each). Each cell: the largest distance of the tool\n\
         from where it is without faults, mm / after the operator's death, counted from its last command,\n\
         the hand is followed, ms / the arm moves, ms.\n\n",
    );
    write!(table, "{:>9}", "loss %")?;
    DELAY_MS.iter().try_for_each(|delay| write!(table, "{:>22}", format!("{delay} ms")))?;
    writeln!(table)?;
    for loss in LOSS {
        write!(table, "{:>9.0}", loss * 100.0)?;
        for delay_ms in DELAY_MS {
            let faults = faults(loss, delay_ms);
            let whole = run(7, faults, false);
            let killed = run(7, faults, true);
            let pairs = whole.tool.iter().zip(&reference.tool);
            let error_m = pairs.map(|(a, b)| apart(*a, *b)).fold(0.0, f64::max);
            let stop_us = killed.followed_us.saturating_sub(killed.heard_us);
            let rest_us = killed.moved_us.saturating_sub(killed.heard_us);
            assert!(killed.moved_us < RESTS_US, "{loss}, {delay_ms}: it does not stop: {:?}", killed.state);
            for outcome in [&whole, &killed] {
                assert!(outcome.fastest <= 1.0 + 1e-9, "{loss}, {delay_ms}: {}", outcome.fastest);
            }
            assert!(whole.followed > 0, "{loss}, {delay_ms}: nothing was followed");
            assert!(stop_us <= 100_000, "{loss}, {delay_ms}: {stop_us}");
            let cell =
                format!("{:.1} / {} / {}", error_m * 1e3, stop_us.div_ceil(1000), rest_us.div_ceil(1000));
            write!(table, "{cell:>22}")?;
        }
        writeln!(table)?;
    }
    golden::check_file(
        &tetrad_tests::repository().join("tests/snapshots/link_faults.txt"),
        table.as_bytes(),
    )?;
    Ok(())
}

/// Where hold-to-run was heard all the time, the arm ends where the hand led it, whatever was lost on the
/// way: each packet holds the whole motion.
#[test]
fn what_was_lost_on_the_way_is_not_missing_at_the_end() {
    let reference = reference();
    let end = *reference.tool.last().expect("cycles");
    assert!(apart(end, reference.tool[0]) > 0.02, "it went somewhere");
    for (loss, delay_ms) in [(0.1, 20), (0.3, 20), (0.3, 100), (0.2, 1000)] {
        let outcome = run(3, faults(loss, delay_ms), false);
        let last = *outcome.tool.last().expect("cycles");
        assert!(apart(last, end) < 1e-4, "{loss}, {delay_ms}: {} m", apart(last, end));
    }
}

/// A cut in the middle of the movement: the arm stops, and where the operator holds on it waits for a new
/// press or goes on by itself, but never jumps.
#[test]
fn a_cut_stops_the_arm_and_its_end_moves_nothing_at_once() {
    for (from_us, until_us) in [(6_000_000, 6_300_000), (6_000_000, 8_000_000)] {
        let cut = Faults { cut: Some((from_us, until_us)), ..faults(0.0, 20) };
        let outcome = run(5, cut, false);
        assert!(outcome.fastest <= 1.0 + 1e-9, "{}", outcome.fastest);
        let at = |us: u64| outcome.tool[usize::try_from(us / 10_000).expect("few cycles")];
        let moved = apart(at(until_us - 10_000), at(until_us));
        assert!(moved < 1e-5, "at rest at the end of the cut: {moved} m");
        if until_us - from_us > 500_000 {
            assert_eq!(outcome.state, Some(State::Armed), "it takes a release and a press");
            assert!(apart(at(until_us), at(END_US - 10_000)) < 1e-9, "and until then nothing moves");
        }
    }
}
