//! What the experiments count: errors of centres and of poses, in the units of the tables.

use super::trace::{BallTrace, HandTrace, Trace, TraceFrame};
use crate::output::Spread;
use crate::report::Cell;
use nalgebra::Vector3;
use tetrad_core::observation::ObservationState;

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
                centres.add(ball, ball.seen.state == ObservationState::Visible);
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
        let mut cells = vec![
            Cell::count(self.in_sight),
            Cell::Number(self.errors_px.len() as f64 / self.in_sight as f64, 3),
        ];
        cells.extend([Self::mean, Self::p99, Self::max].map(|value| Cell::Number(value(self), 4)));
        cells
    }

    fn spread(&self, value: fn(&Spread) -> f64) -> f64 {
        Spread::of(self.errors_px.iter().copied()).as_ref().map_or(f64::NAN, value)
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

    /// Mean and maximum in words.
    pub(super) fn text(&self) -> String {
        format!("{:.3} px, at most {:.2}", self.mean(), self.max())
    }
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
        let measured: Vec<&HandTrace> = hands().filter(|hand| hand.state.is_measured()).collect();
        let errors = || measured.iter().filter_map(|hand| hand.error.as_ref());
        let places = || errors().map(|error| error.translation_m * 1e3);
        let nowhere = Vector3::repeat(f64::NAN);
        let low = places().reduce(|a, b| a.inf(&b)).unwrap_or(nowhere);
        let high = places().reduce(|a, b| a.sup(&b)).unwrap_or(nowhere);
        let distance = Spread::of(places().map(|place| place.norm()));
        let turn = Spread::of(errors().map(|error| error.rotation_rad.norm().to_degrees()));
        let of = |spread: &Option<Spread>, value: fn(&Spread) -> f64| spread.as_ref().map_or(f64::NAN, value);
        Self {
            frames: trace.frames.len(),
            measured: measured.len(),
            box_mm: high - low,
            mean_mm: of(&distance, |s| s.mean),
            max_mm: of(&distance, |s| s.max),
            turn_mean_deg: of(&turn, |s| s.mean),
            turn_max_deg: of(&turn, |s| s.max),
            step_mm: of(&Spread::of(hands().filter_map(|hand| hand.step_error_m).map(|m| m * 1e3)), |s| {
                s.mean
            }),
        }
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
        let mut cells =
            vec![Cell::count(self.frames), Cell::Number(self.measured as f64 / self.frames as f64, 3)];
        let millimetres = self.box_mm.iter().copied().chain([self.mean_mm, self.max_mm]);
        cells.extend(millimetres.map(|mm| Cell::Number(mm, 3)));
        cells.extend([self.turn_mean_deg, self.turn_max_deg].map(|deg| Cell::Number(deg, 3)));
        cells.push(Cell::Number(self.step_mm, 3));
        cells
    }

    /// The worst of each figure over several runs, in words.
    pub(super) fn worst<'a>(runs: impl Iterator<Item = &'a Self>) -> String {
        let mut most: Option<(Vector3<f64>, f64, f64)> = None;
        for run in runs.filter(|run| run.measured > 0) {
            let (edges, mean, turn) = most.unwrap_or_else(|| (Vector3::zeros(), 0.0, 0.0));
            most = Some((edges.sup(&run.box_mm), mean.max(run.mean_mm), turn.max(run.turn_max_deg)));
        }
        let Some((edges, mean, turn)) = most else { return "no pose".to_owned() };
        let [x, y, z]: [f64; 3] = edges.into();
        format!("box {x:.2} x {y:.2} x {z:.2} mm; mean {mean:.2} mm; turn at most {turn:.2}\u{b0}")
    }
}
