//! Pictures of a camera as JPEG, for people, with what was seen drawn over them or told beside.
//!
//! Drawing and encoding have a thread of their own: the camera's hands over a copy of a picture now and
//! then, and never waits. Of pictures that wait the newest counts.

use super::camera::Windows;
use super::jpeg::jpeg;
use crate::link::Picture;
use crate::locked::lock;
use crate::output::Canvas;
use crate::precedence::step_back;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::ObservationPacket;

/// A picture waits for so long before it is drawn and encoded: two cameras that go together are still tracked when
/// the first of them has handed its picture over, and processors that share a core or a cache slow each other down.
const MOTION_FIRST: Duration = Duration::from_millis(4);

/// Where the balls are marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marks {
    /// In the picture.
    Drawn,
    /// By whoever shows it.
    Beside,
}

/// A camera's preview. Where it is dropped, its thread ends.
pub struct Preview {
    shared: Arc<Shared>,
    period_us: u64,
    /// When the next picture is due, by the clock of the packets.
    due_us: u64,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    desk: Mutex<Desk>,
    changed: Condvar,
}

#[derive(Default)]
struct Desk {
    waiting: Option<Job>,
    /// Memory of the picture before, to be used again.
    spare: Vec<u8>,
    over: bool,
}

struct Job {
    bytes: Vec<u8>,
    stride: usize,
    format: PixelFormat,
    packet: ObservationPacket,
    windows: Windows,
}

impl Preview {
    /// Starts the thread that draws; `send` gets at most `fps` pictures a second, with what was seen in
    /// each and where it was looked for.
    ///
    /// # Errors
    /// The system has no thread left.
    pub fn start(
        fps: f64,
        marks: Marks,
        send: impl FnMut(Picture, &ObservationPacket, &Windows) + Send + 'static,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let thread =
            std::thread::Builder::new().name("preview".to_owned()).spawn(move || theirs.work(marks, send))?;
        let period_us = (1e6 / fps.max(1e-3)) as u64;
        Ok(Self { shared, period_us, due_us: 0, thread: Some(thread) })
    }

    /// Takes a copy of the picture if one is due.
    pub fn offer(&mut self, picture: &FrameView<'_>, packet: &ObservationPacket, windows: &Windows) {
        if packet.capture_us < self.due_us {
            return;
        }
        self.due_us += self.period_us;
        if self.due_us <= packet.capture_us {
            // what was left out is not made up for
            self.due_us = packet.capture_us + self.period_us;
        }
        let mut bytes = std::mem::take(&mut self.shared.lock().spare);
        bytes.clear();
        bytes.extend_from_slice(picture.data());
        let (stride, format) = (picture.stride(), picture.format());
        let job = Job { bytes, stride, format, packet: *packet, windows: *windows };
        self.shared.lock().waiting = Some(job);
        self.shared.changed.notify_one();
    }
}

