//! One peer, as both sides of the lock see it: the station's loop and the thread of the network.

use super::carrier::Carrier;
use super::clock::ClockEstimate;
use super::closing::Closing;
use super::gate::Gate;
use super::inbox::{CAMERAS, Inbox, InboxCounts, Received};
use super::message::MAX_CONFIGURATION;
use super::name::StationName;
use super::news::News;
use super::outbox::{Outbox, OutboxCounts, PACKETS};
use super::picture::{Picture, PictureError};
use super::tls::Lane;
use crate::locked::lock;
use crate::robot::clock::Clock;
use quinn::{Connection, Side};
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard};
use tetrad_core::wire::{EncodeError, Packet};
use tokio::sync::watch;

/// Whether two connections that a peer has dialled come from two sockets.
fn are_of_two(one: &Connection, other: &Connection) -> bool {
    let dialled_there = |connection: &Connection| connection.side() == Side::Server;
    dialled_there(one) && dialled_there(other) && one.remote_address() != other.remote_address()
}

/// A peer of this station. Clones are the same peer. No call waits.
#[derive(Clone, Debug)]
pub struct Peer(pub(super) Arc<PeerShared>);

#[derive(Debug)]
pub(super) struct PeerShared {
    pub(super) name: StationName,
    pub(super) address: Option<String>,
    pub(super) outbox: Outbox<PACKETS>,
    pub(super) pictures: Outbox<CAMERAS>,
    pub(super) configuration: watch::Sender<Option<Arc<[u8]>>>,
    state: Mutex<PeerState>,
    news: Arc<News>,
    clock: Clock,
}

#[derive(Debug, Default)]
pub(super) struct PeerState {
    pub(super) inbox: Inbox,
    connections: [Option<Connection>; 2],
    /// How often the peer was connected.
    connected: u32,
    pictures: [Option<Received<Picture>>; CAMERAS],
    /// The session that the gates' numbers are of.
    pictures_of: Option<u32>,
    picture_gates: [Gate; CAMERAS],
    pictures_taken: u64,
    configuration: Option<Vec<u8>>,
}

/// What is known of the link to one peer.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkStats {
    /// Where the peer is; `None` while it is not connected.
    pub address: Option<SocketAddr>,
    /// How often it was connected.
    pub connected: u32,
    /// When the last packet that counts came, this station's clock, microseconds.
    pub heard_us: Option<u64>,
    /// The way there and back, smoothed by QUIC, microseconds.
    pub round_trip_us: Option<u64>,
    /// The peer's clock.
    pub clock: Option<ClockEstimate>,
    /// What became of the packets that came.
    pub received: InboxCounts,
    /// What became of the packets that were to be sent.
    pub sent: OutboxCounts,
    /// QUIC packets that did not arrive there, of those in the next.
    pub lost_packets: u64,
    /// QUIC packets that were sent on this connection.
    pub sent_packets: u64,
    /// Pictures that came.
    pub pictures_received: u64,
    /// What became of the pictures that were to be sent.
    pub pictures_sent: OutboxCounts,
}

/// Why a configuration is not sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a configuration of {0} bytes is too long: at most {MAX_CONFIGURATION}")]
pub struct ConfigurationTooLong(usize);

impl Peer {
    /// The peer's name.
    #[must_use]
    pub fn name(&self) -> &StationName {
        &self.0.name
    }

    /// Whether the peer is there.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.0.has(Lane::Motion)
    }

    /// Hands over a picture. Where one of its camera waits, it goes in its place. What is sent has at
    /// most the rate the link was given.
    ///
    /// # Errors
    /// [`PictureError::TooLong`]
    pub fn send_picture(&self, picture: &Picture) -> Result<(), PictureError> {
        self.0.pictures.put(usize::from(picture.camera), picture.encode()?.into());
        Ok(())
    }

    /// The newest picture of a camera, if it was not taken yet.
    #[must_use]
    pub fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        self.0.lock().pictures.get_mut(usize::from(camera))?.take()
    }

    /// What the peer shall know from now on. It is told again whenever it comes back.
    ///
    /// # Errors
    /// [`ConfigurationTooLong`]
    pub fn set_configuration(&self, configuration: &[u8]) -> Result<(), ConfigurationTooLong> {
        if configuration.len() > MAX_CONFIGURATION {
            return Err(ConfigurationTooLong(configuration.len()));
        }
        self.0.configuration.send_replace(Some(configuration.into()));
        Ok(())
    }

    /// What the peer wants this station to know, if it was not taken yet.
    #[must_use]
    pub fn configuration(&self) -> Option<Vec<u8>> {
        self.0.lock().configuration.take()
    }

    /// What is known of the link.
    #[must_use]
    pub fn stats(&self) -> LinkStats {
        let now_us = self.0.clock.now_us();
        let state = self.0.lock();
        let connection = state.connections[Lane::Motion as usize].as_ref();
        let path = connection.map(|connection| connection.stats().path);
        let micros = |rtt: std::time::Duration| u64::try_from(rtt.as_micros()).unwrap_or(u64::MAX);
        LinkStats {
            address: connection.map(Connection::remote_address),
            connected: state.connected,
            heard_us: state.inbox.heard_us(),
            round_trip_us: path.map(|path| micros(path.rtt)),
            clock: state.inbox.clock.at(now_us),
            received: state.inbox.counts(),
            sent: self.0.outbox.counts(),
            lost_packets: path.map_or(0, |path| path.lost_packets),
            sent_packets: path.map_or(0, |path| path.sent_packets),
            pictures_received: state.pictures_taken,
            pictures_sent: self.0.pictures.counts(),
        }
    }
}

