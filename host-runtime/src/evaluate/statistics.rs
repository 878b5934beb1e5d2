//! What the experiments count: errors of centres and of poses, in the units of the tables.

use super::headline::{Bound, Told, largest};
use super::trace::{BallTrace, HandTrace, PoseError, Trace, TraceFrame};
use crate::output::Spread;
use crate::report::Cell;
use nalgebra::Vector3;

/// From this share of its outline on a ball counts as wholly in sight.
const WHOLE: f64 = 0.999;

/// Errors of centres over some balls and frames.
#[derive(Clone, Debug, Default)]
pub(super) struct Centres {
    pub(super) errors_px: Vec<f64>,
    /// Balls that ought to be measured.
    pub(super) in_sight: usize,
}

impl Centres {
    /// Adds the balls of the frames that `of_interest` picks, of those wholly in sight.
    pub(super) fn of(trace: &Trace, of_interest: impl Fn(&TraceFrame) -> bool) -> Self {
        let mut centres = Self::default();
        for frame in trace.frames.iter().filter(|frame| of_interest(frame)) {
            for ball in frame.cameras.iter().flatten().filter(|ball| ball.truth.visible_fraction > WHOLE) {
                centres.add(ball, ball.seen.state.is_measured());
            }
        }
        centres
    }

    /// Adds a ball that ought to be measured.
    pub(super) fn add(&mut self, ball: &BallTrace, measured: bool) {
        self.in_sight += 1;
        if measured {
            self.errors_px.push(ball.error_px());
        }
    }

    pub(super) fn extend(&mut self, other: &Self) {
        self.errors_px.extend_from_slice(&other.errors_px);
        self.in_sight += other.in_sight;
    }

    /// The columns of [`Centres::cells`].
    pub(super) const COLUMNS: [&'static str; 5] = ["balls", "measured_share", "mean_px", "p99_px", "max_px"];

    pub(super) fn cells(&self) -> Vec<Cell> {
        let mut cells = vec![Cell::count(self.in_sight), Cell::Number(self.share(), 3)];
        cells.extend([Self::mean, Self::p99, Self::max].map(|value| Cell::Number(value(self), 4)));
        cells
    }

    fn spread(&self, value: fn(&Spread) -> f64) -> f64 {
        spread(self.errors_px.iter().copied()).as_ref().map_or(f64::NAN, value)
    }

    /// Of the balls that ought to be measured; not a number where there are none.
    fn share(&self) -> f64 {
        self.errors_px.len() as f64 / self.in_sight as f64
    }

    pub(super) fn mean(&self) -> f64 {
        self.spread(|s| s.mean)
    }

    fn p99(&self) -> f64 {
        self.spread(|s| s.p99)
    }

    pub(super) fn max(&self) -> f64 {
        self.spread(|s| s.max)
    }

    /// The worst mean, the largest error and the lowest share of several, held against bounds of the
    /// first two, pixels.
    pub(super) fn worst<'a>(
        several: impl Iterator<Item = &'a Self> + Clone,
        (mean, max): (Bound, Bound),
    ) -> Told {
        let shares = several.clone().map(|centres| -centres.share());
        Told::default()
            .figure(("", " px"), largest(several.clone().map(Self::mean)), 3, mean)
            .figure((", at most ", ""), largest(several.map(Self::max)), 2, max)
            .share(-largest(shares))
    }
}

/// The spread of values; `None` of no values or where one is not finite.
fn spread(values: impl Iterator<Item = f64> + Clone) -> Option<Spread> {
    values.clone().all(f64::is_finite).then(|| Spread::of(values)).flatten()
}

/// Errors of the pose over a run, of the frames in which it was measured.
#[derive(Clone, Debug)]
pub(super) struct Poses {
    pub(super) frames: usize,
    pub(super) measured: usize,
    /// Largest less smallest error along each axis, millimetres: the paper's box.
    pub(super) box_mm: Vector3<f64>,
    /// Distance from the true place, millimetres.
    pub(super) mean_mm: f64,
    pub(super) max_mm: f64,
    /// Angle from the true orientation, degrees.
    pub(super) turn_mean_deg: f64,
    pub(super) turn_max_deg: f64,
    /// Mean error of the increment alpha, millimetres.
    pub(super) step_mm: f64,
}

