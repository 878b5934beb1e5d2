//! Whether the reported uncertainty is honest: errors divided by the reported standard deviation have
//! a root mean square of 1 when it is.

use super::run::{MODES, Variant};
use super::scenes::named;
use super::trace::{Case, PoseError, Trace};
use super::{Headline, Outcome, Plan, Traced};
use crate::report::{Cell, Section, Table};
use crate::settings::Mode;
use nalgebra::Vector6;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{Observation, ObservationState};
use tetrad_fixtures::Light;

/// Scenes in which every state occurs: whole and covered balls, one camera, a hand that is away.
const SCENES: [(&str, usize); 12] = [
    ("static-8px", 60),
    ("static-16px", 60),
    ("static-side-16px", 60),
    ("static-side-32px", 60),
    ("linear-0.5-30fps", 150),
    ("circular-0.5-30fps", 150),
    ("demo", 300),
    ("finger", 150),
    ("cover", 180),
    ("cover-all", 180),
    ("crossing", 420),
    ("edge", 210),
];

/// States with a place.
const OBSERVED: [ObservationState; 3] =
    [ObservationState::Visible, ObservationState::Occluded, ObservationState::Predicted];

/// Before the scene's name in a case's label.
const LABEL: &str = "uncertainty ";

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let one_camera = Variant { cameras: 1, ..Variant::of(Mode::Refined) };
    let [paper, refined] = MODES.map(Variant::of);
    let case = |(name, frames): (&str, usize)| {
        let mut scene = named(name);
        // a movement is shown whole: what is covered in a scene is covered late in it
        scene.frames = if plan.quick && !is_timed(name) { frames / 3 } else { frames };
        Case::new(format!("{LABEL}{name}"), scene, plan.seed, &[paper, refined, one_camera])
    };
    let mut cases: Vec<Case> = SCENES.into_iter().map(case).collect();
    let mut side = named("circular-0.5-30fps");
    side.light = Light::side(0.45);
    side.frames = plan.pick(150, 50);
    cases.push(Case::new(format!("{LABEL}circular, side"), side, plan.seed, &[paper, refined, one_camera]));
    cases
}

/// Whether something happens at a certain time of the scene.
fn is_timed(name: &str) -> bool {
    ["finger", "cover", "cover-all", "crossing", "edge"].contains(&name)
}

/// A mean square that grows.
#[derive(Clone, Copy, Debug, Default)]
struct Ratio {
    count: usize,
    squares: f64,
}

impl Ratio {
    fn add(&mut self, square: f64) {
        if square.is_finite() {
            self.count += 1;
            self.squares += square;
        }
    }

    fn root(self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }
}

pub(super) fn outcome(_: Plan, traced: &[Traced]) -> Outcome {
    let traces =
        |mode: Mode| traced.iter().flat_map(|t| &t.traces).filter(move |trace| trace.variant.mode == mode);
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut told: Vec<String> = Vec::new();
    let mut row = |what: &str, state: &'static str, mode: Mode, ratio: Ratio| {
        if mode == Mode::Refined && ratio.count > 0 {
            told.push(format!("{what} {state} {:.2}", ratio.root()));
        }
        let count = Cell::count(ratio.count);
        rows.push(vec![what.into(), state.into(), mode.name().into(), count, Cell::number(ratio.root())]);
    };
    for state in OBSERVED {
        for mode in MODES {
            row("centre", state.name(), mode, centres(traces(mode), state));
        }
    }
    let by_scene = traced.iter().flat_map(|Traced { case, traces }| {
        let refined = traces.iter().filter(|trace| trace.variant.mode == Mode::Refined);
        refined.flat_map(move |trace| scene_rows(case, trace))
    });
    let by_scene = Table {
        name: "uncertainty-scenes",
        caption: "The same by scene, refined".to_owned(),
        columns: vec!["scene", "cameras", "what", "state", "count", "rms"],
        rows: by_scene.collect(),
    };
    let of_refined = |state: PoseState| poses(traces(Mode::Refined), state);
    for state in PoseState::ALL.into_iter().filter(|state| *state != PoseState::Lost) {
        row("pose", state.name(), Mode::Refined, of_refined(state));
    }
    let section = Section {
        id: "uncertainty",
        title: "Errors against the reported uncertainty".to_owned(),
        text: "Every observation and every pose says how well it is known. Here the errors are divided by what was \
               reported (e\u{1d40} C\u{207b}\u{00b9} e over its dimensions, 2 or 6), over thirteen scenes at rest, moving, covered and \
               crossing, with two cameras and with one. A root mean square of 1 is honest, below 1 too modest, \
               above 1 too bold. Paper mode says nothing of its pose."
            .to_owned(),
        tables: vec![Table {
            name: "uncertainty",
            caption: "Errors divided by the reported standard deviation, root mean square".to_owned(),
            columns: vec!["what", "state", "mode", "count", "rms"],
            rows,
        }, by_scene],
        figures: Vec::new(),
    };
    let headlines = vec![Headline {
        what: "Errors over reported sigma, by state (1 is honest)".to_owned(),
        published: "\u{2013}",
        promised: "0.7 to 1.4",
        refined: told.join(", "),
        paper: "\u{2013}".to_owned(),
    }];
    Outcome { section, headlines }
}

