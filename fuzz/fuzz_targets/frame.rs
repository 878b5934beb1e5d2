//! Any buffer, size, stride and format: refused with a reason, or a frame whose every pixel can be
//! read and whose outside cannot.
#![no_main]

use libfuzzer_sys::fuzz_target;
use tetrad_core::vision::frame::{FrameView, PixelFormat};

fuzz_target!(|input: (u16, u16, usize, u8, i32, i32, &[u8])| {
    let (width, height, stride, format, x, y, data) = input;
    let format = PixelFormat::ALL[usize::from(format) % PixelFormat::ALL.len()];
    // Small sizes as often as impossible ones: most buffers are too short for anything else.
    for (width, height) in [(width, height), (width % 64, height % 64)] {
        for stride in [stride, format.row_bytes(usize::from(width)), stride % 512] {
            let Ok(frame) = FrameView::new(data, width, height, stride, format) else { continue };
            assert_eq!(frame.pixel(x, y).is_some(), frame.contains(x, y));
            let (right, bottom) = (i32::from(width), i32::from(height));
            for row in 0..bottom {
                assert!((0..right).all(|column| frame.pixel(column, row).is_some()));
            }
            assert!(frame.pixel(right, 0).is_none() && frame.pixel(0, bottom).is_none());
        }
    }
});
