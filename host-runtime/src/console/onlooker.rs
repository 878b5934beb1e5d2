//! Pictures of a camera of this computer, for pages that look at it.

use super::desk::{Desk, Shown};
use super::snapshot::BallView;
use crate::station::camera::{Onlooker, Windows};
use crate::station::{Marks, Preview};
use std::io;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::wire::ObservationPacket;

/// Pictures a second, at most.
const FPS: f64 = 15.0;

/// Looks on for the pages.
struct ForPages {
    desk: Desk,
    view: usize,
    preview: Preview,
}

impl Onlooker for ForPages {
    fn pictured(&mut self, picture: &FrameView<'_>, packet: &ObservationPacket, windows: &Windows) {
        if self.desk.is_looked_at(self.view) {
            self.preview.offer(picture, packet, windows);
        }
    }
}

/// What the camera's thread hands its pictures to: nothing is done while nobody looks at the view, and where
/// somebody does, a copy is made fifteen times a second and encoded on another thread.
///
/// # Errors
/// The system has no thread left.
pub fn onlooker(desk: &Desk, view: usize) -> io::Result<Box<dyn Onlooker>> {
    let to = desk.clone();
    let preview = Preview::start(FPS, Marks::Beside, move |picture, packet, windows| {
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
    Ok(Box::new(ForPages { desk: desk.clone(), view, preview }))
}
