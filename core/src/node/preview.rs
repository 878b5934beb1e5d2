//! What the windows around the balls hold, for people: a thumbnail of one ball after the other, in strips.
//!
//! A thumbnail is copied while its picture is there, so that all of it is of that picture. Its strips go one
//! with each picture: beside an observation a slow line has room for one, and not for three.

use crate::geometry::round_to_i32;
use crate::observation::{BALLS, Ball, Observation, ObservationState, Observations};
use crate::vision::frame::FrameView;
use crate::wire::PreviewPacket;
use crate::wire::preview::Strip;

/// How much wider than its ball a thumbnail is about: as much again beside it says where it lies.
const DIAMETERS: f32 = 2.0;

/// The thumbnails of one camera.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Preview {
    /// A thumbnail begins every so many pictures; 0 for none.
    every: u16,
    /// Pictures since the newest began.
    since: u16,
    /// Whose turn it is next.
    turn: Ball,
    /// The next strip of the newest; behind the last there is nothing to show.
    next: usize,
    /// Where the newest is, and of which picture.
    taken: Taken,
    strips: [Strip; PreviewPacket::STRIPS],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Taken {
    sequence: u32,
    ball: Ball,
    place: Place,
}

/// The part of a picture that a thumbnail shows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    left: u16,
    top: u16,
    step: u8,
}

impl Preview {
    /// None.
    pub(super) const fn off() -> Self {
        Self {
            every: 0,
            since: 0,
            turn: Ball::Red,
            next: PreviewPacket::STRIPS,
            taken: Taken { sequence: 0, ball: Ball::Red, place: Place { left: 0, top: 0, step: 1 } },
            strips: [[[0; PreviewPacket::ROW_BYTES]; PreviewPacket::STRIP_ROWS]; PreviewPacket::STRIPS],
        }
    }

    /// One every so many pictures from the next on; none where that is 0.
    pub(super) fn begin(&mut self, every: u16) {
        self.every = every;
        self.forget();
    }

    /// The pictures that come next are of another time: what is left of an old one is not shown.
    pub(super) fn forget(&mut self) {
        self.next = PreviewPacket::STRIPS;
        // a thumbnail is due
        self.since = u16::MAX;
    }

    /// Looks at a picture whose balls are known; the strip that goes with it. `named` are the camera, its session and
    /// the number of the picture's observation.
    pub(super) fn picture(
        &mut self,
        frame: &FrameView<'_>,
        balls: &Observations,
        named: (u8, u32, u32),
    ) -> Option<PreviewPacket> {
        if self.every == 0 {
            return None;
        }
        let (camera, session, sequence) = named;
        self.since = self.since.saturating_add(1);
        if self.next >= PreviewPacket::STRIPS && self.since >= self.every {
            self.take(frame, balls, sequence);
        }
        let pixels = *self.strips.get(self.next)?;
        let row = self.next * PreviewPacket::STRIP_ROWS;
        self.next += 1;
        let Taken { sequence, ball, place: Place { left, top, step } } = self.taken;
        Some(PreviewPacket { camera, session, sequence, ball, left, top, step, row: row as u8, pixels })
    }

    /// Copies what is around the next ball that has a place; nothing where none has.
    fn take(&mut self, frame: &FrameView<'_>, balls: &Observations, sequence: u32) {
        let in_turn = Ball::ALL.into_iter().zip(balls).cycle().skip(self.turn.index()).take(BALLS);
        let placed = in_turn.filter_map(|(ball, seen)| Some((ball, place(frame, seen)?))).next();
        let Some((ball, place)) = placed else { return };
        self.taken = Taken { sequence, ball, place };
        self.turn = match ball {
            Ball::Red => Ball::Green,
            Ball::Green => Ball::Blue,
            Ball::Blue => Ball::Yellow,
            Ball::Yellow => Ball::Red,
        };
        (self.next, self.since) = (0, 0);
        let step = i32::from(place.step);
        let mut y = i32::from(place.top) + step / 2;
        for row in self.strips.iter_mut().flatten() {
            let mut x = i32::from(place.left) + step / 2;
            for bytes in row.as_chunks_mut::<2>().0 {
                let rgb = frame.pixel(x, y).unwrap_or_default();
                let [r, g, b] = [rgb.r, rgb.g, rgb.b].map(u16::from);
                *bytes = (r >> 3 << 11 | g >> 2 << 5 | b >> 3).to_be_bytes();
                x += step;
            }
            y += step;
        }
    }
}

/// Where a ball's thumbnail is; `None` for a ball without a place, and in a picture that is smaller than one.
fn place(frame: &FrameView<'_>, seen: &Observation) -> Option<Place> {
    if seen.state == ObservationState::Lost {
        return None;
    }
    let (wide, high) = (i32::from(PreviewPacket::WIDTH), i32::from(PreviewPacket::HEIGHT));
    let (width, height) = (i32::from(frame.width()), i32::from(frame.height()));
    let wanted = round_to_i32(DIAMETERS * seen.diameter / f32::from(PreviewPacket::WIDTH)).max(1);
    let step = wanted.min(width / wide).min(height / high).min(i32::from(u8::MAX));
    // from the corner on that has the centre in the middle, and inside the picture
    let from = |centre: f32, size: i32, side: i32| {
        let corner = round_to_i32(centre).saturating_sub(size * step / 2);
        u16::try_from(corner.min(side - size * step).max(0)).ok()
    };
    if step < 1 {
        return None;
    }
    let (left, top) = (from(seen.centre.u, wide, width)?, from(seen.centre.v, high, height)?);
    Some(Place { left, top, step: u8::try_from(step).ok()? })
}
