use super::*;
use tetrad_core::config::{DRIVEN_RAD_S2, JOINTS};

mod any_course;

const CYCLE_US: u64 = 10_000;

/// An arm by a clock that is set by hand, driven as a station does: one set-point a cycle.
struct Bench {
    clock: Clock,
    arm: SimulatedArm,
}

impl Bench {
    fn new(options: &str) -> Self {
        let clock = Clock::given();
        let options = SimulatedOptions::parse(options).unwrap();
        let arm = SimulatedArm::with_clock(&PumaConfig::default(), &options, clock.clone()).unwrap();
        Self { clock, arm }
    }

    /// The same, switched on and ready.
    fn ready(options: &str) -> Self {
        let mut bench = Self::new(options);
        bench.arm.enable().unwrap();
        bench.wait_until_ready();
        bench
    }

    fn wait_until_ready(&self) {
        for _ in 0..2_000 {
            if self.arm.status() == PortStatus::Ready {
                return;
            }
            self.wait_us(1_000);
        }
        panic!("not ready after 2 s: {}", self.arm.status());
    }

    fn wait_us(&self, us: u64) {
        self.clock.set(self.clock.now_us() + us);
    }

    fn measured(&mut self) -> Joints<f64> {
        self.arm.read_joints().unwrap().joints
    }

    /// Moves every joint by `step` radians a cycle, for `cycles`; gives back the last set-point.
    fn drive(&mut self, step: f64, cycles: usize) -> Joints<f64> {
        let mut joints = *self.arm.plant().set_point();
        for _ in 0..cycles {
            joints = joints.map(|angle| angle + step);
            self.arm.write_set_point(&joints).unwrap();
            self.wait_us(CYCLE_US);
        }
        joints
    }

    fn is_at_rest(&mut self) -> bool {
        let _ = self.arm.read_joints();
        self.arm.plant().is_braked() && self.arm.plant().speeds() == [0.0; JOINTS]
    }
}

