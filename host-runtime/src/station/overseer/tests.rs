//! On given time, with a simulated arm whose cable can be pulled.

use super::*;
use crate::link::Doorbell;
use crate::link::local::{self, LocalEnd};
use crate::robot::simulated::{Mischief, SimulatedArm, SimulatedOptions};
use std::sync::Arc;
use tetrad_core::config::SlaveConfig;

const CYCLE_US: u64 = 10_000;

struct Rig {
    clock: Clock,
    slave: LinkedSlave<LocalEnd>,
    mischief: Mischief,
    overseer: Overseer,
}

impl Rig {
    fn new(record: Option<ArmRecord>) -> Self {
        let clock = Clock::given();
        let config = SlaveConfig::default();
        let options = SimulatedOptions::default();
        let arm = SimulatedArm::with_clock(&config.puma, &options, clock.clone()).unwrap();
        let mischief = arm.mischief();
        let [end, _] = local::pair(&clock, [Doorbell::default(), Doorbell::default()], [1, 2]);
        let scene = SceneCameras::start(&[], &config.puma, &end, 1, &clock).unwrap();
        let overseer = Overseer::new(scene, record, &clock);
        let slave = LinkedSlave::new(&config, Box::new(arm), end, 1).unwrap();
        Self { clock, slave, mischief, overseer }
    }

    /// The lines of so many milliseconds.
    fn run_ms(&mut self, ms: u64) -> Vec<String> {
        let mut lines = Vec::new();
        for _ in 0..ms * 1_000 / CYCLE_US {
            self.clock.set(self.clock.now_us() + CYCLE_US);
            let cycle = self.slave.cycle(&self.clock);
            lines.extend(self.overseer.look(&mut self.slave, &cycle));
        }
        lines
    }
}

#[test]
fn an_arm_that_does_not_answer_is_told_of_and_lost_after_two_seconds() {
    let mut rig = Rig::new(None);
    assert_eq!(rig.run_ms(5_000), [] as [String; 0], "one that is only switched off is not lost");
    rig.mischief.silence();
    let said = rig.run_ms(1_990);
    assert_eq!(said, ["the arm does not answer: unless it does within 2 s, its slave ends"]);
    assert_eq!(rig.overseer.lost, None);
    assert_eq!(rig.run_ms(20), [] as [String; 0]);
    let lost = rig.overseer.lost.clone().expect("it is lost");
    let failure = Failure::from(SlaveTrouble::Lost(lost));
    assert_eq!(failure.exit, Exit::DeviceLost);
    assert!(failure.to_string().starts_with("error: the arm is lost ("), "{failure}");
}

#[test]
fn one_that_answers_in_time_is_not_lost() {
    let mut rig = Rig::new(None);
    for _ in 0..3 {
        rig.mischief.silence();
        assert_eq!(rig.run_ms(1_900).len(), 1);
        rig.mischief.answer();
        assert_eq!(rig.run_ms(100), ["the arm answers again"]);
    }
    assert_eq!(rig.overseer.lost, None);
}

#[test]
fn a_loss_ends_the_run_and_a_stop_that_is_not_taken_is_told() {
    let clock = Clock::wall();
    let config = SlaveConfig::default();
    let options = SimulatedOptions::parse("silence=0ms").unwrap();
    let arm = SimulatedArm::with_clock(&config.puma, &options, clock.clone()).unwrap();
    let [end, _] = local::pair(&clock, [Doorbell::default(), Doorbell::default()], [1, 2]);
    let scene = SceneCameras::start(&[], &config.puma, &end, 1, &clock).unwrap();
    let mut slave = LinkedSlave::new(&config, Box::new(arm), end, 1).unwrap();
    let asked = Arc::new(AtomicBool::new(false));
    let overseer = Overseer::new(scene, None, &clock);
    let overseen = overseer.serve(&mut slave, 10_000, &asked, |_, _, _| {});
    assert!(matches!(overseen.trouble, Some(SlaveTrouble::Lost(_))), "{overseen:?}");
    assert!(asked.load(Ordering::Relaxed), "whoever else waits for the end is told");

    // asked to end before it is known to be lost
    let overseer = Overseer::new(
        SceneCameras::start(&[], &config.puma, &local_end(&clock), 1, &clock).unwrap(),
        None,
        &clock,
    );
    let overseen = overseer.serve(&mut slave, 10_000, &asked, |_, _, _| {});
    assert_eq!(overseen.trouble, Some(SlaveTrouble::Unstopped(PortError::Lost)));
}

fn local_end(clock: &Clock) -> LocalEnd {
    let [end, _] = local::pair(clock, [Doorbell::default(), Doorbell::default()], [1, 2]);
    end
}

#[cfg(target_os = "linux")]
#[test]
fn a_record_that_cannot_be_written_is_left_and_the_run_goes_on() {
    // a directory whose arm.csv is a pipe that nobody reads any more
    let (reader, writer) = std::io::pipe().unwrap();
    let dir = tempfile::tempdir().unwrap();
    let target = format!("/dev/fd/{}", std::os::fd::AsRawFd::as_raw_fd(&writer));
    std::os::unix::fs::symlink(target, dir.path().join("arm.csv")).unwrap();
    let mut rig = Rig::new(Some(ArmRecord::create(dir.path()).unwrap()));
    drop(reader);
    let mut said = Vec::new();
    let began = std::time::Instant::now();
    while said.is_empty() {
        // the thread that writes finds it out some time
        assert!(began.elapsed() < std::time::Duration::from_secs(60), "never told");
        said = rig.run_ms(10);
    }
    said.extend(rig.run_ms(1_000));
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].contains("arm.csv") && said[0].ends_with("the run goes on without"), "{said:?}");
    assert!(rig.overseer.record.is_none());
}
