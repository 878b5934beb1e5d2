//! What is asked of a camera at work: a whole picture, and other colours to look for.
//!
//! The camera's thread looks at one flag a picture. Whoever asks is called back there, and never holds it
//! up.

use crate::locked::lock;
use crate::pipeline::{CameraStart, tracker_of};
use std::collections::VecDeque;
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use tetrad_core::config::TrackerConfig;
use tetrad_core::observation::BALLS;
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::frame::{FrameError, FrameView, PixelFormat};
use tetrad_core::vision::tracker::{CameraTracker, TrackerError};
use tetrad_core::wire::ObservationPacket;

/// So many may wait for a picture at once; one more sends away the one that has waited longest.
const MOST_GRABS: usize = 16;

/// The balls of a camera, ordered as [`tetrad_core::observation::Ball::ALL`].
pub type Taught = [Option<LearntBall>; BALLS];

/// What a camera looks for from a picture on: everything that its tracker begins with then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// The balls, which are anywhere.
    pub balls: Taught,
    /// How they are tracked.
    pub config: TrackerConfig,
}

/// Called on the camera's thread with its next picture: it hands it on, and does nothing else there.
pub type Grab = Box<dyn FnOnce(Arc<Still>) + Send>;

/// A picture as the tracker had it, every pixel.
#[derive(Clone)]
pub struct Still {
    bytes: Vec<u8>,
    stride: usize,
    format: PixelFormat,
    size: (u16, u16),
    /// What was seen in it.
    pub packet: ObservationPacket,
}

impl Still {
    /// A copy.
    #[must_use]
    pub fn of(picture: &FrameView<'_>, packet: &ObservationPacket) -> Self {
        Self {
            bytes: picture.data().to_vec(),
            stride: picture.stride(),
            format: picture.format(),
            size: (picture.width(), picture.height()),
            packet: *packet,
        }
    }

    /// Width and height, pixels.
    #[must_use]
    pub const fn size(&self) -> (u16, u16) {
        self.size
    }

    /// The picture.
    ///
    /// # Errors
    /// None where it is a copy of a picture.
    pub fn view(&self) -> Result<FrameView<'_>, FrameError> {
        let (width, height) = self.size;
        FrameView::new(&self.bytes, width, height, self.stride, self.format)
    }
}

impl fmt::Debug for Still {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (width, height) = self.size;
        write!(f, "Still({width}x{height}, {:?})", self.format)
    }
}

/// Asks a camera at work for a whole picture, or to look for other colours. Clones ask the same camera.
#[derive(Clone)]
pub struct CameraHandle(Arc<Shared>);

struct Shared {
    /// Whether there is anything in `asks`.
    asked: AtomicBool,
    config: TrackerConfig,
    size: (u16, u16),
    asks: Mutex<Asks>,
}

struct Asks {
    /// What it looks for.
    taught: Taught,
    /// What it is to look for from its next picture on.
    order: Option<Taught>,
    grabs: VecDeque<Grab>,
    /// There will be no more pictures.
    over: bool,
}

impl CameraHandle {
    pub(super) fn new(config: TrackerConfig, start: &CameraStart, size: (u16, u16)) -> Self {
        let asks = Asks { taught: start.balls, order: None, grabs: VecDeque::new(), over: false };
        Self(Arc::new(Shared { asked: AtomicBool::new(false), config, size, asks: Mutex::new(asks) }))
    }

    /// Width and height of its pictures when it was opened, pixels.
    #[must_use]
    pub fn size(&self) -> (u16, u16) {
        self.0.size
    }

    /// What it looks for, or will from its next picture on.
    #[must_use]
    pub fn taught(&self) -> Taught {
        self.lock().taught
    }

    /// Whether these balls can be tracked.
    ///
    /// # Errors
    /// [`TrackerError`] naming the ball.
    pub fn check(&self, balls: &Taught) -> Result<(), TrackerError> {
        self.order(balls).tracker().map(drop)
    }

    /// It looks for these balls from its next picture on, and everywhere in it.
    ///
    /// # Errors
    /// [`TrackerError`] naming the ball; it goes on as before.
    pub fn teach(&self, balls: &Taught) -> Result<(), TrackerError> {
        self.check(balls)?;
        let mut asks = self.lock();
        (asks.taught, asks.order) = (*balls, Some(*balls));
        self.0.asked.store(true, Ordering::Release);
        Ok(())
    }

    /// Asks for its next picture, which is one that was looked at as it was taught before. Where there is
    /// none, or too many wait, `grab` is dropped without a call.
    pub fn grab(&self, grab: Grab) {
        let mut asks = self.lock();
        if asks.over {
            return;
        }
        if asks.grabs.len() >= MOST_GRABS {
            asks.grabs.pop_front();
        }
        asks.grabs.push_back(grab);
        self.0.asked.store(true, Ordering::Release);
    }

    /// There will be no more pictures: nobody waits for one any longer.
    pub(super) fn close(&self) {
        let mut asks = self.lock();
        asks.over = true;
        asks.grabs.clear();
    }

