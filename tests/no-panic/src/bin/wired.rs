//! A slave between a serial line and a CAN bus, with any packets, frames and settings.
#![no_std]
#![no_main]

use core::fmt::Write;
use core::hint::black_box;
use tetrad_core::arm::canopen::{Frame, Frames, slcan};
use tetrad_core::arm::wired::WiredSlave;
use tetrad_core::config::{CanopenConfig, SlaveConfig};
use tetrad_core::wire::Decoder;
use tetrad_no_panic::Nowhere;

tetrad_no_panic::program!({
    let settings = black_box((SlaveConfig::default(), CanopenConfig::default()));
    match WiredSlave::new(&settings.0, &settings.1, black_box(1)) {
        Ok(mut slave) => {
            let (mut line, mut bus) = (Decoder::new(), slcan::Decoder::new());
            for _ in 0..black_box(9) {
                for packet in line.packets(black_box(&[1, 2, 3])).flatten() {
                    slave.take(&packet, black_box(10));
                }
                if let Some(slcan::Line::Frame(frame)) = bus.push(black_box(7)) {
                    slave.hear(&frame, black_box(10));
                }
                if let Some(frame) = Frame::new(black_box(0x181), black_box(&[1, 2])) {
                    slave.hear(&frame, black_box(11));
                }
                slave.hear_garbage(black_box(3));
                let mut frames = Frames::default();
                black_box(slave.cycle(black_box(12), &mut frames));
                for frame in frames.as_slice() {
                    black_box(slcan::encode(frame));
                }
                if let Some(refusal) = slave.take_refusal() {
                    let _ = write!(Nowhere, "{refusal}");
                }
                if black_box(true) {
                    slave.confirm_homed();
                    slave.stop();
                }
            }
        }
        Err(error) => {
            let _ = write!(Nowhere, "{error}");
        }
    }
});
