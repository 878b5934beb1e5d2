//! What the thread of the network and the station's loops share.

use super::discovery::Discovery;
use super::event::LinkEvent;
use super::name::StationName;
use super::news::News;
use super::peer::PeerShared;
use super::refusals::Refusals;
use crate::robot::clock::Clock;
use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, PoisonError};

/// Events that nobody has looked at yet; the oldest go first, so that a flood costs no memory.
const EVENTS: usize = 64;

/// Sessions whose owner is remembered; a peer that comes anew each second fills them in an hour.
const SESSIONS: usize = 4096;

#[derive(Debug)]
pub(super) struct LinkShared {
    pub(super) name: StationName,
    /// What this station's packets are of.
    pub(super) session: u32,
    pub(super) clock: Clock,
    pub(super) picture_bytes_per_s: u32,
    pub(super) peers: Vec<Arc<PeerShared>>,
    pub(super) news: Arc<News>,
    /// What looks peers up on the local network.
    pub(super) discovery: Option<Discovery>,
    events: Mutex<VecDeque<LinkEvent>>,
    sessions: Mutex<VecDeque<(u32, StationName)>>,
    refusals: Mutex<Refusals>,
}

impl LinkShared {
    pub(super) fn new(
        name: StationName,
        session: u32,
        clock: Clock,
        picture_bytes_per_s: u32,
        peers: Vec<Arc<PeerShared>>,
        news: Arc<News>,
    ) -> Self {
        Self {
            name,
            session,
            clock,
            picture_bytes_per_s,
            peers,
            news,
            discovery: None,
            events: Mutex::default(),
            sessions: Mutex::default(),
            refusals: Mutex::default(),
        }
    }

    /// A session belongs to the first who says it is of it; whether that is this peer.
    pub(super) fn claim(&self, session: u32, peer: &StationName) -> bool {
        if session == self.session {
            return false;
        }
        let mut sessions = self.sessions.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, owner)) = sessions.iter().find(|(claimed, _)| *claimed == session) {
            return owner == peer;
        }
        if sessions.len() >= SESSIONS {
            sessions.pop_front();
        }
        sessions.push_back((session, peer.clone()));
        true
    }

    pub(super) fn tell(&self, event: LinkEvent) {
        match &event {
            LinkEvent::Connected { .. } => tracing::info!("{event}"),
            _ => tracing::warn!("{event}"),
        }
        let mut events = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        if events.len() >= EVENTS {
            events.pop_front();
        }
        events.push_back(event);
        drop(events);
        self.news.ring();
    }

    /// Somebody was turned away.
    pub(super) fn refuse(&self, address: SocketAddr, reason: String) {
        let now_us = self.clock.now_us();
        let mut refusals = self.refusals.lock().unwrap_or_else(PoisonError::into_inner);
        let told = refusals.tell(address.ip(), &reason, now_us);
        drop(refusals);
        if let Some(untold) = told {
            self.tell(LinkEvent::Refused { address, reason, untold });
        }
    }

    pub(super) fn take_events(&self) -> Vec<LinkEvent> {
        self.events.lock().unwrap_or_else(PoisonError::into_inner).drain(..).collect()
    }
}
