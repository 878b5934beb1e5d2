//! A closed curve through edges, some of which are not on it.

use super::scan::{Edge, Edges, MAX_PAIRS, MAX_SCANS};
use crate::geometry::ImagePoint;
use nalgebra::{SMatrix, SVector};

/// Radius, centre (2), second harmonics (2).
const UNKNOWNS: usize = 5;

/// Scales of the weight function in turn, pixels: an edge this far off the curve counts a quarter. The
/// first is about how far the first curve may be off.
const SCALES: [f32; 4] = [2.0, 1.0, 0.5, 0.3];

/// The same where the first curve is known to be near.
const NEAR_SCALES: [f32; 3] = [0.8, 0.3, 0.3];

/// A solution that moves no further than this, pixels, at the last scale is the last.
const SETTLED: f32 = 0.01;

/// What an edge is off without being wrong, pixels: weighs edges against the prior.
const EDGE_SIGMA: f32 = 0.1;

/// Nothing is known beforehand of the centre: so many pixels.
const CENTRE_SIGMA: f32 = 20.0;

/// Edges next to each other are taken to be off alike at most so far: a correlation.
const MOST_LIKENESS: f32 = 0.7;

/// And at least so far.
const LEAST_LIKENESS: f32 = -0.35;

/// Edges that are off by more than this, pixels, are so because of what is behind the ball, and that
/// moves them together.
const CLUTTER_SIGMA: f32 = 0.045;

/// How much of its square counts of an edge without its pair: it errs by its chroma, which says
/// nothing of the others.
const LONE_SHARE: f32 = 0.25;

/// From this weight on an edge is on the curve.
const INLIER_WEIGHT: f32 = 0.25;

/// A circle with the second harmonics that perspective gives it, in a picture whose rows were divided
/// by the aspect: r = radius + a cos 2t + b sin 2t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Curve {
    pub(super) centre: ImagePoint,
    pub(super) radius: f32,
    pub(super) a: f32,
    pub(super) b: f32,
}

/// What is known of the curve before it is fitted.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    pub(super) radius: f32,
    pub(super) radius_sigma: f32,
    pub(super) a: f32,
    pub(super) b: f32,
    pub(super) harmonic_sigma: f32,
}

/// A curve and how well it fits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) curve: Curve,
    /// Of the centre, pixels squared: uu, uv, vv (v divided by the aspect).
    pub(super) covariance: [f32; 3],
    /// Edges on the curve.
    pub(super) inliers: u32,
}

type Normal = SMatrix<f32, UNKNOWNS, UNKNOWNS>;
type Unknowns = SVector<f32, UNKNOWNS>;

/// Fits a curve to edges given from the centre of `start`. `None` where they do not determine one.
/// Never a part of its caller, whose scans are done when this one's equations need stack.
#[inline(never)]
pub(super) fn fit(start: &Curve, edges: &Edges, aspect: f32, prior: &Prior, is_near: bool) -> Option<Fit> {
    let scales: &[f32] = if is_near { &NEAR_SCALES } else { &SCALES };
    let last_scale = scales.last().copied().unwrap_or_default();
    let mut rows: heapless::Vec<Row, MAX_SCANS> = heapless::Vec::new();
    for Edge { x, y, weight, pair } in &edges.edges {
        let rho2 = (x * x + y * y).max(1e-3);
        let rho = libm::sqrtf(rho2);
        let (c, s) = (x / rho, y / rho);
        // there are as many places as edges
        let _ = rows.push(Row {
            terms: [1.0, c, s, c * c - s * s, 2.0 * c * s],
            rho,
            weight: *weight,
            pair: *pair,
        });
    }
    // from the centre of `start`
    let mut unknowns = [start.radius, 0.0, 0.0, start.a, start.b];
    let mut last = None;
    for &scale in scales {
        let per_scale2 = 1.0 / (scale * scale);
        let (mut normal, mut right) = equations_of(prior);
        let (mut weights, mut squares, mut inliers) = (0.0f32, 0.0f32, 0u32);
        // what the edges on either side were off on the line before
        let mut before = [0.0f32; 2];
        let (mut alike, mut own) = (0.0f32, 1e-9f32);
        let mut pairs = Pairs::default();
        for Row { terms, rho, weight, pair } in &rows {
            let off = rho - product(terms, &unknowns);
            let near = 1.0 / (1.0 + off * off * per_scale2);
            let robust = near * near;
            let w = weight * robust;
            weights += w;
            squares += w * off * off;
            pairs.add(*pair, w, off);
            let [same_side, other_side] = before;
            alike += same_side * w * off;
            own += w * off * w * off;
            before = [other_side, w * off];
            inliers += u32::from(robust >= INLIER_WEIGHT);
            add(&mut normal, &mut right, terms, *rho, w);
        }
        let factor = normal.cholesky()?;
        let solved: Unknowns = factor.solve(&right);
        let [next] = solved.data.0;
        let step = unknowns.iter().zip(&next).map(|(a, b)| libm::fabsf(a - b)).fold(0.0, f32::max);
        unknowns = next;
        // what a pixel has too much of a chroma, its neighbour has too little of: their mean is right
        let scatter = if edges.shared_chroma {
            pairs.scatter()
        } else {
            Scatter { weights, squares, likeness: alike / own }
        };
        last = Some((factor, scatter, inliers));
        if step <= SETTLED && scale <= last_scale {
            break;
        }
    }
    let (factor, Scatter { weights, squares, likeness }, inliers) = last?;
    // neighbours that are off alike (a thing behind the ball, its texture) tell less than others
    let likeness = if likeness > MOST_LIKENESS { MOST_LIKENESS } else { likeness.max(LEAST_LIKENESS) };
    let repeated = (1.0 + likeness) / (1.0 - likeness);
    let variance = squares / (weights - UNKNOWNS as f32 * 0.5).max(1.0);
    let variance = repeated * variance * (1.0 + variance / (CLUTTER_SIGMA * CLUTTER_SIGMA));
    let [radius, du, dv, a, b] = unknowns;
    let inverse = factor.inverse();
    let at = |i: usize, j: usize| inverse.get((i, j)).copied().unwrap_or(f32::MAX);
    let sigma2 = variance.max(EDGE_SIGMA * EDGE_SIGMA * 0.01);
    let centre = ImagePoint::new(start.centre.u + du, start.centre.v + dv * aspect);
    let good = centre.is_finite() && radius.is_finite() && a.is_finite() && b.is_finite();
    good.then_some(Fit {
        curve: Curve { centre, radius, a, b },
        covariance: [at(1, 1) * sigma2, at(1, 2) * sigma2, at(2, 2) * sigma2],
        inliers,
    })
}

