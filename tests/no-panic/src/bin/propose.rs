//! Proposing the four balls in any number of any pictures.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::ProposeConfig;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::propose::propose;

tetrad_no_panic::program!({
    let data: &[u8] = black_box(&[0; 128]);
    let frame = || FrameView::packed(data, black_box(8), black_box(4), black_box(PixelFormat::Rgba8888));
    if let (Ok(left), Ok(right)) = (frame(), frame()) {
        let config = black_box(ProposeConfig::default());
        black_box(propose(black_box(&[left, right][..]), &config));
    }
});
