//! Pictures of a camera of this computer, for pages that look at it.

use super::desk::{Desk, Shown};
use super::snapshot::BallView;
use crate::station::camera::Onlooker;
use crate::station::{Marks, Preview};
use std::io;

/// Pictures a second, at most.
const FPS: f64 = 15.0;

/// What the camera's thread hands its pictures to: nothing is done while nobody looks at the view, and where
/// somebody does, a copy is made fifteen times a second and encoded on another thread.
///
/// # Errors
/// The system has no thread left.
pub fn onlooker(desk: &Desk, view: usize) -> io::Result<Onlooker> {
    let to = desk.clone();
    let mut preview = Preview::start(FPS, Marks::Beside, move |picture, packet, windows| {
        let shown = Shown {
            sequence: picture.sequence,
            taken_us: picture.capture_us,
            width: picture.width,
            height: picture.height,
            balls: BallView::all_in(&packet.balls, windows),
            jpeg: picture.jpeg.into(),
        };
        to.show(view, shown);
    })?;
    let desk = desk.clone();
    Ok(Box::new(move |picture, packet, windows| {
        if desk.is_looked_at(view) {
            preview.offer(picture, packet, windows);
        }
    }))
}
