//! Learning any ball from any point of any picture, and the scan through it.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::LearnConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::vision::colour::{Primary, Reference};
use tetrad_core::vision::frame::{FrameView, PixelFormat, Rgb};
use tetrad_core::vision::learn::{HorizontalScan, learn};

tetrad_no_panic::program!({
    let format = black_box(PixelFormat::Rgb565Be);
    if let Ok(frame) = FrameView::packed(black_box(&[0; 64]), black_box(8), black_box(4), format) {
        let at = black_box(ImagePoint::new(1.0, 2.0));
        let config = black_box(LearnConfig::default());
        let _ = black_box(learn(&frame, black_box(Primary::Red), at, &config));
        let colour = || black_box(Rgb::new(1, 2, 3));
        let reference = Reference {
            primary: black_box(Primary::Blue),
            reference: colour(),
            typical: colour(),
            background: colour(),
        };
        let scan = HorizontalScan::<64>::through(&frame, &reference, black_box(128), at, black_box(3.0));
        let _ = black_box(scan);
    }
});
