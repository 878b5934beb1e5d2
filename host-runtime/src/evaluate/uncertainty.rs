//! Whether the reported uncertainty is honest: errors divided by the reported standard deviation have
//! a root mean square of 1 when it is.

use super::headline::{Bound, Headline, NOTHING, Told};
use super::run::{MODES, Variant};
use super::scenes::named;
use super::trace::{Case, HandTrace, PoseError, Trace};
use super::{Outcome, Plan, Traced};
use crate::report::{Cell, Section, Table};
use crate::settings::Mode;
use nalgebra::Vector6;
use tetrad_core::hand::state::PoseState;
use tetrad_core::observation::{Observation, ObservationState};
use tetrad_fixtures::{Light, Scene};

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

/// Movements that are covered again and again. All frames of one cover share one error, so that it takes
/// many covers, at different places of different movements, to judge a state nobody sees.
const COVERED: [&str; 5] =
    ["demo", "cover-all", "circular-0.25-30fps", "circular-0.5-30fps", "linear-0.5-30fps"];

/// Seconds from one cover to the next, and frames of all of them.
const AGAIN_S: f64 = 2.7;
const COVERS: usize = 4;
const COVERED_FRAMES: usize = 351;

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
    for name in COVERED {
        let label = format!("{LABEL}{name}, covered again and again");
        let mut scene = covered(name);
        scene.frames = plan.pick(COVERED_FRAMES, COVERED_FRAMES / COVERS);
        cases.push(Case::new(label, scene, plan.seed, &[refined, one_camera]));
    }
    cases
}

/// A hand over which the palm of `cover-all` comes again and again.
fn covered(name: &str) -> Scene {
    let mut scene = named(name);
    scene.occluders = named("cover-all").occluders;
    for palm in &mut scene.occluders {
        let once = palm.reach.clone();
        let at = |cover: usize| once.iter().map(move |(t_s, reach)| (t_s + AGAIN_S * cover as f64, *reach));
        palm.reach = (0..COVERS).flat_map(at).collect();
    }
    scene
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
    /// Samples without a ratio: no covariance, none that can be inverted, or no error.
    failed: usize,
}

impl Ratio {
    fn add(&mut self, square: f64) {
        if square.is_finite() {
            self.count += 1;
            self.squares += square;
        } else {
            self.failed += 1;
        }
    }

    /// Of all samples that have a ratio; not a number where there is none.
    fn root(self) -> f64 {
        (self.squares / self.count as f64).sqrt()
    }

    const fn samples(self) -> usize {
        self.count + self.failed
    }

    fn pooled(ratios: &[(String, Self)]) -> Self {
        ratios.iter().fold(Self::default(), |all, (_, one)| Self {
            count: all.count + one.count,
            squares: all.squares + one.squares,
            failed: all.failed + one.failed,
        })
    }

    /// How far from honest, too bold or too modest alike; without a ratio infinitely.
    fn dishonesty(self) -> f64 {
        let logarithm = self.root().ln().abs();
        if self.failed > 0 || logarithm.is_nan() { f64::INFINITY } else { logarithm }
    }
}

/// The columns of [`cells`].
const COLUMNS: [&str; 3] = ["samples", "without_ratio", "rms"];

fn cells(ratio: Ratio) -> [Cell; 3] {
    let rms = if ratio.samples() == 0 { DID_NOT_OCCUR.into() } else { Cell::number(ratio.root()) };
    [Cell::count(ratio.samples()), Cell::count(ratio.failed), rms]
}

const DID_NOT_OCCUR: &str = "did not occur";

/// A kind of sample: what it is, its state, and how it is counted in a run.
struct Kind {
    what: &'static str,
    state: &'static str,
    of: Box<dyn Fn(&Trace) -> Ratio>,
}

impl Kind {
    /// Every state of a centre, then every state of a pose.
    fn all() -> Vec<Self> {
        let centre = |state: ObservationState| Self {
            what: "centre",
            state: state.name(),
            of: Box::new(move |trace| centres(trace, state)),
        };
        let pose = |state: PoseState| Self {
            what: "pose",
            state: state.name(),
            of: Box::new(move |trace| poses(trace, state)),
        };
        let with_pose = PoseState::ALL.into_iter().filter(|state| *state != PoseState::Lost);
        OBSERVED.into_iter().map(centre).chain(with_pose.map(pose)).collect()
    }

    /// The ratio of every run of a mode, and where it comes from.
    fn by_scene(&self, traced: &[Traced], mode: Mode) -> Vec<(String, Ratio)> {
        let runs = traced.iter().flat_map(|Traced { case, traces }| {
            traces.iter().filter(|trace| trace.variant.mode == mode).map(move |trace| (case, trace))
        });
        let run = |(case, trace): (&Case, &Trace)| {
            let cameras = if trace.variant.cameras == 1 { ", 1 camera" } else { "" };
            let scene = case.label.trim_start_matches(LABEL);
            (format!("{scene}{cameras}"), (self.of)(trace))
        };
        runs.map(run).collect()
    }
}

