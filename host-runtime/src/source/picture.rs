//! One PNG or JPEG file, decoded into a buffer that is used again for the next.
//!
//! Balls are found by colour at eight bits a component, so that is what is accepted: RGB, RGBA and
//! palette PNGs, colour JPEGs. Grey and 16-bit pictures are refused rather than converted, because
//! whoever made them meant something else. Damaged and cut-off files are refused too: half a
//! picture would be tracked as if the other half were grey. The orientation tag of a JPEG is not
//! applied: pixel coordinates are those of the stored picture.

use std::{
    io::Read,
    path::{Path, PathBuf},
};

use tetrad_core::vision::frame::{MAX_SIDE, PixelFormat};
use zune_jpeg::zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};

use super::SourceError;
use crate::regular_file;

/// The most bytes a picture file may have: a picture of the greatest size, not compressed at all.
const MAX_FILE_BYTES: u64 = MAX_SIDE as u64 * MAX_SIDE as u64 * 4;

const PNG_SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
const JPEG_START: [u8; 3] = [0xff, 0xd8, 0xff];

/// A decoded picture, rows without padding. Empty until the first [`Picture::load`] and after a
/// failed one.
#[derive(Debug)]
pub struct Picture {
    /// The pixels.
    pub pixels: Vec<u8>,
    /// Width in pixels.
    pub width: u16,
    /// Height in pixels.
    pub height: u16,
    /// [`PixelFormat::Rgb888`], or [`PixelFormat::Rgba8888`] when the file has an alpha channel.
    pub format: PixelFormat,
    /// The file it was read from.
    pub path: PathBuf,
    /// The file's bytes, kept so that the next picture needs no new memory.
    file: Vec<u8>,
}

impl Default for Picture {
    fn default() -> Self {
        Self {
            pixels: Vec::new(),
            width: 0,
            height: 0,
            format: PixelFormat::Rgb888,
            path: PathBuf::new(),
            file: Vec::new(),
        }
    }
}

