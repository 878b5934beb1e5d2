//! Where a thread leaves the newest observations of its camera for the operator's loop.

use crate::link::Received;
use crate::locked::lock;
use std::sync::{Mutex, MutexGuard};
use tetrad_core::wire::ObservationPacket;

/// Lines that wait to be told; a reader that does not ask loses the oldest.
const MOST_NOTICES: usize = 100;

/// The newest observations that were not taken yet, and what there is to tell.
#[derive(Debug, Default)]
pub(super) struct Newest(Mutex<State>);

#[derive(Debug, Default)]
struct State {
    observation: Option<Received<ObservationPacket>>,
    notices: Vec<String>,
}

impl Newest {
    pub(super) fn put(&self, observation: Received<ObservationPacket>) {
        self.lock().observation = Some(observation);
    }

    pub(super) fn take(&self) -> Option<Received<ObservationPacket>> {
        self.lock().observation.take()
    }

    pub(super) fn tell(&self, notices: impl IntoIterator<Item = String>) {
        let mut state = self.lock();
        state.notices.extend(notices);
        let over = state.notices.len().saturating_sub(MOST_NOTICES);
        state.notices.drain(..over);
    }

    pub(super) fn notices(&self) -> Vec<String> {
        std::mem::take(&mut self.lock().notices)
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        lock(&self.0)
    }
}
