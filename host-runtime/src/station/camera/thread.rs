//! A camera of this computer on a thread of its own, for an operator in the same process.

use super::{CameraCounts, CameraHandle, CameraSink, CameraStation, Order, Step, Windows};
use crate::exit::Failure;
use crate::link::Received;
use crate::precedence::Tracking;
use crate::station::newest::Newest;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::wire::ObservationPacket;

/// What looks on at a camera, on the camera's thread. It keeps nobody waiting.
pub trait Onlooker: Send {
    /// It is lent each picture, with what was seen in it and where it was looked for.
    fn pictured(&mut self, picture: &FrameView<'_>, packet: &ObservationPacket, windows: &Windows);

    /// The camera was taught anew: the picture of that number, which is its next, is the first that is looked
    /// at so.
    fn taught(&mut self, _order: &Order, _from: u32, _now_us: u64) {}
}

/// A running [`CameraStation`]. Its observations come as those of another station do.
pub struct CameraThread {
    newest: Arc<Newest>,
    handle: CameraHandle,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<Ended>>,
}

type Ended = (CameraCounts, Result<(), Failure>);

impl CameraThread {
    /// Starts it; `ring` wakes the operator's loop whenever there are new observations, and the
    /// `onlookers` look on after that, one after the other.
    ///
    /// # Errors
    /// The system has no thread left.
    pub fn start(
        station: CameraStation,
        ring: impl Fn() + Send + 'static,
        onlookers: Vec<Box<dyn Onlooker>>,
    ) -> io::Result<Self> {
        let newest = Arc::new(Newest::default());
        let handle = station.handle();
        let stop = Arc::new(AtomicBool::new(false));
        let theirs = (Arc::clone(&newest), Arc::clone(&stop));
        let thread = std::thread::Builder::new()
            .name("camera".to_owned())
            .spawn(move || run(station, Place { newest: &theirs.0, ring: &ring, onlookers }, &theirs.1))?;
        Ok(Self { newest, handle, stop, thread: Some(thread) })
    }

    /// The newest observations, if they were not taken yet.
    #[must_use]
    pub fn observation(&self) -> Option<Received<ObservationPacket>> {
        self.newest.take()
    }

    /// Where it is asked for pictures and taught anew.
    #[must_use]
    pub const fn handle(&self) -> &CameraHandle {
        &self.handle
    }

    /// What the operator should know and was not told yet.
    #[must_use]
    pub fn take_notices(&self) -> Vec<String> {
        self.newest.notices()
    }

    /// Whether there will be no more observations: a recording is over, or cannot be read on.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Ends it, and gives what it has seen and why it ended before.
    ///
    /// # Panics
    /// Where the thread did.
    #[must_use = "what it has seen is told nowhere else"]
    pub fn end(mut self) -> (CameraCounts, Result<(), Failure>) {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            // it is taken here alone, and by value
            None => (CameraCounts::new(), Ok(())),
        }
    }
}

impl Drop for CameraThread {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Where the observations go, and the pictures.
struct Place<'a> {
    newest: &'a Newest,
    ring: &'a dyn Fn(),
    onlookers: Vec<Box<dyn Onlooker>>,
}

impl CameraSink for Place<'_> {
    fn observed(&mut self, packet: &ObservationPacket) {
        // it is here as soon as it is made
        let received_us = packet.capture_us + u64::from(packet.observed_us);
        self.newest.put(Received { what: *packet, received_us, captured_us: Some(packet.capture_us) });
        (self.ring)();
    }

    fn pictured(&mut self, picture: &FrameView<'_>, packet: &ObservationPacket, windows: &Windows) {
        for onlooker in &mut self.onlookers {
            onlooker.pictured(picture, packet, windows);
        }
    }

    fn taught(&mut self, order: &Order, from: u32, now_us: u64) {
        for onlooker in &mut self.onlookers {
            onlooker.taught(order, from, now_us);
        }
    }
}

fn run(mut station: CameraStation, mut place: Place<'_>, stop: &AtomicBool) -> Ended {
    let mut tracking = Tracking::begin();
    let mut ended = Ok(());
    while !stop.load(Ordering::Relaxed) {
        match station.step(&mut place) {
            Ok(Step::Observed) => {}
            Ok(Step::Lost(wait)) => std::thread::sleep(wait),
            Ok(Step::Ended) => break,
            Err(failure) => {
                ended = Err(failure);
                break;
            }
        }
        tracking.look();
        let notices = station.take_notices();
        if !notices.is_empty() {
            place.newest.tell(notices);
        }
    }
    station.handle.close();
    place.newest.tell(station.take_notices());
    (place.ring)();
    (station.counts.clone(), ended)
}