/// The rows of one run: each state that occurred.
fn scene_rows(case: &Case, trace: &Trace) -> Vec<Vec<Cell>> {
    let row = |what: &str, state: &str, ratio: Ratio| {
        let cameras = Cell::count(trace.variant.cameras);
        let scene = case.label.trim_start_matches(LABEL);
        let count = Cell::count(ratio.count);
        (ratio.count > 0).then(|| {
            vec![scene.into(), cameras, what.into(), state.into(), count, Cell::number(ratio.root())]
        })
    };
    let one = || std::iter::once(trace);
    let centres = OBSERVED.iter().filter_map(|&state| row("centre", state.name(), centres(one(), state)));
    let poses = PoseState::ALL.iter().filter_map(|&state| row("pose", state.name(), poses(one(), state)));
    centres.chain(poses).collect()
}

fn centres<'a>(traces: impl Iterator<Item = &'a Trace>, state: ObservationState) -> Ratio {
    let mut ratio = Ratio::default();
    let frames = traces.flat_map(|trace| &trace.frames);
    for ball in
        frames.flat_map(|frame| frame.cameras.iter().flatten()).filter(|ball| ball.seen.state == state)
    {
        ratio.add(mahalanobis(&ball.seen, ball.error_uv()) / 2.0);
    }
    ratio
}

/// e' C^-1 e; not a number where C says nothing.
fn mahalanobis(seen: &Observation, (u, v): (f64, f64)) -> f64 {
    let [uu, uv, vv] = [seen.covariance.uu, seen.covariance.uv, seen.covariance.vv].map(f64::from);
    let determinant = uu * vv - uv * uv;
    if determinant > 0.0 { (vv * u * u - 2.0 * uv * u * v + uu * v * v) / determinant } else { f64::NAN }
}

fn poses<'a>(traces: impl Iterator<Item = &'a Trace>, state: PoseState) -> Ratio {
    let mut ratio = Ratio::default();
    let hands = traces.flat_map(|trace| &trace.frames).filter_map(|frame| frame.hand.as_ref());
    for error in hands.filter(|hand| hand.state == state).filter_map(|hand| hand.error.as_ref()) {
        ratio.add(normalised(error) / 6.0);
    }
    ratio
}

fn normalised(error: &PoseError) -> f64 {
    let Some(covariance) = error.covariance else { return f64::NAN };
    let (t, w) = (error.translation_m, error.rotation_rad);
    let e = Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    covariance.cast::<f64>().cholesky().map_or(f64::NAN, |c| e.dot(&c.solve(&e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix6, Vector3};
    use tetrad_core::observation::ImageCovariance;

    #[test]
    fn an_error_of_one_sigma_in_every_direction_counts_as_its_dimensions() {
        let covariance = ImageCovariance { uu: 0.04, uv: 0.0, vv: 0.09 };
        let seen = Observation { covariance, ..Observation::default() };
        assert!((mahalanobis(&seen, (0.2, -0.3)) - 2.0).abs() < 1e-6);
        assert!(mahalanobis(&Observation::default(), (0.2, 0.3)).is_nan());
        let error = PoseError {
            translation_m: Vector3::new(0.001, -0.001, 0.001),
            rotation_rad: Vector3::new(0.01, 0.01, -0.01),
            covariance: Some(Matrix6::from_diagonal(&Vector6::new(1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4))),
        };
        assert!((normalised(&error) - 6.0).abs() < 1e-5);
        assert!(normalised(&PoseError { covariance: None, ..error }).is_nan());
    }
}