impl Carrier for Peer {
    fn send(&self, packet: &Packet) -> Result<(), EncodeError> {
        self.0.outbox.put_packet(packet)
    }

    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R {
        look(&mut self.0.lock().inbox)
    }

    fn send_picture(&self, picture: Picture) {
        // the file of a camera of ours is far below the longest
        let _ = Self::send_picture(self, &picture);
    }

    fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        Self::picture(self, camera)
    }

    fn tell_configuration(&self, configuration: &[u8]) {
        let _ = self.set_configuration(configuration);
    }

    fn configuration(&self) -> Option<Vec<u8>> {
        Self::configuration(self)
    }
}

impl PeerShared {
    pub(super) fn new(name: StationName, address: Option<String>, news: Arc<News>, clock: Clock) -> Self {
        Self {
            name,
            address,
            outbox: Outbox::default(),
            pictures: Outbox::default(),
            configuration: watch::Sender::new(None),
            state: Mutex::default(),
            news,
            clock,
        }
    }

    pub(super) fn lock(&self) -> MutexGuard<'_, PeerState> {
        lock(&self.state)
    }

    /// Whether there is a connection for this.
    pub(super) fn has(&self, lane: Lane) -> bool {
        self.lock().connections[lane as usize].is_some()
    }

    /// The connection of the peer as it is now, where that is another session than this.
    pub(super) fn connected_as_another(&self, session: u32) -> Option<Connection> {
        let state = self.lock();
        let connection = state.connections[Lane::Motion as usize].as_ref();
        connection.filter(|_| state.inbox.session() != Some(session)).cloned()
    }

    /// Whether a connection for pictures is of another process of this peer's name than the one that is
    /// there. Both that a process has dialled come from its one socket.
    pub(super) fn is_beside_another(&self, pictures: &Connection) -> bool {
        let state = self.lock();
        let motion = state.connections[Lane::Motion as usize].as_ref();
        motion.is_some_and(|motion| are_of_two(motion, pictures))
    }

    /// A datagram has come. What is not a packet to be used is counted and dropped.
    pub(super) fn take_datagram(&self, body: &[u8]) {
        let now_us = self.clock.now_us();
        if self.lock().inbox.take(body, now_us).is_ok() {
            self.news.ring();
        }
    }

    /// A picture has come. Older ones than the last are dropped, as are those of another session.
    pub(super) fn take_picture(&self, picture: Picture) {
        let now_us = self.clock.now_us();
        let mut state = self.lock();
        if state.inbox.session() != Some(picture.session) {
            return;
        }
        let captured_us = state.inbox.clock.here_us(picture.capture_us, now_us);
        let camera = usize::from(picture.camera);
        if state.pictures_of != Some(picture.session) {
            state.pictures_of = Some(picture.session);
            state.picture_gates = [Gate::default(); CAMERAS];
        }
        if state.picture_gates.get_mut(camera).is_none_or(|gate| gate.admit(picture.sequence).is_err()) {
            return;
        }
        if let Some(slot) = state.pictures.get_mut(camera) {
            *slot = Some(Received { what: picture, received_us: now_us, captured_us });
        }
        state.pictures_taken += 1;
        drop(state);
        self.news.ring();
    }

    pub(super) fn take_configuration(&self, configuration: Vec<u8>) {
        self.lock().configuration = Some(configuration);
        self.news.ring();
    }

    /// A connection is ready. One that was there before is ended: the peer would not have made
    /// another if it still heard that one.
    pub(super) fn connect(&self, lane: Lane, connection: &Connection) {
        let mut state = self.lock();
        if lane == Lane::Motion {
            state.connected += 1;
        }
        let before = state.connections[lane as usize].replace(connection.clone());
        let pictures = &mut state.connections[Lane::Pictures as usize];
        let of_another =
            pictures.take_if(|pictures| lane == Lane::Motion && are_of_two(connection, pictures));
        drop(state);
        before.iter().chain(&of_another).for_each(|replaced| Closing::Replaced.close(replaced));
        self.news.ring();
    }

    /// A connection has ended; whether it was the current one.
    pub(super) fn disconnect(&self, lane: Lane, connection: &Connection) -> bool {
        let mut state = self.lock();
        let slot = &mut state.connections[lane as usize];
        let current = slot.as_ref().is_some_and(|current| current.stable_id() == connection.stable_id());
        if current {
            *slot = None;
        }
        drop(state);
        self.news.ring();
        current
    }
}