    /// What it is to look for from now on, and its tracker, where it was taught anew.
    pub(super) fn take_order(&self) -> Option<(Order, CameraTracker)> {
        if !self.0.asked.load(Ordering::Acquire) {
            return None;
        }
        let order = self.order(&self.lock().order.take()?);
        // it was checked when it was given
        order.tracker().ok().map(|tracker| (order, tracker))
    }

    /// Hands the picture to those who wait for one.
    pub(super) fn serve(&self, picture: &FrameView<'_>, packet: &ObservationPacket) {
        if !self.0.asked.load(Ordering::Acquire) {
            return;
        }
        let grabs = {
            let mut asks = self.lock();
            self.0.asked.store(asks.order.is_some(), Ordering::Release);
            std::mem::take(&mut asks.grabs)
        };
        if !grabs.is_empty() {
            let still = Arc::new(Still::of(picture, packet));
            grabs.into_iter().for_each(|grab| grab(Arc::clone(&still)));
        }
    }

    fn order(&self, balls: &Taught) -> Order {
        let rigid = balls.iter().all(Option::is_some);
        Order { balls: *balls, config: TrackerConfig { rigid, ..self.0.config } }
    }

    fn lock(&self) -> MutexGuard<'_, Asks> {
        lock(&self.0.asks)
    }
}

impl Order {
    /// The tracker that begins so, live and in a replay.
    ///
    /// # Errors
    /// [`TrackerError`] naming the ball.
    pub fn tracker(&self) -> Result<CameraTracker, TrackerError> {
        tracker_of(self.config, &CameraStart::anywhere(self.balls))
    }
}

impl fmt::Debug for CameraHandle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CameraHandle").field("size", &self.0.size).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use tetrad_core::observation::Ball;
    use tetrad_core::vision::colour::{Primary, Reference};
    use tetrad_core::vision::frame::Rgb;
    use tetrad_fixtures::packets;

    const RED: LearntBall = LearntBall {
        reference: Reference {
            primary: Primary::Red,
            reference: Rgb::new(200, 30, 30),
            typical: Rgb::new(190, 40, 40),
            background: Rgb::new(90, 90, 90),
        },
        diameter: 20.0,
        aspect: 1.0,
    };

    fn handle() -> CameraHandle {
        CameraHandle::new(
            TrackerConfig::paper(),
            &CameraStart::anywhere([Some(RED), None, None, None]),
            (4, 2),
        )
    }

    #[test]
    fn whoever_asks_gets_the_next_picture_once() {
        let handle = handle();
        let bytes: Vec<u8> = (0..4 * 2 * 3).collect();
        let picture = FrameView::packed(&bytes, 4, 2, PixelFormat::Rgb888).unwrap();
        let packet = packets::observation(1, 2);
        handle.serve(&picture, &packet);
        let (send, sent) = mpsc::channel();
        handle.grab(Box::new(|_| panic!("it is one too many, and has waited longest")));
        for _ in 0..MOST_GRABS {
            let send = send.clone();
            handle.grab(Box::new(move |still| send.send(still).unwrap()));
        }
        handle.serve(&picture, &packet);
        handle.serve(&picture, &packet);
        drop(send);
        let stills: Vec<_> = sent.iter().collect();
        assert_eq!(stills.len(), MOST_GRABS);
        assert_eq!((stills[0].size(), stills[0].packet), ((4, 2), packet));
        assert_eq!(stills[0].view().unwrap().data(), bytes);
    }

    #[test]
    fn an_order_is_taken_once_and_one_that_cannot_be_tracked_is_refused() {
        let handle = handle();
        assert!(handle.take_order().is_none());
        let too_large = LearntBall { diameter: 1e6, ..RED };
        let error = handle.teach(&[Some(too_large), None, None, None]).unwrap_err();
        assert!(error.to_string().starts_with("red: "), "{error}");
        assert_eq!(handle.taught()[0], Some(RED));
        let smaller = [Some(LearntBall { diameter: 9.0, ..RED }), None, None, None];
        handle.teach(&smaller).unwrap();
        assert_eq!(handle.taught(), smaller);
        let (order, tracker) = handle.take_order().expect("a tracker");
        assert_eq!(order.balls, smaller);
        assert!(!order.config.rigid, "one ball is no frame");
        assert_eq!(tracker.reference(Ball::Red), Some(RED.reference));
        assert!(handle.take_order().is_none());
    }

    #[test]
    fn nobody_waits_for_a_camera_that_is_over() {
        let handle = handle();
        let (send, sent) = mpsc::channel::<Arc<Still>>();
        let before = send.clone();
        handle.grab(Box::new(move |still| before.send(still).unwrap()));
        handle.close();
        handle.grab(Box::new(move |still| send.send(still).unwrap()));
        assert!(sent.recv().is_err(), "both are sent away");
    }

    #[test]
    fn an_order_is_not_forgotten_over_a_picture() {
        let handle = handle();
        handle.teach(&[Some(RED), None, None, None]).unwrap();
        let picture = FrameView::packed(&[0; 24], 4, 2, PixelFormat::Rgb888).unwrap();
        handle.serve(&picture, &packets::observation(1, 2));
        assert!(handle.take_order().is_some());
    }
}
