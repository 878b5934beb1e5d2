use super::*;
use FrameError::{Empty, OddHeight, OddWidth, StrideTooSmall, TooLarge, WrongLength};
use PixelFormat::{Bgr888, Nv12, Rgb565Be, Rgb565Le, Rgb888, Rgba8888, Uyvy, Yuyv};

const SHARES_COLUMNS: [PixelFormat; 3] = [Yuyv, Uyvy, Nv12];

/// Bytes that no picture below is made of: read by mistake they give another colour.
const PADDING: u8 = 0x5a;

const fn rgb(r: u8, g: u8, b: u8) -> Rgb {
    Rgb::new(r, g, b)
}

fn refusal(
    data: &[u8],
    (width, height): (u16, u16),
    stride: usize,
    format: PixelFormat,
) -> Option<FrameError> {
    FrameView::new(data, width, height, stride, format).err()
}

/// A picture of one format: the bytes of its rows, and its pixels as worked out by hand.
struct Example<const PIXELS: usize> {
    format: PixelFormat,
    size: (u16, u16),
    rows: &'static [&'static [u8]],
    pixels: [Rgb; PIXELS],
}

impl<const PIXELS: usize> Example<PIXELS> {
    /// Reads the picture with rows of every padding from 0 to 5 bytes, the last row's there or not.
    fn check(&self) {
        for padding in 0..6 {
            let mut buffer = [PADDING; 128];
            let stride = self.rows[0].len() + padding;
            for (at, row) in buffer.chunks_mut(stride).zip(self.rows) {
                at[..row.len()].copy_from_slice(row);
            }
            let whole = stride * self.rows.len();
            for length in whole - padding..=whole {
                self.check_buffer(&buffer[..length], stride);
            }
            let needed = whole - padding;
            for given in [0, needed - 1, whole + 1] {
                assert_eq!(
                    refusal(&buffer[..given], self.size, stride, self.format),
                    Some(WrongLength { needed, given }),
                    "{:?}, padding {padding}",
                    self.format
                );
            }
        }
    }

    fn check_buffer(&self, data: &[u8], stride: usize) {
        let (width, height) = self.size;
        let view = FrameView::new(data, width, height, stride, self.format).unwrap();
        assert_eq!((view.width(), view.height(), view.format()), (width, height, self.format));
        let (width, height) = (i32::from(width), i32::from(height));
        let mut expected = self.pixels.into_iter();
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            assert_eq!(view.pixel(x, y), expected.next(), "{view:?}, column {x}, row {y}");
        }
        assert_eq!(expected.next(), None);
        for x in [-1, width, i32::MIN, i32::MAX] {
            assert_eq!(view.pixel(x, 0), None, "{view:?}, column {x}");
            assert_eq!(view.pixel(x, height - 1), None, "{view:?}, column {x}");
        }
        for y in [-1, height, i32::MIN, i32::MAX] {
            assert_eq!(view.pixel(0, y), None, "{view:?}, row {y}");
            assert_eq!(view.pixel(width - 1, y), None, "{view:?}, row {y}");
        }
    }
}

#[test]
fn rgb888_is_read_in_order() {
    Example {
        format: Rgb888,
        size: (3, 2),
        rows: &[&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[10, 11, 12, 13, 14, 15, 253, 254, 255]],
        pixels: [
            rgb(1, 2, 3),
            rgb(4, 5, 6),
            rgb(7, 8, 9),
            rgb(10, 11, 12),
            rgb(13, 14, 15),
            rgb(253, 254, 255),
        ],
    }
    .check();
}

#[test]
fn bgr888_is_read_backwards() {
    Example {
        format: Bgr888,
        size: (3, 2),
        rows: &[&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[10, 11, 12, 13, 14, 15, 253, 254, 255]],
        pixels: [
            rgb(3, 2, 1),
            rgb(6, 5, 4),
            rgb(9, 8, 7),
            rgb(12, 11, 10),
            rgb(15, 14, 13),
            rgb(255, 254, 253),
        ],
    }
    .check();
}

