//! The operator's line to the slave: a peer of the link, or a thread of this process.

use super::HoldToRun;
use crate::cli::slave::linked::no_scene;
use crate::cli::slave::open_port;
use crate::cli::slave::talk::change;
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::inbox::Inbox;
use crate::link::local::{self, LocalEnd};
use crate::link::{Carrier, Doorbell, Link, Peer, Picture, Received, StationName};
use crate::locked::lock;
use crate::output::ArmRecord;
use crate::robot::clock::Clock;
use crate::settings::station::SlaveSettings;
use crate::station::{Cycle, LinkedSlave, Overseen, Overseer, SceneCameras, SlaveAnnouncement};
use anyhow::Context as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use tetrad_core::arm::teleop::State;
use tetrad_core::wire::{EncodeError, Packet};

/// See the [module's text](self).
pub(super) enum SlaveLine {
    Station(Peer),
    Here(SlaveThread),
}

/// A slave in a thread of this process.
pub(super) struct SlaveThread {
    end: LocalEnd,
    desk: Arc<Desk>,
    thread: Option<JoinHandle<Overseen>>,
}

/// What the thread and the operator's loop have in common.
#[derive(Debug, Default)]
struct Desk {
    /// The arm is to come to rest and the thread to end.
    end: AtomicBool,
    /// Somebody has said that the joints are homed.
    homed: AtomicBool,
    notices: Mutex<Vec<String>>,
}

/// Refuses to press the button by itself where an arm would move.
pub(super) fn check_hold(settings: &SlaveSettings, hold: HoldToRun) -> Result<(), Failure> {
    let address = settings.arm.port.clone().unwrap_or_default();
    if hold == HoldToRun::Always && address.moves_an_arm() {
        return Err(Failure::bad_arguments(format!(
            "{address} moves an arm: somebody has to hold the button, --hold-to-run always will not do"
        ))
        .help("leave the flag out and hold the space bar, or try it with port = \"sim:\" first"));
    }
    Ok(())
}

impl SlaveLine {
    pub(super) fn peer(name: &StationName, link: Option<&Link>) -> Result<Self, Failure> {
        let peer = link.and_then(|link| link.peer(name));
        let peer = peer.ok_or_else(|| Failure::bad_arguments(format!("no [[peer]] is called `{name}`")))?;
        Ok(Self::Station(peer))
    }

    /// Opens the arm and the cameras of its scene and starts their threads.
    pub(super) fn here(
        settings: &SlaveSettings,
        operator: u32,
        clock: &Clock,
        bell: &Doorbell,
        record: Option<ArmRecord>,
    ) -> Result<Self, Failure> {
        let address = settings.arm.port.clone().unwrap_or_default();
        let (config, port) = open_port(&address, &settings.arm)?;
        let session = operator.wrapping_add(1);
        let [theirs, end] = local::pair(clock, [Doorbell::default(), bell.clone()], [session, operator]);
        let cameras = u8::try_from(settings.cameras.len()).unwrap_or(u8::MAX);
        if let Ok(message) = SlaveAnnouncement::new(&address, &config, cameras).encode() {
            theirs.tell_configuration(&message);
        }
        let scene = SceneCameras::start(&settings.cameras, &config.puma, &theirs, session, clock);
        let work = Work {
            overseer: Overseer::new(scene.map_err(no_scene)?, record, clock),
            notice: port.notice(),
            slave: LinkedSlave::new(&config, port, theirs, session).or_exit(Exit::BadArguments)?,
            cycle_us: config.governor.cycle_us,
            desk: Arc::default(),
        };
        let desk = Arc::clone(&work.desk);
        let thread = std::thread::Builder::new().name("slave".to_owned()).spawn(move || work.all());
        let thread = thread.context("the slave's thread cannot be started").or_exit(Exit::Failed)?;
        Ok(Self::Here(SlaveThread { end, desk, thread: Some(thread) }))
    }

    /// Somebody at the operator's keys vouches for the joints; whether that counts, which it does where
    /// the arm is at the same computer.
    pub(super) fn confirm_homed(&self) -> bool {
        match self {
            Self::Station(_) => false,
            Self::Here(here) => {
                here.desk.homed.store(true, Ordering::Relaxed);
                true
            }
        }
    }

