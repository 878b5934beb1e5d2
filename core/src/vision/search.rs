//! Where to look next: the uniform and the spiral search of section 3.2, as pure geometry.
//!
//! Neither looks at a pixel. Each yields coordinates; its state is a small `Copy` value, so the
//! alternation can go back to the uniform search exactly where it left it.
//!
//! Worst cases, for a region of side L and an expected diameter d: the uniform search yields
//! 1 + 4 + ... + 4^k coordinates with L / 2^k the first box under d / 2, that is fewer than
//! (16/3) (2 L / d)^2; the spiral yields at most (3 d + 2)^2 with the paper's bound.

use crate::geometry::round_to_i32;

/// A rectangle of pixels: columns `x0..x1`, rows `y0..y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First column.
    pub x0: i32,
    /// First row.
    pub y0: i32,
    /// One past the last column.
    pub x1: i32,
    /// One past the last row.
    pub y1: i32,
}

impl Region {
    /// The square of `side` pixels centred at (`u`, `v`), cut to `width` x `height` pixels. `None`
    /// when nothing is left or the centre is not a number.
    #[must_use]
    pub fn square(u: f32, v: f32, side: f32, width: u16, height: u16) -> Option<Self> {
        if !(u.is_finite() && v.is_finite() && side.is_finite()) {
            return None;
        }
        let half = side * 0.5;
        // `as` saturates, so a centre far outside gives an empty region and not a wrapped one.
        let region = Self {
            x0: round_to_i32(u - half).max(0),
            y0: round_to_i32(v - half).max(0),
            x1: round_to_i32(u + half).saturating_add(1).min(i32::from(width)),
            y1: round_to_i32(v + half).saturating_add(1).min(i32::from(height)),
        };
        (region.width() > 0 && region.height() > 0).then_some(region)
    }

    /// The whole of a picture of `width` x `height` pixels.
    #[must_use]
    pub fn whole(width: u16, height: u16) -> Self {
        Self { x0: 0, y0: 0, x1: i32::from(width), y1: i32::from(height) }
    }

    /// Columns; not positive when empty.
    #[must_use]
    pub const fn width(&self) -> i32 {
        self.x1.saturating_sub(self.x0)
    }

    /// Rows; not positive when empty.
    #[must_use]
    pub const fn height(&self) -> i32 {
        self.y1.saturating_sub(self.y0)
    }
}

/// Coordinates beyond plus or minus this are brought to it: twice the largest picture, far inside what
/// the arithmetic here can hold.
const FARTHEST: i32 = 2 * 8192;

/// Most times a region may be halved: 8192 / 2^13 is one pixel.
const MAX_LEVEL: u32 = 13;

/// The uniform search: the centre of the region, then of its 4 quarters, of their 16 quarters, until
/// the box is under half the expected diameter. `Copy`: keeping a copy is keeping the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UniformSearch {
    region: Region,
    level: u32,
    last_level: u32,
    column: i32,
    row: i32,
}

impl UniformSearch {
    /// A search of `region` for something `diameter` pixels across.
    #[must_use]
    pub fn new(region: Region, diameter: f32) -> Self {
        let inside = |c: i32| c.clamp(-FARTHEST, FARTHEST);
        let region = Region {
            x0: inside(region.x0),
            y0: inside(region.y0),
            x1: inside(region.x1),
            y1: inside(region.y1),
        };
        let side = region.width().max(region.height()) as f32;
        let mut last_level = 0;
        let mut box_side = side;
        // At least one pixel: finer than the picture's own grid there is nothing to see.
        let limit = if diameter * 0.5 > 1.0 { diameter * 0.5 } else { 1.0 };
        while box_side >= limit && last_level < MAX_LEVEL {
            box_side *= 0.5;
            last_level += 1;
        }
        Self { region, level: 0, last_level, column: 0, row: 0 }
    }

    /// The side of the smallest box, pixels: what lies between two neighbouring coordinates.
    #[must_use]
    pub fn finest_box(&self) -> f32 {
        self.region.width().max(self.region.height()) as f32 / (1u32 << self.last_level) as f32
    }
}

impl Iterator for UniformSearch {
    type Item = (i32, i32);

    fn next(&mut self) -> Option<(i32, i32)> {
        if self.level > self.last_level {
            return None;
        }
        let boxes = 1i32 << self.level;
        // Centre of box c of n over a side of w pixels: w (2 c + 1) / 2 n. 8192 * 2^14 fits an i32.
        let x = self.region.x0 + ((self.region.width() * (2 * self.column + 1)) >> (self.level + 1));
        let y = self.region.y0 + ((self.region.height() * (2 * self.row + 1)) >> (self.level + 1));
        self.column += 1;
        if self.column == boxes {
            self.column = 0;
            self.row += 1;
            if self.row == boxes {
                self.row = 0;
                self.level += 1;
            }
        }
        Some((x, y))
    }
}

/// The square spiral: segments of 1, 1, 2, 2, 3, 3, ... pixels, a quarter turn after each, until
/// n (n + 1) + 1 exceeds the bound. The first coordinate is the start itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spiral {
    x: i32,
    y: i32,
    dx: i32,
    dy: i32,
    /// n: pixels in the present segment.
    segment: i32,
    left_in_segment: i32,
    second_of_pair: bool,
    last_segment: i32,
    /// Pixels still missing from the square that the present turn completes.
    left_in_turn: i32,
    /// Half the side of that square, rounded down.
    turn: i32,
}

impl Spiral {
    /// A spiral from (`x`, `y`) over a square of `bound_side` pixels: the paper's 3 d.
    #[must_use]
    pub fn new(x: i32, y: i32, bound_side: f32) -> Self {
        let (x, y) = (x.clamp(-FARTHEST, FARTHEST), y.clamp(-FARTHEST, FARTHEST));
        let bound = bound_side * bound_side;
        let mut last_segment = 1;
        while ((last_segment * (last_segment + 1) + 1) as f32) <= bound && last_segment < 2 * 8192 {
            last_segment += 1;
        }
        // One pixel before the start, in a first segment that is one longer: the first step is to it.
        Self {
            x: x - 1,
            y,
            dx: 1,
            dy: 0,
            segment: 1,
            left_in_segment: 2,
            second_of_pair: false,
            last_segment,
            left_in_turn: 1,
            turn: 0,
        }
    }

    /// Whether the coordinate yielded last closed a turn: the square seen so far is complete.
    #[must_use]
    pub const fn closed_a_turn(&self) -> bool {
        self.left_in_turn == 0 && self.turn > 0
    }
}

impl Iterator for Spiral {
    type Item = (i32, i32);

    #[inline]
    fn next(&mut self) -> Option<(i32, i32)> {
        if self.segment > self.last_segment {
            return None;
        }
        self.x += self.dx;
        self.y += self.dy;
        self.left_in_segment -= 1;
        if self.left_in_turn == 0 {
            self.turn += 1;
            // The ring around a square of side 2 k - 1.
            self.left_in_turn = 8 * self.turn;
        }
        self.left_in_turn -= 1;
        let here = (self.x, self.y);
        if self.left_in_segment == 0 {
            // A quarter turn: right, up, left, down.
            (self.dx, self.dy) = (self.dy, -self.dx);
            if self.second_of_pair {
                self.segment += 1;
            }
            self.second_of_pair = !self.second_of_pair;
            self.left_in_segment = self.segment;
        }
        Some(here)
    }
}

#[cfg(test)]
mod tests;
