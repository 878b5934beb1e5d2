//! Cameras under Linux, through Video4Linux.
//!
//! A thin layer of our own over the kernel's calls: the crates for it need libclang, hide
//! timestamps or sequence numbers, or requeue buffers the kernel owns after a time-out.
//!
//! ```text
//! open (retried for two seconds) -> negotiate format and rate -> automatic controls off
//!   -> four mapped buffers -> stream: newest whole picture, sequence gaps, driver's time stamps
//! ```
//!
//! Uncompressed formats only; MJPEG cameras usually offer YUYV at 640 x 480 as well.
//! Everything but the system calls themselves works on a small `Device` trait, so that the tests run
//! it on a camera in memory.

mod controls;
mod device;
pub mod devices;
mod ioctl;
mod layout;
mod negotiate;
mod stream;

#[cfg(test)]
mod tests;

use std::{io, path::Path, time::Duration};

use tetrad_core::vision::frame::FrameView;

use self::{
    device::Device,
    ioctl::Kernel,
    negotiate::{Disagreement, negotiate},
    stream::Stream,
};
use super::{DEFAULT_FPS, Frame, Labels, Options, Source, SourceError, SourceInfo};

pub use stream::Losses;

/// A camera that is busy or missing is tried again after this pause: one that was just plugged in or
/// left by another program, or that wakes up, takes a moment.
const RETRY_PAUSE: Duration = Duration::from_millis(100);

/// Pauses before a camera is given up: two seconds in all.
const RETRIES: u32 = 20;

/// An opened, running camera.
pub struct CameraSource {
    camera: Camera<Kernel>,
}

impl CameraSource {
    /// Opens the camera at `path` and starts it.
    ///
    /// # Errors
    /// [`SourceError`] naming the camera: missing, busy, without permission, or without a format
    /// that is read here.
    pub fn open(spec: &str, path: &Path, options: &Options) -> Result<Self, SourceError> {
        let attempt = || {
            let device = Kernel::open(path).map_err(|error| refused(spec, "opened", error))?;
            Camera::start(spec, device, options)
        };
        let camera = with_retries(attempt, || std::thread::sleep(RETRY_PAUSE))?;
        Ok(Self { camera })
    }

    /// Pictures lost so far, by cause.
    #[must_use]
    pub const fn losses(&self) -> Losses {
        self.camera.stream.losses()
    }
}

impl Source for CameraSource {
    fn info(&self) -> &SourceInfo {
        &self.camera.info
    }

    fn next(&mut self) -> Result<Option<Frame<'_>>, SourceError> {
        self.camera.next().map(Some)
    }

    fn now_s(&self) -> Option<f64> {
        Some(self.camera.stream.now_s())
    }

    fn take_notices(&mut self) -> Vec<String> {
        self.camera.take_notices()
    }
}

/// The same for any device.
struct Camera<D: Device> {
    info: SourceInfo,
    stride: usize,
    stream: Stream<D>,
}

impl<D: Device> Camera<D> {
    fn start(spec: &str, mut device: D, options: &Options) -> Result<Self, Refusal> {
        let identity = device.identity().map_err(|error| refused(spec, ASKED_WHAT, error))?;
        if !identity.captures {
            let reason = if identity.multi_planar {
                "its driver captures by the multi-planar interface only, which is not read in this version: use a USB camera"
            } else {
                "this device node gives no pictures (cameras have further nodes, for metadata): `tetrad devices` lists those that do"
            };
            return Err(Refusal::Never(SourceError::argument(spec, reason)));
        }
        let mut notices = Vec::new();
        let fps = options.fps.unwrap_or(DEFAULT_FPS);
        let agreed =
            negotiate(&mut device, options.size, fps, &mut notices).map_err(|error| match error {
                Disagreement::Io(error) => refused(spec, "asked for its formats", error),
                Disagreement::Unusable(reason) => {
                    Refusal::Never(SourceError::Unusable { device: spec.to_owned(), reason })
                }
            })?;
        let saved = controls::switch_off(&mut device, &mut notices);
        let stream = Stream::start(device, spec, agreed, saved, notices)
            .map_err(|error| refused(spec, "started", error))?;
        let info = SourceInfo {
            name: spec.to_owned(),
            width: agreed.width,
            height: agreed.height,
            format: agreed.format,
            fps: agreed.fps,
            frames: None,
            live: true,
            labels: Labels::Order,
        };
        Ok(Self { info, stride: agreed.stride, stream })
    }