/// The prior as equations of the weight of its certainty.
fn equations_of(prior: &Prior) -> (Normal, Unknowns) {
    let per = |sigma: f32| (EDGE_SIGMA * EDGE_SIGMA) / (sigma * sigma).max(1e-6);
    let (radius, centre, harmonic) = (per(prior.radius_sigma), per(CENTRE_SIGMA), per(prior.harmonic_sigma));
    let normal = Normal::from_diagonal(&Unknowns::from([radius, centre, centre, harmonic, harmonic]));
    let right = Unknowns::from([radius * prior.radius, 0.0, 0.0, harmonic * prior.a, harmonic * prior.b]);
    (normal, right)
}

/// One edge as an equation.
struct Row {
    terms: [f32; UNKNOWNS],
    rho: f32,
    weight: f32,
    pair: usize,
}

/// How far edges lie off the curve.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    /// Of so many values ...
    weights: f32,
    /// ... the sum of the squares, pixels squared.
    squares: f32,
    /// The correlation of neighbours.
    likeness: f32,
}

/// The edges of lines side by side taken together.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    edges: f32,
    weight: f32,
    off: f32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Pairs([Pair; MAX_PAIRS]);

impl Pairs {
    fn add(&mut self, pair: usize, weight: f32, off: f32) {
        if let Some(pair) = self.0.get_mut(pair) {
            pair.edges += 1.0;
            pair.weight += weight;
            pair.off += weight * off;
        }
    }

    /// That of the pairs' means, each with the variance of an edge of its own.
    fn scatter(&self) -> Scatter {
        let mut scatter = Scatter { weights: 0.0, squares: 0.0, likeness: 0.0 };
        let (mut alike, mut own, mut before) = (0.0f32, 1e-9f32, 0.0f32);
        for Pair { edges, weight, off } in &self.0 {
            if *weight > 0.0 {
                scatter.weights += weight / edges;
                let share = if *edges > 1.0 { 1.0 } else { LONE_SHARE };
                scatter.squares += share * off * off / weight;
            }
            alike += before * off;
            own += off * off;
            before = *off;
        }
        scatter.likeness = alike / own;
        scatter
    }
}

fn product(a: &[f32; UNKNOWNS], b: &[f32; UNKNOWNS]) -> f32 {
    let ([a0, a1, a2, a3, a4], [b0, b1, b2, b3, b4]) = (a, b);
    a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3 + a4 * b4
}

/// Adds one edge to the normal equations.
#[inline]
fn add(normal: &mut Normal, right: &mut Unknowns, row: &[f32; UNKNOWNS], value: f32, weight: f32) {
    let columns = normal.data.0.iter_mut().zip(right.data.0.iter_mut().flatten()).zip(row);
    for ((column, right), x) in columns {
        let weighted = weight * x;
        *right += weighted * value;
        for (entry, y) in column.iter_mut().zip(row) {
            *entry += weighted * y;
        }
    }
}
