//! The horizontal scan through a ball as data: figures 1, 2 and 5 of the paper.

use super::LearnError;
use crate::geometry::ImagePoint;
use crate::vision::colour::{FULL_SCALE, Matcher, Reference, distance, matching};
use crate::vision::edges::{RowEdges, SpiralLimits};
use crate::vision::frame::FrameView;
use heapless::Vec;

/// One column of a scan. R, G, B, V and D from 0 to 1, M from -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanColumn {
    /// The column in the picture.
    pub x: u16,
    /// c1
    pub r: f32,
    /// c2
    pub g: f32,
    /// c3
    pub b: f32,
    /// V of the ball's primary.
    pub v: f32,
    /// D to the ball's reference.
    pub d: f32,
    /// M = V - D
    pub m: f32,
}

/// A row of the picture over about three diameters of a ball, at most `N` columns.
#[derive(Clone, Debug, PartialEq)]
pub struct HorizontalScan<const N: usize> {
    /// The row in the picture: that of the ball's centre.
    pub row: u16,
    /// Every `step`-th column of the window, from left to right.
    pub columns: Vec<ScanColumn, N>,
    /// 1, or more where the window is wider than `N`: the columns between are left out, not
    /// averaged, so a value is always that of a pixel.
    pub step: u16,
    /// The right-hand side of eq. 1, -1 to 1.
    pub threshold: f32,
    /// j_min and j_max of section 3.3: the ball's first and last matched column in this row, to the
    /// pixel even where columns are left out. `None` when no pixel of the row matches.
    pub borders: Option<(i16, i16)>,
}

/// The window's width in diameters: the side of the searched square of section 3.2.
const WINDOW_DIAMETERS: f32 = 3.0;
/// As the tracker has it by default: the least share of matched pixels in a spiral, 1/256.
const LEAST_MATCH_256: u32 = 12;

impl<const N: usize> HorizontalScan<N> {
    /// The scan through `centre` of a ball `diameter` pixels across, judged by eq. 1 with `reference`
    /// and `alpha_256` (1/256). Reads the window's row and the square of three diameters.
    ///
    /// # Errors
    /// [`LearnError::Outside`] when the centre is not in the picture, [`LearnError::NoContrast`] when
    /// the reference gives no threshold.
    pub fn through(
        frame: &FrameView<'_>,
        reference: &Reference,
        alpha_256: u16,
        centre: ImagePoint,
        diameter: f32,
    ) -> Result<Self, LearnError> {
        let (cx, cy) = (libm::roundf(centre.u) as i32, libm::roundf(centre.v) as i32);
        if !centre.is_finite() || !diameter.is_finite() || !frame.contains(cx, cy) {
            return Err(LearnError::Outside);
        }
        let matcher = Matcher::new(reference, alpha_256).map_err(|_| LearnError::NoContrast)?;
        let half = libm::ceilf(diameter.max(1.0) * WINDOW_DIAMETERS / 2.0) as i32;
        let last = i32::from(frame.width()) - 1;
        let (from, to) = (cx.saturating_sub(half).max(0), cx.saturating_add(half).min(last));
        let step = (to - from + 1 + N as i32 - 1).checked_div(N as i32).unwrap_or(1).max(1);
        let mut columns = Vec::new();
        let mut x = from;
        while x <= to {
            if let Some(p) = frame.pixel(x, cy) {
                let column = ScanColumn {
                    x: x as u16,
                    r: f32::from(p.r) / 255.0,
                    g: f32::from(p.g) / 255.0,
                    b: f32::from(p.b) / 255.0,
                    v: reference.primary.luminance(p) as f32 / 765.0,
                    d: distance(p, reference.reference) as f32 / FULL_SCALE as f32,
                    m: matching(reference.primary, p, reference.reference) as f32 / FULL_SCALE as f32,
                };
                if columns.push(column).is_err() {
                    break;
                }
            }
            x += step;
        }
        Ok(Self {
            row: cy as u16,
            columns,
            step: step as u16,
            threshold: matcher.threshold() as f32 / FULL_SCALE as f32,
            borders: borders(frame, &matcher, (cx, cy), half),
        })
    }
}

/// The ball's edges in the row of (`cx`, `cy`), started on the matched pixel nearest to it within the
/// ball (the middle itself may be a highlight).
fn borders(frame: &FrameView<'_>, matcher: &Matcher, (cx, cy): (i32, i32), half: i32) -> Option<(i16, i16)> {
    let matches = |x: &i32| frame.pixel(*x, cy).is_some_and(|p| matcher.accepts(p));
    let start = (0..=half / 3).flat_map(|off| [cx - off, cx + off]).find(matches)?;
    let mut edges = RowEdges::new();
    let mut tested = 0;
    let limits = SpiralLimits { side: 2.0 * half as f32, min_match_256: LEAST_MATCH_256 };
    // Abandoned or not, the rows hold what was matched, and showing it is what a scan is for.
    let _ = edges.collect(frame, matcher, (start, cy), limits, &mut tested);
    let row = edges.row(cy);
    (row.pixels() > 0).then_some((row.first, row.last))
}
