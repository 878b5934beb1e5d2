//! Finding a ball: the alternation of uniform and spiral search of section 3.2, and the score that
//! picks among several finds.
//!
//! The uniform search looks for a pixel that matches; the spiral search then looks for the ball
//! around it. A spiral that is abandoned gives the turn back to the uniform search, which goes on
//! exactly where it stopped. Cells in which a spiral has already matched are not entered again, and
//! the number of spirals of one search is bounded (`SearchConfig::max_spirals`).

use super::centre::{Blob, Clean, row_edge_centre};
use super::colour::{FULL_SCALE, Matcher, distance_squared};
use super::edges::{RowEdges, SpiralLimits};
use super::frame::{FrameView, Rgb};
use super::search::{Region, UniformSearch};
use crate::config::{MAX_CANDIDATES, MAX_ROWS, SearchConfig, ShapeConfig};
use crate::observation::BALLS;

/// Height / width relative to what is expected (or its inverse) at which a blob is no ball at all.
const MAX_STRETCH: f32 = 1.8;

/// Roundness of a blob at which it is no ball at all ...
const LEAST_ROUNDNESS: f32 = 0.65;

/// ... and from which on it could not be rounder. Digitised discs reach 0.88 to 0.98.
const GOOD_ROUNDNESS: f32 = 0.9;

/// The factor of a blob that only just passes eq. 1 ...
const LEAST_COLOUR: f32 = 0.7;

/// ... which rises to 1 where its mean colour passes by so much of M's range.
const GOOD_EXCESS: f32 = 0.075;

/// Cells along either side of the region searched.
const CELLS: i32 = 64;

/// Working memory of the searches: 2 KiB, kept by the caller, never part of a tracker's state.
#[derive(Clone)]
pub struct Scratch {
    edges: RowEdges,
    explored: [u64; CELLS as usize],
}

impl Default for Scratch {
    fn default() -> Self {
        Self::new()
    }
}

impl Scratch {
    /// Empty working memory.
    #[must_use]
    pub fn new() -> Self {
        let mut scratch = Self::ZERO;
        scratch.clear();
        scratch
    }

    /// What becomes empty working memory by [`Self::clear`], made where it is kept (as [`RowEdges::ZERO`]).
    pub(super) const ZERO: Self = Self { edges: RowEdges::ZERO, explored: [0; CELLS as usize] };

    pub(super) fn clear(&mut self) {
        self.edges.clear();
    }

    /// The row edges of the blob that was collected last.
    #[must_use]
    pub const fn edges(&self) -> &RowEdges {
        &self.edges
    }
}

/// What a ball should look like: from the last time it was seen whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expectation {
    /// Width, pixels.
    pub diameter: f32,
    /// Height / width.
    pub aspect: f32,
    /// How many times larger or smaller it may be.
    pub size_range: f32,
    /// Matched pixels it must have at least.
    pub min_matched: u32,
    /// The diameter that the uniform search must not miss, pixels.
    pub least_diameter: f32,
    /// Side of the square that a spiral may scan, pixels.
    pub spiral_side: f32,
}

impl Expectation {
    /// A ball near where it was a frame ago: of nearly the same size, or hidden in part.
    #[must_use]
    pub fn nearby(
        clean: &Clean,
        aspect: f32,
        hidden_share: f32,
        search: &SearchConfig,
        shape: &ShapeConfig,
    ) -> Self {
        let diameter = clean.diameter;
        Self {
            diameter,
            aspect,
            size_range: shape.size_step,
            min_matched: shape.min_area.max((hidden_share * clean.area) as u32),
            least_diameter: diameter.min(diameter * aspect),
            spiral_side: spiral_side(diameter * aspect.max(1.0), search.spiral_diameters),
        }
    }

    /// A ball that may be anywhere, and so nearer or further away: whole, since half a ball is not
    /// taken on trust.
    #[must_use]
    pub fn anywhere(clean: &Clean, aspect: f32, search: &SearchConfig, shape: &ShapeConfig) -> Self {
        let diameter = clean.diameter;
        let range = shape.size_range.max(1.0);
        Self {
            diameter,
            aspect,
            size_range: range,
            min_matched: shape.min_area,
            least_diameter: diameter.min(diameter * aspect) / range,
            // From a pixel on its rim a ball reaches over its own diameter to either side.
            spiral_side: spiral_side(diameter * aspect.max(1.0), search.spiral_diameters.max(2.0 * range)),
        }
    }
}

