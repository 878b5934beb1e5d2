//! Pictures as JPEG, made so that what moves the arm never waits for it.

use jpeg_encoder::{Encoder, EncodingError, ImageBuffer, JpegColorType, rgb_to_ycbcr};
use tetrad_core::vision::frame::{FrameView, Rgb};

/// Of the JPEG: what is looked at is where the marks are.
const PREVIEW_QUALITY: u8 = 75;

/// A camera's picture as a JPEG file, as previews are.
///
/// # Errors
/// The picture has no pixels.
pub(crate) fn jpeg(view: &FrameView<'_>) -> Result<Vec<u8>, EncodingError> {
    let mut file = Vec::new();
    encode_jpeg(&mut file, view, PREVIEW_QUALITY)?;
    Ok(file)
}

/// Writes a picture as a JPEG file behind what `file` holds; `quality` is of 100.
///
/// Encoding takes milliseconds, and newer kernels let a thread finish its slice before one that has just
/// been woken gets its turn, however little the first one's niceness leaves it. So it gives way after
/// each row: some tens of microseconds pass between two of these moments.
///
/// # Errors
/// The picture has no pixels.
pub(crate) fn encode_jpeg(
    file: &mut Vec<u8>,
    view: &FrameView<'_>,
    quality: u8,
) -> Result<(), EncodingError> {
    Encoder::new(file, quality).encode_image(Rows(view))
}

/// A picture that is read row by row.
struct Rows<'a>(&'a FrameView<'a>);

impl ImageBuffer for Rows<'_> {
    fn get_jpeg_color_type(&self) -> JpegColorType {
        JpegColorType::Ycbcr
    }

    fn width(&self) -> u16 {
        self.0.width()
    }

    fn height(&self) -> u16 {
        self.0.height()
    }

    fn fill_buffers(&self, y: u16, [luma, blue, red, _]: &mut [Vec<u8>; 4]) {
        std::thread::yield_now();
        for x in 0..self.0.width() {
            let Rgb { r, g, b } = self.0.pixel(x.into(), y.into()).unwrap_or_default();
            let (y, cb, cr) = rgb_to_ycbcr(r, g, b);
            luma.push(y);
            blue.push(cb);
            red.push(cr);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use jpeg_encoder::ColorType;
    use tetrad_core::vision::frame::PixelFormat;

    #[test]
    fn the_file_is_the_one_that_the_library_makes_of_the_same_pixels() {
        let (width, height) = (50, 34);
        let rgb: Vec<u8> = (0..width * height * 3).map(|at| (at * at % 251) as u8).collect();
        let (width, height) = (width as u16, height as u16);
        let mut theirs = Vec::new();
        Encoder::new(&mut theirs, PREVIEW_QUALITY).encode(&rgb, width, height, ColorType::Rgb).unwrap();
        let view = FrameView::new(&rgb, width, height, 3 * usize::from(width), PixelFormat::Rgb888).unwrap();
        assert_eq!(jpeg(&view).unwrap(), theirs);
    }
}