    /// What a slave of this process has to tell.
    pub(super) fn notices(&self) -> Vec<String> {
        match self {
            Self::Station(_) => Vec::new(),
            Self::Here(here) => std::mem::take(&mut *here.desk.notices()),
        }
    }

    /// Whether anybody is at the other end.
    pub(super) fn is_connected(&self) -> bool {
        match self {
            Self::Station(peer) => peer.is_connected(),
            Self::Here(here) => !here.is_over(),
        }
    }

    /// Whether the thread has ended though nobody asked it to.
    pub(super) fn is_over(&self) -> bool {
        matches!(self, Self::Here(here) if here.is_over())
    }

    /// The peer, where it is one.
    pub(super) const fn as_peer(&self) -> Option<&Peer> {
        match self {
            Self::Station(peer) => Some(peer),
            Self::Here(_) => None,
        }
    }

    /// Ends a slave of this process: its arm comes to rest. What its run came to, once.
    pub(super) fn end(&mut self) -> Result<Option<Overseen>, Failure> {
        match self {
            Self::Station(_) => Ok(None),
            Self::Here(here) => here.join(),
        }
    }
}

/// What the thread works with.
struct Work {
    slave: LinkedSlave<LocalEnd>,
    overseer: Overseer,
    notice: Option<String>,
    cycle_us: u32,
    desk: Arc<Desk>,
}

impl Work {
    fn all(self) -> Overseen {
        let Self { mut slave, overseer, notice, cycle_us, desk } = self;
        desk.notices().extend(notice);
        let mut told = None;
        let mut overseen = overseer.serve(&mut slave, cycle_us, &desk.end, |slave, cycle, lines| {
            if desk.homed.swap(false, Ordering::Relaxed) {
                slave.confirm_homed();
            }
            let reason = port_reason(slave, cycle);
            let news = reason.iter().filter(|reason| told.as_ref() != Some(*reason));
            let news = news.map(|reason| format!("    the arm's port: {reason}"));
            let mut lines: Vec<_> = lines.into_iter().chain(change(cycle)).chain(news).collect();
            told = reason;
            if !lines.is_empty() {
                desk.notices().append(&mut lines);
            }
        });
        let report = slave.station().port().report();
        overseen.lines.splice(0..0, report.into_iter().map(|line| ("arm", line)));
        overseen
    }
}

/// Why the arm's port stands as it does, where that is in the way: the arm's state that the operator gets
/// has no words.
fn port_reason(slave: &LinkedSlave<LocalEnd>, cycle: &Cycle) -> Option<String> {
    let stands = matches!(cycle.step.decision.status.state(), State::Stopped | State::Fault);
    stands.then(|| slave.station().port().reason()).flatten()
}

impl Desk {
    fn notices(&self) -> MutexGuard<'_, Vec<String>> {
        lock(&self.notices)
    }
}

impl SlaveThread {
    fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    fn join(&mut self) -> Result<Option<Overseen>, Failure> {
        self.desk.end.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(overseen)) => Ok(Some(overseen)),
            Some(Err(_)) => Err(Failure::new(
                Exit::Failed,
                anyhow::anyhow!("the slave's thread has panicked; its port brings the arm to rest by itself"),
            )),
            None => Ok(None),
        }
    }
}

impl Drop for SlaveThread {
    fn drop(&mut self) {
        // what was to be told was told, or somebody else's error is
        let _ = self.join();
    }
}

impl Carrier for SlaveLine {
    fn send(&self, packet: &Packet) -> Result<(), EncodeError> {
        match self {
            Self::Station(peer) => peer.send(packet),
            Self::Here(here) => here.end.send(packet),
        }
    }

    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R {
        match self {
            Self::Station(peer) => peer.with_inbox(look),
            Self::Here(here) => here.end.with_inbox(look),
        }
    }

    fn send_picture(&self, picture: Picture) {
        match self {
            Self::Station(peer) => Carrier::send_picture(peer, picture),
            Self::Here(here) => here.end.send_picture(picture),
        }
    }

    fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        match self {
            Self::Station(peer) => peer.picture(camera),
            Self::Here(here) => here.end.picture(camera),
        }
    }

    fn tell_configuration(&self, configuration: &[u8]) {
        match self {
            Self::Station(peer) => peer.tell_configuration(configuration),
            Self::Here(here) => here.end.tell_configuration(configuration),
        }
    }

    fn configuration(&self) -> Option<Vec<u8>> {
        match self {
            Self::Station(peer) => peer.configuration(),
            Self::Here(here) => here.end.configuration(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;
    use crate::robot::simulated::{SimulatedArm, SimulatedOptions};
    use std::time::{Duration, Instant};
    use tetrad_core::arm::port::{JointReading, PortError, PortStatus, RobotPort};
    use tetrad_core::arm::puma560::Joints;
    use tetrad_core::config::SlaveConfig;

    /// An arm whose controller cannot tell whether its joints are homed.
    struct Unhomed {
        arm: SimulatedArm,
        homed: Arc<AtomicBool>,
    }

    impl RobotPort<f64> for Unhomed {
        fn read_joints(&mut self) -> Result<JointReading<f64>, PortError> {
            self.arm.read_joints()
        }

        fn write_set_point(&mut self, joints: &Joints<f64>) -> Result<(), PortError> {
            self.arm.write_set_point(joints)
        }

        fn enable(&mut self) -> Result<(), PortError> {
            self.arm.enable()
        }

        fn stop(&mut self) -> Result<(), PortError> {
            self.arm.stop()
        }

        fn status(&self) -> PortStatus {
            if self.homed.load(Ordering::Relaxed) { self.arm.status() } else { PortStatus::NotHomed }
        }
    }

    impl Robot for Unhomed {
        fn confirm_homed(&mut self) {
            self.homed.store(true, Ordering::Relaxed);
        }

        fn reason(&self) -> Option<String> {
            let homed = self.homed.load(Ordering::Relaxed);
            (!homed).then(|| "its joints are where nobody knows".to_owned())
        }
    }

    #[test]
    fn a_slave_of_this_process_can_be_told_that_its_joints_are_homed() {
        let clock = Clock::wall();
        let config = SlaveConfig::default();
        let homed = Arc::<AtomicBool>::default();
        let arm = SimulatedArm::new(&config.puma, &SimulatedOptions::default()).unwrap();
        let port = Box::new(Unhomed { arm, homed: Arc::clone(&homed) });
        let [theirs, end] = local::pair(&clock, [Doorbell::default(), Doorbell::default()], [1, 2]);
        let scene = SceneCameras::start(&[], &config.puma, &theirs, 1, &clock).unwrap();
        let work = Work {
            overseer: Overseer::new(scene, None, &clock),
            notice: None,
            slave: LinkedSlave::new(&config, port, theirs, 1).unwrap(),
            cycle_us: config.governor.cycle_us,
            desk: Arc::default(),
        };
        let desk = Arc::clone(&work.desk);
        let thread = std::thread::spawn(move || work.all());
        let mut line = SlaveLine::Here(SlaveThread { end, desk, thread: Some(thread) });
        let wait = |what: &str, done: &mut dyn FnMut() -> bool| {
            let began = Instant::now();
            while !done() {
                assert!(began.elapsed() < Duration::from_secs(60), "{what}");
                std::thread::sleep(Duration::from_millis(5));
            }
        };
        let mut said = Vec::new();
        wait("the port's reason was never told", &mut || {
            said.extend(line.notices());
            !said.is_empty()
        });
        assert_eq!(said, ["    the arm's port: its joints are where nobody knows"]);
        assert!(line.confirm_homed());
        wait("the arm never heard", &mut || homed.load(Ordering::Relaxed));
        assert!(!line.is_over());
        let overseen = line.end().unwrap().expect("it was at work");
        assert_eq!(overseen.trouble, None);
        assert!(overseen.lines.iter().any(|(label, _)| *label == "cycles"), "{overseen:?}");
        assert!(line.end().unwrap().is_none(), "once");
    }
}