impl Drop for Preview {
    fn drop(&mut self) {
        self.shared.lock().over = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Desk> {
        lock(&self.desk)
    }

    /// The next picture, [`MOTION_FIRST`] after it came; `None` at the end.
    fn take(&self) -> Option<Job> {
        let idle = |desk: &mut Desk| desk.waiting.is_none() && !desk.over;
        let desk = self.changed.wait_while(self.lock(), idle);
        if !desk.unwrap_or_else(PoisonError::into_inner).over {
            std::thread::sleep(MOTION_FIRST);
        }
        let mut desk = self.lock();
        if desk.over { None } else { desk.waiting.take() }
    }

    fn work(&self, marks: Marks, mut send: impl FnMut(Picture, &ObservationPacket, &Windows)) {
        step_back();
        let mut sequence = 0;
        while let Some(job) = self.take() {
            let ObservationPacket { camera, session, capture_us, width, height, .. } = job.packet;
            // a picture that the tracker has read has a size that can be encoded
            if let Some(jpeg) = job.drawn(marks) {
                let picture = Picture { camera, session, sequence, capture_us, width, height, jpeg };
                send(picture, &job.packet, &job.windows);
                sequence = sequence.wrapping_add(1);
            }
            self.lock().spare = job.bytes;
        }
    }
}

impl Job {
    /// `None` where the picture is none that can be read or encoded.
    fn drawn(&self, marks: Marks) -> Option<Vec<u8>> {
        let ObservationPacket { width, height, .. } = self.packet;
        let view = FrameView::new(&self.bytes, width, height, self.stride, self.format).ok()?;
        match marks {
            Marks::Beside => jpeg(&view).ok(),
            Marks::Drawn => {
                let mut canvas = Canvas::side_by_side(&[view]);
                canvas.circles(&self.packet.balls);
                jpeg(&canvas.view()?).ok()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use tetrad_core::geometry::ImagePoint;
    use tetrad_core::observation::{BALLS, Observation, ObservationState};
    use zune_jpeg::JpegDecoder;
    use zune_jpeg::zune_core::bytestream::ZCursor;

    const SIDE: u16 = 64;

    fn packet(sequence: u32, capture_us: u64) -> ObservationPacket {
        let mut balls = [Observation::default(); BALLS];
        balls[2] = Observation {
            state: ObservationState::Visible,
            centre: ImagePoint::new(32.0, 32.0),
            diameter: 40.0,
            ..Observation::default()
        };
        ObservationPacket {
            camera: 3,
            session: 7,
            sequence,
            capture_us,
            ready_us: 0,
            observed_us: 0,
            width: SIDE,
            height: SIDE,
            pixels_tested: 0,
            balls,
        }
    }

    #[test]
    fn due_pictures_come_as_jpeg_with_the_balls_marked() {
        let (send, sent) = mpsc::channel();
        let mut preview =
            Preview::start(10.0, Marks::Drawn, move |picture, _, _| send.send(picture).unwrap()).unwrap();
        let bytes = vec![40; usize::from(SIDE) * usize::from(SIDE) * 3];
        let view = FrameView::packed(&bytes, SIDE, SIDE, PixelFormat::Rgb888).unwrap();
        let mut next = |capture_us, due: bool| {
            preview.offer(&view, &packet(0, capture_us), &[None; BALLS]);
            let wait = if due { Duration::from_secs(60) } else { Duration::from_millis(100) };
            sent.recv_timeout(wait).ok()
        };
        let first = next(1_000_000, true).unwrap();
        assert_eq!((first.camera, first.session, first.sequence, first.capture_us), (3, 7, 0, 1_000_000));
        assert_eq!((first.width, first.height), (SIDE, SIDE));
        let pixels = JpegDecoder::new(ZCursor::new(&first.jpeg)).decode().unwrap();
        let grey = |x: usize, y: usize| pixels[(y * usize::from(SIDE) + x) * 3];
        let [inside, rim, outside] = [grey(32, 32), grey(52, 32), grey(2, 2)];
        assert!(inside < 80 && outside < 80 && rim > 120, "{inside} {rim} {outside}");
        let number = |picture: Option<Picture>| picture.map(|picture| picture.sequence);
        assert_eq!(number(next(1_050_000, false)), None, "not before a tenth of a second");
        assert_eq!(number(next(1_110_000, true)), Some(1));
        assert_eq!(number(next(1_205_000, true)), Some(2), "the rate is kept although one was late");
        assert_eq!(number(next(5_000_000, true)), Some(3), "after a pause");
        assert_eq!(number(next(5_050_000, false)), None, "which is not made up for");
    }

    #[test]
    fn a_slow_reader_gets_the_newest() {
        let (send, sent) = mpsc::sync_channel(0);
        let mut preview =
            Preview::start(1e3, Marks::Drawn, move |picture, _, _| send.send(picture).unwrap()).unwrap();
        let bytes = vec![40; usize::from(SIDE) * usize::from(SIDE) * 3];
        let view = FrameView::packed(&bytes, SIDE, SIDE, PixelFormat::Rgb888).unwrap();
        for number in 0..200 {
            preview.offer(&view, &packet(number, u64::from(number) * 1_000), &[None; BALLS]);
        }
        let came: Vec<_> = std::iter::from_fn(|| sent.recv_timeout(Duration::from_secs(1)).ok()).collect();
        assert!(came.len() < 20, "{}", came.len());
        assert_eq!(came.last().unwrap().capture_us, 199_000);
    }
}
