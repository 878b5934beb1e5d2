//! Whatever is done to the arm in whatever order: the contract of the port holds.

use super::*;
use proptest::prelude::*;

#[derive(Clone, Debug)]
enum Deed {
    Enable,
    Stop,
    /// So many cycles of set-points, each joint by this share of its largest step.
    Drive(u8, [f64; JOINTS]),
    /// A set-point far away or beyond all ranges.
    Jump(usize, f64),
    Wait(u64),
    Fault(u8),
    Mend,
    Silence,
    Answer,
}

fn deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        3 => Just(Deed::Enable),
        1 => Just(Deed::Stop),
        6 => (1u8..40, prop::array::uniform6(-1.0..1.0)).prop_map(|(cycles, shares)| Deed::Drive(cycles, shares)),
        1 => (0..JOINTS, prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(100.0), -1.0..-0.2])
            .prop_map(|(joint, by)| Deed::Jump(joint, by)),
        4 => (0u64..700).prop_map(Deed::Wait),
        1 => (1u8..=6).prop_map(Deed::Fault),
        1 => Just(Deed::Mend),
        1 => Just(Deed::Silence),
        2 => Just(Deed::Answer),
    ]
}

/// The arm as it was a millisecond ago.
struct Watched {
    bench: Bench,
    speeds: Joints<f64>,
    joints: Joints<f64>,
    unready_ms: u64,
}

impl Watched {
    fn new(seed: u64) -> Self {
        let bench = Bench::new(&format!("seed={seed}"));
        let plant = bench.arm.plant();
        Self { speeds: plant.speeds(), joints: plant.joints(), unready_ms: 0, bench }
    }

    /// Lets a millisecond pass and looks.
    fn pass(&mut self) {
        let limits = PumaConfig::default().joints;
        self.bench.wait_us(1_000);
        let told = self.bench.arm.status();
        let read = self.bench.arm.read_joints();
        assert_eq!(told, self.bench.arm.status(), "a look changed the status");
        assert_eq!(read.is_err(), told == PortStatus::Lost);
        let plant = self.bench.arm.plant();
        for joint in 0..JOINTS {
            let (speed, angle) = (plant.speeds()[joint], plant.joints()[joint]);
            assert!(speed.abs() <= limits[joint].max_speed_rad_s + 1e-12);
            assert!((speed - self.speeds[joint]).abs() <= DRIVEN_RAD_S2[joint] * 1e-3 + 1e-12);
            assert!((angle - self.joints[joint] - speed * 1e-3).abs() < 1e-12);
        }
        (self.speeds, self.joints) = (plant.speeds(), plant.joints());
        let is_on = matches!(told, PortStatus::Enabling | PortStatus::Ready);
        self.unready_ms = if is_on { 0 } else { self.unready_ms + 1 };
        // 100 ms of the watchdog where it went silent, and the slowest joint's 0.34 s to stop
        if self.unready_ms > 450 {
            assert!(plant.is_braked() && plant.speeds() == [0.0; JOINTS], "{told} and moving");
        }
    }

    fn write(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
        let before = self.bench.arm.status();
        let result = self.bench.arm.write_set_point(joints);
        assert!(result.is_err() || before == PortStatus::Ready, "taken although {before}");
        result
    }

    fn act(&mut self, deed: &Deed) {
        let mischief = self.bench.arm.mischief();
        match deed {
            Deed::Enable => drop(self.bench.arm.enable()),
            Deed::Stop => {
                let stopped = self.bench.arm.stop();
                assert_eq!(stopped.is_err(), self.bench.arm.status() == PortStatus::Lost);
                assert_ne!(self.bench.arm.status(), PortStatus::Ready);
            }
            Deed::Drive(cycles, shares) => {
                let puma = PumaConfig::default().joints;
                let mut joints = *self.bench.arm.plant().set_point();
                for _ in 0..*cycles {
                    for (angle, (joint, share)) in joints.iter_mut().zip(puma.iter().zip(shares)) {
                        let next = *angle + share * joint.max_speed_rad_s * 0.01;
                        *angle = next.max(joint.min_rad).min(joint.max_rad);
                    }
                    if self.write(&joints).is_err() {
                        return;
                    }
                    (0..10).for_each(|_| self.pass());
                }
            }
            Deed::Jump(joint, by) => {
                let mut joints = *self.bench.arm.plant().set_point();
                joints[*joint] += by;
                assert!(self.write(&joints).is_err());
            }
            Deed::Wait(ms) => (0..*ms).for_each(|_| self.pass()),
            Deed::Fault(joint) => mischief.fault(Some(*joint), 0x2310),
            Deed::Mend => mischief.mend(),
            Deed::Silence => mischief.silence(),
            Deed::Answer => mischief.answer(),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn the_contract_holds_whatever_is_done(seed in 0u64..1000, deeds in prop::collection::vec(deed(), 1..60)) {
        let mut watched = Watched::new(seed);
        for deed in &deeds {
            watched.act(deed);
        }
        // and it always comes to rest
        watched.bench.arm.mischief().silence();
        (0..500).for_each(|_| watched.pass());
    }
}