impl Poses {
    pub(super) fn of(trace: &Trace) -> Self {
        let hands = || trace.frames.iter().filter_map(|frame| frame.hand.as_ref());
        let errors: Vec<&PoseError> = hands().filter_map(HandTrace::measured).collect();
        let places = || errors.iter().map(|error| error.translation_m * 1e3);
        let edge = |axis: usize| {
            let along = spread(places().map(|place| place[axis]));
            along.map_or(f64::NAN, |s| s.max - s.min)
        };
        let distance = spread(places().map(|place| place.norm()));
        let turn = spread(errors.iter().map(|error| error.rotation_rad.norm().to_degrees()));
        let steps: Vec<f64> = hands().filter_map(|hand| hand.step_error_m).map(|m| m * 1e3).collect();
        let of = |spread: &Option<Spread>, value: fn(&Spread) -> f64| spread.as_ref().map_or(f64::NAN, value);
        Self {
            frames: trace.frames.len(),
            measured: errors.len(),
            box_mm: Vector3::new(edge(0), edge(1), edge(2)),
            mean_mm: of(&distance, |s| s.mean),
            max_mm: of(&distance, |s| s.max),
            turn_mean_deg: of(&turn, |s| s.mean),
            turn_max_deg: of(&turn, |s| s.max),
            step_mm: of(&spread(steps.iter().copied()), |s| s.mean),
        }
    }

    /// Of all frames; not a number where there are none.
    pub(super) fn share(&self) -> f64 {
        self.measured as f64 / self.frames as f64
    }

    /// The columns of [`Poses::cells`].
    pub(super) const COLUMNS: [&'static str; 10] = [
        "frames",
        "measured_share",
        "box_x_mm",
        "box_y_mm",
        "box_z_mm",
        "mean_mm",
        "max_mm",
        "turn_mean_deg",
        "turn_max_deg",
        "step_mm",
    ];

    pub(super) fn cells(&self) -> Vec<Cell> {
        let mut cells = vec![Cell::count(self.frames), Cell::Number(self.share(), 3)];
        let millimetres = self.box_mm.iter().copied().chain([self.mean_mm, self.max_mm]);
        cells.extend(millimetres.map(|mm| Cell::Number(mm, 3)));
        cells.extend([self.turn_mean_deg, self.turn_max_deg].map(|deg| Cell::Number(deg, 3)));
        cells.push(Cell::Number(self.step_mm, 3));
        cells
    }

    /// The worst of each figure and the lowest share of several runs, held against bounds.
    pub(super) fn worst<'a>(runs: impl Iterator<Item = &'a Self> + Clone, bounds: &PoseBounds) -> Told {
        let worst = |value: fn(&Self) -> f64| largest(runs.clone().map(value));
        Told::default()
            .figure(("box ", ""), worst(|run| run.box_mm.x), 2, bounds.edge_mm)
            .figure((" x ", ""), worst(|run| run.box_mm.y), 2, bounds.edge_mm)
            .figure((" x ", " mm"), worst(|run| run.box_mm.z), 2, bounds.edge_mm)
            .figure(("; mean ", ""), worst(|run| run.mean_mm), 2, bounds.mean_mm)
            .figure((", at most ", " mm"), worst(|run| run.max_mm), 2, bounds.max_mm)
            .figure(("; turn at most ", "\u{b0}"), worst(|run| run.turn_max_deg), 2, bounds.turn_deg)
            .share(-worst(|run| -run.share()))
    }
}

/// What the figures of [`Poses::worst`] are held against.
#[derive(Clone, Copy, Debug)]
pub(super) struct PoseBounds {
    pub(super) edge_mm: Bound,
    pub(super) mean_mm: Bound,
    pub(super) max_mm: Bound,
    pub(super) turn_deg: Bound,
}

impl PoseBounds {
    /// Nothing is promised.
    pub(super) const FREE: Self =
        Self { edge_mm: Bound::Free, mean_mm: Bound::Free, max_mm: Bound::Free, turn_deg: Bound::Free };
}

#[cfg(test)]
pub(super) mod tests;
