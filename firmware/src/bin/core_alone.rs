//! Core by itself, in the firmware's profile: what it takes of flash. It is linked and never run.
//!
//! It is what a smart camera has of core: balls taught by each command, tracked in both modes in pictures of any
//! format, and packets both ways. Without texts, tasks and semihosting, and without a panic: when one is
//! left, the linker misses [`a_panic_path_is_left`].
#![no_std]
#![no_main]

use core::hint::black_box;
use core::panic::PanicInfo;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{Decoder, MAX_FRAME_LEN, Packet, encode};

unsafe extern "C" {
    safe fn a_panic_path_is_left() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    a_panic_path_is_left()
}

/// A packet as bytes of the line.
fn send(packet: &Packet) {
    let mut frame = [0; MAX_FRAME_LEN];
    let _ = black_box(encode(packet, &mut frame));
    black_box(&frame);
}

fn camera() {
    let config = NodeConfig {
        camera: black_box(1),
        session: black_box(2),
        tracker: black_box(TrackerConfig::default()),
        learn: black_box(LearnConfig::default()),
        started: black_box(true),
    };
    let Ok(mut node) = Node::new(&config) else { return };
    let mut decoder = Decoder::new();
    for received in decoder.packets(black_box(&[0; 64])) {
        let notice = match received {
            Ok(Packet::Command(told)) => node.command(&told),
            _ => Some(node.not_understood()),
        };
        if let Some(notice) = notice {
            send(&notice.into());
        }
    }
    let picture: &[u8] = black_box(&[0; 64]);
    match FrameView::packed(picture, black_box(8), black_box(4), black_box(PixelFormat::Rgb565Be)) {
        Ok(frame) => {
            let seen = node.picture(&frame, black_box(1), black_box(2));
            for notice in &seen.notices {
                send(&(*notice).into());
            }
            if let Some(observation) = seen.observation {
                send(&observation.into());
            }
            if let Some(strip) = seen.preview {
                send(&strip.into());
            }
        }
        Err(error) => send(&node.refuse(error.into()).into()),
    }
}

/// The linker's entry point.
#[unsafe(no_mangle)]
pub extern "C" fn _start() -> ! {
    camera();
    loop {
        core::hint::spin_loop();
    }
}