fn spiral_side(diameter: f32, diameters: f32) -> f32 {
    (diameter * diameters).min(MAX_ROWS as f32)
}

/// A blob and how much it looks like the ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// What was measured.
    pub blob: Blob,
    /// 1 for the expected size and shape in the expected colour, 0 for none of it.
    pub score: f32,
}

/// The best candidates for a ball, each with the number of the threshold that it was matched with: the
/// matcher itself would be a third of a candidate, and there are sixteen at a time.
pub type Shortlist = heapless::Vec<(Candidate, u8), MAX_CANDIDATES>;

/// What is common to the searches of one ball in one frame.
#[derive(Clone, Debug)]
pub struct Search<'a> {
    /// The picture.
    pub frame: &'a FrameView<'a>,
    /// Eq. 1 for this ball.
    pub matcher: &'a Matcher,
    /// What it should look like.
    pub expected: Expectation,
    /// The typical colour of this ball ...
    pub own: Rgb,
    /// ... and of the others: a blob nearer to one of those is that one.
    pub rivals: heapless::Vec<Rgb, BALLS>,
    /// Section 3.2.
    pub search: &'a SearchConfig,
    /// Scores.
    pub shape: &'a ShapeConfig,
}

impl Search<'_> {
    /// The ball in a window: the first find that looks like it, else the largest that may be a part
    /// of it, else nothing. The flag says whether anything of its colour was left that is no ball.
    pub fn in_window(
        &self,
        region: Region,
        scratch: &mut Scratch,
        tested: &mut u32,
    ) -> (Option<Candidate>, bool) {
        let mut best: Option<Candidate> = None;
        let left = self.each_blob(region, u32::MAX, scratch, tested, |found| {
            if best.is_none_or(|b| {
                found.score > b.score || (b.score <= 0.0 && found.blob.matched > b.blob.matched)
            }) {
                best = Some(found);
            }
            found.score >= self.shape.good_score
        });
        (best, left)
    }

    /// Adds the best finds in a region to `best`, best first: a global search takes none on trust. Each has
    /// the number of the `threshold` that gave it.
    pub fn candidates(
        &self,
        region: Region,
        threshold: u8,
        best: &mut Shortlist,
        scratch: &mut Scratch,
        tested: &mut u32,
    ) {
        let pixels = region.width() as f32 * region.height() as f32;
        let budget = tested.saturating_add((pixels * self.search.global_budget) as u32);
        self.each_blob(region, budget, scratch, tested, |found| {
            if found.score >= self.shape.global_score {
                if best.is_full() && best.last().is_some_and(|(worst, _)| worst.score < found.score) {
                    best.pop();
                }
                // in before the first that is worse (`insert` has a panic path)
                let (mut moving, mut shifts) = ((found, threshold), false);
                for place in best.iter_mut() {
                    shifts |= place.0.score < moving.0.score;
                    if shifts {
                        core::mem::swap(place, &mut moving);
                    }
                }
                // full of better ones: there is no place for it
                let _ = best.push(moving);
            }
            false
        });
    }

    /// Runs the alternation and hands every bounded blob to `judge`, which ends it by answering
    /// true. Says whether anything matched at all.
    fn each_blob(
        &self,
        region: Region,
        budget: u32,
        scratch: &mut Scratch,
        tested: &mut u32,
        mut judge: impl FnMut(Candidate) -> bool,
    ) -> bool {
        // at hand for every pixel, wherever the caller keeps them
        let (frame, matcher) = (*self.frame, *self.matcher);
        let mut looked = *tested;
        let mut left = false;
        let mut spirals = 0;
        let cells = Cells::over(region);
        scratch.explored = [0; CELLS as usize];
        let limits =
            SpiralLimits { side: self.expected.spiral_side, min_match_256: self.search.min_match_256 };
        for (x, y) in UniformSearch::new(region, self.expected.least_diameter) {
            if looked >= budget || spirals >= self.search.max_spirals {
                break;
            }
            looked += 1;
            if !frame.pixel(x, y).is_some_and(|p| matcher.accepts(p)) {
                continue;
            }
            if cells.marked(&scratch.explored, x, y) {
                continue;
            }
            spirals += 1;
            let outcome = scratch.edges.collect(&frame, &matcher, (x, y), limits, &mut looked);
            left = true;
            if outcome.is_ok()
                && let Some(blob) = row_edge_centre(&frame, &scratch.edges)
                && blob.matched >= self.expected.min_matched
                && self.no_larger_than_expected(&blob)
                && !self.is_a_rival(blob.colour)
                && judge(Candidate { blob, score: self.score(&blob) })
            {
                break;
            }
            cells.mark_rows(&mut scratch.explored, &scratch.edges);
            cells.mark(&mut scratch.explored, x, y);
        }
        *tested = looked;
        left
    }

    /// Whether a colour is nearer (D of section 2) to another ball's than to this one's.
    fn is_a_rival(&self, colour: Rgb) -> bool {
        let own = distance_squared(colour, self.own);
        self.rivals.iter().any(|rival| distance_squared(colour, *rival) < own)
    }

    fn no_larger_than_expected(&self, blob: &Blob) -> bool {
        let slack = self.shape.digitisation;
        let widest = self.expected.diameter * self.expected.size_range + slack;
        blob.diameter <= widest && blob.height <= widest * self.expected.aspect + slack
    }

    /// How much a blob looks like the ball: size, height / width, how well its rows fill the disc in
    /// its box, how solid, how much of its colour. Each factor is 1 for a perfect ball and 0 where
    /// it cannot be one.
    fn score(&self, blob: &Blob) -> f32 {
        let e = &self.expected;
        let slack = self.shape.digitisation / blob.diameter.max(1.0);
        let (w, h) = (blob.diameter.max(1.0), blob.height.max(1.0));
        let size = ratio(libm::sqrtf(w * h / e.aspect), e.diameter);
        let off = (size - 1.0 - slack).max(0.0);
        let of_size = 1.0 / (1.0 + off * off);
        let aspect = ratio(h / w, e.aspect);
        let of_aspect = 1.0 - (aspect - 1.0 - slack).max(0.0) / (MAX_STRETCH - 1.0);
        let of_disc = (blob.roundness - LEAST_ROUNDNESS + slack * 0.5) / (GOOD_ROUNDNESS - LEAST_ROUNDNESS);
        let of_solid = blob.matched as f32 / blob.area.max(1.0);
        let excess =
            (self.matcher.matching(blob.colour) - self.matcher.threshold()) as f32 / FULL_SCALE as f32;
        let of_colour = LEAST_COLOUR + (excess / GOOD_EXCESS).min(1.0) * (1.0 - LEAST_COLOUR);
        let factors = [of_size, of_aspect, of_disc.min(1.0), of_solid, of_colour];
        factors.iter().map(|f| f.max(0.0)).product()
    }
}

