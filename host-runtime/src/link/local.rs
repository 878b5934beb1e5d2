//! Two stations in one process: what a [`Peer`](super::Peer) does over a network, without one.
//!
//! The same inbox decides what counts, and of each kind only the newest stays. Both ends have one
//! clock, so that when something was captured is known from the first packet on.

use super::carrier::Carrier;
use super::gate::Gate;
use super::inbox::{CAMERAS, EndedSession, Inbox, Received};
use super::news::Doorbell;
use super::picture::Picture;
use crate::locked::lock;
use crate::robot::clock::Clock;
use std::sync::{Arc, Mutex, MutexGuard};
use tetrad_core::wire::{EncodeError, MAX_BODY_LEN, Packet, encode_body};

/// One end of a link within a process. Clones are the same end; it may go to another thread.
#[derive(Clone, Debug)]
pub struct LocalEnd {
    here: Arc<Side>,
    there: Arc<Side>,
    clock: Clock,
}

#[derive(Debug)]
struct Side {
    state: Mutex<SideState>,
    bell: Doorbell,
}

#[derive(Debug, Default)]
struct SideState {
    inbox: Inbox,
    pictures: [Option<Received<Picture>>; CAMERAS],
    gates: [Gate; CAMERAS],
    configuration: Option<Vec<u8>>,
}

/// Two ends. What comes to an end rings its bell; sessions are those that the ends' packets will say
/// they are of.
#[must_use]
pub fn pair(clock: &Clock, bells: [Doorbell; 2], sessions: [u32; 2]) -> [LocalEnd; 2] {
    let [first, second] = bells.map(|bell| {
        let mut inbox = Inbox::default();
        inbox.share_clock();
        let state = SideState { inbox, ..SideState::default() };
        Arc::new(Side { state: Mutex::new(state), bell })
    });
    let [of_first, of_second] = sessions;
    let end = |here: &Arc<Side>, there: &Arc<Side>| LocalEnd {
        here: Arc::clone(here),
        there: Arc::clone(there),
        clock: clock.clone(),
    };
    let ends = [end(&first, &second), end(&second, &first)];
    // an inbox that has heard of no session takes any
    let _ = first.lock().begin(of_second);
    let _ = second.lock().begin(of_first);
    ends
}

impl LocalEnd {
    /// The other end has begun anew: its packets are of this session.
    ///
    /// # Errors
    /// [`EndedSession`]
    pub fn begin(&self, session: u32) -> Result<(), EndedSession> {
        self.here.lock().begin(session)
    }
}

impl Carrier for LocalEnd {
    fn send(&self, packet: &Packet) -> Result<(), EncodeError> {
        let mut body = [0; MAX_BODY_LEN];
        // over the wire as anywhere else
        let length = encode_body(packet, &mut body)?;
        let now_us = self.clock.now_us();
        let taken = self.there.lock().inbox.take(body.get(..length).unwrap_or_default(), now_us);
        if taken.is_ok() {
            self.there.bell.ring();
        }
        Ok(())
    }

    fn with_inbox<R>(&self, look: impl FnOnce(&mut Inbox) -> R) -> R {
        look(&mut self.here.lock().inbox)
    }

    fn send_picture(&self, picture: Picture) {
        self.there.take_picture(picture, self.clock.now_us());
    }

    fn picture(&self, camera: u8) -> Option<Received<Picture>> {
        self.here.lock().pictures.get_mut(usize::from(camera))?.take()
    }

    fn tell_configuration(&self, configuration: &[u8]) {
        self.there.lock().configuration = Some(configuration.to_vec());
        self.there.bell.ring();
    }

    fn configuration(&self) -> Option<Vec<u8>> {
        self.here.lock().configuration.take()
    }
}

impl SideState {
    fn begin(&mut self, session: u32) -> Result<(), EndedSession> {
        let before = self.inbox.session();
        self.inbox.begin(session)?;
        if before != Some(session) {
            self.inbox.share_clock();
            (self.gates, self.pictures) = Default::default();
        }
        Ok(())
    }
}

impl Side {
    fn lock(&self) -> MutexGuard<'_, SideState> {
        lock(&self.state)
    }

    fn take_picture(&self, picture: Picture, now_us: u64) {
        let mut state = self.lock();
        let camera = usize::from(picture.camera);
        if state.inbox.session() != Some(picture.session)
            || state.gates.get_mut(camera).is_none_or(|gate| gate.admit(picture.sequence).is_err())
        {
            return;
        }
        let captured_us = Some(picture.capture_us);
        if let Some(slot) = state.pictures.get_mut(camera) {
            *slot = Some(Received { what: picture, received_us: now_us, captured_us });
        }
        drop(state);
        self.bell.ring();
    }
}

#[cfg(test)]
mod tests {
    use super::super::test_packets::{motion, observation};
    use super::*;
    use std::time::Duration;

    fn picture(session: u32, sequence: u32) -> Picture {
        let (width, height, jpeg) = (2, 2, vec![1, 2, 3]);
        Picture { camera: 1, session, sequence, capture_us: 30, width, height, jpeg }
    }

    #[test]
    fn the_newest_comes_to_the_other_end_by_one_clock_and_rings() {
        let clock = Clock::given();
        let bell = Doorbell::default();
        let [camera, operator] = pair(&clock, [Doorbell::default(), bell.clone()], [7, 8]);
        let mut watch = bell.watch();
        assert!(!watch.wait(Duration::ZERO));
        clock.set(50);
        camera.send(&observation(7, 1, 0)).unwrap();
        camera.send(&observation(7, 2, 0)).unwrap();
        assert!(watch.wait(Duration::ZERO));
        let came = operator.observation(0).unwrap();
        assert_eq!((came.what.sequence, came.received_us), (2, 50));
        assert_eq!(came.captured_us, Some(came.what.capture_us));
        assert_eq!(operator.observation(0), None);
        camera.send(&motion(9, 1)).unwrap();
        assert_eq!(operator.motion(), None, "of another session than the end was made for");
        assert_eq!(camera.observation(0), None);
    }

    #[test]
    fn pictures_and_configurations_come_once_and_never_go_back() {
        let clock = Clock::given();
        let [slave, operator] = pair(&clock, [Doorbell::default(), Doorbell::default()], [7, 8]);
        slave.send_picture(picture(7, 5));
        slave.send_picture(picture(7, 4));
        slave.send_picture(picture(6, 9));
        assert_eq!(operator.picture(1).unwrap().what.sequence, 5);
        assert_eq!((operator.picture(1), operator.picture(0)), (None, None));
        slave.tell_configuration(b"sim:");
        assert_eq!(operator.configuration().as_deref(), Some(&b"sim:"[..]));
        assert_eq!(operator.configuration(), None);
    }

    #[test]
    fn an_end_that_begins_anew_is_heard_and_its_old_session_is_not() {
        let clock = Clock::given();
        let [camera, operator] = pair(&clock, [Doorbell::default(), Doorbell::default()], [7, 8]);
        camera.send(&observation(7, 9, 0)).unwrap();
        operator.begin(70).unwrap();
        assert_eq!(operator.observation(0), None);
        camera.send(&observation(70, 0, 0)).unwrap();
        camera.send(&observation(7, 10, 0)).unwrap();
        let came = operator.observation(0).unwrap();
        assert_eq!((came.what.session, came.captured_us), (70, Some(came.what.capture_us)));
    }
}
