//! The port of a program without threads, as a microcontroller has it: the same drives, in simulated time.

use super::bench::{PERIOD_US, START};
use tetrad_core::arm::canopen::{CanopenArm, Frames};
use tetrad_core::arm::port::{PortError, PortFault, PortStatus, RobotPort};
use tetrad_core::arm::puma560::{Drives, Joints};
use tetrad_core::config::{CanopenConfig, DrivesConfig, PumaConfig};
use tetrad_fixtures::drive::{Drive, Status};

struct Rig {
    arm: CanopenArm,
    drives: Vec<Drive>,
    now_us: u64,
}

fn status(arm: &CanopenArm) -> PortStatus {
    RobotPort::<f32>::status(arm)
}

fn enable(arm: &mut CanopenArm) -> Result<(), PortError> {
    RobotPort::<f32>::enable(arm)
}

impl Rig {
    fn new() -> Self {
        let config = CanopenConfig::default();
        let arm = CanopenArm::new(&PumaConfig::default(), &config).expect("the defaults");
        let drives = config.nodes.iter().zip(START).map(|(node, start)| Drive::new(*node, start)).collect();
        Self { arm, drives, now_us: 0 }
    }

    /// A cycle in which the port is asked for something.
    fn cycle<R>(&mut self, ask: impl FnOnce(&mut CanopenArm) -> R) -> R {
        self.now_us += PERIOD_US;
        self.arm.begin_cycle(self.now_us);
        let answer = ask(&mut self.arm);
        let mut frames = Frames::default();
        self.arm.end_cycle(&mut frames);
        let mut answers = Vec::new();
        for drive in &mut self.drives {
            frames.as_slice().iter().for_each(|frame| drive.receive(frame, &mut answers));
            drive.tick(self.now_us, &mut answers);
        }
        answers.iter().for_each(|frame| self.arm.receive(self.now_us + PERIOD_US / 2, frame));
        answer
    }

    fn until(&mut self, wanted: PortStatus) {
        for _ in 0..1_000 {
            if self.cycle(|arm| status(arm)) == wanted {
                return;
            }
        }
        panic!("{:?} and not {wanted:?}: {:?}", status(&self.arm), self.arm.reason());
    }

    fn ready() -> Self {
        let mut rig = Self::new();
        assert_eq!(status(&rig.arm), PortStatus::Disabled);
        rig.cycle(enable).expect("nothing is in the way");
        rig.until(PortStatus::Ready);
        rig
    }

    fn joints(&mut self) -> Joints<f32> {
        self.cycle(|arm| arm.read_joints()).expect("they were measured").joints
    }
}

#[test]
fn set_points_in_single_precision_come_to_the_drives_to_the_count() {
    let mut rig = Rig::ready();
    let motors = Drives::new(&DrivesConfig::default()).expect("the defaults");
    let mut joints = rig.joints();
    for _ in 0..100 {
        joints[0] += 0.004;
        joints[4] -= 0.002;
        rig.cycle(|arm| arm.write_set_point(&joints)).expect("a small step");
        let targets = motors.counts(&joints).expect("within 32 bits");
        let told: Vec<i32> = rig.drives.iter().map(Drive::position).collect();
        assert_eq!(told, targets);
    }
}

#[test]
fn what_is_no_step_is_refused_and_silence_stops() {
    let mut rig = Rig::ready();
    let joints = rig.joints();
    let mut far = joints;
    far[1] += 0.5;
    assert_eq!(rig.cycle(|arm| arm.write_set_point(&far)), Err(PortError::TooFar(2)));
    let mut bad = joints;
    bad[3] = f32::NAN;
    assert_eq!(rig.cycle(|arm| arm.write_set_point(&bad)), Err(PortError::NotFinite(4)));
    rig.until(PortStatus::Stopped);
    assert_eq!(rig.cycle(|arm| arm.write_set_point(&joints)), Err(PortError::NotReady(PortStatus::Stopped)));
    assert!(rig.drives.iter().all(|drive| drive.status != Status::OperationEnabled));
}

#[test]
fn a_fault_is_not_reset_before_it_can_have_been_read() {
    let mut rig = Rig::ready();
    let mut answers = Vec::new();
    rig.drives[2].fail(0x8611, &mut answers);
    answers.iter().for_each(|frame| rig.arm.receive(rig.now_us + 1, frame));
    let fault = PortFault { joint: Some(3), code: 0x8611 };
    rig.until(PortStatus::Fault(fault));
    assert_eq!(rig.cycle(enable), Err(PortError::Refused(fault)));
    for _ in 0..100 {
        rig.cycle(|_| ());
    }
    rig.cycle(enable).expect("a second later");
    rig.until(PortStatus::Ready);
}

#[test]
fn drives_that_fall_silent_are_lost() {
    let mut rig = Rig::ready();
    let joints = rig.joints();
    rig.drives.iter_mut().for_each(|drive| drive.faults.dead = true);
    for _ in 0..10 {
        let _ = rig.cycle(|arm| arm.write_set_point(&joints));
    }
    assert_eq!(status(&rig.arm), PortStatus::Lost);
    let read: Result<_, PortError> = rig.cycle(RobotPort::<f32>::read_joints);
    assert_eq!(read.unwrap_err(), PortError::Lost);
}
