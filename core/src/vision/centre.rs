//! The centre of a ball from its row edges: section 3.3, eq. 2.
//!
//! As printed, eq. 2 averages with j_min (j_min + 1), which puts the centre of a row of one pixel in
//! column j at 0. The mean of the columns j_min to j_max is (j_max (j_max + 1) - j_min (j_min - 1))
//! / (2 N_r) = (j_min + j_max) / 2, and that is what stands here.
//!
//! This is the `paper` measure. A finer one replaces [`row_edge_centre`] and keeps [`Blob`].

use super::edges::RowEdges;
use super::frame::{FrameView, Rgb};
use crate::geometry::ImagePoint;
use core::f32::consts::FRAC_PI_4;

/// What was measured of one blob of a ball's colour.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Blob {
    /// The mean of the row centres, weighted by N_r, pixels.
    pub centre: ImagePoint,
    /// The largest N_r, pixels: the paper's diameter.
    pub diameter: f32,
    /// Rows from first to last, pixels.
    pub height: f32,
    /// The sum of all N_r, pixels: the area with highlights filled.
    pub area: f32,
    /// Matched pixels alone.
    pub matched: u32,
    /// Intersection over union of its rows and the ellipse in its bounding box: 1 for a disc, 0.78
    /// for a square, less for a ball with a hand attached.
    pub roundness: f32,
    /// Mean colour of the matched pixels.
    pub colour: Rgb,
    /// First column, last column, first row, last row.
    pub bounds: (i32, i32, i32, i32),
    /// Whether the picture's edge cuts it.
    pub cut: bool,
}

/// A ball as it was when it was last seen whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clean {
    /// The largest N_r, pixels.
    pub diameter: f32,
    /// Rows, pixels.
    pub height: f32,
    /// Pixels.
    pub area: f32,
}

impl Clean {
    /// From a taught diameter and aspect.
    #[must_use]
    pub fn taught(diameter: f32, aspect: f32) -> Self {
        let height = diameter * aspect;
        Self { diameter, height, area: diameter * height * FRAC_PI_4 }
    }

    /// From a blob that is a whole ball.
    #[must_use]
    pub const fn of(blob: &Blob) -> Self {
        Self { diameter: blob.diameter, height: blob.height, area: blob.area }
    }

    /// A share of the way to another size.
    #[must_use]
    pub fn towards(&self, to: &Self, share: f32) -> Self {
        let step = |from: f32, to: f32| from + (to - from) * share;
        Self {
            diameter: step(self.diameter, to.diameter),
            height: step(self.height, to.height),
            area: step(self.area, to.area),
        }
    }
}

/// Eq. 2 over all rows. `None` when no row was matched.
#[must_use]
pub fn row_edge_centre(frame: &FrameView<'_>, edges: &RowEdges) -> Option<Blob> {
    let bounds = edges.bounds()?;
    let (min_x, max_x, first_row, last_row) = bounds;
    let (mut weight, mut sum_u, mut sum_v, mut widest) = (0i64, 0i64, 0i64, 0i32);
    for (row, extent) in edges.rows() {
        let n = extent.pixels();
        widest = widest.max(n);
        weight += i64::from(n);
        // Twice the row centre, counted from the blob's own corner: exact in integers.
        sum_u += i64::from(n) * i64::from(i32::from(extent.first) + i32::from(extent.last) - 2 * min_x);
        sum_v += i64::from(n) * i64::from(row - first_row);
    }
    if weight <= 0 {
        return None;
    }
    // Up to 384 rows of 8192 pixels: sums below 2^45, so the quotients are formed in f64.
    let u = f64::from(min_x) + sum_u as f64 / (2 * weight) as f64;
    let v = f64::from(first_row) + sum_v as f64 / weight as f64;
    Some(Blob {
        centre: ImagePoint::new(u as f32, v as f32),
        diameter: widest as f32,
        height: (last_row - first_row + 1) as f32,
        area: weight as f32,
        matched: edges.matched(),
        roundness: roundness(edges, bounds),
        colour: edges.mean_colour(),
        bounds,
        cut: min_x <= 0
            || first_row <= 0
            || max_x >= i32::from(frame.width()) - 1
            || last_row >= i32::from(frame.height()) - 1,
    })
}

