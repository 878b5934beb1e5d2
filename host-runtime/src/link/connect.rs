//! How connections come to be: by being dialled, and by dialling.

use super::closing::{Closing, in_words};
use super::discovery::MDNS;
use super::event::LinkEvent;
use super::peer::PeerShared;
use super::shared::LinkShared;
use super::tls::{Lane, peer_name};
use super::{pictures, session};
use quinn::{ClientConfig, Connection, Endpoint, Incoming};
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

/// Handshakes at a time; what comes meanwhile is not answered.
const HANDSHAKES: usize = 32;

/// From so many on, whoever dials must show that it gets what is sent to its address.
const HANDSHAKES_WITHOUT_PROOF: usize = 8;

/// A handshake is to be over within this.
const HANDSHAKE: Duration = Duration::from_secs(5);

/// Between two attempts: doubled each time, from and to.
const BACK_OFF: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));

/// Takes those who dial, for ever.
pub(super) async fn accept(endpoint: Endpoint, link: Arc<LinkShared>) {
    let handshakes = Arc::new(Semaphore::new(HANDSHAKES));
    while let Some(incoming) = endpoint.accept().await {
        let Ok(place) = Arc::clone(&handshakes).try_acquire_owned() else {
            incoming.ignore();
            continue;
        };
        let many = HANDSHAKES - handshakes.available_permits() > HANDSHAKES_WITHOUT_PROOF;
        if many && !incoming.remote_address_validated() && incoming.may_retry() {
            // it may have gone away meanwhile: then there is nobody to tell
            let _ = incoming.retry();
            continue;
        }
        let link = Arc::clone(&link);
        tokio::spawn(async move {
            let address = incoming.remote_address();
            match timeout(HANDSHAKE, shake_hands(incoming, &link)).await {
                Ok(Ok((connection, lane, peer))) => {
                    drop(place);
                    carry(&connection, lane, &link, &peer).await;
                }
                Ok(Err(reason)) => link.refuse(address, reason),
                Err(_) => {
                    let reason = "it did not finish the handshake".to_owned();
                    link.refuse(address, reason);
                }
            }
        });
    }
}

async fn shake_hands(
    incoming: Incoming,
    link: &LinkShared,
) -> Result<(Connection, Lane, Arc<PeerShared>), String> {
    let connection = incoming.await.map_err(|error| in_words(&error))?;
    // the handshake let only named peers through, so this is for what is not foreseen
    let name = peer_name(&connection, link.peers.iter().map(|peer| &peer.name));
    let known = name.and_then(|name| link.peers.iter().find(|peer| peer.name == *name));
    let (Some(peer), Some(lane)) = (known, Lane::of(&connection)) else {
        Closing::Stranger.close(&connection);
        return Err(Closing::Stranger.text().to_owned());
    };
    if peer.address.is_some() && link.name < peer.name && peer.has(lane) {
        Closing::Dialled.close(&connection);
        return Err(Closing::Dialled.text().to_owned());
    }
    Ok((connection, lane, Arc::clone(peer)))
}

/// Carries what the connection is for until it ends; whether the peer was there.
async fn carry(connection: &Connection, lane: Lane, link: &LinkShared, peer: &Arc<PeerShared>) -> Carried {
    if lane == Lane::Pictures {
        let reason = pictures::run(connection, peer, link.picture_bytes_per_s).await;
        // one that is turned away has no connection for motion either
        return Carried { greeted: peer.has(Lane::Motion), reason };
    }
    let greeted = AtomicBool::new(false);
    let ended = session::run(connection, link, peer, || {
        greeted.store(true, Ordering::Relaxed);
        let address = connection.remote_address();
        link.tell(LinkEvent::Connected { peer: peer.name.clone(), address });
    })
    .await;
    let carried = Carried { greeted: greeted.into_inner(), reason: ended.in_words() };
    let reason = carried.reason.clone();
    if carried.greeted {
        link.tell(LinkEvent::Lost { peer: peer.name.clone(), reason });
    } else if connection.side() == quinn::Side::Server {
        link.refuse(connection.remote_address(), reason);
    }
    carried
}

struct Carried {
    greeted: bool,
    reason: String,
}

/// Dials a peer again and again, for ever.
pub(super) async fn dial(
    endpoint: Endpoint,
    config: ClientConfig,
    lane: Lane,
    link: Arc<LinkShared>,
    peer: Arc<PeerShared>,
    address: String,
) {
    let (shortest, longest) = BACK_OFF;
    let mut back_off = shortest;
    let mut told = None;
    for attempt in 0.. {
        while peer.has(lane) {
            // it has dialled itself
            sleep(longest).await;
        }
        let reason =
            match timeout(HANDSHAKE, reach(&endpoint, &config, (&link, &peer), (&address, attempt))).await {
                Ok(Ok(connection)) => {
                    let carried = carry(&connection, lane, &link, &peer).await;
                    if carried.greeted {
                        back_off = shortest;
                        told = None;
                    }
                    (!carried.greeted).then_some(carried.reason)
                }
                Ok(Err(reason)) => Some(reason),
                Err(_) => Some("no answer".to_owned()),
            };
        if let Some(reason) = reason.filter(|_| lane == Lane::Motion)
            && told.as_ref() != Some(&reason)
        {
            told = Some(reason.clone());
            link.tell(LinkEvent::NotReached { peer: peer.name.clone(), address: address.clone(), reason });
        }
        sleep(back_off).await;
        back_off = (2 * back_off).min(longest);
    }
}

async fn reach(
    endpoint: &Endpoint,
    config: &ClientConfig,
    (link, peer): (&LinkShared, &PeerShared),
    (address, attempt): (&str, usize),
) -> Result<Connection, String> {
    let local = endpoint.local_addr().map_err(|error| error.to_string())?;
    let remote = match &link.discovery {
        Some(discovery) if address == MDNS => {
            let announced = discovery.address(&peer.name, attempt, local.is_ipv4());
            announced.ok_or_else(|| "nobody on this network has announced it yet".to_owned())?
        }
        _ => resolve(address, local).await?,
    };
    let connecting = endpoint
        .connect_with(config.clone(), remote, peer.name.as_str())
        .map_err(|error| error.to_string())?;
    connecting.await.map_err(|error| in_words(&error))
}

async fn resolve(address: &str, local: SocketAddr) -> Result<SocketAddr, String> {
    let resolved = tokio::net::lookup_host(address).await.map_err(|error| error.to_string())?;
    let same_family = |remote: &SocketAddr| remote.is_ipv4() == local.is_ipv4();
    resolved.into_iter().find(same_family).ok_or_else(|| {
        let family = if local.is_ipv4() { "IPv4" } else { "IPv6" };
        format!("it has no {family} address, and this station listens on {local}")
    })
}
