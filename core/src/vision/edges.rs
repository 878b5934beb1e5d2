//! The rim of a ball, row by row: section 3.3's left-most and right-most matched pixels.
//!
//! The spiral hands over matched pixels from the inside out. A pixel counts when it touches what was
//! matched before, so a speck beside the ball does not widen a row. What lies between the two edges
//! of a row is taken as ball, so a highlight inside leaves no hole.

use super::colour::Matcher;
use super::frame::{FrameView, Rgb};
use super::search::Spiral;
use crate::config::MAX_ROWS;

/// Unmatched pixels within a row that do not yet part it: one, for a noisy pixel on the rim.
const ROW_GAP: i32 = 1;

/// Pixels visited before a spiral can be inconsistent: eight by eight say too little.
const EARLIEST_VERDICT: u32 = 64;

/// The first and last matched column of one row; empty while `first > last`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowExtent {
    /// j_min
    pub first: i16,
    /// j_max
    pub last: i16,
}

impl RowExtent {
    const EMPTY: Self = Self { first: i16::MAX, last: i16::MIN };

    /// Whether column `x` is at most `gap` unmatched pixels away. Never for an empty row: its ends lie
    /// beyond any column.
    #[inline]
    const fn reaches(self, x: i32, gap: i32) -> bool {
        x >= self.first as i32 - 1 - gap && x <= self.last as i32 + 1 + gap
    }

    const fn is_empty(self) -> bool {
        self.first > self.last
    }

    /// N_r of eq. 2: pixels from edge to edge, both included.
    #[must_use]
    pub const fn pixels(self) -> i32 {
        if self.is_empty() { 0 } else { self.last as i32 - self.first as i32 + 1 }
    }
}

/// Why a spiral did not end with a bounded blob.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Abandoned {
    /// The pixel it was started on does not match.
    NoMatch,
    /// Matched pixels are too small a share of those visited (section 3.2: inconsistent).
    Inconsistent,
    /// The bound was reached and the matched colour goes on: larger than any ball expected here.
    Unbounded,
}

/// How far a spiral goes and what it takes for inconsistent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpiralLimits {
    /// Side of the square it may scan, pixels (section 3.2: three diameters).
    pub side: f32,
    /// Least share of matched among visited pixels, 1/256.
    pub min_match_256: u32,
}

/// The rows of one blob. 1.5 KiB: kept by whoever searches and used again for each spiral.
#[derive(Clone)]
pub struct RowEdges {
    rows: [RowExtent; MAX_ROWS],
    /// Row 0 of the table in picture coordinates.
    top: i32,
    /// The row that the spiral started in, and how many rows above and below it may be matched.
    seed_row: i32,
    reach: i32,
    matched: u32,
    sum: [u32; 3],
}

impl Default for RowEdges {
    fn default() -> Self {
        Self::new()
    }
}

impl RowEdges {
    /// An empty table.
    #[must_use]
    pub fn new() -> Self {
        let mut edges = Self::ZERO;
        edges.clear();
        edges
    }

    /// What becomes an empty table by [`Self::clear`]. Zeros are written where they are kept; what is not
    /// zero is made elsewhere and copied, which takes its size of stack once more.
    pub(super) const ZERO: Self = Self {
        rows: [RowExtent { first: 0, last: 0 }; MAX_ROWS],
        top: 0,
        seed_row: 0,
        reach: 0,
        matched: 0,
        sum: [0; 3],
    };

    pub(super) fn clear(&mut self) {
        self.rows.fill(RowExtent::EMPTY);
    }