impl Picture {
    /// Decodes the file at `path` in place of what was here.
    ///
    /// # Errors
    /// [`SourceError::BadInput`] naming the file, what is wrong with it and what would mend it.
    pub fn load(&mut self, path: &Path) -> Result<(), SourceError> {
        (self.width, self.height) = (0, 0);
        self.pixels.clear();
        self.path = path.to_owned();
        self.file.clear();
        regular_file::open(path)
            .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut self.file))
            .map_err(|error| SourceError::input(path, format!("cannot be read: {error}")))?;
        let decoded = if self.file.is_empty() {
            Err("the file is empty".to_owned())
        } else if self.file.len() as u64 > MAX_FILE_BYTES {
            Err(format!("the file is larger than any picture that is read here ({MAX_FILE_BYTES} bytes)"))
        } else if self.file.starts_with(&PNG_SIGNATURE) {
            self.decode_png()
        } else if self.file.starts_with(&JPEG_START) {
            self.decode_jpeg()
        } else {
            Err("neither PNG nor JPEG, whatever its name says: convert it to PNG".to_owned())
        };
        decoded.map_err(|reason| SourceError::input(path, reason))
    }

    fn decode_png(&mut self) -> Result<(), String> {
        let damaged = |error| format!("damaged or cut-off PNG ({error}): write the picture again");
        let mut decoder = png::Decoder::new_with_limits(
            std::io::Cursor::new(self.file.as_slice()),
            png::Limits { bytes: MAX_FILE_BYTES as usize },
        );
        decoder.set_transformations(png::Transformations::EXPAND);
        let header = decoder.read_header_info().map_err(damaged)?;
        let (width, height) = checked_size(header.width as usize, header.height as usize)?;
        let mut reader = decoder.read_info().map_err(damaged)?;
        let format = match reader.output_color_type() {
            (png::ColorType::Rgb, png::BitDepth::Eight) => PixelFormat::Rgb888,
            (png::ColorType::Rgba, png::BitDepth::Eight) => PixelFormat::Rgba8888,
            (png::ColorType::Rgb | png::ColorType::Rgba, _) => {
                return Err(
                    "16 bits a component, and 8 are read here: `magick IN.png -depth 8 OUT.png`".to_owned()
                );
            }
            _ => return Err(grey("PNG")),
        };
        let bytes = reader.output_buffer_size().ok_or("the picture does not fit into memory")?;
        self.pixels.resize(bytes, 0);
        reader.next_frame(&mut self.pixels).map_err(damaged)?;
        // Reads on to the end chunk, so that a file cut off behind its last row is noticed as well.
        reader.finish().map_err(damaged)?;
        (self.width, self.height, self.format) = (width, height, format);
        Ok(())
    }

    fn decode_jpeg(&mut self) -> Result<(), String> {
        let damaged = |error| damaged_jpeg(&format!("{error}"));
        if !jpeg_is_whole(&self.file) {
            return Err(damaged_jpeg("it ends before its end marker"));
        }
        // Strict: otherwise the decoder fills what is missing of a cut-off file with grey.
        let options = DecoderOptions::default()
            .set_strict_mode(true)
            .set_max_width(usize::from(u16::MAX))
            .set_max_height(usize::from(u16::MAX))
            .jpeg_set_out_colorspace(ColorSpace::RGB);
        let mut decoder =
            zune_jpeg::JpegDecoder::new_with_options(ZCursor::new(self.file.as_slice()), options);
        decoder.decode_headers().map_err(damaged)?;
        let (width, height) = decoder.dimensions().ok_or("the JPEG does not say how large it is")?;
        let (width, height) = checked_size(width, height)?;
        match decoder.input_colorspace() {
            Some(ColorSpace::YCbCr | ColorSpace::RGB) => {}
            Some(ColorSpace::Luma) => return Err(grey("JPEG")),
            other => {
                let found = other.map_or("unknown colours".to_owned(), |space| format!("{space:?} colours"));
                return Err(format!(
                    "a JPEG with {found}: `magick IN.jpg -colorspace sRGB OUT.jpg` makes it readable"
                ));
            }
        }
        let bytes = decoder.output_buffer_size().ok_or("the picture does not fit into memory")?;
        self.pixels.resize(bytes, 0);
        decoder.decode_into(&mut self.pixels).map_err(damaged)?;
        (self.width, self.height, self.format) = (width, height, PixelFormat::Rgb888);
        Ok(())
    }
}

fn damaged_jpeg(how: &str) -> String {
    format!("damaged or cut-off JPEG ({how}): write the picture again")
}

/// Whether the picture's own end marker is there. A decoder may be content with less: a last scan
/// cut off within its final bytes still fills every block. What follows the end marker (a camera
/// maker's additions) is not looked at.
fn jpeg_is_whole(file: &[u8]) -> bool {
    const END_OF_IMAGE: u8 = 0xd9;
    let mut rest = file;
    // Between markers lie either the lengths of segments or the data of a scan. Data never holds
    // 0xff except before 0x00 or a restart marker, so both are passed by looking for the next marker.
    loop {
        let Some(at) = rest.windows(2).position(|pair| pair[0] == 0xff && !matches!(pair[1], 0 | 0xff))
        else {
            return false;
        };
        let marker = rest[at + 1];
        rest = &rest[at + 2..];
        match marker {
            END_OF_IMAGE => return true,
            // Start of image, restarts and the lone arithmetic marker have no length.
            0xd0..=0xd8 | 0x01 => {}
            _ => {
                let [high, low, ..] = *rest else { return false };
                let Some(after) = rest.get(usize::from(u16::from_be_bytes([high, low]))..) else {
                    return false;
                };
                rest = after;
            }
        }
    }
}

fn checked_size(width: usize, height: usize) -> Result<(u16, u16), String> {
    match (u16::try_from(width), u16::try_from(height)) {
        (Ok(width @ 1..=MAX_SIDE), Ok(height @ 1..=MAX_SIDE)) => Ok((width, height)),
        _ => Err(format!(
            "{width} x {height} pixels, and at most {MAX_SIDE} a side are read here: scale it down"
        )),
    }
}

fn grey(kind: &str) -> String {
    format!(
        "a grey {kind}, and balls are found by their colour: take the pictures in colour; if this is colour footage, write it again as RGB (`magick IN -type TrueColor PNG24:OUT.png`)"
    )
}
