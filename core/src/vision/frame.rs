//! A borrowed picture: the only code that indexes its bytes.
//!
//! A [`FrameView`] checks size, stride and format once; afterwards a pixel is converted to RGB when
//! it is asked for, and nothing else of the buffer is touched but for one byte in each cache line
//! around a ball that the tracker is about to read (`fetch`). Nothing here panics.

use core::fmt;

/// The largest width or height of a picture, in pixels: coordinates then fit `i16` with room for
/// search windows that reach over the border.
pub const MAX_SIDE: u16 = 8192;

/// A colour, eight bits a component: c1, c2, c3 of the paper's section 2, not yet divided by 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Rgb {
    /// c1
    pub r: u8,
    /// c2
    pub g: u8,
    /// c3
    pub b: u8,
}

impl Rgb {
    /// A colour from its three components, 0 to 255.
    #[must_use]
    pub const fn new(r: u8, g: u8, b: u8) -> Self {
        Self { r, g, b }
    }
}

/// How pixels lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PixelFormat {
    /// Three bytes: R, G, B.
    Rgb888,
    /// Three bytes: B, G, R.
    Bgr888,
    /// Four bytes: R, G, B and one that is ignored.
    Rgba8888,
    /// Two bytes, low byte first: RRRRRGGG GGGBBBBB as a 16-bit number.
    Rgb565Le,
    /// Two bytes, high byte first, as most camera sensors send it.
    Rgb565Be,
    /// Two pixels in four bytes: Y0 U Y1 V (BT.601, limited range). Even widths only.
    Yuyv,
    /// Two pixels in four bytes: U Y0 V Y1 (BT.601, limited range). Even widths only.
    Uyvy,
    /// A plane of Y, then a plane of interleaved U V at half width and half height (BT.601, limited
    /// range). Even widths and heights only; both planes have the same stride.
    Nv12,
}

impl PixelFormat {
    /// Every format there is.
    pub const ALL: [Self; 8] = [
        Self::Rgb888,
        Self::Bgr888,
        Self::Rgba8888,
        Self::Rgb565Le,
        Self::Rgb565Be,
        Self::Yuyv,
        Self::Uyvy,
        Self::Nv12,
    ];

    /// Bytes in one row of pixels without padding (for NV12: of the Y plane).
    #[must_use]
    pub const fn row_bytes(self, width: usize) -> usize {
        match self {
            Self::Rgb888 | Self::Bgr888 => width * 3,
            Self::Rgba8888 => width * 4,
            Self::Rgb565Le | Self::Rgb565Be | Self::Yuyv | Self::Uyvy => width * 2,
            Self::Nv12 => width,
        }
    }

    /// Rows of `stride` bytes in a whole buffer: the height, and half as many again for NV12.
    #[must_use]
    pub const fn rows(self, height: usize) -> usize {
        match self {
            Self::Nv12 => height + height / 2,
            _ => height,
        }
    }

    const fn needs_even_width(self) -> bool {
        matches!(self, Self::Yuyv | Self::Uyvy | Self::Nv12)
    }

    const fn needs_even_height(self) -> bool {
        matches!(self, Self::Nv12)
    }
}

/// Why a buffer is not a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FrameError {
    /// Width or height is zero.
    Empty,
    /// Width or height is above [`MAX_SIDE`].
    TooLarge,
    /// The format shares chroma between neighbours and the width is odd.
    OddWidth,
    /// The format shares chroma between rows and the height is odd.
    OddHeight,
    /// The stride is smaller than a row of pixels.
    StrideTooSmall {
        /// Bytes a row needs.
        needed: usize,
        /// Bytes a row was said to have.
        given: usize,
    },
    /// The buffer ends before the last row does, or goes on after its padding.
    WrongLength {
        /// The least number of bytes: the last row needs no padding.
        needed: usize,
        /// Bytes given.
        given: usize,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Empty => f.write_str("the picture has no pixels"),
            Self::TooLarge => write!(f, "the picture is wider or higher than {MAX_SIDE} pixels"),
            Self::OddWidth => {
                f.write_str("this format shares chroma between two columns: its width must be even")
            }
            Self::OddHeight => {
                f.write_str("this format shares chroma between two rows: its height must be even")
            }
            Self::StrideTooSmall { needed, given } => {
                write!(f, "a row needs {needed} bytes and the stride is {given}")
            }
            Self::WrongLength { needed, given } => {
                write!(
                    f,
                    "the picture needs {needed} bytes (and at most its padding more) and the buffer has {given}"
                )
            }
        }
    }
}