    /// Runs a spiral from (`x`, `y`) and keeps the edges of the blob it starts in. Ends when a whole turn adds nothing. `tested` grows by the pixels read.
    ///
    /// # Errors
    /// [`Abandoned`]; the rows then hold what was matched so far.
    pub fn collect(
        &mut self,
        frame: &FrameView<'_>,
        matcher: &Matcher,
        (x, y): (i32, i32),
        limits: SpiralLimits,
        tested: &mut u32,
    ) -> Result<(), Abandoned> {
        self.restart(y);
        let matcher = *matcher;
        let frame = *frame;
        *tested += 1;
        match frame.pixel(x, y) {
            Some(colour) if matcher.accepts(colour) => self.add(x, y, colour),
            _ => return Err(Abandoned::NoMatch),
        }
        let (mut visited, mut read) = (1u32, 0u32);
        let mut added_in_turn = 0u32;
        // A spiral of n pixels a segment reaches (n + 1) / 2 to either side.
        let reach = limits.side as i32 / 2 + 2;
        let far_from_border = frame.contains(x - reach, y - reach) && frame.contains(x + reach, y + reach);
        let mut spiral = Spiral::new(x, y, limits.side);
        spiral.next();
        self.reach = 1;
        while let Some((px, py)) = spiral.next() {
            // What does not touch the blob would not count if it matched: it is not even read.
            if far_from_border || frame.contains(px, py) {
                visited += 1;
                if self.touches(px, py) {
                    read += 1;
                    if let Some(colour) = frame.pixel_inside(px as usize, py as usize)
                        && matcher.accepts(colour)
                    {
                        self.add(px, py, colour);
                        added_in_turn += 1;
                    }
                }
            }
            if spiral.closed_a_turn() {
                if added_in_turn == 0 {
                    *tested += read;
                    return Ok(());
                }
                if visited > EARLIEST_VERDICT
                    && self.matched * 256 < visited.saturating_mul(limits.min_match_256)
                {
                    *tested += read;
                    return Err(Abandoned::Inconsistent);
                }
                added_in_turn = 0;
                self.reach = (self.reach + 1).min((MAX_ROWS / 2) as i32);
            }
        }
        *tested += read;
        Err(Abandoned::Unbounded)
    }

    fn restart(&mut self, seed_row: i32) {
        let from = self.index(self.seed_row - self.reach).min(MAX_ROWS);
        for row in self.rows.iter_mut().skip(from).take((2 * self.reach + 1) as usize) {
            *row = RowExtent::EMPTY;
        }
        self.top = seed_row - (MAX_ROWS / 2) as i32;
        self.seed_row = seed_row;
        self.reach = 0;
        self.matched = 0;
        self.sum = [0; 3];
    }

    /// Whether a pixel is beside what was matched so far.
    #[inline]
    fn touches(&self, x: i32, y: i32) -> bool {
        let Some(&[above, here, below]) = self.rows.get(self.index(y - 1)..).and_then(<[_]>::first_chunk)
        else {
            return false;
        };
        here.reaches(x, ROW_GAP) || above.reaches(x, 0) || below.reaches(x, 0)
    }

    /// Adds a matched pixel.
    #[inline]
    fn add(&mut self, x: i32, y: i32, colour: Rgb) {
        let index = self.index(y);
        // A spiral that reaches beyond the table has reached beyond its bound too.
        let Some(row) = self.rows.get_mut(index) else { return };
        // MAX_SIDE keeps coordinates inside an i16.
        row.first = row.first.min(x as i16);
        row.last = row.last.max(x as i16);
        self.matched += 1;
        let [r, g, b] = &mut self.sum;
        *r += u32::from(colour.r);
        *g += u32::from(colour.g);
        *b += u32::from(colour.b);
    }

    /// The place of a row in the table; beyond it when the row is.
    #[inline]
    const fn index(&self, y: i32) -> usize {
        // A row above the table wraps to beyond its end.
        (y - self.top) as u32 as usize
    }

    /// The extent of picture row `y`.
    #[must_use]
    pub fn row(&self, y: i32) -> RowExtent {
        self.rows.get(self.index(y)).copied().unwrap_or(RowExtent::EMPTY)
    }

