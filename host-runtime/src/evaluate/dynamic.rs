//! The error of a moving ball's centre against its speed and the exposure: one camera at a time, as in
//! section 5; and figure 6, the detected path of the red ball.

use super::headline::{Bound, Headline};
use super::run::{MODES, Variant};
use super::scenes::{colour, named};
use super::statistics::Centres;
use super::trace::{BallTrace, Case, Trace, TraceFrame};
use super::{Outcome, Plan, Traced};
use crate::report::ink::GREY;
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use nalgebra::Vector3;
use tetrad_core::observation::Ball;
use tetrad_fixtures::{Light, Motion, Scene};

const SPEEDS: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
const EXPOSURES_MS: [f64; 2] = [4.0, 8.0];
const PATHS: [&str; 2] = ["linear", "circular"];

/// Long enough to reach 0.9 m/s at the scenes' 2 m/s^2, metres.
const PATH_M: f64 = 0.45;

/// Frames at less than this share of the speed (rest, turning back) are left out.
const AT_SPEED: f64 = 0.8;

/// Mean and upper bound of section 5 up to 0.5 m/s, and at 0.7 m/s, pixels.
const PUBLISHED_PX: [(f64, f64); 2] = [(0.5, 1.0), (0.7, 3.0)];

/// Speeds and exposures of which something is promised: in side light too.
const PROMISED: [(f64, f64); 2] = [(0.5, 4.0), (0.7, 8.0)];

/// The light of most rows, and the other one.
const ROOM: &str = "room";
const SIDE: &str = "side 45 %";

/// A path, its speed, the exposure and the light.
fn grid() -> impl Iterator<Item = (&'static str, f64, f64, &'static str)> {
    let exposures = EXPOSURES_MS.into_iter();
    let room = exposures.flat_map(|ms| {
        PATHS.into_iter().flat_map(move |path| SPEEDS.map(move |speed| (path, speed, ms, ROOM)))
    });
    room.chain(PATHS.into_iter().flat_map(|path| PROMISED.map(|(speed, ms)| (path, speed, ms, SIDE))))
}

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let case = |(path, speed, exposure_ms, light): (&'static str, f64, f64, &'static str)| {
        let mut scene = named(&format!("{path}-{speed}-30fps"));
        if let Motion::Linear { path_m, .. } = &mut scene.motion {
            *path_m = path_m.normalize() * PATH_M;
        }
        scene.exposure_s = exposure_ms / 1e3;
        scene.frames = plan.pick(240, 75);
        let mut label = format!("{path} {speed} m/s, {exposure_ms} ms");
        if light == SIDE {
            scene.light = Light::side(0.45);
            label = format!("{label}, {light}");
        }
        Case::new(label, scene, plan.seed, &MODES.map(Variant::of))
    };
    grid().map(case).collect()
}

struct Row {
    path: &'static str,
    speed: f64,
    exposure_ms: f64,
    light: &'static str,
    mode: Mode,
    centres: Centres,
}

pub(super) fn outcome(_: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    for ((path, speed, exposure_ms, light), Traced { case, traces }) in grid().zip(traced) {
        for trace in traces {
            let centres = Centres::of(trace, |frame| is_at_speed(&case.scene, frame, speed));
            rows.push(Row { path, speed, exposure_ms, light, mode: trace.variant.mode, centres });
        }
    }
    let errors = Figure {
        name: "dynamic-error",
        caption: "Mean error of a moving ball's centre, linear and circular path together; grey: the means \
                  the paper reports at up to 0.5 and at 0.7 m/s"
            .to_owned(),
        panels: EXPOSURES_MS.map(|ms| panel(ms, &rows)).to_vec(),
    };
    let section = Section {
        id: "dynamic",
        title: "Dynamic error of the centre".to_owned(),
        text: format!(
            "The hand runs to and fro on a straight path of {PATH_M} m and round a circle of 0.1 m radius at 30 \
             frames a second. The error is told from the true centre in the middle of the exposure; frames \
             at less than 80 % of the speed are left out. Where something is promised the same is run lit from \
             the side (45 %), and the worse light stands in the first table; the figures are of room light. The first figure is the paper's figure 6, the path of \
             the red ball in the left picture."
        ),
        tables: vec![table(&rows)],
        figures: vec![figure_6(traced), errors],
    };
    let headlines = vec![
        headline(
            "Moving centre at 0.5 m/s, 4 ms exposure, worst path and light",
            (0.5, 4.0),
            &rows,
            ("1 px, at most 1.6", "0.08 px, at most 0.3"),
            (Bound::Most(0.08), Bound::Most(0.3)),
        ),
        headline(
            "Moving centre at 0.7 m/s, 8 ms exposure, worst path and light",
            (0.7, 8.0),
            &rows,
            ("3 px, at most 7", "0.2 px"),
            (Bound::Most(0.2), Bound::Free),
        ),
    ];
    Outcome { section, headlines }
}

