//! What joins the stations: QUIC with mutual TLS, and a loopback with faults that behaves alike.
//!
//! ```text
//!  station's loop                    the link's thread (tokio, one thread)              the network
//!
//!   send(packet) ----> outbox ----> session ----> datagrams, unreliable ------------->
//!   motion() ... <---- inbox  <---- session <---- datagrams <------------------------
//!                        clock  <---- session <---> one stream: greeting, time, configuration
//!   send_picture() --> outbox ----> pictures ---> a second connection, one stream a picture
//!   wait()       <----- news
//! ```
//!
//! | job | file |
//! |---|---|
//! | names, the authority, who a station is, TLS | `name`, [`authority`], `identity`, `tls` |
//! | the port, and what may come through it | [`socket`] |
//! | connections made, dialled, lost, made again | `connect`, `transport`, `closing` |
//! | stations that announce themselves, where to dial those | [`discovery`], `announced` |
//! | one connection for packets, one for pictures | `session`, `pictures` |
//! | what is on the streams | [`message`], [`picture`] |
//! | the newest only, either way | `outbox`, [`inbox`], `gate` |
//! | the other station's clock | [`clock`] |
//! | what stations see | [`carrier`], `peer`, `news`, `event`, `refusals` |
//! | the same without a network, with faults | [`faulty`] |
//! | the same within a process | [`local`] |
//!
//! - **Nobody waits.** No call of a station's loop waits for the network, and nothing queues: of each
//!   kind of packet the newest stands in for all before, at either end.
//! - **Nobody unnamed.** A station talks to the peers it is configured for, each under its own name, with
//!   a certificate of their common authority. There is no plain mode.
//! - **Nothing twice.** What QUIC has seen before it drops. Above it, a packet counts if it is of the
//!   session its connection's peer has said is its, and is newer than all before. A session that was
//!   followed by another never comes back.
//! - **Pictures never hold up motion.** They have a connection of their own, with its own congestion and
//!   losses, and a bounded rate.
//! - **Times.** The age of a packet is counted from when it came, by this station's clock. When it was
//!   captured is told from the measured offset of the clocks, and is for pairing and figures alone.

mod announced;
pub mod authority;
pub mod carrier;
pub mod clock;
mod closing;
mod connect;
pub mod discovery;
mod event;
pub mod faulty;
mod gate;
mod identity;
pub mod inbox;
pub mod local;
pub mod message;
mod name;
mod news;
mod outbox;
mod peer;
pub mod picture;
mod pictures;
mod refusals;
mod session;
mod shared;
pub mod socket;
#[cfg(test)]
mod test_packets;
mod tls;
mod transport;

pub use carrier::Carrier;
pub use discovery::{Discovery, DiscoveryError, MDNS};
pub use event::LinkEvent;
pub use gate::Counts;
pub use identity::{Identity, IdentityError};
pub use inbox::Received;
pub use name::{BadName, StationName};
pub use news::{Doorbell, Watch};
pub use outbox::OutboxCounts;
pub use peer::{ConfigurationTooLong, LinkStats, Peer};
pub use picture::Picture;

use crate::robot::clock::Clock;
use discovery::Scope;
use news::News;
use peer::PeerShared;
use quinn::{ClientConfig, Endpoint, EndpointConfig, ServerConfig, TokioRuntime, TransportConfig};
use shared::LinkShared;
use socket::MarkedIds;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;
use tls::Lane;
use tokio::runtime::Runtime;
use tokio::sync::oneshot;

#[cfg(test)]
mod tests;

/// The rate of pictures to each peer where none is given, bytes a second: two cameras of 640x480 as JPEG
/// at 30 a second are some 2 MB/s.
pub const PICTURE_BYTES_PER_S: u32 = 2_500_000;

/// Handshakes that wait to be looked at, and what is kept of each, bytes: a flood costs no more.
const WAITING: usize = 64;
const WAITING_BYTES: u64 = 16 * 1024;

/// How long the end of a link waits for its peers to have been told.
const FAREWELL: Duration = Duration::from_secs(1);

/// Whom a station talks to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkConfig {
    /// Where it is dialled; `None` where it only dials.
    pub listen: Option<SocketAddr>,
    /// The peers. Those with an address are dialled.
    pub peers: Vec<PeerConfig>,
    /// The rate of pictures to each peer, bytes a second.
    pub picture_bytes_per_s: u32,
}

/// A peer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PeerConfig {
    /// What it is called, in its certificate too.
    pub name: StationName,
    /// HOST:PORT to dial, or [`MDNS`] to look it up on the local network; `None` where it dials. One of
    /// the two has to.
    pub address: Option<String>,
}