    /// Every row that was matched, top to bottom, with its number in the picture.
    pub fn rows(&self) -> impl Iterator<Item = (i32, RowExtent)> + '_ {
        let reach = self.reach;
        let from = self.index(self.seed_row - reach).min(MAX_ROWS);
        let count = (2 * reach + 1) as usize;
        (self.top + from as i32..)
            .zip(self.rows.iter().skip(from).take(count).copied())
            .filter(|(_, row)| !row.is_empty())
    }

    /// Matched pixels.
    #[must_use]
    pub const fn matched(&self) -> u32 {
        self.matched
    }

    /// The mean colour of the matched pixels: the p_typ of the next iteration.
    #[must_use]
    pub fn mean_colour(&self) -> Rgb {
        let n = self.matched.max(1);
        let [r, g, b] = self.sum;
        Rgb::new((r / n) as u8, (g / n) as u8, (b / n) as u8)
    }

    /// First and last column, first and last row; `None` when nothing was matched.
    #[must_use]
    pub fn bounds(&self) -> Option<(i32, i32, i32, i32)> {
        self.rows().fold(None, |bounds, (y, extent)| {
            let (first, last) = (i32::from(extent.first), i32::from(extent.last));
            match bounds {
                None => Some((first, last, y, y)),
                Some((min_x, max_x, first_row, _)) => Some((min_x.min(first), max_x.max(last), first_row, y)),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::colour::Primary;
    use crate::vision::frame::PixelFormat;

    const SIDE: usize = 64;

    /// Red where `inside`, grey elsewhere.
    fn picture(inside: impl Fn(i32, i32) -> bool) -> [u8; SIDE * SIDE * 3] {
        let mut data = [90u8; SIDE * SIDE * 3];
        for (i, pixel) in data.chunks_exact_mut(3).enumerate() {
            if inside((i % SIDE) as i32, (i / SIDE) as i32) {
                pixel.copy_from_slice(&[200, 20, 20]);
            }
        }
        data
    }

    fn matcher() -> Matcher {
        Matcher::with_threshold(Primary::Red, Rgb::new(200, 20, 20), 6000)
    }

    fn limits(side: f32) -> SpiralLimits {
        SpiralLimits { side, min_match_256: 12 }
    }

    fn collect(data: &[u8], x: i32, y: i32, bound: f32) -> (RowEdges, Result<(), Abandoned>, u32) {
        let frame = FrameView::packed(data, SIDE as u16, SIDE as u16, PixelFormat::Rgb888).unwrap();
        let mut edges = RowEdges::new();
        let mut tested = 0;
        let outcome = edges.collect(&frame, &matcher(), (x, y), limits(bound), &mut tested);
        (edges, outcome, tested)
    }

    fn disc(x: i32, y: i32, cx: i32, cy: i32, r: i32) -> bool {
        (x - cx).pow(2) + (y - cy).pow(2) <= r * r
    }

    #[test]
    fn a_disc_is_found_from_any_of_its_pixels() {
        let data = picture(|x, y| disc(x, y, 32, 30, 8));
        for y in 0..SIDE as i32 {
            for x in 0..SIDE as i32 {
                let (edges, outcome, _) = collect(&data, x, y, 48.0);
                if disc(x, y, 32, 30, 8) {
                    assert_eq!(outcome, Ok(()));
                    assert_eq!(edges.bounds(), Some((24, 40, 22, 38)), "from {x},{y}");
                    assert!(edges.rows().all(|(row, e)| {
                        disc(i32::from(e.first), row, 32, 30, 8)
                            && !disc(i32::from(e.first) - 1, row, 32, 30, 8)
                    }));
                } else {
                    assert_eq!(outcome, Err(Abandoned::NoMatch));
                }
            }
        }
    }

    #[test]
    fn a_highlight_leaves_the_edges_alone() {
        let data = picture(|x, y| disc(x, y, 32, 32, 10) && !disc(x, y, 35, 29, 3));
        let (edges, outcome, _) = collect(&data, 27, 35, 60.0);
        assert_eq!(outcome, Ok(()));
        assert_eq!(edges.bounds(), Some((22, 42, 22, 42)));
    }

    #[test]
    fn a_speck_beside_the_ball_does_not_widen_it() {
        let data = picture(|x, y| disc(x, y, 32, 32, 8) || (x == 45 && y == 32));
        let (edges, _, _) = collect(&data, 32, 32, 48.0);
        assert_eq!(edges.bounds(), Some((24, 40, 24, 40)));
    }

    #[test]
    fn a_field_of_the_colour_is_unbounded_and_bounded_in_cost() {
        let data = picture(|_, _| true);
        let (_, outcome, tested) = collect(&data, 32, 32, 30.0);
        assert_eq!(outcome, Err(Abandoned::Unbounded));
        assert!(tested <= 32 * 32, "{tested}");
    }

    #[test]
    fn a_thin_line_is_inconsistent() {
        let data = picture(|_, y| y == 32);
        let (_, outcome, _) = collect(&data, 32, 32, 60.0);
        assert_eq!(outcome, Err(Abandoned::Inconsistent));
    }

    #[test]
    fn the_table_is_clean_after_a_restart() {
        let data = picture(|x, y| disc(x, y, 20, 20, 9) || disc(x, y, 48, 48, 5));
        let frame = FrameView::packed(&data, SIDE as u16, SIDE as u16, PixelFormat::Rgb888).unwrap();
        let mut edges = RowEdges::new();
        let mut tested = 0;
        edges.collect(&frame, &matcher(), (20, 20), limits(48.0), &mut tested).unwrap();
        edges.collect(&frame, &matcher(), (48, 48), limits(48.0), &mut tested).unwrap();
        assert_eq!(edges.bounds(), Some((43, 53, 43, 53)));
        assert_eq!(edges.rows().count(), 11);
    }
}