fn roundness(edges: &RowEdges, (min_x, max_x, first_row, last_row): (i32, i32, i32, i32)) -> f32 {
    let (a, b) = ((max_x - min_x + 1) as f32 * 0.5, (last_row - first_row + 1) as f32 * 0.5);
    let (u, v) = ((min_x + max_x) as f32 * 0.5, (first_row + last_row) as f32 * 0.5);
    let (mut both, mut either) = (0.0f32, 0.0f32);
    for (row, extent) in edges.rows() {
        let y = (row as f32 - v) / b;
        let half = a * libm::sqrtf((1.0 - y * y).max(0.0));
        let (first, last) = (f32::from(extent.first) - 0.5, f32::from(extent.last) + 0.5);
        let overlap = (last.min(u + half) - first.max(u - half)).max(0.0);
        both += overlap;
        either += (last - first) + 2.0 * half - overlap;
    }
    both / either.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::colour::{Matcher, Primary};
    use crate::vision::edges::SpiralLimits;
    use crate::vision::frame::PixelFormat;

    const SIDE: usize = 48;

    fn blob(inside: impl Fn(i32, i32) -> bool, x: i32, y: i32) -> Blob {
        let mut data = [60u8; SIDE * SIDE * 3];
        for (i, pixel) in data.chunks_exact_mut(3).enumerate() {
            if inside((i % SIDE) as i32, (i / SIDE) as i32) {
                pixel.copy_from_slice(&[20, 40, 220]);
            }
        }
        let frame = FrameView::packed(&data, SIDE as u16, SIDE as u16, PixelFormat::Rgb888).unwrap();
        let matcher = Matcher::with_threshold(Primary::Blue, Rgb::new(20, 40, 220), 6000);
        let mut edges = RowEdges::new();
        let mut tested = 0;
        edges
            .collect(&frame, &matcher, (x, y), SpiralLimits { side: 45.0, min_match_256: 12 }, &mut tested)
            .unwrap();
        row_edge_centre(&frame, &edges).unwrap()
    }

    #[test]
    fn one_pixel_has_its_own_centre() {
        let b = blob(|x, y| x == 7 && y == 9, 7, 9);
        assert_eq!((b.centre, b.diameter, b.area), (ImagePoint::new(7.0, 9.0), 1.0, 1.0));
    }

    #[test]
    fn a_row_of_two_has_its_centre_between() {
        let b = blob(|x, y| (x == 7 || x == 8) && y == 9, 7, 9);
        assert_eq!(b.centre, ImagePoint::new(7.5, 9.0));
    }

    #[test]
    fn rows_weigh_by_their_pixels() {
        // one row of 3 above one row of 1
        let b = blob(|x, y| (y == 10 && (10..13).contains(&x)) || (y == 11 && x == 11), 11, 10);
        assert_eq!(b.centre, ImagePoint::new(11.0, 10.25));
    }

    #[test]
    fn a_disc_is_centred_and_round() {
        let b = blob(|x, y| (x - 24).pow(2) + (y - 22).pow(2) <= 68, 22, 20);
        assert_eq!(b.centre, ImagePoint::new(24.0, 22.0));
        assert_eq!((b.diameter, b.height), (17.0, 17.0));
        assert!((b.area / (b.diameter * b.height) - core::f32::consts::FRAC_PI_4).abs() < 0.1);
        assert!(!b.cut);
    }

    #[test]
    fn the_edge_of_the_picture_cuts() {
        assert!(blob(|x, y| (x - 2).pow(2) + (y - 22).pow(2) <= 64, 3, 22).cut);
    }
}
