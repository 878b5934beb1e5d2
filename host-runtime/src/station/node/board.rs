//! A smart camera without its board at the other end of a pseudo terminal, and a line that loses frames.

use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{Decoder, MAX_FRAME_LEN, Packet, encode};

pub(super) const WIDTH: u16 = 160;
pub(super) const HEIGHT: u16 = 120;

/// The middle of the ball.
pub(super) const AT: ImagePoint = ImagePoint { u: 80.0, v: 60.0 };

/// A red disc of 20 px before grey.
fn picture() -> Vec<u8> {
    let pixel = |index: i32| {
        let (x, y) = (index % i32::from(WIDTH), index / i32::from(WIDTH));
        let (du, dv) = (x - 80, y - 60);
        if du * du + dv * dv <= 100 { [200, 36, 40] } else { [70, 72, 74] }
    };
    (0..i32::from(WIDTH) * i32::from(HEIGHT)).flat_map(pixel).collect()
}

/// The camera, with a picture every few milliseconds.
pub(super) struct Board {
    pub(super) device: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// The terminal lives while this is open.
    _slave: TTYPort,
}

impl Board {
    /// Every so many frames the line loses one, each way; none where that is 0.
    pub(super) fn start(loses: u32, session: impl Fn(u32) -> u32 + Send + 'static) -> Self {
        let (mut master, slave) = TTYPort::pair().unwrap();
        let device = slave.name().unwrap().into();
        master.set_timeout(Duration::from_millis(2)).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            let (tracker, learn) = (TrackerConfig::default(), LearnConfig::default());
            let config = NodeConfig { camera: 0, session: 0, tracker, learn, started: false };
            let mut node = Node::new(&config).unwrap();
            let (mut decoder, bytes, mut frames, mut time_us) = (Decoder::new(), picture(), 0, 0);
            let mut is_lost = move || {
                frames += 1;
                loses > 0 && frames % loses == 0
            };
            while !stopped.load(Ordering::Relaxed) {
                let mut said: Vec<Packet> = Vec::new();
                let mut read = [0; 64];
                let count = master.read(&mut read).unwrap_or(0);
                for packet in decoder.packets(&read[..count]) {
                    match packet {
                        Ok(Packet::Command(_)) if is_lost() => {}
                        Ok(Packet::Command(command)) => said.extend(node.command(&command).map(Packet::from)),
                        _ => said.push(node.not_understood().into()),
                    }
                }
                let view = FrameView::packed(&bytes, WIDTH, HEIGHT, PixelFormat::Rgb888).unwrap();
                let seen = node.picture(&view, time_us, 10);
                time_us += 10_000;
                said.extend(seen.notices.iter().map(|notice| Packet::from(*notice)));
                said.extend(seen.observation.map(|mut observation| {
                    observation.session = session(observation.sequence);
                    Packet::from(observation)
                }));
                said.extend(seen.preview.map(|mut strip| {
                    strip.session = session(strip.sequence);
                    Packet::from(strip)
                }));
                for packet in said {
                    let mut frame = [0; MAX_FRAME_LEN];
                    let length = encode(&packet, &mut frame).unwrap();
                    if is_lost() {
                        frame[length / 2] ^= 0x40;
                    }
                    // nobody may listen
                    let _ = master.write_all(&frame[..length]);
                }
            }
        });
        Self { device, stop, thread: Some(thread), _slave: slave }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
