//! From power on to following set-points.

use super::bench::{Bench, START};
use tetrad_core::arm::port::PortStatus;
use tetrad_core::config::{CanopenConfig, Homing};
use tetrad_fixtures::drive::{Nmt, Status};

#[test]
fn drives_are_set_up_without_torque_and_enabled_when_asked() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.steps(200);
    assert_eq!(bench.master.status(), PortStatus::Disabled);
    assert_eq!(bench.master.positions().unwrap().0, START);
    for drive in &bench.drives {
        assert_eq!((drive.nmt, drive.status), (Nmt::Operational, Status::SwitchOnDisabled));
        assert_eq!((drive.get(0x1600, 0), drive.get(0x1600, 2)), (2, 0x607A_0020));
        assert_eq!((drive.get(0x6061, 0), drive.get(0x6007, 0), drive.get(0x60C2, 1)), (8, 3, 10));
        assert_eq!(drive.get(0x1801, 1) >> 31, 1, "TPDO2 is off");
        assert_eq!(drive.history, [Status::SwitchOnDisabled]);
    }
    bench.master.enable();
    bench.until(PortStatus::Ready);
    for (drive, start) in bench.drives.iter().zip(START) {
        assert_eq!(drive.status, Status::OperationEnabled);
        assert!(drive.targets.iter().all(|target| *target == start), "a jump: {:?}", drive.targets);
    }
}

/// Nothing is sent as long as it is only listened.
#[test]
fn the_bus_is_listened_to_first() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.steps(29);
    assert!(bench.sent.is_empty());
    bench.steps(3);
    assert!(!bench.sent.is_empty());
}

#[test]
fn a_thousand_set_points_arrive_to_the_count() {
    let mut bench = Bench::ready();
    let before: Vec<usize> = bench.drives.iter().map(|drive| drive.targets.len()).collect();
    let mut wanted = Vec::new();
    for k in 0..1_000 {
        let mut targets = START;
        for (joint, target) in (1i32..).zip(&mut targets) {
            *target += ((f64::from(k) / 90.0 * f64::from(joint)).sin() * 900.0) as i32;
        }
        wanted.push(targets);
        bench.master.set_point(targets);
        bench.step();
    }
    for (joint, drive) in bench.drives.iter().enumerate() {
        let got = &drive.targets[before[joint]..];
        let wanted: Vec<i32> = wanted.iter().map(|targets| targets[joint]).collect();
        assert_eq!(got, wanted, "joint {}", joint + 1);
        assert_eq!(drive.position(), wanted[999]);
    }
    let counters = bench.master.counters();
    assert_eq!((counters.set_points, counters.incomplete, counters.stale_answers), (1_000, 0, 0));
}

/// Two steps written in one cycle are two cycles' way, not one at twice the speed.
#[test]
fn no_motor_is_sent_faster_than_its_joint_may_go() {
    let mut bench = Bench::ready();
    let mut far = START;
    far[0] += 1_000;
    bench.master.set_point(far);
    bench.step();
    // 1.92 rad/s, 9964.9 counts a radian, 10 ms, a fifth more
    assert_eq!(*bench.drives[0].targets.last().unwrap(), START[0] + 230);
}

#[test]
fn drives_that_lack_what_is_not_needed_are_taken() {
    let mut bench = Bench::new(&CanopenConfig::default());
    for drive in &mut bench.drives {
        drive.faults.lacking = vec![0x1006, 0x1016, 0x6007, 0x60C2, 0x1801];
    }
    bench.master.enable();
    bench.until(PortStatus::Ready);
}

#[test]
fn an_arm_that_is_not_homed_gets_no_torque_until_it_is_and_is_asked_again() {
    let config = CanopenConfig { homing: Homing::StatusBit(14), ..CanopenConfig::default() };
    let mut bench = Bench::new(&config);
    bench.master.enable();
    bench.until(PortStatus::NotHomed);
    bench.steps(100);
    assert!(bench.drives.iter().all(|drive| drive.status == Status::SwitchOnDisabled));
    bench.drives.iter_mut().for_each(|drive| drive.more_status |= 1 << 14);
    bench.steps(100);
    assert_eq!(bench.master.status(), PortStatus::Disabled);
    bench.master.enable();
    bench.until(PortStatus::Ready);
    // and one that loses it is stopped
    bench.drives[2].more_status = 0;
    bench.steps(2);
    assert_eq!(bench.master.status(), PortStatus::NotHomed);
    assert!(bench.reason().starts_with("the drive of joint 3 (node 3) is not homed any more"));
    bench.assert_others_stop(None);
    bench.drives[2].more_status = 1 << 14;
    bench.steps(2);
    assert_eq!(bench.master.status(), PortStatus::Stopped);
}

#[test]
fn homing_can_be_confirmed_by_somebody() {
    let config = CanopenConfig { homing: Homing::Confirm, ..CanopenConfig::default() };
    let mut bench = Bench::new(&config);
    bench.master.enable();
    bench.until(PortStatus::NotHomed);
    bench.master.confirm_homed();
    bench.master.enable();
    bench.until(PortStatus::Ready);
}
