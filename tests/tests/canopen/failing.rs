//! Whatever fails: a named state, the arm at rest, a message that says what to do, no jump on return.

use super::bench::{Bench, START};
use tetrad_core::arm::canopen::Frame;
use tetrad_core::arm::port::{PortFault, PortStatus};
use tetrad_core::config::CanopenConfig;
use tetrad_fixtures::drive::{Drive, Status};

fn fault(joint: u8, code: u32) -> PortStatus {
    PortStatus::Fault(PortFault { joint: Some(joint), code })
}

fn fail(bench: &mut Bench, joint: usize, code: u16) {
    let mut out = Vec::new();
    bench.drives[joint].fail(code, &mut out);
    bench.hear(&out);
}

#[test]
fn a_fault_in_motion_stops_the_others_and_is_reset_when_enabled() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 150, 20);
    fail(&mut bench, 3, 0x8611);
    bench.drive_on(0, 150, 2);
    assert_eq!(bench.master.status(), fault(4, 0x8611));
    let reason = "the drive of joint 4 (node 4) is in fault 0x8611 (following error";
    assert!(bench.reason().starts_with(reason), "{}", bench.reason());
    bench.assert_others_stop(Some(3));
    // it does not come back by itself, and not while the cause lasts
    bench.drives[3].faults.lasting = true;
    bench.master.enable();
    bench.steps(150);
    assert_eq!(bench.master.status(), fault(4, 0x8611));
    bench.drives[3].faults.lasting = false;
    let stands: Vec<i32> = bench.drives.iter().map(Drive::position).collect();
    bench.master.enable();
    bench.until(PortStatus::Ready);
    assert_eq!(bench.drives.iter().map(Drive::position).collect::<Vec<_>>(), stands, "a jump");
}

/// Without EMCY the code is read.
#[test]
fn a_fault_at_start_is_told_with_its_code_and_not_reset() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.drives[1].fail(0x3210, &mut Vec::new());
    bench.master.enable();
    bench.until(fault(2, 0x3210));
    assert!(bench.reason().contains("voltage"), "{}", bench.reason());
    bench.steps(100);
    assert_eq!(bench.drives[1].status, Status::Fault);
    assert!(bench.drives.iter().all(|drive| !drive.history.contains(&Status::OperationEnabled)));
    bench.master.enable();
    bench.until(PortStatus::Ready);
}

#[test]
fn a_missing_node_is_named() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.drives[4].faults.dead = true;
    bench.master.enable();
    bench.until(PortStatus::Lost);
    assert!(bench.reason().starts_with("the drive of joint 5 (node 5) does not answer; check its power"));
    assert!(bench.drives.iter().all(|drive| drive.status == Status::SwitchOnDisabled));
    bench.drives[4].faults.dead = false;
    bench.master.enable();
    bench.until(PortStatus::Ready);
}

#[test]
fn a_bus_without_drives_is_told_from_a_missing_node() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.cut = true;
    bench.until(PortStatus::Lost);
    assert!(bench.reason().starts_with("no drive answers; check the bus cable"), "{}", bench.reason());
}

#[test]
fn a_line_at_the_wrong_speed_is_told_from_a_bus_without_drives() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.cut = true;
    bench.master.hear_garbage(12_345);
    bench.until(PortStatus::Lost);
    let reason = "no drive answers, and 12345 bytes came that are no CAN frames; check `baud`";
    assert!(bench.reason().starts_with(reason), "{}", bench.reason());
}

#[test]
fn a_node_that_falls_silent_in_motion_stops_the_others() {
    let mut bench = Bench::ready();
    bench.drive_on(2, -90, 20);
    bench.drives[5].faults.dead = true;
    bench.drive_on(2, -90, 5);
    assert_eq!(bench.master.status(), PortStatus::Ready, "four cycles may be missed");
    bench.drive_on(2, -90, 2);
    assert_eq!(bench.master.status(), PortStatus::Lost);
    assert!(bench.reason().starts_with("the drive of joint 6 (node 6) does not answer"));
    bench.assert_others_stop(Some(5));
    assert!(bench.master.is_partly_lost());
    bench.steps(20);
    let reason = bench.master.reason().unwrap().to_string();
    assert!(
        reason.contains("; stopped: joints 1, 2, 3, 4, 5; not known to have stopped: joint 6, "),
        "{reason}"
    );
}