/// Whether the hand has most of its speed in a frame.
fn is_at_speed(scene: &Scene, frame: &TraceFrame, speed: f64) -> bool {
    const AROUND_S: f64 = 1e-3;
    let at = |t: f64| scene.hand_at(t).translation;
    let moved: Vector3<f64> = at(frame.t_s + AROUND_S) - at(frame.t_s - AROUND_S);
    moved.norm() / (2.0 * AROUND_S) >= AT_SPEED * speed
}

fn table(rows: &[Row]) -> Table {
    let mut columns = vec!["path", "speed_m_s", "exposure_ms", "light", "mode"];
    columns.extend(Centres::COLUMNS);
    let row = |row: &Row| {
        let mut cells: Vec<Cell> = vec![
            row.path.into(),
            Cell::Number(row.speed, 1),
            Cell::Number(row.exposure_ms, 0),
            row.light.into(),
            row.mode.name().into(),
        ];
        cells.extend(row.centres.cells());
        cells
    };
    Table {
        name: "dynamic",
        caption: "Error of a moving ball's centre, pixels".to_owned(),
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

/// Both paths at one speed and exposure, in room light.
fn together(rows: &[Row], speed: f64, exposure_ms: f64, mode: Mode) -> Centres {
    let mut all = Centres::default();
    let own = rows.iter().filter(|r| r.speed == speed && r.exposure_ms == exposure_ms && r.mode == mode);
    for row in own.filter(|row| row.light == ROOM) {
        all.extend(&row.centres);
    }
    all
}

fn panel(exposure_ms: f64, rows: &[Row]) -> Panel {
    let mut series: Vec<Series> = MODES
        .iter()
        .map(|&mode| {
            let point = |speed| (speed, together(rows, speed, exposure_ms, mode).mean());
            Series::new(mode.name(), Look::Dotted, colour(mode), SPEEDS.map(point).to_vec())
        })
        .collect();
    series.push(Series::new("published", Look::Points, GREY, PUBLISHED_PX.to_vec()));
    Panel {
        title: format!("Exposure {exposure_ms} ms"),
        x: Axis::from_zero("speed, m/s"),
        y: Axis::log("mean error, px"),
        equal: false,
        series,
    }
}

/// The red ball in the left picture: where it is seen, and how far from its true place.
fn figure_6(traced: &[Traced]) -> Figure {
    let traces = |path: &str| -> &[Trace] {
        let mut found = grid()
            .zip(traced)
            .filter(|((p, speed, ms, light), _)| (*p, *speed, *ms, *light) == (path, 0.5, 4.0, ROOM));
        found.next().map_or(&[], |(_, traced)| &traced.traces)
    };
    let red = |trace: &Trace, point: fn(f64, &BallTrace) -> (f64, f64)| -> Vec<(f64, f64)> {
        let frames = trace.frames.iter();
        let balls = frames.filter_map(|frame| Some((frame.t_s, frame.cameras.first()?[Ball::Red.index()])));
        balls.map(|(t_s, ball)| point(t_s, &ball)).collect()
    };
    let curves = |path: &str, look: Look, point: fn(f64, &BallTrace) -> (f64, f64)| -> Vec<Series> {
        let curve = |trace: &Trace| {
            let mode = trace.variant.mode;
            Series::new(mode.name(), look, colour(mode), red(trace, point))
        };
        traces(path).iter().map(curve).collect()
    };
    let place = |path: &'static str| {
        let mut series = Vec::new();
        if let Some(trace) = traces(path).first() {
            series.push(Series::new(
                "true",
                Look::Line,
                GREY,
                red(trace, |_, ball| ball.truth.outline_centre),
            ));
        }
        series.extend(curves(path, Look::Points, |_, ball| {
            (f64::from(ball.seen.centre.u), f64::from(ball.seen.centre.v))
        }));
        Panel {
            title: format!("{path}, 0.5 m/s"),
            x: Axis::linear("u, px"),
            y: Axis { down: true, ..Axis::linear("v, px") },
            equal: true,
            series,
        }
    };
    let error = |path: &'static str| Panel {
        title: format!("{path}: distance from the true place"),
        x: Axis::linear("time, s"),
        y: Axis::from_zero("px"),
        equal: false,
        series: curves(path, Look::Line, |t_s, ball| (t_s, ball.error_px())),
    };
    Figure {
        name: "figure-6",
        caption: "Figure 6: the detected path of the red ball in the left camera's picture, and its error"
            .to_owned(),
        panels: PATHS.map(place).into_iter().chain(PATHS.map(error)).collect(),
    }
}

fn headline(
    what: &str,
    (speed, ms): (f64, f64),
    rows: &[Row],
    (published, promised): (&'static str, &'static str),
    bounds: (Bound, Bound),
) -> Headline {
    let told = |mode| {
        let own = rows.iter().filter(|r| r.speed == speed && r.exposure_ms == ms && r.mode == mode);
        Centres::worst(own.map(|row| &row.centres), bounds)
    };
    Headline {
        what: what.to_owned(),
        published,
        promised,
        refined: told(Mode::Refined),
        paper: told(Mode::Paper),
    }
}
