//! Where rows and columns cross the rim.
//!
//! A part of the rim whose normal is nearer to the horizontal is crossed by rows, the rest by
//! columns, so that a scan meets the rim at 45 degrees at the most and pixels are read as they are.

use super::fit::Curve;
use super::unmix::{Palette, minus, plus, scaled};
use crate::geometry::round_to_i32;
use crate::vision::frame::{FrameView, PixelFormat, Rgb};

/// The most scans of one ball: ten across each quarter of the rim. From 14 pixels on rows (columns)
/// are left out, two by two: pixels that share their chroma are both read.
pub const MAX_SCANS: usize = 40;

/// The most pixels of one scan.
pub const MAX_SCAN_PIXELS: usize = 20;

/// Lines of a quarter, two by two, from an odd one on.
const PAIRS_PER_QUARTER: usize = MAX_SCANS / 8 + 1;

/// Pairs of lines.
pub(super) const MAX_PAIRS: usize = 4 * PAIRS_PER_QUARTER;

/// Share of the radius up to which rows (columns) cross at 45 degrees or less, and a little more, so
/// that no direction is left out.
const QUARTER: f32 = 0.72;

/// The inside of a scan must be so near to the ball's hue: the sine squared of 14 degrees.
const MAX_HUE: f32 = 0.12;

/// The least brightness of the inside against the ball's middle.
const LEAST_BRIGHTNESS: f32 = 0.15;

/// The most variance of an unmixed pixel per grey level of noise: a contrast of 14 levels.
const MAX_VARIANCE: f32 = 0.005;

/// A step this large in what is behind the ball, as a share of the step at the rim, halves what a
/// crossing counts: one over its square.
const PER_STEP2: f32 = 100.0;

/// One crossing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// From the curve's centre, pixels to the right.
    pub(super) x: f32,
    /// From the curve's centre, pixels down, divided by the aspect.
    pub(super) y: f32,
    /// What it counts, by its contrast: 0 to 1.
    pub(super) weight: f32,
    /// It and the one beside it have the same number: their pixels may share their chroma.
    pub(super) pair: usize,
}

/// The crossings of one ball.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    pub(super) edges: heapless::Vec<Edge, MAX_SCANS>,
    /// Scans made, with or without a crossing.
    pub(super) tried: u32,
    /// Whether pixels side by side share their chroma.
    pub(super) shared_chroma: bool,
}

/// How far a scan reaches to either side of where the rim is expected, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    pub(super) inside: i32,
    pub(super) outside: i32,
}

/// Which way a scan runs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Axis {
    Row,
    Column,
}

/// What all scans of one ball share.
pub(super) struct Scanner<'a> {
    pub(super) frame: &'a FrameView<'a>,
    pub(super) palette: &'a Palette,
    pub(super) aspect: f32,
    pub(super) reach: Reach,
}