pub(super) fn outcome(_: Plan, traced: &[Traced]) -> Outcome {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut scenes: Vec<Vec<Cell>> = Vec::new();
    let mut headlines = Vec::new();
    for kind in Kind::all() {
        let [paper, refined] = MODES.map(|mode| kind.by_scene(traced, mode));
        // paper mode says nothing of its pose
        let says = kind.what == "centre";
        let told_paper = if says { told(&paper, Bound::Free) } else { Told::words(NOTHING) };
        let row = |ratio: Ratio, first: [&str; 3]| {
            first.map(Cell::from).into_iter().chain(cells(ratio)).collect::<Vec<_>>()
        };
        if says {
            rows.push(row(Ratio::pooled(&paper), [kind.what, kind.state, Mode::Paper.name()]));
        }
        rows.push(row(Ratio::pooled(&refined), [kind.what, kind.state, Mode::Refined.name()]));
        let occurred = refined.iter().filter(|(_, ratio)| ratio.samples() > 0);
        scenes.extend(occurred.map(|(scene, ratio)| row(*ratio, [kind.what, kind.state, scene])));
        headlines.push(headline(kind.what, kind.state, &refined, told_paper));
    }
    let columns = |first: [&'static str; 3]| first.into_iter().chain(COLUMNS).collect();
    let section = Section {
        id: "uncertainty",
        title: "Errors against the reported uncertainty".to_owned(),
        text: "Every observation and every pose says how well it is known. Here the errors are divided by what was \
               reported (e\u{1d40} C\u{207b}\u{00b9} e over its dimensions, 2 or 6), over eighteen scenes at rest, moving, covered \
               (five of them again and again) and crossing, with two cameras and, for the pose, with one. A root mean square of 1 is honest, below 1 too modest, \
               above 1 too bold. Samples without a ratio have no covariance or none that can be inverted. Paper \
               mode says nothing of its pose."
            .to_owned(),
        tables: vec![
            Table {
                name: "uncertainty",
                caption: "Errors divided by the reported standard deviation, root mean square".to_owned(),
                columns: columns(["what", "state", "mode"]),
                rows,
            },
            Table {
                name: "uncertainty-scenes",
                caption: "The same by scene, refined; states that occurred".to_owned(),
                columns: columns(["what", "state", "scene"]),
                rows: scenes,
            },
        ],
        figures: Vec::new(),
    };
    Outcome { section, headlines }
}

fn headline(what: &str, state: &str, refined: &[(String, Ratio)], paper: Told) -> Headline {
    Headline {
        what: format!("Error over reported sigma (1 is honest), {what} {state}"),
        published: NOTHING,
        promised: "0.7 to 1.4, all scenes together",
        refined: told(refined, Bound::Between(0.7, 1.4)),
        paper,
    }
}

/// The pooled ratio, held against its bound, and the scene farthest from 1.
fn told(ratios: &[(String, Ratio)], bound: Bound) -> Told {
    let pooled = Ratio::pooled(ratios);
    if pooled.samples() == 0 {
        return Told::words("").failed(DID_NOT_OCCUR);
    }
    let occurred = ratios.iter().filter(|(_, ratio)| ratio.samples() > 0);
    let worst = occurred.max_by(|(_, a), (_, b)| a.dishonesty().total_cmp(&b.dishonesty()));
    let mut told = Told::default().figure(("", ""), pooled.root(), 2, bound);
    told = told.note(&format!(" of {} samples", pooled.samples()));
    if let Some((scene, ratio)) = worst {
        let root = if ratio.failed > 0 { "none".to_owned() } else { format!("{:.2}", ratio.root()) };
        told = told.note(&format!("; worst scene {root} ({scene}, {} samples)", ratio.samples()));
    }
    if pooled.failed > 0 {
        told = told.failed(&format!("; {} have no usable covariance", pooled.failed));
    }
    told
}

/// Of runs with both cameras: one with the left camera alone sees the same pictures again.
fn centres(trace: &Trace, state: ObservationState) -> Ratio {
    let mut ratio = Ratio::default();
    if trace.variant.cameras < 2 {
        return ratio;
    }
    let balls = trace.frames.iter().flat_map(|frame| frame.cameras.iter().flatten());
    for ball in balls.filter(|ball| ball.seen.state == state) {
        ratio.add(mahalanobis(&ball.seen, ball.error_uv()) / 2.0);
    }
    ratio
}

fn poses(trace: &Trace, state: PoseState) -> Ratio {
    let mut ratio = Ratio::default();
    let hands = trace.frames.iter().filter_map(|frame| frame.hand.as_ref());
    for hand in hands.filter(|hand: &&HandTrace| hand.state == state) {
        ratio.add(hand.error.as_ref().map_or(f64::NAN, normalised) / 6.0);
    }
    ratio
}

/// The root mean square of errors over reported deviations, of centres in full sight and of poses from both
/// cameras.
pub(super) fn over_sigma(trace: &Trace) -> [f64; 2] {
    [centres(trace, ObservationState::Visible).root(), poses(trace, PoseState::Both).root()]
}

/// e' C^-1 e; not a number where C says nothing.
fn mahalanobis(seen: &Observation, (u, v): (f64, f64)) -> f64 {
    let [uu, uv, vv] = [seen.covariance.uu, seen.covariance.uv, seen.covariance.vv].map(f64::from);
    let determinant = uu * vv - uv * uv;
    if determinant > 0.0 { (vv * u * u - 2.0 * uv * u * v + uu * v * v) / determinant } else { f64::NAN }
}

fn normalised(error: &PoseError) -> f64 {
    let Some(covariance) = error.covariance else { return f64::NAN };
    let (t, w) = (error.translation_m, error.rotation_rad);
    let e = Vector6::new(t.x, t.y, t.z, w.x, w.y, w.z);
    covariance.cast::<f64>().cholesky().map_or(f64::NAN, |c| e.dot(&c.solve(&e)))
}

#[cfg(test)]
mod tests;
