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

    const fn is_empty(self) -> bool {
        self.first > self.last
    }

    /// N_r of eq. 2: pixels from edge to edge, both included.
    #[must_use]
    pub const fn pixels(self) -> i32 {
        if self.is_empty() { 0 } else { self.last as i32 - self.first as i32 + 1 }
    }

    const fn reaches(self, x: i32, gap: i32) -> bool {
        !self.is_empty() && x >= self.first as i32 - 1 - gap && x <= self.last as i32 + 1 + gap
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
    first_row: i32,
    last_row: i32,
    min_x: i32,
    max_x: i32,
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
    pub const fn new() -> Self {
        Self {
            rows: [RowExtent::EMPTY; MAX_ROWS],
            top: 0,
            first_row: i32::MAX,
            last_row: i32::MIN,
            min_x: i32::MAX,
            max_x: i32::MIN,
            matched: 0,
            sum: [0; 3],
        }
    }

    /// Runs a spiral from (`x`, `y`) and keeps the edges of the
    /// blob it starts in. Ends when a whole turn adds nothing. `tested` grows by the pixels looked at.
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
        let mut visited = 0u32;
        let mut added_in_turn = 0u32;
        let mut spiral = Spiral::new(x, y, limits.side);
        while let Some((px, py)) = spiral.next() {
            if let Some(colour) = frame.pixel(px, py) {
                visited += 1;
                if matcher.accepts(colour) && self.add(px, py, colour) {
                    added_in_turn += 1;
                }
            }
            if self.matched == 0 {
                *tested += visited;
                return Err(Abandoned::NoMatch);
            }
            if spiral.closed_a_turn() {
                if added_in_turn == 0 {
                    *tested += visited;
                    return Ok(());
                }
                if visited > 64 && self.matched * 256 < visited * limits.min_match_256 {
                    *tested += visited;
                    return Err(Abandoned::Inconsistent);
                }
                added_in_turn = 0;
            }
        }
        *tested += visited;
        Err(Abandoned::Unbounded)
    }

    fn restart(&mut self, seed_row: i32) {
        if self.first_row <= self.last_row {
            let from = (self.first_row - self.top).max(0) as usize;
            let count = (self.last_row - self.first_row + 1).max(0) as usize;
            for row in self.rows.iter_mut().skip(from).take(count) {
                *row = RowExtent::EMPTY;
            }
        }
        self.top = seed_row - (MAX_ROWS / 2) as i32;
        self.first_row = i32::MAX;
        self.last_row = i32::MIN;
        self.min_x = i32::MAX;
        self.max_x = i32::MIN;
        self.matched = 0;
        self.sum = [0; 3];
    }

    /// Adds a matched pixel if it touches the blob; says whether it did.
    fn add(&mut self, x: i32, y: i32, colour: Rgb) -> bool {
        if self.matched > 0
            && !(self.row(y).reaches(x, ROW_GAP)
                || self.row(y - 1).reaches(x, 0)
                || self.row(y + 1).reaches(x, 0))
        {
            return false;
        }
        // MAX_SIDE keeps coordinates inside an i16.
        let Some(row) = usize::try_from(y - self.top).ok().and_then(|i| self.rows.get_mut(i)) else {
            return false;
        };
        row.first = row.first.min(x as i16);
        row.last = row.last.max(x as i16);
        self.first_row = self.first_row.min(y);
        self.last_row = self.last_row.max(y);
        self.min_x = self.min_x.min(x);
        self.max_x = self.max_x.max(x);
        self.matched += 1;
        let [r, g, b] = &mut self.sum;
        *r += u32::from(colour.r);
        *g += u32::from(colour.g);
        *b += u32::from(colour.b);
        true
    }

    /// The extent of picture row `y`.
    #[must_use]
    pub fn row(&self, y: i32) -> RowExtent {
        usize::try_from(y - self.top).ok().and_then(|i| self.rows.get(i)).copied().unwrap_or(RowExtent::EMPTY)
    }

    /// Every row that was matched, top to bottom, with its number in the picture.
    pub fn rows(&self) -> impl Iterator<Item = (i32, RowExtent)> + '_ {
        let from = self.first_row;
        let count = if from <= self.last_row { (self.last_row - from + 1) as usize } else { 0 };
        let skip = if count > 0 { (from - self.top).max(0) as usize } else { 0 };
        (from..).zip(self.rows.iter().skip(skip).take(count).copied()).filter(|(_, row)| !row.is_empty())
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
    pub const fn bounds(&self) -> Option<(i32, i32, i32, i32)> {
        if self.matched == 0 { None } else { Some((self.min_x, self.max_x, self.first_row, self.last_row)) }
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
