//! The operator's line to the slave: a peer of the link, or a thread of this process.

use super::HoldToRun;
use crate::cli::slave::open_port;
use crate::exit::{Exit, Failure, OrExit as _};
use crate::link::inbox::Inbox;
use crate::link::local::{self, LocalEnd};
use crate::link::{Carrier, Doorbell, Link, Peer, Picture, Received, StationName};
use crate::robot::clock::Clock;
use crate::settings::station::SlaveSettings;
use crate::station::{LinkedSlave, SlaveAnnouncement, serve};
use anyhow::Context as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
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
    thread: Option<JoinHandle<Result<Vec<String>, Failure>>>,
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

    /// Opens the arm and starts its thread.
    pub(super) fn here(
        settings: &SlaveSettings,
        operator: u32,
        clock: &Clock,
        bell: &Doorbell,
    ) -> Result<Self, Failure> {
        let address = settings.arm.port.clone().unwrap_or_default();
        let (config, port) = open_port(&address, &settings.arm)?;
        let session = operator.wrapping_add(1);
        let [theirs, end] = local::pair(clock, [Doorbell::default(), bell.clone()], [session, operator]);
        if let Ok(message) = SlaveAnnouncement::new(&address, &config, 0).encode() {
            theirs.tell_configuration(&message);
        }
        let mut slave = LinkedSlave::new(&config, port, theirs, session).or_exit(Exit::BadArguments)?;
        let stop = Arc::new(AtomicBool::new(false));
        let (ends, its_clock) = (Arc::clone(&stop), clock.clone());
        let work = move || {
            let served = serve(&mut slave, config.governor.cycle_us, &its_clock, &ends, |_, _| {});
            let mut lines = slave.station().robot().report();
            lines.push(format!("cycles of {} us, {}", config.governor.cycle_us, served.lateness));
            match served.unstopped {
                Some(error) => {
                    let cause = anyhow::Error::new(error).context("the arm could not be stopped at its port");
                    Err(Failure::new(Exit::DeviceLost, cause))
                }
                None => Ok(lines),
            }
        };
        let thread = std::thread::Builder::new().name("slave".to_owned()).spawn(work);
        let thread = thread.context("the slave's thread cannot be started").or_exit(Exit::Failed)?;
        Ok(Self::Here(SlaveThread { end, stop, thread: Some(thread) }))
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
