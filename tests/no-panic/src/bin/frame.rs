//! Constructing a frame from any buffer, and reading any pixel of it.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::vision::frame::{FrameView, PixelFormat};

tetrad_no_panic::program!({
    let data: &[u8] = black_box(&[0; 64]);
    for format in PixelFormat::ALL {
        let frame = FrameView::new(data, black_box(4), black_box(4), black_box(16), black_box(format));
        if let Ok(frame) = frame {
            black_box(frame.pixel(black_box(-1), black_box(3)));
        }
    }
});
