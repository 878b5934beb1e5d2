//! What tasks hand to each other, and through what.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use tetrad_core::vision::frame::{FrameError, FrameView, PixelFormat};
use tetrad_core::wire::{BadPicture, CommandPacket, Packet};

/// Bytes of the largest picture: QVGA, two bytes a pixel.
pub const PICTURE_BYTES: usize = 320 * 240 * 2;

/// How many buffers there are: one is filled while the other is looked at.
pub const BUFFERS: usize = 2;

/// Room for one picture, where a sensor's DMA can write words.
#[repr(C, align(32))]
pub struct PictureBuffer(pub [u8; PICTURE_BYTES]);

impl PictureBuffer {
    /// All black.
    #[must_use]
    pub const fn new() -> Self {
        Self([0; PICTURE_BYTES])
    }
}

impl Default for PictureBuffer {
    fn default() -> Self {
        Self::new()
    }
}

/// What a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Captured {
    /// Bytes of the picture; what is behind them in the buffer is of another one.
    pub length: usize,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// How pixels lie in it.
    pub format: PixelFormat,
    /// When it was taken, microseconds of the camera's clock.
    pub capture_us: u64,
    /// How much later it was whole, microseconds.
    pub ready_us: u32,
}

/// A picture on its way from the sensor to the tracker.
pub struct Picture {
    /// Handed on, and back through [`Buffers`] when it was looked at.
    pub buffer: &'static mut PictureBuffer,
    /// What is in it.
    pub captured: Captured,
}

impl Picture {
    /// The picture as core looks at it.
    ///
    /// # Errors
    /// It has not as many bytes as it should, or a size or format that is none.
    pub fn view(&self) -> Result<FrameView<'_>, FrameError> {
        let Captured { length, width, height, format, .. } = self.captured;
        // a longer one than the buffer was not kept whole: its length is refused
        let bytes = self.buffer.0.get(..length).unwrap_or_default();
        FrameView::packed(bytes, width, height, format)
    }
}

/// Whatever comes to the tracker, in the order in which it came.
pub enum Input {
    /// A picture.
    Picture(Picture),
    /// The sensor had one that cannot be looked at.
    BadPicture(BadPicture),
    /// Something it is told.
    Command(CommandPacket),
    /// Bytes came that were no command for a camera.
    NotUnderstood,
    /// Bytes came faster than they were taken.
    LineOverrun,
    /// There are no more pictures: those of a recording have been shown.
    End,
    /// A sender of pictures begins: the camera is to be made anew.
    Begin(Begin),
}

/// What a sender of pictures begins with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Begin {
    /// The camera's session from now on.
    pub session: u32,
    /// Whether balls are tracked by the finer methods.
    pub refined: bool,
}

/// Buffers that nobody uses.
pub type Buffers = Channel<CriticalSectionRawMutex, &'static mut PictureBuffer, BUFFERS>;

/// What comes to the tracker.
pub type Inputs = Channel<CriticalSectionRawMutex, Input, 4>;

/// What goes to the line; `None` behind the last packet of a recording.
pub type Packets = Channel<CriticalSectionRawMutex, Option<Packet>, 4>;