/// The master cannot tell them: they watch its heartbeat themselves.
#[test]
fn a_cut_bus_is_told_from_a_silent_node_and_the_drives_stop_by_themselves() {
    let mut bench = Bench::ready();
    bench.drive_on(1, 100, 20);
    bench.cut = true;
    bench.steps(10);
    assert_eq!(bench.master.status(), PortStatus::Lost);
    assert!(bench.reason().starts_with("no drive answers"), "{}", bench.reason());
    bench.steps(40);
    assert!(bench.drives.iter().all(|drive| drive.lost_master && drive.rests()));
    // back only when asked, and from where the arm is
    bench.cut = false;
    bench.steps(100);
    assert_eq!(bench.master.status(), PortStatus::Lost);
    let stands: Vec<i32> = bench.drives.iter().map(Drive::position).collect();
    bench.master.enable();
    bench.until(PortStatus::Ready);
    assert_eq!(bench.drives.iter().map(Drive::position).collect::<Vec<_>>(), stands, "a jump");
}

#[test]
fn an_emergency_stop_is_seen_as_a_drive_that_left_operation() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 10, 5);
    bench.drives[0].faults.safe_torque_off = true;
    bench.drive_on(0, 10, 2);
    assert_eq!(bench.master.status(), fault(1, 0x1_0003));
    assert!(bench.reason().contains("went to 'switch on disabled' by itself; check the emergency stop"));
    bench.assert_others_stop(Some(0));
    // enabling while it is still pressed ends, too
    bench.master.enable();
    bench.steps(600);
    assert_eq!(bench.master.status(), fault(1, 0x1_0004));
    assert!(bench.reason().contains("stays in 'switch on disabled'"), "{}", bench.reason());
}

#[test]
fn another_master_is_heard_before_anything_is_sent() {
    for (id, data, what) in [
        (0x000u16, &[0x01u8, 0x00][..], "NMT commands"),
        (0x080, &[], "SYNC"),
        (0x203, &[0x0F, 0x00], "set-points for node 3"),
        (0x602, &[0x40, 0x41, 0x60, 0, 0, 0, 0, 0], "SDO requests to node 2"),
        (0x77F, &[0x05], "a heartbeat as node 127"),
    ] {
        let mut bench = Bench::new(&CanopenConfig::default());
        bench.master.enable();
        bench.steps(2);
        bench.hear(&[Frame::new(id, data).unwrap()]);
        bench.steps(100);
        let status = PortStatus::Fault(PortFault { joint: None, code: 0x1_0001 });
        assert_eq!(bench.master.status(), status);
        assert!(bench.reason().contains(what), "{}", bench.reason());
        assert!(bench.sent.is_empty(), "the drives are not ours");
    }
}

#[test]
fn another_master_in_motion_stops_the_arm() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 50, 20);
    bench.hear(&[Frame::new(0x080, &[]).unwrap()]);
    bench.step();
    assert_eq!(bench.master.status(), PortStatus::Fault(PortFault { joint: None, code: 0x1_0001 }));
    bench.assert_others_stop(None);
}

#[test]
fn nonsense_is_not_believed_and_stops_the_arm() {
    let jump = [&0x0227u16.to_le_bytes()[..], &(START[2] + 100_000).to_le_bytes()[..]].concat();
    let status = [&0xFFFFu16.to_le_bytes()[..], &START[2].to_le_bytes()[..]].concat();
    for (data, what) in [(vec![1, 2, 3], "3 bytes"), (status, "statusword 0xffff"), (jump, "100000 counts")] {
        let mut bench = Bench::ready();
        bench.drive_on(0, 20, 10);
        bench.drives[2].faults.nonsense = Some(data);
        bench.drive_on(0, 20, 2);
        assert_eq!(bench.master.status(), PortStatus::Ready, "two may be disturbed");
        assert_eq!(bench.master.positions().unwrap().0[2], START[2]);
        bench.drive_on(0, 20, 2);
        assert_eq!(bench.master.status(), fault(3, 0x1_0002));
        assert!(bench.reason().contains(what), "{}", bench.reason());
        bench.assert_others_stop(Some(2));
    }
}