#[test]
fn rgba8888_leaves_the_fourth_byte_out() {
    Example {
        format: Rgba8888,
        size: (1, 3),
        rows: &[&[1, 2, 3, 99], &[4, 5, 6, 0], &[253, 254, 255, 7]],
        pixels: [rgb(1, 2, 3), rgb(4, 5, 6), rgb(253, 254, 255)],
    }
    .check();
}

/// Five bits abcde become abcdeabc, six bits abcdef become abcdefab: 1 becomes 8 (red, blue) or 4
/// (green), 16 becomes 132, 32 becomes 130.
const FROM_565: [Rgb; 9] = [
    rgb(255, 0, 0),   // f800
    rgb(0, 255, 0),   // 07e0
    rgb(0, 0, 255),   // 001f
    rgb(8, 0, 0),     // 0800
    rgb(0, 4, 0),     // 0020
    rgb(0, 0, 8),     // 0001
    rgb(132, 0, 132), // 8010
    rgb(0, 130, 0),   // 0400
    rgb(16, 69, 165), // 1234: 00010 010001 10100
];

#[test]
fn rgb565_low_byte_first() {
    Example {
        format: Rgb565Le,
        size: (3, 3),
        rows: &[
            &[0x00, 0xf8, 0xe0, 0x07, 0x1f, 0x00],
            &[0x00, 0x08, 0x20, 0x00, 0x01, 0x00],
            &[0x10, 0x80, 0x00, 0x04, 0x34, 0x12],
        ],
        pixels: FROM_565,
    }
    .check();
}

#[test]
fn rgb565_high_byte_first() {
    Example {
        format: Rgb565Be,
        size: (3, 3),
        rows: &[
            &[0xf8, 0x00, 0x07, 0xe0, 0x00, 0x1f],
            &[0x08, 0x00, 0x00, 0x20, 0x00, 0x01],
            &[0x80, 0x10, 0x04, 0x00, 0x12, 0x34],
        ],
        pixels: FROM_565,
    }
    .check();
}

/// R = 1.164 (Y - 16) + 1.596 (V - 128), G = 1.164 (Y - 16) - 0.392 (U - 128) - 0.813 (V - 128),
/// B = 1.164 (Y - 16) + 2.017 (U - 128), rounded and kept within 0 to 255.
///
/// Y 16 and 235 without colour: black and white. U 90, V 239: Y 81 gives 75.7 + 177.2 = 252.8,
/// 75.7 + 14.9 - 90.2 = 0.3, 75.7 - 76.7 = -1.0; Y 145 gives 150.2 + 177.2 = 327.4,
/// 150.2 + 14.9 - 90.2 = 74.9, 150.2 - 76.7 = 73.6. No colour again: Y 126 gives 128.1. U 240, V 110:
/// Y 41 gives 29.1 - 28.7 = 0.4, 29.1 - 43.9 + 14.6 = -0.1, 29.1 + 225.9 = 255.0; Y 201 gives
/// 215.4 - 28.7 = 186.7, 215.4 - 43.9 + 14.6 = 186.2, 441.3.
const FROM_YUV: [[Rgb; 2]; 4] = [
    [rgb(0, 0, 0), rgb(255, 255, 255)],
    [rgb(253, 0, 0), rgb(255, 75, 74)],
    [rgb(128, 128, 128), rgb(0, 0, 0)],
    [rgb(0, 0, 255), rgb(187, 186, 255)],
];

#[test]
fn yuyv_shares_chroma_between_two_columns() {
    let [a, b, c, d] = FROM_YUV;
    Example {
        format: Yuyv,
        size: (4, 2),
        rows: &[&[16, 128, 235, 128, 81, 90, 145, 239], &[126, 128, 16, 128, 41, 240, 201, 110]],
        pixels: [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]],
    }
    .check();
}

#[test]
fn uyvy_shares_chroma_between_two_columns() {
    let [a, b, c, d] = FROM_YUV;
    Example {
        format: Uyvy,
        size: (4, 2),
        rows: &[&[128, 16, 128, 235, 90, 81, 239, 145], &[128, 126, 128, 16, 240, 41, 110, 201]],
        pixels: [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]],
    }
    .check();
}

