//! A drawn ball, learnt and found, to the bit: what a wrong compiler setting, another rounding or a bad
//! memory would change.

use crate::config::LearnConfig;
use crate::geometry::ImagePoint;
use crate::vision::colour::Primary;
use crate::vision::frame::{FrameView, PixelFormat};
use crate::vision::learn::learn;

const WIDTH: u16 = 40;
const HEIGHT: u16 = 30;
const PIXELS: usize = WIDTH as usize * HEIGHT as usize;

/// The disc's centre and the square of its radius, in half pixels.
const CENTRE: (i32, i32) = (41, 30);
const RADIUS_SQUARED: i32 = 12 * 12;

/// Two colours as RGB565.
const RED: u16 = 0xB924;
const GREY: u16 = 0x4A69;

/// One level of red brighter, from one column to the next.
const STEP: u16 = 1 << 11;

/// Centre and diameter as they come out on every target.
const EXPECTED: [u32; 3] = [0x41A6_E567, 0x416C_6C19, 0x4143_C706];

/// Whether what is computed here is what is computed everywhere.
pub(super) fn passes() -> bool {
    outcome() == Some(EXPECTED)
}

/// What is looked at: a ball, brighter to the right, so that what comes out is no round number. The compiler
/// draws it and it stays in flash: learning leaves no room for it on a microcontroller's stack.
static PICTURE: [[u8; 2]; PIXELS] = drawn();

const fn drawn() -> [[u8; 2]; PIXELS] {
    let mut picture = [[0; 2]; PIXELS];
    let mut index = 0;
    while index < PIXELS {
        let (x, y) = (index as i32 % WIDTH as i32, index as i32 / WIDTH as i32);
        let (du, dv) = (2 * x - CENTRE.0, 2 * y - CENTRE.1);
        let inside = du * du + dv * dv <= RADIUS_SQUARED;
        let pixel = if inside { RED + (x / 6) as u16 * STEP } else { GREY };
        picture[index] = pixel.to_le_bytes();
        index += 1;
    }
    picture
}

/// The bits of the centre and the diameter of the ball in the picture.
pub(super) fn outcome() -> Option<[u32; 3]> {
    let frame = FrameView::packed(PICTURE.as_flattened(), WIDTH, HEIGHT, PixelFormat::Rgb565Le).ok()?;
    let learnt = learn(&frame, Primary::Red, ImagePoint::new(19.0, 16.0), &LearnConfig::default()).ok()?;
    Some([learnt.centre.u.to_bits(), learnt.centre.v.to_bits(), learnt.diameter.to_bits()])
}