impl Scanner<'_> {
    /// Crosses the rim wherever `curve` says that it is.
    pub(super) fn scan(&self, curve: &Curve, tested: &mut u32) -> Edges {
        let shared_chroma = self.shares_chroma(Axis::Row) || self.shares_chroma(Axis::Column);
        let mut found = Edges { shared_chroma, ..Edges::default() };
        self.quarter(Axis::Row, curve, &mut found, tested);
        self.quarter(Axis::Column, curve, &mut found, tested);
        found
    }

    /// Whether lines side by side across an axis share their chroma.
    const fn shares_chroma(&self, axis: Axis) -> bool {
        match self.frame.format() {
            PixelFormat::Yuyv | PixelFormat::Uyvy => matches!(axis, Axis::Column),
            PixelFormat::Nv12 => true,
            _ => false,
        }
    }

    /// The two opposite quarters of the rim that one axis crosses.
    fn quarter(&self, axis: Axis, curve: &Curve, found: &mut Edges, tested: &mut u32) {
        let radius = curve.radius;
        // lines are counted across the axis, positions along it
        let (line_centre, line_scale, along_centre, along_scale) = match axis {
            Axis::Row => (curve.centre.v, self.aspect, curve.centre.u, 1.0),
            Axis::Column => (curve.centre.u, 1.0, curve.centre.v, self.aspect),
        };
        let half_lines = QUARTER * radius * line_scale;
        let first = -round_to_i32(half_lines - line_centre - 0.5);
        let last = round_to_i32(line_centre + half_lines - 0.5);
        let per_side = (MAX_SCANS / 4) as i32;
        let stride = (last.saturating_sub(first) / per_side).saturating_add(1).max(1);
        // an even line and the odd one after it: where some are left out, none without its other
        let odd = if self.shares_chroma(axis) { first & 1 } else { 0 };
        let (first, odd) = if stride > 1 { (first - odd, 0) } else { (first, odd) };
        let radius2 = radius * radius;
        let per_radius3 = 1.0 / (radius2 * radius);
        let per_line2 = 1.0 / (24.0 * line_scale * line_scale);
        let per_line = 1.0 / line_scale;
        for i in 0..per_side {
            let line = first + (i / 2) * 2 * stride + i % 2;
            if line > last {
                break;
            }
            let across = (line as f32 - line_centre) * per_line;
            let half2 = (radius2 - across * across).max(1e-3);
            let half = libm::sqrtf(half2);
            // an edge averaged over a line's thickness lies x'' / 24 inside that of its middle
            let bulge = per_line2 * radius2 / (half2 * half);
            for outward in [-1, 1] {
                found.tried += 1;
                let pair = pair_of(axis, i + odd, outward);
                let along = half * outward as f32;
                let (x, y) = if axis == Axis::Row { (along, across) } else { (across, along) };
                let bent = curve.a * (x * x - y * y) + 2.0 * curve.b * x * y;
                let expected = along_centre + along * (1.0 + bent * per_radius3) * along_scale;
                let Some((edge, weight)) =
                    self.cross(axis, line, expected, outward, half * along_scale, tested)
                else {
                    continue;
                };
                let at = (edge - along_centre) / along_scale + bulge * outward as f32;
                let (x, y) = if axis == Axis::Row { (at, across) } else { (across, at) };
                // there are as many places as scans
                let _ = found.edges.push(Edge { x, y, weight, pair });
            }
        }
    }

    /// One scan along `line`: where the rim is, and what that counts.
    fn cross(
        &self,
        axis: Axis,
        line: i32,
        expected: f32,
        outward: i32,
        half_chord: f32,
        tested: &mut u32,
    ) -> Option<(f32, f32)> {
        let middle = round_to_i32(expected);
        let inside = self.reach.inside.min(round_to_i32(half_chord)).max(1);
        let start = middle - outward * inside;
        let count = (inside + self.reach.outside + 1).min(MAX_SCAN_PIXELS as i32);
        let end = start + outward * (count - 1);
        let place = |at: i32| if axis == Axis::Row { (at, line) } else { (line, at) };
        let ((x0, y0), (x1, y1)) = (place(start), place(end));
        if !self.frame.contains(x0, y0) || !self.frame.contains(x1, y1) {
            return None;
        }
        let inner_count = if inside >= 3 { 2 } else { 1 };
        let mut at = start;
        let mut sum_of = |count: i32| {
            let mut sum = [0u32; 3];
            for _ in 0..count {
                let (x, y) = place(at);
                let Rgb { r, g, b } = self.frame.pixel_inside(x as usize, y as usize)?;
                let [red, green, blue] = &mut sum;
                *red += u32::from(r);
                *green += u32::from(g);
                *blue += u32::from(b);
                at += outward;
            }
            Some(sum.map(|x| x as f32))
        };
        let inner = sum_of(inner_count)?;
        let between = sum_of(count - inner_count - OUTER_COUNT)?;
        let (near, far) = (sum_of(1)?, sum_of(1)?);
        let outer = plus(&near, &far);
        *tested += count as u32;
        let inside_colour = scaled(&inner, 1.0 / inner_count as f32);
        let brightness = self.palette.brightness(&inside_colour, MAX_HUE)?;
        if brightness < LEAST_BRIGHTNESS {
            return None;
        }
        let behind = scaled(&outer, 1.0 / OUTER_COUNT as f32);
        let unmixer = self.palette.unmixer(brightness, &inside_colour, &behind)?;
        let variance = unmixer.variance();
        if variance > MAX_VARIANCE {
            return None;
        }
        // an edge of something behind the ball
        let step = unmixer.shares(&minus(&far, &near), 0.0);
        let calm = 1.0 / (1.0 + step * step * PER_STEP2);
        let all = plus(&plus(&inner, &between), &outer);
        let background = unmixer.shares(&all, count as f32);
        let ball = count as f32 - background;
        if !(0.5..=count as f32 - 0.5).contains(&ball) {
            return None;
        }
        let edge = start as f32 + outward as f32 * (ball - 0.5);
        Some((edge, (1.0 - variance * (1.0 / MAX_VARIANCE)) * calm))
    }
}

/// The pairs of lines, told by a number: those of an axis and side follow each other.
fn pair_of(axis: Axis, line: i32, outward: i32) -> usize {
    let quarter = usize::from(axis == Axis::Column) * 2 + usize::from(outward > 0);
    quarter * PAIRS_PER_QUARTER + (line / 2) as usize
}

/// The outermost pixels of a scan: the background.
const OUTER_COUNT: i32 = 2;