/// Four squares of two by two pixels, one pair of U and V each; the lower row has the brightness of
/// the upper one the other way round.
#[test]
fn nv12_shares_chroma_between_two_columns_and_two_rows() {
    let [a, b, c, d] = FROM_YUV;
    Example {
        format: Nv12,
        size: (4, 4),
        rows: &[
            &[16, 235, 81, 145],
            &[235, 16, 145, 81],
            &[126, 16, 41, 201],
            &[16, 126, 201, 41],
            &[128, 128, 90, 239],
            &[128, 128, 240, 110],
        ],
        pixels: [
            a[0], a[1], b[0], b[1], //
            a[1], a[0], b[1], b[0], //
            c[0], c[1], d[0], d[1], //
            c[1], c[0], d[1], d[0],
        ],
    }
    .check();
}

#[test]
fn a_picture_without_pixels_is_refused() {
    for format in PixelFormat::ALL {
        for size in [(0, 0), (0, 2), (2, 0)] {
            assert_eq!(refusal(&[0; 64], size, 8, format), Some(Empty), "{format:?}");
        }
    }
}

#[test]
fn a_picture_over_the_largest_side_is_refused() {
    // The widest row of all formats, of four bytes a pixel.
    static ROW: [u8; 4 * MAX_SIDE as usize] = [0; 4 * MAX_SIDE as usize];
    for format in PixelFormat::ALL {
        // Even, and odd: it is too large before it is anything else.
        for side in [MAX_SIDE + 1, MAX_SIDE + 2, u16::MAX] {
            for size in [(side, 2), (2, side)] {
                assert_eq!(refusal(&ROW, size, 4 * usize::from(side), format), Some(TooLarge), "{format:?}");
            }
        }
        let rows = if format == Nv12 { 2 } else { 1 };
        let stride = format.row_bytes(usize::from(MAX_SIDE));
        let data = &ROW[..stride * format.rows(rows)];
        let at_the_limit = FrameView::packed(data, MAX_SIDE, rows as u16, format);
        assert!(at_the_limit.is_ok(), "{format:?}");
        let last = at_the_limit.unwrap().pixel(i32::from(MAX_SIDE) - 1, 0);
        assert!(last.is_some(), "{format:?}");
    }
}

#[test]
fn an_odd_width_is_refused_where_columns_share_chroma() {
    for format in PixelFormat::ALL {
        let row = format.row_bytes(3);
        let expected = SHARES_COLUMNS.contains(&format).then_some(OddWidth);
        let length = row * format.rows(2);
        assert_eq!(refusal(&[0; 64][..length], (3, 2), row, format), expected, "{format:?}");
    }
}

#[test]
fn an_odd_height_is_refused_where_rows_share_chroma() {
    for format in PixelFormat::ALL {
        let row = format.row_bytes(2);
        let expected = (format == Nv12).then_some(OddHeight);
        let length = row * format.rows(3);
        assert_eq!(refusal(&[0; 64][..length], (2, 3), row, format), expected, "{format:?}");
    }
}

#[test]
fn a_stride_below_a_row_is_refused() {
    let bytes = [12, 12, 16, 8, 8, 8, 8, 4];
    for (format, needed) in PixelFormat::ALL.into_iter().zip(bytes) {
        for given in [0, 1, needed - 1] {
            let refused = refusal(&[0; 64], (4, 2), given, format);
            assert_eq!(refused, Some(StrideTooSmall { needed, given }), "{format:?}");
        }
        let length = needed * format.rows(2);
        assert_eq!(refusal(&[0; 64][..length], (4, 2), needed, format), None, "{format:?}");
    }
}

#[test]
fn a_stride_whose_rows_overflow_is_refused() {
    let data = [0; 24];
    for format in PixelFormat::ALL {
        for stride in [usize::MAX, usize::MAX / 2, usize::MAX / 8 + 1] {
            let refused = refusal(&data, (8, 16), stride, format);
            assert_eq!(refused, Some(WrongLength { needed: usize::MAX, given: 24 }), "{format:?}");
        }
    }
}