fn largest_difference(a: &Joints<f64>, b: &Joints<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn switching_on_takes_a_moment_and_moves_nothing() {
    let mut bench = Bench::new("noise=off");
    let stood = bench.measured();
    assert_eq!(bench.arm.write_set_point(&stood), Err(PortError::NotReady(PortStatus::Disabled)));
    bench.arm.enable().unwrap();
    bench.wait_us(499_999);
    assert_eq!(bench.arm.status(), PortStatus::Enabling);
    assert_eq!(bench.arm.write_set_point(&stood), Err(PortError::NotReady(PortStatus::Enabling)));
    bench.wait_us(1);
    assert_eq!(bench.arm.status(), PortStatus::Ready);
    bench.arm.write_set_point(&stood).unwrap();
    bench.wait_us(CYCLE_US);
    // the encoder shows the nearest count; the joints go to it
    assert_eq!(bench.measured(), stood);
}

#[test]
fn it_follows_behind_by_its_lag_and_arrives() {
    let mut bench = Bench::ready("noise=off");
    // 0.5 rad/s, for 1 s: 20 ms behind is 10 mrad; the interpolation ends at the set-point itself
    let set_point = bench.drive(0.005, 100);
    let behind = largest_difference(&bench.measured(), &set_point);
    assert!((behind - 0.01).abs() < 0.000_6, "{behind}");
    for _ in 0..30 {
        bench.arm.write_set_point(&set_point).unwrap();
        bench.wait_us(CYCLE_US);
    }
    let resolution = 1.0 / 8_547.6;
    let off = largest_difference(&bench.measured(), &set_point);
    assert!(off < resolution, "{off}");
}

#[test]
fn what_is_measured_is_whole_counts() {
    let mut bench = Bench::ready("");
    bench.drive(0.0031, 20);
    let counts = bench.measured()[0] * 9_964.9;
    assert!((counts - counts.round()).abs() < 1e-6, "{counts}");
    assert_ne!(bench.measured(), bench.arm.plant().joints());
}

#[test]
fn noise_trembles_by_as_much_as_it_says() {
    let mut bench = Bench::ready("noise=3");
    let stood = *bench.arm.plant().set_point();
    let (mut sum, cycles) = ([0.0; JOINTS], 2_000);
    for _ in 0..cycles {
        bench.drive(0.0, 3);
        for (sum, (at, stood)) in sum.iter_mut().zip(bench.arm.plant().joints().iter().zip(&stood)) {
            *sum += (at - stood).powi(2);
        }
    }
    // the torque that the first joints have is not always enough for it
    let counts_per_rad = [9_964.9, 13_727.4, 8_547.6, 12_101.6, 11_446.9, 12_205.0];
    for (sum, counts) in sum.iter().zip(counts_per_rad) {
        let counts = (sum / f64::from(cycles)).sqrt() * counts;
        assert!((2.4..3.6).contains(&counts), "{counts}");
    }
}

#[test]
fn the_same_seed_gives_the_same_motion_however_often_anybody_looks() {
    let run = |seed: u64, looks: u64| {
        let mut bench = Bench::ready(&format!("seed={seed}"));
        let mut joints = *bench.arm.plant().set_point();
        for _ in 0..50 {
            joints = joints.map(|angle| angle + 0.004);
            bench.arm.write_set_point(&joints).unwrap();
            for _ in 0..looks {
                bench.wait_us(CYCLE_US / looks);
                bench.measured();
            }
        }
        bench.arm.plant().joints().map(f64::to_bits)
    };
    assert_eq!(run(1, 1), run(1, 1));
    assert_eq!(run(1, 1), run(1, 8));
    assert_ne!(run(1, 1), run(2, 1));
}

#[test]
fn motors_are_never_asked_for_more_than_they_have() {
    let puma = PumaConfig::default();
    let options = SimulatedOptions { noise_counts: 3.0, ..SimulatedOptions::default() };
    let mut plant = Plant::new(&puma, &options).unwrap();
    plant.release();
    let start = plant.joints();
    let (mut speeds, mut angles) = (plant.speeds(), start);
    let mut fastest = [0.0f64; JOINTS];
    for step in 1..20_000u64 {
        // jumps that no gate would let through
        match step % 4_000 {
            1 => plant.go_to(&start.map(|angle| angle + 0.8)),
            1_500 => plant.go_to(&start),
            3_000 => plant.stop(),
            3_900 => plant.release(),
            _ => {}
        }
        plant.advance_to(step * 1_000);
        for (place, joint) in puma.joints.iter().enumerate() {
            let (speed, angle) = (plant.speeds()[place], plant.joints()[place]);
            assert!(speed.abs() <= joint.max_speed_rad_s + 1e-12);
            assert!((speed - speeds[place]).abs() <= DRIVEN_RAD_S2[place] * 1e-3 + 1e-12);
            assert!((angle - angles[place]).abs() <= joint.max_speed_rad_s * 1e-3 + 1e-12);
            fastest[place] = fastest[place].max(speed.abs() / joint.max_speed_rad_s);
        }
        (speeds, angles) = (plant.speeds(), plant.joints());
    }
    assert_eq!(fastest, [1.0; JOINTS], "the bounds were not reached");
}

#[test]
fn without_set_points_it_comes_to_rest_and_stays_there() {
    let mut bench = Bench::ready("noise=off");
    let last = bench.drive(0.01, 30);
    bench.wait_us(90_000);
    assert_eq!(bench.arm.status(), PortStatus::Ready);
    bench.wait_us(1);
    assert_eq!(bench.arm.status(), PortStatus::Stopped);
    assert_eq!(bench.arm.reason().as_deref(), Some("no set-point came for 100 ms"));
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::NotReady(PortStatus::Stopped)));
    bench.wait_us(200_000);
    assert!(bench.is_at_rest());
    let stood = bench.arm.plant().joints();
    bench.wait_us(60_000_000);
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::NotReady(PortStatus::Stopped)));
    assert_eq!(bench.arm.plant().joints(), stood);
}

#[test]
fn after_a_stop_in_motion_the_first_set_point_is_where_the_arm_is() {
    let mut bench = Bench::ready("noise=off&enable_ms=0");
    let last = bench.drive(0.015, 40);
    bench.arm.stop().unwrap();
    assert_eq!(bench.arm.status(), PortStatus::Stopped);
    assert_eq!(bench.arm.reason(), None);
    // enabled at once, it is ready when it has come to rest, not before
    bench.arm.enable().unwrap();
    assert_eq!(bench.arm.status(), PortStatus::Enabling);
    bench.wait_until_ready();
    let stood = bench.measured();
    let beyond = stood[0] - last[0];
    assert!(beyond > 0.1, "1.5 rad/s at 5.7 rad/s^2 goes on by 0.2 rad less the lag: {beyond}");
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::TooFar(1)));
    bench.wait_us(CYCLE_US);
    assert!(largest_difference(&bench.measured(), &stood) < 1e-3, "it moved by being enabled");
    bench.arm.write_set_point(&stood).unwrap();
}

#[test]
fn a_refused_set_point_moves_nothing_and_does_not_feed_the_watchdog() {
    let mut bench = Bench::ready("noise=off");
    let stood = bench.measured();
    let mut bad = stood;
    bad[0] += 0.015;
    bad[4] = f64::NAN;
    for _ in 0..10 {
        assert_eq!(bench.arm.write_set_point(&bad), Err(PortError::NotFinite(5)));
        bench.wait_us(CYCLE_US);
    }
    assert_eq!(bench.measured(), stood);
    bench.wait_us(1);
    assert_eq!(bench.arm.status(), PortStatus::Stopped);
}

