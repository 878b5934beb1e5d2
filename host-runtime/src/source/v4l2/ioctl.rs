//! The kernel's side: system calls on one device file and the memory it maps. All of
//! the unsafe code for devices is here.

use std::{
    ffi::{CString, c_int, c_void},
    fs::{File, OpenOptions},
    io,
    os::{
        fd::AsRawFd,
        unix::{ffi::OsStrExt, fs::OpenOptionsExt},
    },
    path::Path,
    ptr::NonNull,
    time::{Duration, Instant},
};

use super::{
    device::{ControlInfo, Device, Filled, FourCc, FrameSize, Identity, Picture, Wake},
    layout::{self, Request},
};

const CAP_CAPTURE: u32 = 0x1;
const CAP_CAPTURE_MPLANE: u32 = 0x1000;
const CAP_STREAMING: u32 = 0x0400_0000;
const CAP_DEVICE_CAPS: u32 = 0x8000_0000;
const PARAMETER_TIME_PER_FRAME: u32 = 0x1000;
const BUFFER_ERROR: u32 = 0x40;
const BUFFER_CLOCK_MASK: u32 = 0xe000;
const BUFFER_CLOCK_MONOTONIC: u32 = 0x2000;
const FIELD_ANY: u32 = 0;
const FIELD_NONE: u32 = 1;
const PRIVATE_MAGIC: u32 = 0xfeed_cafe;
const ENCODING_DEFAULT: u32 = 0;
const ENCODING_601: u32 = 1;
const QUANTIZATION_FULL: u32 = 1;
const COLORSPACE_REC709: u32 = 3;
const COLORSPACE_JPEG: u32 = 7;
/// Disabled, read-only or inactive.
const CONTROL_NOT_SETTABLE: u32 = 0x1 | 0x4 | 0x10;
/// More than any driver lists; a driver that never ends its list is stopped here.
const MAX_LISTED: u32 = 256;

/// An opened device file.
pub(super) struct Kernel {
    file: File,
    buffers: Vec<Mapped>,
    streaming: bool,
}

/// A buffer of the driver, mapped into our memory.
struct Mapped {
    start: NonNull<c_void>,
    length: usize,
    /// The driver owns the content and may be writing it.
    queued: bool,
}

// SAFETY: the mapping belongs to the whole process; only the address crosses threads.
unsafe impl Send for Mapped {}

impl Drop for Mapped {
    fn drop(&mut self) {
        // SAFETY: start and length are those mmap returned, and no borrow of the bytes outlives self.
        unsafe { libc::munmap(self.start.as_ptr(), self.length) };
    }
}