/// Why there is no link.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Two peers, or a peer and the station itself, are called the same.
    #[error("two stations are called `{0}`: give each a name of its own")]
    SameName(StationName),
    /// A peer can neither be dialled nor dial.
    #[error("`{0}` has no address and this station does not listen: give one of the two")]
    NoWay(StationName),
    /// The address is somebody else's.
    #[error("cannot listen on {0}; choose an address of this computer and a port that is free")]
    Listen(SocketAddr, #[source] io::Error),
    /// The certificate or the key cannot be used.
    #[error("the certificate or the key of `{0}` cannot be used; make new ones with `tetrad keys`")]
    Tls(StationName, #[source] rustls::Error),
    /// Stations cannot be looked up on the local network.
    #[error("stations cannot be looked up on the local network")]
    Discovery(#[from] DiscoveryError),
    /// The thread cannot be started.
    #[error("the link's thread cannot be started")]
    Thread(#[source] io::Error),
}

/// A station's link to its peers. Where it is dropped, the peers are told and the thread ends.
#[derive(Debug)]
pub struct Link {
    shared: Arc<LinkShared>,
    local: SocketAddr,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Link {
    /// Starts the link's thread. Peers come and go from then on.
    ///
    /// # Errors
    /// [`LinkError`]
    pub fn start(config: &LinkConfig, identity: &Identity, clock: Clock) -> Result<Self, LinkError> {
        let sought = config.sought();
        let discovery =
            if sought.is_empty() { None } else { Some(Discovery::start(sought, Scope::Network)?) };
        Self::start_with(config, identity, clock, discovery)
    }

    /// The same with what looks stations up on the local network, which may announce this one as well.
    ///
    /// # Errors
    /// [`LinkError`]
    pub fn start_with(
        config: &LinkConfig,
        identity: &Identity,
        clock: Clock,
        discovery: Option<Discovery>,
    ) -> Result<Self, LinkError> {
        config.check(identity.name())?;
        let tls = |error| LinkError::Tls(identity.name().clone(), error);
        let transport = Arc::new(transport::config());
        let names = config.peers.iter().map(|peer| peer.name.clone()).collect();
        let mut server = ServerConfig::with_crypto(Arc::new(tls::server(identity, names).map_err(tls)?));
        server
            .transport_config(Arc::clone(&transport))
            .migration(false)
            .max_incoming(WAITING)
            .incoming_buffer_size(WAITING_BYTES)
            .incoming_buffer_size_total(WAITING as u64 * WAITING_BYTES);
        let server = config.listen.is_some().then_some(server);
        let clients = Clients {
            motion: client(identity, Lane::Motion, &transport).map_err(tls)?,
            pictures: client(identity, Lane::Pictures, &transport).map_err(tls)?,
        };
        let session = tls::random_u32().map_err(tls)?;

        let news = Arc::new(News::default());
        let peer = |peer: &PeerConfig| {
            let (name, address) = (peer.name.clone(), peer.address.clone());
            Arc::new(PeerShared::new(name, address, Arc::clone(&news), clock.clone()))
        };
        let peers = config.peers.iter().map(peer).collect();
        let name = identity.name().clone();
        let rate = config.picture_bytes_per_s;
        let mut shared = LinkShared::new(name, session, clock.clone(), rate, peers, Arc::clone(&news));
        shared.discovery = discovery;
        let shared = Arc::new(shared);

        let address = config.listen.unwrap_or(SocketAddr::from((Ipv4Addr::UNSPECIFIED, 0)));
        let listen = |error| LinkError::Listen(address, error);
        let mark = tls::random_u32().map_err(tls)?.to_be_bytes();
        let (socket, receive_buffer) = socket::bind(address, mark).map_err(listen)?;
        if receive_buffer < socket::RECEIVE_BUFFER {
            shared.tell(LinkEvent::SmallBuffer { granted: receive_buffer });
        }
        let mut quic = EndpointConfig::default();
        // the socket's filter goes by both
        quic.cid_generator(move || Box::new(MarkedIds::new(mark))).grease_quic_bit(false);
        let local = socket.local_addr().map_err(listen)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(LinkError::Thread)?;
        let endpoint = {
            let _inside = runtime.enter();
            Endpoint::new(quic, server, socket, Arc::new(TokioRuntime)).map_err(listen)?
        };
        let (stop, stopped) = oneshot::channel();
        let theirs = Arc::clone(&shared);
        let thread = std::thread::Builder::new()
            .name("link".to_owned())
            .spawn(move || run(&runtime, &endpoint, &theirs, &clients, stopped))
            .map_err(LinkError::Thread)?;
        Ok(Self { shared, local, stop: Some(stop), thread: Some(thread) })
    }

    /// What this station's packets have to say they are of.
    #[must_use]
    pub fn session(&self) -> u32 {
        self.shared.session
    }

    /// Where the station is dialled.
    #[must_use]
    pub const fn local_address(&self) -> SocketAddr {
        self.local
    }

    /// Announces this station on the local network, where it can look others up or `discovery` was given.
    ///
    /// # Errors
    /// [`DiscoveryError`]
    pub fn announce(&self) -> Result<(), DiscoveryError> {
        match &self.shared.discovery {
            Some(discovery) => discovery.announce(&self.shared.name, self.local),
            None => Ok(()),
        }
    }

    /// The peer of that name.
    #[must_use]
    pub fn peer(&self, name: &StationName) -> Option<Peer> {
        self.peers().find(|peer| peer.name() == name)
    }

    /// The peers, as they were configured.
    pub fn peers(&self) -> impl Iterator<Item = Peer> {
        self.shared.peers.iter().map(|peer| Peer(Arc::clone(peer)))
    }

    /// Something to sleep on until a peer sends something, comes or goes.
    #[must_use]
    pub fn watch(&self) -> Watch {
        Watch::new(Arc::clone(&self.shared.news))
    }

    /// What rings when a peer sends something, comes or goes, for what else shall wake the station.
    #[must_use]
    pub fn doorbell(&self) -> Doorbell {
        Doorbell(Arc::clone(&self.shared.news))
    }

    /// What happened since this was last asked: a line each for the log.
    #[must_use]
    pub fn events(&self) -> Vec<LinkEvent> {
        self.shared.take_events()
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        if let Some(stop) = self.stop.take() {
            // where the thread has ended, nobody needs to be told
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl LinkConfig {
    /// The peers that are to be looked up on the local network.
    #[must_use]
    pub fn sought(&self) -> Vec<StationName> {
        let sought = self.peers.iter().filter(|peer| peer.address.as_deref() == Some(MDNS));
        sought.map(|peer| peer.name.clone()).collect()
    }

    /// Whether these peers can be told apart and reached; `own` is the station itself.
    ///
    /// # Errors
    /// [`LinkError::SameName`], [`LinkError::NoWay`]
    pub fn check(&self, own: &StationName) -> Result<(), LinkError> {
        let mut names: Vec<_> = self.peers.iter().map(|peer| &peer.name).chain([own]).collect();
        names.sort();
        if let Some(pair) = names.windows(2).find(|pair| pair.first() == pair.last())
            && let Some(name) = pair.first()
        {
            return Err(LinkError::SameName((*name).clone()));
        }
        let unreachable = self.peers.iter().find(|peer| peer.address.is_none());
        match unreachable.filter(|_| self.listen.is_none()) {
            Some(peer) => Err(LinkError::NoWay(peer.name.clone())),
            None => Ok(()),
        }
    }
}

struct Clients {
    motion: ClientConfig,
    pictures: ClientConfig,
}

fn client(
    identity: &Identity,
    lane: Lane,
    transport: &Arc<TransportConfig>,
) -> Result<ClientConfig, rustls::Error> {
    let mut config = ClientConfig::new(Arc::new(tls::client(identity, lane)?));
    config.transport_config(Arc::clone(transport));
    Ok(config)
}

/// The link's thread.
fn run(
    runtime: &Runtime,
    endpoint: &Endpoint,
    link: &Arc<LinkShared>,
    clients: &Clients,
    stopped: oneshot::Receiver<()>,
) {
    runtime.block_on(async {
        tokio::spawn(connect::accept(endpoint.clone(), Arc::clone(link)));
        for peer in &link.peers {
            let Some(address) = &peer.address else { continue };
            for lane in Lane::ALL {
                let config = match lane {
                    Lane::Motion => &clients.motion,
                    Lane::Pictures => &clients.pictures,
                };
                let (link, peer) = (Arc::clone(link), Arc::clone(peer));
                let dial = connect::dial(endpoint.clone(), config.clone(), lane, link, peer, address.clone());
                tokio::spawn(dial);
            }
        }
        // an error says that the link is dropped as well
        let _ = stopped.await;
        closing::Closing::Ends.close_all(endpoint);
        // a peer that cannot be told finds out by itself
        let _ = tokio::time::timeout(FAREWELL, endpoint.wait_idle()).await;
    });
}