impl core::error::Error for FrameError {}

/// A borrowed picture. Checked once, then every read is safe.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    data: &'a [u8],
    width: u16,
    height: u16,
    stride: usize,
    format: PixelFormat,
}

impl<'a> FrameView<'a> {
    /// A picture of `width` x `height` pixels whose rows start `stride` bytes apart.
    ///
    /// # Errors
    /// [`FrameError`] names what does not fit. The buffer may end with the last row's pixels or with
    /// its padding; any other length is refused.
    pub fn new(
        data: &'a [u8],
        width: u16,
        height: u16,
        stride: usize,
        format: PixelFormat,
    ) -> Result<Self, FrameError> {
        if width == 0 || height == 0 {
            return Err(FrameError::Empty);
        }
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(FrameError::TooLarge);
        }
        if format.needs_even_width() && !width.is_multiple_of(2) {
            return Err(FrameError::OddWidth);
        }
        if format.needs_even_height() && !height.is_multiple_of(2) {
            return Err(FrameError::OddHeight);
        }
        let row = format.row_bytes(usize::from(width));
        if stride < row {
            return Err(FrameError::StrideTooSmall { needed: row, given: stride });
        }
        let rows = format.rows(usize::from(height));
        // A stride so large that the product overflows cannot have a buffer behind it.
        let Some(whole) = stride.checked_mul(rows) else {
            return Err(FrameError::WrongLength { needed: usize::MAX, given: data.len() });
        };
        let needed = whole - (stride - row);
        if data.len() < needed || data.len() > whole {
            return Err(FrameError::WrongLength { needed, given: data.len() });
        }
        Ok(Self { data, width, height, stride, format })
    }

    /// A picture whose rows follow each other without padding.
    ///
    /// # Errors
    /// As [`FrameView::new`].
    pub fn packed(data: &'a [u8], width: u16, height: u16, format: PixelFormat) -> Result<Self, FrameError> {
        Self::new(data, width, height, format.row_bytes(usize::from(width)), format)
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(&self) -> u16 {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(&self) -> u16 {
        self.height
    }

    /// How pixels lie in memory.
    #[must_use]
    pub const fn format(&self) -> PixelFormat {
        self.format
    }

    /// The bytes, as they were given.
    #[must_use]
    pub const fn data(&self) -> &'a [u8] {
        self.data
    }

    /// How many bytes after each other rows start.
    #[must_use]
    pub const fn stride(&self) -> usize {
        self.stride
    }

    /// Whether column `x`, row `y` lies inside the picture.
    #[inline]
    #[must_use]
    pub fn contains(&self, x: i32, y: i32) -> bool {
        x >= 0 && y >= 0 && x < i32::from(self.width) && y < i32::from(self.height)
    }

    /// The colour of the pixel in column `x`, row `y`, or `None` outside the picture.
    #[inline]
    #[must_use]
    pub fn pixel(&self, x: i32, y: i32) -> Option<Rgb> {
        if self.contains(x, y) { self.pixel_inside(x as usize, y as usize) } else { None }
    }

    /// The same where the caller knows that the place is inside. Outside it gives some other pixel or
    /// `None`.
    #[inline(always)]
    pub(super) fn pixel_inside(&self, x: usize, y: usize) -> Option<Rgb> {
        let row = y * self.stride;
        match self.format {
            PixelFormat::Rgb888 => {
                let [r, g, b] = self.bytes(row + 3 * x)?;
                Some(Rgb { r, g, b })
            }
            PixelFormat::Bgr888 => {
                let [b, g, r] = self.bytes(row + 3 * x)?;
                Some(Rgb { r, g, b })
            }
            PixelFormat::Rgba8888 => {
                let [r, g, b] = self.bytes(row + 4 * x)?;
                Some(Rgb { r, g, b })
            }
            PixelFormat::Rgb565Le => Some(from_565(u16::from_le_bytes(self.bytes(row + 2 * x)?))),
            PixelFormat::Rgb565Be => Some(from_565(u16::from_be_bytes(self.bytes(row + 2 * x)?))),
            PixelFormat::Yuyv => {
                let [y0, u, y1, v] = self.bytes(row + 4 * (x / 2))?;
                Some(from_yuv(if x.is_multiple_of(2) { y0 } else { y1 }, u, v))
            }
            PixelFormat::Uyvy => {
                let [u, y0, v, y1] = self.bytes(row + 4 * (x / 2))?;
                Some(from_yuv(if x.is_multiple_of(2) { y0 } else { y1 }, u, v))
            }
            PixelFormat::Nv12 => {
                let [luma] = self.bytes(row + x)?;
                let chroma_row = (usize::from(self.height) + y / 2) * self.stride;
                let [u, v] = self.bytes(chroma_row + 2 * (x / 2))?;
                Some(from_yuv(luma, u, v))
            }
        }
    }

    /// Reads one byte in every cache line of rows `y0..y1` from column `x0` to `x1`. A frame that a
    /// camera or a decoder has just written lies in slow memory, and a spiral waits for it line by
    /// line; asked for all at once the lines come together. Changes nothing but time.
    pub(super) fn fetch(&self, (x0, x1): (i32, i32), (y0, y1): (i32, i32)) {
        const CACHE_LINE: usize = 64;
        let row_bytes = |x: i32| self.format.row_bytes(x.max(0).min(i32::from(self.width)) as usize);
        let (from, to) = (row_bytes(x0), row_bytes(x1));
        let mut sum = 0u32;
        for y in y0.max(0)..y1.min(i32::from(self.height)) {
            let row = y as usize * self.stride;
            let mut at = row + from;
            while at < row + to {
                sum = sum.wrapping_add(self.data.get(at).copied().map_or(0, u32::from));
                at += CACHE_LINE;
            }
        }
        // Keeps the reads although nobody wants their sum.
        core::hint::black_box(sum);
    }

    /// `N` bytes from `at`; the constructor has made sure that they are there.
    #[inline]
    fn bytes<const N: usize>(&self, at: usize) -> Option<[u8; N]> {
        self.data.get(at..)?.first_chunk().copied()
    }
}