    fn next(&mut self) -> Result<Frame<'_>, SourceError> {
        let taken = self.stream.next()?;
        let whole = self.stride * self.info.format.rows(usize::from(self.info.height));
        let bytes = self.stream.bytes(taken.buffer);
        // Drivers round buffers up to whole pages.
        let bytes = bytes.get(..whole).unwrap_or(bytes);
        let view = FrameView::new(bytes, self.info.width, self.info.height, self.stride, self.info.format)
            .map_err(|error| SourceError::Unusable {
                device: self.info.name.clone(),
                reason: format!("its pictures are not what it agreed to: {error}"),
            })?;
        Ok(Frame { view, index: taken.index, number: taken.number, t_s: taken.t_s, gap: taken.gap })
    }

    fn take_notices(&mut self) -> Vec<String> {
        let name = &self.info.name;
        self.stream.notices.drain(..).map(|notice| format!("{name}: {notice}")).collect()
    }
}

/// The step at which a file that is no camera shows itself.
const ASKED_WHAT: &str = "asked what it is";

/// Why a camera did not start.
#[derive(Debug)]
enum Refusal {
    /// It may in a moment.
    NotNow(SourceError),
    /// It will not.
    Never(SourceError),
}

/// Sorts a failed call into what passes and what does not, and says what would mend it.
fn refused(spec: &str, doing: &str, error: io::Error) -> Refusal {
    let device = spec.to_owned();
    match error.raw_os_error() {
        Some(libc::ENOENT | libc::ENODEV | libc::ENXIO) => Refusal::NotNow(SourceError::DeviceLost {
            device,
            reason: "no such camera: plug it in; `tetrad devices` lists those there are".to_owned(),
        }),
        Some(libc::EBUSY) => Refusal::NotNow(SourceError::DeviceLost {
            device,
            reason: "in use by another program: close it (`fuser -v` on the device tells which)".to_owned(),
        }),
        Some(libc::EACCES | libc::EPERM) => Refusal::Never(SourceError::Unusable {
            device,
            reason: "no permission: add your user to the group 'video' (`sudo usermod -aG video $USER`) and log in again"
                .to_owned(),
        }),
        Some(libc::ENOTTY | libc::EINVAL) if doing == ASKED_WHAT => Refusal::Never(SourceError::argument(
            spec,
            "this is not a Video4Linux camera: `tetrad devices` lists those there are",
        )),
        Some(libc::ENOSPC) => Refusal::Never(SourceError::Unusable {
            device,
            reason: "no USB bandwidth left for it: put the cameras on separate USB ports of the machine, not one hub, or ask for a smaller size or rate"
                .to_owned(),
        }),
        _ => Refusal::Never(SourceError::Unusable { device, reason: format!("could not be {doing}: {error}") }),
    }
}

/// Tries until it works, will never work, or the patience is over.
fn with_retries<T>(
    mut attempt: impl FnMut() -> Result<T, Refusal>,
    mut pause: impl FnMut(),
) -> Result<T, SourceError> {
    for _ in 0..RETRIES {
        match attempt() {
            Ok(opened) => return Ok(opened),
            Err(Refusal::Never(error)) => return Err(error),
            Err(Refusal::NotNow(_)) => pause(),
        }
    }
    attempt().map_err(|(Refusal::NotNow(error) | Refusal::Never(error))| error)
}
