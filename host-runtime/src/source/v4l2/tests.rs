//! A camera in memory, and what this module makes of its moods.

mod fake;
mod running;
mod starting;

use super::*;
use crate::exit::Exit;
use crate::source::Gap;
use fake::{Arrival, Fake};

fn start(fake: &Fake, options: &Options) -> Result<Camera<Fake>, Refusal> {
    Camera::start("/dev/video7", fake.clone(), options)
}

fn running(fake: &Fake) -> Camera<Fake> {
    start(fake, &Options::default()).unwrap()
}

/// The first byte of the next picture, its number and what is missing before it.
fn look(camera: &mut Camera<Fake>) -> (u8, u64, Gap) {
    let frame = camera.next().unwrap();
    // A fake picture is filled with one grey value, its own.
    (frame.view.pixel(0, 0).unwrap().r, frame.number, frame.gap)
}

/// One picture a wait, valued and numbered 100, 101, ...
fn steady(count: u8) -> Vec<Vec<Arrival>> {
    (0..count).map(|at| vec![Arrival::picture(100 + at, u32::from(at))]).collect()
}

/// Luma `value` with neutral chroma, as core shows it.
fn grey(value: u8) -> u8 {
    (((298 * (i32::from(value) - 16)) + 128) >> 8).clamp(0, 255) as u8
}
