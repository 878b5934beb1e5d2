//! What the rest of this module asks of a camera. The kernel answers in [`super::ioctl`]; the tests
//! answer from memory.

use std::{fmt, io, time::Duration};

/// A pixel format's four letters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct FourCc(pub(super) [u8; 4]);

impl fmt::Display for FourCc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The highest bit of all marks the big-endian sister of a format.
        let letters =
            self.0.map(|byte| char::from(byte & 0x7f)).map(|c| if c.is_ascii_graphic() { c } else { ' ' });
        f.write_str(String::from_iter(letters).trim_end())?;
        if self.0[3] & 0x80 != 0 { f.write_str("-BE") } else { Ok(()) }
    }
}

/// What the driver says of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    /// The camera's name.
    pub(super) card: String,
    /// The driver's name.
    pub(super) driver: String,
    /// Where it is plugged in.
    pub(super) bus: String,
    /// Whether it captures pictures, one plane a buffer, by streaming.
    pub(super) captures: bool,
    /// Whether it captures only by the multi-planar interface.
    pub(super) multi_planar: bool,
}

/// A picture size a camera offers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameSize {
    /// This width and height.
    Exact(u32, u32),
    /// All sizes between two.
    Range {
        /// The least width and height.
        least: (u32, u32),
        /// The greatest width and height.
        greatest: (u32, u32),
    },
}

impl fmt::Display for FrameSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exact(width, height) => write!(f, "{width}x{height}"),
            Self::Range { least, greatest } => {
                write!(f, "{}x{} to {}x{}", least.0, least.1, greatest.0, greatest.1)
            }
        }
    }
}

/// A picture format, asked for or granted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Picture {
    pub(super) fourcc: FourCc,
    pub(super) width: u32,
    pub(super) height: u32,
    /// Bytes from row to row; not asked for.
    pub(super) stride: u32,
    /// Whether the driver says that two half pictures are woven into one.
    pub(super) interlaced: bool,
    /// Whether YUV samples span 0 to 255, or follow BT.709: core reads BT.601 limited range.
    pub(super) other_yuv: bool,
}

impl Picture {
    pub(super) const fn ask(fourcc: FourCc, width: u32, height: u32) -> Self {
        Self { fourcc, width, height, stride: 0, interlaced: false, other_yuv: false }
    }
}

/// A filled buffer, taken from the driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Filled {
    pub(super) index: u32,
    pub(super) bytes: usize,
    /// The driver marks the picture as damaged.
    pub(super) damaged: bool,
    pub(super) sequence: u32,
    /// Seconds of the monotonic clock, when the driver stamps with that clock.
    pub(super) t_s: Option<f64>,
}

/// Why waiting ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wake {
    /// There may be a filled buffer.
    Ready,
    /// The time is over.
    TimedOut,
    /// The device reports an error or is gone.
    Gone,
}

/// What is known of a control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ControlInfo {
    /// Whether a value may be set at present.
    pub(super) settable: bool,
}

/// One opened camera.
pub(super) trait Device: Send {
    fn identity(&mut self) -> io::Result<Identity>;
    fn formats(&mut self) -> io::Result<Vec<FourCc>>;
    fn sizes(&mut self, fourcc: FourCc) -> io::Result<Vec<FrameSize>>;
    /// What the driver would make of this wish.
    fn try_format(&mut self, wish: &Picture) -> io::Result<Picture>;
    /// What the driver has made of it.
    fn set_format(&mut self, wish: &Picture) -> io::Result<Picture>;
    /// Asks for a frame rate and tells which was granted; `None` when the driver does not know.
    fn set_rate(&mut self, fps: f64) -> io::Result<Option<f64>>;
    /// `None` for a control the camera does not have.
    fn control_info(&mut self, id: u32) -> io::Result<Option<ControlInfo>>;
    fn control(&mut self, id: u32) -> io::Result<i32>;
    fn set_control(&mut self, id: u32, value: i32) -> io::Result<()>;

    /// Makes and maps up to `count` buffers, queues them all and starts the stream; tells how many
    /// there are.
    fn start(&mut self, count: u32) -> io::Result<u32>;
    fn wait(&mut self, timeout: Duration) -> io::Result<Wake>;
    /// A filled buffer, if there is one now.
    fn dequeue(&mut self) -> io::Result<Option<Filled>>;
    /// Gives a buffer back to the driver.
    fn queue(&mut self, index: u32) -> io::Result<()>;
    /// The bytes of a buffer; none while the driver has it.
    fn bytes(&self, index: u32) -> &[u8];
    /// The monotonic clock in seconds.
    fn now_s(&self) -> f64;
}