/// a / b or b / a, whichever is at least 1.
fn ratio(a: f32, b: f32) -> f32 {
    let (a, b) = (a.max(1e-3), b.max(1e-3));
    if a > b { a / b } else { b / a }
}

/// A grid of [`CELLS`] x [`CELLS`] over a region: where spirals have been.
#[derive(Clone, Copy)]
struct Cells {
    x0: i32,
    y0: i32,
    /// Pixels along a cell's side, at least 1.
    side: i32,
}

impl Cells {
    fn over(region: Region) -> Self {
        let longest = region.width().max(region.height()).max(1);
        Self { x0: region.x0, y0: region.y0, side: (longest + CELLS - 1) / CELLS }
    }

    fn cell(&self, x: i32, y: i32) -> Option<(usize, u32)> {
        let side = self.side.max(1);
        let (cx, cy) = ((x - self.x0).div_euclid(side), (y - self.y0).div_euclid(side));
        ((0..CELLS).contains(&cx) && (0..CELLS).contains(&cy)).then_some((cy as usize, cx as u32))
    }

    fn marked(&self, grid: &[u64; CELLS as usize], x: i32, y: i32) -> bool {
        self.cell(x, y).is_some_and(|(row, column)| grid.get(row).is_some_and(|r| r >> column & 1 == 1))
    }

    fn mark(&self, grid: &mut [u64; CELLS as usize], x: i32, y: i32) {
        if let Some((row, column)) = self.cell(x, y)
            && let Some(r) = grid.get_mut(row)
        {
            *r |= 1 << column;
        }
    }

    /// Marks the cells under every row of a blob.
    fn mark_rows(&self, grid: &mut [u64; CELLS as usize], edges: &RowEdges) {
        for (y, extent) in edges.rows() {
            let mut x = i32::from(extent.first);
            while x <= i32::from(extent.last) {
                self.mark(grid, x, y);
                x += self.side.max(1);
            }
            self.mark(grid, i32::from(extent.last), y);
        }
    }
}