impl Kernel {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(libc::O_NONBLOCK | libc::O_CLOEXEC)
            .open(path)?;
        Ok(Self { file, buffers: Vec::new(), streaming: false })
    }

    fn call<T>(&self, request: &Request<T>, argument: &mut T) -> io::Result<()> {
        loop {
            // SAFETY: the descriptor is open, and the request's number carries size and type of T,
            // which `layout` has checked against the kernel's, so the kernel reads and writes
            // exactly `argument`. None of the structures holds a pointer.
            let result = unsafe {
                libc::ioctl(self.file.as_raw_fd(), request.number as _, std::ptr::from_mut(argument))
            };
            if result != -1 {
                return Ok(());
            }
            let error = io::Error::last_os_error();
            if error.kind() != io::ErrorKind::Interrupted {
                return Err(error);
            }
        }
    }

    fn map(&self, offset: u32, length: u32) -> io::Result<Mapped> {
        let length = length as usize;
        // SAFETY: a new mapping at an address of the kernel's choice, of a buffer the driver has
        // just described; nothing else refers to it. Read-only: we never write a picture.
        let start = unsafe {
            libc::mmap(
                std::ptr::null_mut(),
                length,
                libc::PROT_READ,
                libc::MAP_SHARED,
                self.file.as_raw_fd(),
                libc::off_t::from(offset),
            )
        };
        match NonNull::new(start) {
            Some(start) if start.as_ptr() != libc::MAP_FAILED => Ok(Mapped { start, length, queued: false }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    fn capture_type() -> i32 {
        layout::CAPTURE as i32
    }
}

/// See [`super::devices::may_use`].
pub(super) fn may_use(path: &Path) -> bool {
    let Ok(path) = CString::new(path.as_os_str().as_bytes()) else { return false };
    // SAFETY: a string that ends with a zero and lives through the call.
    unsafe { libc::access(path.as_ptr(), libc::R_OK | libc::W_OK) == 0 }
}

/// True when the error says that the thing asked for does not exist here.
fn is_absent(error: &io::Error) -> bool {
    matches!(error.raw_os_error(), Some(libc::EINVAL | libc::ENOTTY))
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

fn wish(picture: &Picture) -> layout::Format {
    layout::Format::capture(layout::PixFormat {
        width: picture.width,
        height: picture.height,
        fourcc: picture.fourcc.0,
        field: FIELD_NONE,
        private: PRIVATE_MAGIC,
        ..Default::default()
    })
}

fn granted(format: &layout::Format) -> Picture {
    let pix = &format.pix;
    // The defaults stand for BT.601 limited range, but for these two colour spaces.
    let encoding_601 = match pix.ycbcr_enc {
        ENCODING_DEFAULT => pix.colorspace != COLORSPACE_REC709,
        encoding => encoding == ENCODING_601,
    };
    let full_range = match pix.quantization {
        0 => pix.colorspace == COLORSPACE_JPEG,
        range => range == QUANTIZATION_FULL,
    };
    Picture {
        fourcc: FourCc(pix.fourcc),
        width: pix.width,
        height: pix.height,
        stride: pix.bytesperline,
        interlaced: !matches!(pix.field, FIELD_ANY | FIELD_NONE),
        other_yuv: !encoding_601 || full_range,
    }
}

fn buffer(index: u32) -> layout::Buffer {
    layout::Buffer { index, kind: layout::CAPTURE, memory: layout::MEMORY_MMAP, ..Default::default() }
}

impl Device for Kernel {
    fn identity(&mut self) -> io::Result<Identity> {
        let mut said = layout::Capability::default();
        self.call(&layout::QUERYCAP, &mut said)?;
        let has = if said.capabilities & CAP_DEVICE_CAPS != 0 { said.device_caps } else { said.capabilities };
        Ok(Identity {
            card: text(&said.card),
            driver: text(&said.driver),
            bus: text(&said.bus_info),
            captures: has & CAP_CAPTURE != 0 && has & CAP_STREAMING != 0,
            multi_planar: has & CAP_CAPTURE_MPLANE != 0,
        })
    }

    fn formats(&mut self) -> io::Result<Vec<FourCc>> {
        let mut formats = Vec::new();
        for index in 0..MAX_LISTED {
            let mut said = layout::FormatDescription { index, kind: layout::CAPTURE, ..Default::default() };
            match self.call(&layout::ENUM_FMT, &mut said) {
                Ok(()) => formats.push(FourCc(said.fourcc)),
                Err(error) if is_absent(&error) => break,
                Err(error) => return Err(error),
            }
        }
        Ok(formats)
    }

    fn sizes(&mut self, fourcc: FourCc) -> io::Result<Vec<FrameSize>> {
        let mut sizes = Vec::new();
        for index in 0..MAX_LISTED {
            let mut said = layout::FrameSizeEnum { index, fourcc: fourcc.0, ..Default::default() };
            match self.call(&layout::ENUM_FRAMESIZES, &mut said) {
                Ok(()) if said.kind == 1 => {
                    let [width, height, ..] = said.values;
                    sizes.push(FrameSize::Exact(width, height));
                }
                Ok(()) => {
                    // A range is the whole answer.
                    let [least_width, greatest_width, _, least_height, greatest_height, _] = said.values;
                    sizes.push(FrameSize::Range {
                        least: (least_width, least_height),
                        greatest: (greatest_width, greatest_height),
                    });
                    break;
                }
                Err(error) if is_absent(&error) => break,
                Err(error) => return Err(error),
            }
        }
        Ok(sizes)
    }

    fn try_format(&mut self, picture: &Picture) -> io::Result<Picture> {
        let mut format = wish(picture);
        self.call(&layout::TRY_FMT, &mut format)?;
        Ok(granted(&format))
    }

    fn set_format(&mut self, picture: &Picture) -> io::Result<Picture> {
        let mut format = wish(picture);
        self.call(&layout::S_FMT, &mut format)?;
        Ok(granted(&format))
    }

    fn set_rate(&mut self, fps: f64) -> io::Result<Option<f64>> {
        // Thousandths of a frame a second are finer than any camera's rates.
        let mut parameters = layout::StreamParameters::interval(1000, (fps * 1000.0).round() as u32);
        match self.call(&layout::S_PARM, &mut parameters) {
            Ok(()) => {}
            Err(error) if is_absent(&error) => return Ok(None),
            Err(error) => return Err(error),
        }
        let known = parameters.capability & PARAMETER_TIME_PER_FRAME != 0
            && parameters.numerator != 0
            && parameters.denominator != 0;
        Ok(known.then(|| f64::from(parameters.denominator) / f64::from(parameters.numerator)))
    }

    fn control_info(&mut self, id: u32) -> io::Result<Option<ControlInfo>> {
        let mut said = layout::QueryControl { id, ..Default::default() };
        match self.call(&layout::QUERYCTRL, &mut said) {
            Ok(()) => Ok(Some(ControlInfo { settable: said.flags & CONTROL_NOT_SETTABLE == 0 })),
            Err(error) if is_absent(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    fn control(&mut self, id: u32) -> io::Result<i32> {
        let mut control = layout::Control { id, value: 0 };
        self.call(&layout::G_CTRL, &mut control)?;
        Ok(control.value)
    }

    fn set_control(&mut self, id: u32, value: i32) -> io::Result<()> {
        self.call(&layout::S_CTRL, &mut layout::Control { id, value })
    }

    fn start(&mut self, count: u32) -> io::Result<u32> {
        let mut request = layout::RequestBuffers {
            count,
            kind: layout::CAPTURE,
            memory: layout::MEMORY_MMAP,
            ..Default::default()
        };
        self.call(&layout::REQBUFS, &mut request)?;
        for index in 0..request.count {
            let mut described = buffer(index);
            self.call(&layout::QUERYBUF, &mut described)?;
            self.buffers.push(self.map(described.offset[0], described.length)?);
        }
        for index in 0..request.count {
            self.queue(index)?;
        }
        self.call(&layout::STREAMON, &mut Self::capture_type())?;
        self.streaming = true;
        Ok(request.count)
    }

    fn wait(&mut self, timeout: Duration) -> io::Result<Wake> {
        let deadline = Instant::now() + timeout;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            // Rounded up, so that the last millisecond is not spent in a busy loop.
            let milliseconds = c_int::try_from(left.as_micros().div_ceil(1000)).unwrap_or(c_int::MAX);
            let mut poll = libc::pollfd { fd: self.file.as_raw_fd(), events: libc::POLLIN, revents: 0 };
            // SAFETY: one pollfd, which lives through the call, and an open descriptor.
            match unsafe { libc::poll(&raw mut poll, 1, milliseconds) } {
                0 => return Ok(Wake::TimedOut),
                -1 => {
                    let error = io::Error::last_os_error();
                    if error.kind() != io::ErrorKind::Interrupted {
                        return Err(error);
                    }
                }
                _ if poll.revents & (libc::POLLERR | libc::POLLHUP | libc::POLLNVAL) != 0 => {
                    return Ok(Wake::Gone);
                }
                _ => return Ok(Wake::Ready),
            }
        }
    }

    fn dequeue(&mut self) -> io::Result<Option<Filled>> {
        let mut taken = buffer(0);
        match self.call(&layout::DQBUF, &mut taken) {
            Ok(()) => {}
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
            Err(error) => return Err(error),
        }
        let Some(mapped) = self.buffers.get_mut(taken.index as usize) else {
            return Err(io::Error::other(format!(
                "the driver returned a buffer {} it never had",
                taken.index
            )));
        };
        mapped.queued = false;
        let monotonic = taken.flags & BUFFER_CLOCK_MASK == BUFFER_CLOCK_MONOTONIC;
        Ok(Some(Filled {
            index: taken.index,
            bytes: (taken.bytesused as usize).min(mapped.length),
            damaged: taken.flags & BUFFER_ERROR != 0,
            sequence: taken.sequence,
            t_s: monotonic.then_some(taken.seconds as f64 + taken.microseconds as f64 * 1e-6),
        }))
    }

    fn queue(&mut self, index: u32) -> io::Result<()> {
        let Some(mapped) = self.buffers.get_mut(index as usize) else {
            return Err(io::Error::from(io::ErrorKind::InvalidInput));
        };
        // From here on the driver may write, whatever the call says of its success.
        mapped.queued = true;
        self.call(&layout::QBUF, &mut buffer(index))
    }

    fn bytes(&self, index: u32) -> &[u8] {
        match self.buffers.get(index as usize) {
            // SAFETY: start and length are a live mapping of our own; the driver does not write a
            // buffer it has handed out, and handing it back (`queue`) needs `&mut self`, which
            // ends this borrow first.
            Some(mapped) if !mapped.queued => unsafe {
                std::slice::from_raw_parts(mapped.start.as_ptr().cast(), mapped.length)
            },
            _ => &[],
        }
    }

    fn now_s(&self) -> f64 {
        let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
        // SAFETY: the clock always exists and `time` lives through the call.
        unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &raw mut time) };
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    }
}

impl Drop for Kernel {
    fn drop(&mut self) {
        if self.streaming {
            // Whatever it says: closing the file below ends the stream too.
            let _ = self.call(&layout::STREAMOFF, &mut Self::capture_type());
        }
    }
}

#[cfg(test)]
mod tests;