impl fmt::Debug for FrameView<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FrameView({}x{}, stride {}, {:?})", self.width, self.height, self.stride, self.format)
    }
}

/// Five and six bits widened to eight by repeating the high bits, so that white stays white.
#[inline]
const fn from_565(word: u16) -> Rgb {
    let (r, g, b) = ((word >> 11) as u8, (word >> 5) as u8 & 0x3f, word as u8 & 0x1f);
    Rgb { r: r << 3 | r >> 2, g: g << 2 | g >> 4, b: b << 3 | b >> 2 }
}

/// BT.601 limited range in 8.8 fixed point, rounded: the same integers on every target.
#[inline]
const fn from_yuv(y: u8, u: u8, v: u8) -> Rgb {
    let c = 298 * (y as i32 - 16);
    let d = u as i32 - 128;
    let e = v as i32 - 128;
    Rgb {
        r: clamp8((c + 409 * e + 128) >> 8),
        g: clamp8((c - 100 * d - 208 * e + 128) >> 8),
        b: clamp8((c + 516 * d + 128) >> 8),
    }
}

#[inline]
const fn clamp8(value: i32) -> u8 {
    if value < 0 {
        0
    } else if value > 255 {
        255
    } else {
        value as u8
    }
}

#[cfg(test)]
mod tests;
