//! The operator's line to the slave: a peer of the link, or a thread of this process.

use super::HoldToRun;
use crate::cli::slave::linked::no_scene;
use crate::cli::slave::open_port;
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::inbox::Inbox;
use crate::link::local::{self, LocalEnd};
use crate::link::{Carrier, Doorbell, Link, Peer, Picture, Received, StationName};
use crate::output::ArmCsv;
use crate::robot::clock::Clock;
use crate::settings::station::SlaveSettings;
use crate::station::{LinkedSlave, SceneCameras, SlaveAnnouncement, serve};
use anyhow::Context as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use tetrad_core::wire::{EncodeError, Packet};

/// See the [module's text](self).
pub(super) enum SlaveLine {
    Station(Peer),
    Here(SlaveThread),
}

/// A slave in a thread of this process.
pub(super) struct SlaveThread {
    end: LocalEnd,
    stop: Arc<AtomicBool>,
    notices: Arc<Mutex<Vec<String>>>,
    thread: Option<JoinHandle<Result<Vec<String>, Failure>>>,
}

/// How often the cameras of the scene and refused resets are asked what there is to tell, microseconds.
const LOOK_US: u64 = 50_000;

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
        record: Option<ArmCsv>,
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
            scene: scene.map_err(no_scene)?,
            slave: LinkedSlave::new(&config, port, theirs, session).or_exit(Exit::BadArguments)?,
            record,
            cycle_us: config.governor.cycle_us,
            clock: clock.clone(),
            stop: Arc::default(),
            notices: Arc::default(),
        };
        let (stop, notices) = (Arc::clone(&work.stop), Arc::clone(&work.notices));
        let thread = std::thread::Builder::new().name("slave".to_owned()).spawn(move || work.all());
        let thread = thread.context("the slave's thread cannot be started").or_exit(Exit::Failed)?;
        Ok(Self::Here(SlaveThread { end, stop, notices, thread: Some(thread) }))
    }

    /// What a slave of this process has to tell.
    pub(super) fn notices(&self) -> Vec<String> {
        match self {
            Self::Station(_) => Vec::new(),
            Self::Here(here) => std::mem::take(&mut *lock(&here.notices)),
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

    /// Ends a slave of this process: its arm comes to rest. What its port has to report.
    pub(super) fn end(&mut self) -> Result<Vec<String>, Failure> {
        match self {
            Self::Station(_) => Ok(Vec::new()),
            Self::Here(here) => here.join(),
        }
    }
}

/// What the thread works with.
struct Work {
    slave: LinkedSlave<LocalEnd>,
    scene: SceneCameras,
    record: Option<ArmCsv>,
    cycle_us: u32,
    clock: Clock,
    stop: Arc<AtomicBool>,
    notices: Arc<Mutex<Vec<String>>>,
}

impl Work {
    fn all(self) -> Result<Vec<String>, Failure> {
        let Self { mut slave, scene, mut record, cycle_us, clock, stop, notices } = self;
        let (began_us, mut looked_us) = (clock.now_us(), 0);
        let served = serve(&mut slave, cycle_us, &clock, &stop, |slave, cycle| {
            let now_us = clock.now_us();
            if let Some(reading) = &cycle.reading.joints {
                scene.arm_is_at(&reading.joints, now_us.saturating_sub(u64::from(reading.age_us)));
            }
            let t_s = now_us.saturating_sub(began_us) as f64 * 1e-6;
            if let Some(Err(error)) = record.as_mut().map(|record| record.write(t_s, cycle)) {
                // an arm that moves unrecorded is better than one that stops by surprise
                record = None;
                lock(&notices).push(format!("{:#}; the run goes on without", anyhow::Error::new(error)));
            }
            if now_us.saturating_sub(looked_us) >= LOOK_US {
                looked_us = now_us;
                let refusal = slave.take_refusal().map(|refusal| format!("no reset: {refusal}"));
                lock(&notices).extend(scene.take_notices().into_iter().chain(refusal));
            }
        });
        let mut lines = slave.station().robot().report();
        lines.extend(slave.trail().line());
        lines.push(format!("cycles of {cycle_us} us, {}", served.lateness));
        lines.extend(scene.end());
        match served.unstopped {
            Some(error) => {
                let cause = anyhow::Error::new(error).context("the arm could not be stopped at its port");
                Err(Failure::new(Exit::DeviceLost, cause))
            }
            None => Ok(lines),
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // plain data: whoever panicked with the lock left it whole
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl SlaveThread {
    fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    fn join(&mut self) -> Result<Vec<String>, Failure> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(_)) => Err(Failure::new(
                Exit::Failed,
                anyhow::anyhow!("the slave's thread has panicked; its port brings the arm to rest by itself"),
            )),
            None => Ok(Vec::new()),
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
