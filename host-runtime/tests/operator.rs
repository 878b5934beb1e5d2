//! Promise: an operator joins its cameras, moves an arm over a link with faults, and stalls for nobody.
//!
//! Everything is in one thread and told the time by hand: two cameras that see a simulated hand, in-process
//! carriers, the operator, `link::faulty`, and a slave with a simulated arm.

use nalgebra::Matrix3;
use tetrad::link::faulty::{self, Faults, FaultyEnd};
use tetrad::link::local::{self, LocalEnd};
use tetrad::link::{Carrier as _, Doorbell};
use tetrad::robot::clock::Clock;
use tetrad::robot::simulated::{SimulatedArm, SimulatedOptions};
use tetrad::station::delays::Stage;
use tetrad::station::operator::{Buttons, OperatorConfig, OperatorStep};
use tetrad::station::pairing::Source;
use tetrad::station::{Following, LinkedSlave, Operator, Truth, Unattended};
use tetrad_core::arm::teleop::{Note, State};
use tetrad_core::config::{FilterConfig, HandConfig, SlaveConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::hand::affine::Arms;
use tetrad_core::hand::state::PoseState;
use tetrad_core::hand::tracker::HandMode;
use tetrad_core::observation::{ImageCovariance, Observation, ObservationState};
use tetrad_core::wire::ObservationPacket;
use tetrad_fixtures::Scene;

const OPERATOR: u32 = 70;
const SLAVE: u32 = 80;

/// Sixty pictures a second, taken on a grid of a quarter of a period.
const GRID_FPS: f64 = 240.0;
const GRID_US: u64 = 4_167;
const GRIDS: u64 = 4;

/// What a camera's station takes, and the local network.
const READY_US: u32 = 1_500;
const OBSERVED_US: u32 = 2_000;

/// When pictures begin by the given clock.
const FIRST_US: u64 = 1_000_000;

/// A camera without pixels: it sees the truth.
struct Camera {
    at: usize,
    end: LocalEnd,
    phase: u64,
    sequence: u32,
    /// Gone between these times.
    away_us: std::ops::Range<u64>,
}

impl Camera {
    fn tick(&mut self, scene: &Scene, now_us: u64) {
        let Some(made_us) = now_us.checked_sub(FIRST_US + u64::from(OBSERVED_US)) else { return };
        let grid = made_us / GRID_US;
        let due = made_us.is_multiple_of(GRID_US) && grid % GRIDS == self.phase;
        if !due || self.away_us.contains(&now_us) {
            return;
        }
        let balls = scene.truth(grid as usize, self.at).map(|ball| Observation {
            state: ObservationState::Visible,
            centre: ImagePoint::new(ball.outline_centre.0 as f32, ball.outline_centre.1 as f32),
            diameter: ball.diameter as f32,
            covariance: ImageCovariance::isotropic(0.05),
            visible: 1.0,
        });
        let packet = ObservationPacket {
            camera: 0,
            session: 1,
            sequence: self.sequence,
            capture_us: FIRST_US + grid * GRID_US,
            ready_us: READY_US,
            observed_us: OBSERVED_US,
            width: scene.width,
            height: scene.height,
            pixels_tested: 0,
            balls,
        };
        self.sequence += 1;
        self.end.send(&packet.into()).expect("a sound packet");
    }
}

/// Everything.
struct Cell {
    scene: Scene,
    clock: Clock,
    cameras: [Camera; 2],
    eyes: [LocalEnd; 2],
    operator: Operator,
    unattended: Unattended,
    line: FaultyEnd,
    slave: LinkedSlave<FaultyEnd>,
    config: SlaveConfig,
    following: Following,
    newest_us: u64,
    /// When the hand was followed, and how many cycles of the slave.
    engaged: u64,
    cycles: u64,
}

impl Cell {
    fn new(phase: u64, faults: Faults) -> Self {
        let mut scene = Scene::named("circular-0.25-60fps").expect("the scene");
        scene.fps = GRID_FPS;
        let clock = Clock::given();
        let eye = |session| {
            let [camera, eye] =
                local::pair(&clock, [Doorbell::default(), Doorbell::default()], [session, OPERATOR]);
            (camera, eye)
        };
        let ((left, left_eye), (right, right_eye)) = (eye(1), eye(1));
        let camera = |at, end, phase| Camera { at, end, phase, sequence: 0, away_us: 0..0 };
        let [line, slave_end] = faulty::pair(11, [faults; 2], &clock);
        line.begin(SLAVE).expect("new");
        line.share_clock();
        slave_end.begin(OPERATOR).expect("new");
        let config = SlaveConfig::default();
        let options = SimulatedOptions::default();
        let arm = SimulatedArm::with_clock(&config.puma, &options, clock.clone()).expect("an arm");
        let operator = OperatorConfig {
            arms: Arms::equal(scene.arm_m as f32).expect("arms"),
            mode: HandMode::Refined,
            hand: HandConfig::default(),
            filter: FilterConfig::default(),
            focal_px: vec![None; 2],
        };
        Self {
            cameras: [camera(0, left, 0), camera(1, right, phase)],
            eyes: [left_eye, right_eye],
            operator: Operator::new(&operator, OPERATOR).expect("sound"),
            unattended: Unattended::default(),
            slave: LinkedSlave::new(&config, Box::new(arm), slave_end, SLAVE).expect("sound"),
            line,
            scene,
            clock,
            config,
            following: Following::default(),
            newest_us: 0,
            engaged: 0,
            cycles: 0,
        }
    }

    /// Goes on until a time; every step of the operator.
    fn until(&mut self, end_us: u64) -> Vec<OperatorStep> {
        let mut steps = Vec::new();
        // every microsecond of the grid's is met: the clock goes in steps that divide it
        while self.clock.now_us() < end_us {
            let now_us = self.clock.now_us() + 1;
            self.clock.set(now_us);
            let on_grid = now_us.wrapping_sub(FIRST_US + u64::from(OBSERVED_US)).is_multiple_of(GRID_US);
            if !on_grid && !now_us.is_multiple_of(1_000) {
                continue;
            }
            for camera in &mut self.cameras {
                camera.tick(&self.scene, now_us);
            }
            for (at, eye) in self.eyes.iter().enumerate() {
                if let Some(observation) = eye.observation(0) {
                    self.operator.observe(at, &observation);
                }
            }
            let buttons = self.unattended.buttons(now_us);
            let turn = self.operator.step(&self.line, buttons, &self.clock);
            assert_eq!(turn.unsent, None);
            if let Some(state) = &turn.arm {
                self.unattended.hear(&state.what, now_us);
            }
            if let Some(step) = turn.step {
                self.newest_us = step.joined.t_us;
                steps.push(step);
            }
            if now_us.is_multiple_of(u64::from(self.config.governor.cycle_us)) {
                self.cycle(now_us);
            }
        }
        steps
    }

    fn cycle(&mut self, now_us: u64) {
        let cycle = self.slave.cycle(&self.clock);
        self.cycles += 1;
        let (decision, Some(measured)) = (&cycle.step.decision, &cycle.step.measured) else { return };
        if decision.status.state() != State::Engaged {
            return;
        }
        self.engaged += 1;
        let tool: Truth = (measured.rotation, measured.translation);
        if decision.notes.contains(Note::Latched) || decision.notes.contains(Note::HandJumped) {
            self.following.latch(seconds(self.newest_us), tool);
        }
        self.following.sample(seconds(now_us), tool);
    }

    /// Where the hand is, in its own axes of the first picture.
    fn hand(&self, t_s: f64) -> Truth {
        let (first, now) = (self.scene.hand_at(0.0), self.scene.hand_at(t_s.max(0.0)));
        let turn: Matrix3<f64> = first.rotation.transpose() * now.rotation;
        (turn, first.rotation.transpose() * (now.translation - first.translation))
    }
}

fn seconds(us: u64) -> f64 {
    (us as f64 - FIRST_US as f64) * 1e-6
}

#[test]
fn the_arm_follows_the_hand_over_a_link_with_faults() {
    let clean = Faults::default();
    let bad = Faults { loss: 0.1, delay_us: 20_000, jitter_us: 10_000, duplication: 0.05, ..clean };
    for (phase, faults, most_m) in [(0, clean, 0.01), (1, clean, 0.01), (2, bad, 0.015)] {
        let mut cell = Cell::new(phase, faults);
        let steps = cell.until(16_000_000);
        assert!(cell.engaged * 10 > cell.cycles * 5, "{phase}: engaged {} of {}", cell.engaged, cell.cycles);
        let closeness = cell.following.closeness(&cell.config.teleop.robot_from_hand, |t_s| cell.hand(t_s));
        let closeness = closeness.expect("it followed");
        assert!(closeness.rms_m < most_m, "{phase}: {closeness:?}");
        // cameras at 60 a second, a quarter of a period or a half apart
        let late = steps.iter().skip(10).filter(|step| step.hand.report.state != PoseState::Both).count();
        assert_eq!(late, 0, "{phase}");
        assert!(steps.len() >= 890, "{phase}: {}", steps.len());
    }
}

#[test]
fn delays_are_those_that_were_made() {
    let faults = Faults { delay_us: 20_000, ..Faults::default() };
    let mut cell = Cell::new(1, faults);
    cell.until(8_000_000);
    let p50 = |stage| cell.operator.delays().of(stage).unwrap_or_else(|| panic!("{stage:?}")).p50_us;
    let about = |stage, us: u64| {
        let measured = p50(stage);
        assert!(measured.abs_diff(us) <= us / 50 + 1_100, "{stage:?}: {measured} us, not {us}");
    };
    about(Stage::Ready, u64::from(READY_US));
    about(Stage::Observed, 500);
    about(Stage::Received, 0);
    // the right camera's picture comes a quarter of a period after the left one's
    about(Stage::Joined, GRID_US);
    about(Stage::ReadyToSent, 500);
    about(Stage::Arrived, 20_000);
    about(Stage::Back, 20_000);
    // once a cycle
    let heard_of = p50(Stage::HeardOf);
    assert!((40_000..=52_000).contains(&heard_of), "{heard_of}");
    let table = cell.operator.delays().table();
    assert!(table.lines().count() >= 14, "{table}");
}

#[test]
fn a_camera_that_goes_and_comes_back_leaves_the_pose_to_the_other() {
    let (gone_us, back_us) = (4_000_000, 5_000_000);
    let mut cell = Cell::new(1, Faults::default());
    cell.cameras[1].away_us = gone_us..back_us;
    let steps = cell.until(7_000_000);
    let of = |from_us, to_us| {
        let within = move |step: &&OperatorStep| (from_us..to_us).contains(&step.joined.t_us);
        steps.iter().filter(within).collect::<Vec<_>>()
    };
    let alone = of(gone_us + 50_000, back_us - 20_000);
    assert!(alone.len() >= 50, "it goes on: {}", alone.len());
    for step in &alone {
        assert_eq!(step.joined.views[1].source, Source::Missing);
        assert_eq!((step.hand.report.state, step.motion.views), (PoseState::One, 2));
        assert_eq!(step.motion.seen_in, [1; 4]);
    }
    let pauses = steps.windows(2).map(|pair| pair[1].joined.t_us - pair[0].joined.t_us);
    assert!(pauses.skip(3).all(|us| us <= 3 * GRIDS * GRID_US));
    let together = of(back_us + 100_000, 7_000_000);
    assert!(together.iter().all(|step| step.hand.report.state == PoseState::Both));
    let counts = cell.operator.pairing().counts();
    assert!(counts.partial >= 55 && counts.complete > 250, "{counts:?}");
}

#[test]
fn buttons_are_told_again_and_again_and_at_once_when_they_change() {
    let clock = Clock::given();
    let [line, slave] = faulty::pair(1, [Faults::default(); 2], &clock);
    slave.begin(OPERATOR).expect("new");
    let config = OperatorConfig {
        arms: Arms::equal(0.08).expect("arms"),
        mode: HandMode::Refined,
        hand: HandConfig::default(),
        filter: FilterConfig::default(),
        focal_px: vec![None],
    };
    let mut operator = Operator::new(&config, OPERATOR).expect("sound");
    let mut heard = Vec::new();
    for now_us in (0..200_000).step_by(1_000) {
        clock.set(now_us);
        let pressed = (50_000..57_000).contains(&now_us);
        let buttons = Buttons { pressed, resets: u32::from(now_us >= 103_000), ..Buttons::default() };
        operator.step(&line, buttons, &clock);
        assert!(operator.sleep_us(now_us) <= 20_000);
        heard.extend(slave.buttons().map(|buttons| (now_us, buttons.what.pressed, buttons.what.resets)));
    }
    assert!(heard.windows(2).all(|pair| pair[1].0 - pair[0].0 <= 20_000), "{heard:?}");
    for change in [(50_000, true, 0), (57_000, false, 0), (103_000, false, 1)] {
        assert!(heard.contains(&change), "{change:?} in {heard:?}");
    }
    assert!(heard.len() <= 13, "no more often than that: {heard:?}");
}
