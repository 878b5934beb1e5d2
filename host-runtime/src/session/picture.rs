//! Pictures in a session: the pixels as the camera gave them, and back.

use super::schema::foxglove::{RawImage, Timestamp};
use prost::Message as _;
use prost::encoding::{WireType, encode_key, encode_varint};
use tetrad_core::vision::frame::{FrameView, PixelFormat};

/// The number of `RawImage.data`.
const DATA: u32 = 6;

/// How Foxglove calls the formats; it does not show those of 16 bits, which it has no names for.
const ENCODINGS: [(PixelFormat, &str); 8] = [
    (PixelFormat::Rgb888, "rgb8"),
    (PixelFormat::Bgr888, "bgr8"),
    (PixelFormat::Rgba8888, "rgba8"),
    (PixelFormat::Rgb565Le, "rgb565le"),
    (PixelFormat::Rgb565Be, "rgb565be"),
    (PixelFormat::Yuyv, "yuyv"),
    (PixelFormat::Uyvy, "uyvy"),
    (PixelFormat::Nv12, "nv12"),
];

/// The format's name in a session.
#[must_use]
pub(super) fn encoding(format: PixelFormat) -> &'static str {
    ENCODINGS.iter().find(|(known, _)| *known == format).map_or("", |(_, name)| name)
}

/// The format of that name.
#[must_use]
pub(super) fn format(encoding: &str) -> Option<PixelFormat> {
    ENCODINGS.iter().find(|(_, name)| *name == encoding).map(|(format, _)| *format)
}

/// Puts a picture as a [`RawImage`] behind what is in `bytes`: rows without padding, copied once.
pub(super) fn encode(view: &FrameView<'_>, camera: &str, timestamp: Timestamp, bytes: &mut Vec<u8>) {
    let row = view.format().row_bytes(usize::from(view.width()));
    let rows = view.format().rows(usize::from(view.height()));
    let message = RawImage {
        timestamp: Some(timestamp),
        frame_id: camera.to_owned(),
        width: u32::from(view.width()),
        height: u32::from(view.height()),
        encoding: encoding(view.format()).to_owned(),
        // at most four bytes a pixel of 8192
        step: row as u32,
        data: Vec::new(),
    };
    bytes.extend_from_slice(&message.encode_to_vec());
    encode_key(DATA, WireType::LengthDelimited, bytes);
    encode_varint((row * rows) as u64, bytes);
    if view.stride() == row {
        bytes.extend_from_slice(view.data());
    } else {
        view.data().chunks(view.stride()).for_each(|padded| bytes.extend(padded.iter().take(row)));
    }
}

/// The picture in a message.
///
/// # Errors
/// What about it is no picture.
pub(crate) fn view(image: &RawImage) -> Result<FrameView<'_>, String> {
    let format = format(&image.encoding)
        .ok_or_else(|| format!("pictures in the format `{}` are not read here", image.encoding))?;
    let side = |side: u32| u16::try_from(side).map_err(|_| format!("a side of {side} pixels is too long"));
    let stride = usize::try_from(image.step).map_err(|error| error.to_string())?;
    FrameView::new(&image.data, side(image.width)?, side(image.height)?, stride, format)
        .map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_pixel_by_pixel_without_its_padding() {
        let bytes: Vec<u8> = (0..=255).cycle().take(40 * 8).collect();
        for (format, name) in ENCODINGS {
            let (width, height, stride) = (8, 4, 40);
            let row = format.row_bytes(8);
            let whole = format.rows(4) * stride;
            for length in [whole, whole - (stride - row)] {
                let padded = FrameView::new(&bytes[..length], width, height, stride, format).unwrap();
                let mut message = Vec::new();
                encode(&padded, "left", Timestamp::of_us(1_500_000), &mut message);
                let image = RawImage::decode(message.as_slice()).unwrap();
                assert_eq!((image.encoding.as_str(), image.step as usize), (name, row));
                assert_eq!(image.timestamp, Some(Timestamp { seconds: 1, nanos: 500_000_000 }));
                let back = view(&image).unwrap();
                let pixels = |view: &FrameView<'_>| -> Vec<_> {
                    (0..32).map(|at| view.pixel(at % 8, at / 8)).collect()
                };
                assert_eq!(pixels(&back), pixels(&padded), "{name}");
            }
        }
    }

    #[test]
    fn what_is_no_picture_is_refused_in_words() {
        let image = RawImage { width: 2, height: 1, step: 6, data: vec![0; 6], ..RawImage::default() };
        let mono = RawImage { encoding: "mono8".to_owned(), ..image.clone() };
        assert_eq!(view(&mono).unwrap_err(), "pictures in the format `mono8` are not read here");
        let short = RawImage { encoding: "rgb8".to_owned(), height: 2, ..image.clone() };
        assert!(view(&short).unwrap_err().contains("needs 12 bytes"));
        let wide = RawImage { encoding: "rgb8".to_owned(), width: 70_000, ..image };
        assert_eq!(view(&wide).unwrap_err(), "a side of 70000 pixels is too long");
    }
}