#[test]
fn a_fault_stops_the_arm_until_it_is_mended_and_enabled() {
    let mut bench = Bench::ready("");
    let last = bench.drive(0.01, 20);
    let mischief = bench.arm.mischief();
    mischief.fault(Some(3), 0x2310);
    let fault = PortFault { joint: Some(3), code: 0x2310 };
    assert_eq!(bench.arm.status(), PortStatus::Fault(fault));
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::NotReady(PortStatus::Fault(fault))));
    bench.wait_us(400_000);
    assert!(bench.is_at_rest());
    assert_eq!(bench.arm.enable(), Err(PortError::Refused(fault)));
    mischief.mend();
    assert_eq!(bench.arm.status(), PortStatus::Fault(fault));
    bench.arm.stop().unwrap();
    assert_eq!(bench.arm.status(), PortStatus::Fault(fault));
    bench.arm.enable().unwrap();
    assert_eq!(bench.arm.status(), PortStatus::Enabling);
}

#[test]
fn a_silent_controller_is_lost_and_does_not_come_back_by_itself() {
    let mut bench = Bench::ready("");
    let last = bench.drive(0.01, 20);
    let mischief = bench.arm.mischief();
    mischief.silence();
    assert_eq!(bench.arm.status(), PortStatus::Lost);
    assert_eq!(bench.arm.read_joints(), Err(PortError::Lost));
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::Lost));
    assert_eq!(bench.arm.stop(), Err(PortError::Lost));
    assert_eq!(bench.arm.enable(), Err(PortError::Lost));
    // its own watchdog stops it meanwhile
    bench.wait_us(500_000);
    assert!(bench.is_at_rest());
    mischief.answer();
    assert_eq!(bench.arm.status(), PortStatus::Stopped);

    // heard again before the watchdog: it stops all the same
    let mut bench = Bench::ready("");
    let last = bench.drive(0.01, 20);
    let mischief = bench.arm.mischief();
    mischief.silence();
    assert_eq!(bench.arm.read_joints(), Err(PortError::Lost));
    mischief.answer();
    assert_eq!(bench.arm.write_set_point(&last), Err(PortError::NotReady(PortStatus::Stopped)));
    assert_eq!(bench.arm.reason().as_deref(), Some("the controller was not heard for a while"));
}

#[test]
fn faults_and_silence_come_when_the_address_says_so() {
    let mut bench = Bench::ready("fault=3@1s&silence=4s");
    bench.drive(0.0, 49);
    bench.wait_us(9_999);
    assert_eq!(bench.arm.status(), PortStatus::Ready);
    bench.wait_us(1);
    let fault = PortFault { joint: Some(3), code: 0x8611 };
    assert_eq!(bench.arm.status(), PortStatus::Fault(fault));
    assert_eq!(bench.arm.enable(), Err(PortError::Refused(fault)));
    bench.wait_us(2_000_000);
    bench.arm.enable().unwrap();
    bench.wait_us(500_000);
    assert_eq!(bench.arm.status(), PortStatus::Ready);
    bench.wait_us(500_000);
    assert_eq!(bench.arm.status(), PortStatus::Lost);
    assert_eq!(bench.arm.reason().as_deref(), Some("the simulated controller was told to be silent"));
}

#[test]
fn a_stop_is_obeyed_in_every_status_and_may_be_repeated() {
    let mut bench = Bench::new("");
    bench.arm.stop().unwrap();
    assert_eq!(bench.arm.status(), PortStatus::Disabled);
    bench.arm.enable().unwrap();
    bench.arm.stop().unwrap();
    bench.arm.stop().unwrap();
    bench.wait_us(1_000_000);
    assert_eq!(bench.arm.status(), PortStatus::Stopped);
}

#[test]
fn an_arm_that_cannot_be_is_refused() {
    let refused = |change: fn(&mut SimulatedOptions)| {
        let mut options = SimulatedOptions::default();
        change(&mut options);
        Plant::new(&PumaConfig::default(), &options).unwrap_err()
    };
    assert_eq!(refused(|options| options.lag_s = 0.0), PlantError::Options);
    assert_eq!(refused(|options| options.noise_counts = f64::NAN), PlantError::Options);
    assert_eq!(refused(|options| options.cycle_us = Some(0)), PlantError::Options);
    let out = refused(|options| options.start = Some([0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0]));
    assert!(matches!(out, PlantError::Start { joint: 4, .. }), "{out:?}");
}
