//! What a smart camera shows of its balls: strips to thumbnails, and these to a picture.
//!
//! ```text
//! strips --three of one picture--> a thumbnail --the newest of each ball--> a dark picture with them in their places
//! ```
//!
//! A thumbnail that lacks a strip is not shown: what is seen together was seen at one time.

use crate::link::Received;
use tetrad_core::observation::{BALLS, Observation};
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::wire::preview::Strip;
use tetrad_core::wire::{ObservationPacket, PreviewPacket};

/// A thumbnail goes out of the picture once so many newer ones are whole: its ball had its turn twice, and was lost.
const NEWER: u64 = 2 * BALLS as u64;

/// What is no ball's is as dark as this: RGB565, high byte first.
const DARK: [u8; 2] = [0x10, 0x82];

/// The most pixels of a picture that is shown: no smart camera's has as many, and what a damaged packet claims is
/// no reason to take memory.
const MOST_PIXELS: usize = 2048 * 2048;

/// A part of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Thumbnail {
    first: PreviewPacket,
    strips: [Strip; PreviewPacket::STRIPS],
    /// What was observed in its picture.
    seen: Received<ObservationPacket>,
    /// Counts the whole ones.
    number: u64,
}

impl Thumbnail {
    /// Whether a strip is one of it.
    fn has(&self, strip: &PreviewPacket) -> bool {
        PreviewPacket { row: strip.row, pixels: strip.pixels, ..self.first } == *strip
    }
}

/// Collects strips.
#[derive(Debug, Default)]
pub(super) struct Thumbnails {
    /// What has strips, and which one is next.
    begun: Option<(Thumbnail, usize)>,
    /// The newest whole one of each ball.
    newest: [Option<Thumbnail>; BALLS],
    count: u64,
    is_new: bool,
}

impl Thumbnails {
    /// The camera began anew, or came to another port: what it showed before is over.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Takes a strip; `last` are the newest observations, behind which the first strip of their picture comes.
    pub(super) fn take(&mut self, strip: &PreviewPacket, last: Option<&Received<ObservationPacket>>) {
        let number = strip.strip();
        let thumbnail = match (number, self.begun.take()) {
            // without its observations nobody knows when it was taken
            (0, _) => last.filter(|last| last.what.sequence == strip.sequence).map(|seen| Thumbnail {
                first: *strip,
                strips: Default::default(),
                seen: *seen,
                number: 0,
            }),
            (_, Some((thumbnail, next))) if next == number && thumbnail.has(strip) => Some(thumbnail),
            _ => None,
        };
        let Some(mut thumbnail) = thumbnail else { return };
        if let Some(place) = thumbnail.strips.get_mut(number) {
            *place = strip.pixels;
        }
        if number + 1 < PreviewPacket::STRIPS {
            self.begun = Some((thumbnail, number + 1));
        } else if let Some(place) = self.newest.get_mut(strip.ball.index()) {
            self.count += 1;
            thumbnail.number = self.count;
            *place = Some(thumbnail);
            self.is_new = true;
        }
    }

    /// The picture of all that is shown, where that is another than before.
    pub(super) fn take_picture(&mut self) -> Option<Pieced> {
        if !std::mem::take(&mut self.is_new) {
            return None;
        }
        let mut shown: Vec<&Thumbnail> = self.newest.iter().flatten().collect();
        shown.retain(|thumbnail| thumbnail.number + NEWER > self.count);
        // the newest is drawn over the others
        shown.sort_by_key(|thumbnail| thumbnail.number);
        Pieced::of(&shown)
    }
}

/// A dark picture with thumbnails in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pieced {
    /// RGB565, high byte first.
    bytes: Vec<u8>,
    /// As if it had been observed at one time: of each ball what was seen in the picture of its thumbnail, the others
    /// lost; the rest is the newest thumbnail's, and taken by this station's clock.
    pub packet: ObservationPacket,
}

impl Pieced {
    fn of(shown: &[&Thumbnail]) -> Option<Self> {
        let newest = shown.last()?.seen;
        let mut packet = newest.what;
        packet.capture_us = newest.captured_us.unwrap_or(newest.received_us);
        packet.balls = [Observation::default(); BALLS];
        let (width, height) = (usize::from(packet.width), usize::from(packet.height));
        if width * height > MOST_PIXELS {
            return None;
        }
        let mut pieced = Self { bytes: DARK.repeat(width * height), packet };
        for thumbnail in shown {
            let ball = thumbnail.first.ball.index();
            if let (Some(slot), Some(seen)) =
                (pieced.packet.balls.get_mut(ball), thumbnail.seen.what.balls.get(ball))
            {
                *slot = *seen;
            }
            pieced.draw(thumbnail, width);
        }
        Some(pieced)
    }

    /// The picture.
    #[must_use]
    pub fn view(&self) -> Option<FrameView<'_>> {
        FrameView::packed(&self.bytes, self.packet.width, self.packet.height, PixelFormat::Rgb565Be).ok()
    }

    /// Each pixel as large as what it stands for; what is outside the picture is left out.
    fn draw(&mut self, thumbnail: &Thumbnail, width: usize) {
        let PreviewPacket { left, top, step, .. } = thumbnail.first;
        let (left, top, step) = (usize::from(left), usize::from(top), usize::from(step).max(1));
        let rows = thumbnail.strips.as_flattened().iter().flat_map(|row| std::iter::repeat_n(row, step));
        for (line, row) in self.bytes.chunks_exact_mut(2 * width.max(1)).skip(top).zip(rows) {
            let pixels = row.as_chunks::<2>().0.iter().flat_map(|pixel| std::iter::repeat_n(pixel, step));
            for (place, pixel) in line.as_chunks_mut::<2>().0.iter_mut().skip(left).zip(pixels) {
                *place = *pixel;
            }
        }
    }
}

#[cfg(test)]
mod tests;
