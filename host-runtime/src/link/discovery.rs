//! Stations that announce themselves on the local network by multicast DNS (RFC 6762, 6763), and those that
//! look for them: the service `_tetrad._udp`, with the station's name as the text `name`.
//!
//! Nothing that is heard here is believed beyond where to dial: what is kept is in
//! `announced`.

use super::announced::Announced;
use super::name::StationName;
use mdns_sd::{IfKind, Receiver, ResolvedService, ScopedIp, ServiceDaemon, ServiceEvent, ServiceInfo};
use std::fmt;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// What stands in a peer's address where it is to be looked up.
pub const MDNS: &str = "mdns";

/// The service.
const SERVICE: &str = "_tetrad._udp.local.";

/// The text under which a station's name stands: instances are renamed where two are called the same.
const NAME: &str = "name";

/// How long the end waits for the announcement to be taken back.
const FAREWELL: Duration = Duration::from_millis(500);

/// The longest label of DNS.
const LABEL: usize = 63;

/// Where is announced and listened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scope {
    /// The local network, on the port of mDNS; nothing on loopback.
    Network,
    /// This computer alone, on that port.
    Loopback(u16),
}

/// Why nothing can be announced or looked up.
#[derive(Debug, thiserror::Error)]
pub enum DiscoveryError {
    /// The daemon does not do it.
    #[error("multicast DNS cannot be used; give each [[peer]] its address, and leave [station] announce out")]
    Daemon(#[from] mdns_sd::Error),
    /// The system has no thread left.
    #[error("the thread that looks for stations cannot be started")]
    Thread(#[from] std::io::Error),
}

/// A responder and a querier, each with a thread. Where it is dropped, what was announced is taken back.
pub struct Discovery {
    daemon: ServiceDaemon,
    announced: Arc<Mutex<Announced>>,
    listener: Option<JoinHandle<()>>,
}

impl Discovery {
    /// Looks for these peers; announces nothing yet.
    ///
    /// # Errors
    /// [`DiscoveryError`]
    pub fn start(peers: impl IntoIterator<Item = StationName>, scope: Scope) -> Result<Self, DiscoveryError> {
        let daemon = match scope {
            Scope::Network => {
                let daemon = ServiceDaemon::new()?;
                daemon.disable_interface(vec![IfKind::LoopbackV4, IfKind::LoopbackV6])?;
                daemon
            }
            Scope::Loopback(port) => {
                let daemon = ServiceDaemon::new_with_port(port)?;
                daemon.disable_interface(IfKind::All)?;
                daemon.enable_interface(IfKind::LoopbackV4)?;
                daemon
            }
        };
        let announced = Announced::of(peers, scope != Scope::Network);
        let announced = Arc::new(Mutex::new(announced));
        let events = daemon.browse(SERVICE)?;
        let heard = Arc::clone(&announced);
        let thread = std::thread::Builder::new().name("mdns".to_owned());
        let listener = Some(thread.spawn(move || listen(&events, &heard))?);
        Ok(Self { daemon, announced, listener })
    }

    /// Announces a station that is dialled there; an address of all interfaces is announced as theirs.
    ///
    /// # Errors
    /// [`DiscoveryError`]
    pub fn announce(&self, name: &StationName, listens: SocketAddr) -> Result<(), DiscoveryError> {
        let host = format!("tetrad-{name}").chars().take(LABEL).collect::<String>() + ".local.";
        let text = [(NAME, name.as_str())];
        let all = listens.ip().is_unspecified();
        let addresses: Vec<IpAddr> = if all { Vec::new() } else { vec![listens.ip()] };
        let info =
            ServiceInfo::new(SERVICE, name.as_str(), &host, addresses.as_slice(), listens.port(), &text[..])?;
        self.daemon.register(if all { info.enable_addr_auto() } else { info })?;
        Ok(())
    }

    /// Where to dial a peer in that attempt; `None` while nobody has announced it.
    pub(super) fn address(&self, name: &StationName, attempt: usize, ipv4: bool) -> Option<SocketAddr> {
        let announced = self.announced.lock().unwrap_or_else(PoisonError::into_inner);
        announced.address(name, attempt, ipv4)
    }
}

fn listen(events: &Receiver<ServiceEvent>, announced: &Mutex<Announced>) {
    // ends with the daemon
    while let Ok(event) = events.recv() {
        let mut announced = announced.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            ServiceEvent::ServiceResolved(service) => hear(&mut announced, &service),
            ServiceEvent::ServiceRemoved(_, instance) => announced.forget(&instance),
            _ => {}
        }
    }
}

fn hear(announced: &mut Announced, service: &ResolvedService) {
    let Some(name) = service.get_property_val_str(NAME) else { return };
    let addresses: Vec<IpAddr> = service.get_addresses().iter().map(ScopedIp::to_ip_addr).collect();
    announced.hear(service.get_fullname(), name, &addresses, service.get_port());
}

impl fmt::Debug for Discovery {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Discovery").field("announced", &self.announced).finish_non_exhaustive()
    }
}

impl Drop for Discovery {
    fn drop(&mut self) {
        // one that does not end by itself ends with the process
        let ended = self.daemon.shutdown().ok().and_then(|ended| ended.recv_timeout(FAREWELL).ok());
        if let Some(listener) = self.listener.take().filter(|_| ended.is_some()) {
            let _ = listener.join();
        }
    }
}