#[test]
fn a_drive_that_restarts_in_motion_is_lost_until_enabled() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 20, 10);
    let mut out = Vec::new();
    bench.drives[3].restart(&mut out);
    bench.hear(&out);
    bench.drive_on(0, 20, 1);
    assert_eq!(bench.master.status(), PortStatus::Lost);
    assert!(bench.reason().starts_with("the drive of joint 4 (node 4) was restarted"));
    bench.assert_others_stop(Some(3));
    bench.master.enable();
    bench.until(PortStatus::Ready);
    assert_eq!(bench.drives[3].status, Status::OperationEnabled);
}

#[test]
fn drives_that_cannot_be_set_up_say_why() {
    let told = |change: &dyn Fn(&mut Drive)| {
        let mut bench = Bench::new(&CanopenConfig { vendor: Some(0x1F), ..CanopenConfig::default() });
        change(&mut bench.drives[2]);
        bench.steps(300);
        assert!(bench.drives.iter().all(|drive| drive.status == Status::SwitchOnDisabled));
        (bench.master.status(), bench.reason())
    };
    let (status, reason) = told(&|drive| drive.set(0x1000, 0, 0x0000_0191));
    assert_eq!(status, fault(3, 0x1_0007));
    assert!(reason.contains("no CiA 402 drive: its device type is 0x00000191"), "{reason}");
    let (status, reason) = told(&|drive| drive.set(0x1018, 1, 0x20));
    assert_eq!(status, fault(3, 0x1_0007));
    assert!(reason.contains("vendor 0x20"), "{reason}");
    let (status, reason) = told(&|drive| drive.faults.refusing.push(0x1600));
    assert_eq!(status, fault(3, 0x1_0006));
    assert!(reason.contains("refused 0x1600:00 (abort 0x08000022, not in this state"), "{reason}");
    let (status, _) = told(&|drive| drive.faults.lacking.push(0x6060));
    assert_eq!(status, fault(3, 0x1_0006));
}

#[test]
fn without_set_points_the_arm_stops_and_goes_to_none_of_them_afterwards() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 100, 20);
    bench.steps(12);
    assert_eq!(bench.master.status(), PortStatus::Stopped);
    assert_eq!(bench.reason(), "no set-point came for 100 ms; enable to go on");
    bench.assert_others_stop(None);
    bench.master.set_point([9_999; 6]);
    let stands: Vec<i32> = bench.drives.iter().map(Drive::position).collect();
    bench.master.enable();
    bench.until(PortStatus::Ready);
    bench.steps(5);
    assert_eq!(bench.drives.iter().map(Drive::position).collect::<Vec<_>>(), stands);
}

#[test]
fn a_stop_latches_and_a_worse_thing_takes_its_place() {
    let mut bench = Bench::ready();
    bench.drive_on(0, 100, 20);
    bench.master.stop();
    bench.assert_others_stop(None);
    assert_eq!(bench.master.status(), PortStatus::Stopped);
    bench.drives[1].faults.dead = true;
    bench.steps(30);
    assert_eq!(bench.master.status(), PortStatus::Lost);
    bench.master.stop();
    assert_eq!(bench.master.status(), PortStatus::Lost);
}

#[test]
fn late_sdo_answers_are_counted_and_not_believed() {
    let mut bench = Bench::new(&CanopenConfig::default());
    bench.steps(35);
    bench.hear(&[Frame::new(0x581, &[0x43, 0x18, 0x10, 4, 0, 0, 0, 0]).unwrap()]);
    bench.master.enable();
    bench.until(PortStatus::Ready);
    assert_eq!(bench.master.counters().stale_answers, 1);
}
