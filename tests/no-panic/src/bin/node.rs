//! A smart camera told anything, shown anything.
#![no_std]
#![no_main]

use core::hint::black_box;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::node::{Node, NodeConfig};
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::{BadPicture, Command, CommandPacket, MAX_FRAME_LEN, Packet, decode_body, encode};

tetrad_no_panic::program!({
    let config = NodeConfig {
        camera: black_box(1),
        session: black_box(2),
        tracker: black_box(TrackerConfig::default()),
        learn: black_box(LearnConfig::default()),
        started: black_box(true),
    };
    if let Ok(mut node) = Node::new(&config) {
        let learn = Command::Learn { ball: Ball::Blue, at: ImagePoint::new(1.0, 2.0) };
        let learn = black_box(CommandPacket { session: 1, sequence: 2, command: learn });
        black_box(node.command(&learn));
        if let Ok(Packet::Command(told)) = decode_body(black_box(&[0; 40])) {
            black_box(node.command(&told));
        }
        let preview = CommandPacket { session: 1, sequence: 3, command: Command::Preview { every: 4 } };
        black_box(node.command(black_box(&preview)));
        let format = black_box(PixelFormat::Rgb565Be);
        match FrameView::new(black_box(&[0; 64]), black_box(8), black_box(4), black_box(16), format) {
            Ok(frame) => {
                let seen = black_box(node.picture(&frame, black_box(1), black_box(2)));
                if let Some(strip) = seen.preview {
                    let mut line = [0; MAX_FRAME_LEN];
                    let _ = black_box(encode(&strip.into(), &mut line));
                    black_box(&line);
                }
            }
            Err(error) => {
                black_box(node.refuse(error.into()));
            }
        }
        black_box(node.refuse(black_box(BadPicture::Overrun)));
        black_box(node.not_understood());
        black_box(node.line_overrun());
    }
});
