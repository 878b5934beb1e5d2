//! The error of the hand's place and orientation on a line and on a circle (section 5, figures 7 and
//! 8), with two cameras, with one, and with focal lengths that are wrong.

use super::headline::{Bound, Headline, NOTHING, Told};
use super::run::{MODES, Variant};
use super::scenes::{colour, named};
use super::statistics::{PoseBounds, Poses};
use super::trace::{Case, Trace};
use super::{Outcome, Plan, Traced};
use crate::report::ink::GREY;
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use nalgebra::Vector3;
use tetrad_fixtures::Light;

const PATHS: [(&str, &str); 2] = [("linear", "linear, 0.3 m"), ("circular", "circular, 0.1 m radius")];
const SPEEDS: [f64; 2] = [0.25, 0.5];

/// How the hand is seen, in the words of the table.
const VIEWS: [(&str, usize, f64); 4] = [
    ("two cameras", 2, 1.0),
    ("two cameras, focal lengths 10 % short", 2, 0.9),
    ("two cameras, focal lengths 10 % long", 2, 1.1),
    ("one camera", 1, 1.0),
];

fn lights() -> [(&'static str, Light); 2] {
    [("even", Light::even()), ("side 45 %", Light::side(0.45))]
}

fn variants() -> Vec<Variant> {
    let refined =
        VIEWS.map(|(_, cameras, focal_share)| Variant { cameras, focal_share, ..Variant::of(Mode::Refined) });
    // the paper's way knows no focal length and takes two cameras
    std::iter::once(Variant::of(Mode::Paper)).chain(refined).collect()
}

fn grid() -> Vec<((&'static str, &'static str), f64, &'static str, Light)> {
    let mut grid = Vec::new();
    for (light_name, light) in lights() {
        for path in PATHS {
            for speed in SPEEDS {
                grid.push((path, speed, light_name, light.clone()));
            }
        }
    }
    grid
}

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let case = |((path, _), speed, light_name, light)| {
        let mut scene = named(&format!("{path}-{speed}-30fps"));
        scene.light = light;
        scene.frames = plan.pick(300, 120);
        Case::new(format!("path {path} {speed} m/s, {light_name}"), scene, plan.seed, &variants())
    };
    grid().into_iter().map(case).collect()
}

struct Row {
    path: (&'static str, &'static str),
    speed: f64,
    light: &'static str,
    view: &'static str,
    mode: Mode,
    poses: Poses,
}

pub(super) fn outcome(_: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    for ((path, speed, light, _), Traced { traces, .. }) in grid().into_iter().zip(traced) {
        for trace in traces {
            let Variant { mode, cameras, focal_share, .. } = trace.variant;
            let view = VIEWS.iter().find(|(_, c, f)| *c == cameras && *f == focal_share);
            let view = view.map_or("", |(name, ..)| name);
            rows.push(Row { path, speed, light, view, mode, poses: Poses::of(trace) });
        }
    }
    let section = Section {
        id: "paths",
        title: "3D error on a line and a circle".to_owned(),
        text: "The hand runs on a line of 0.3 m across all three directions and round a circle of 0.1 m radius. \
               The pose is told from the first frame on, and its error from the true pose at the middle of \
               the exposure, in the axes of the hand at the start: nothing is aligned afterwards. Box: the \
               largest less the smallest error along each axis. Paper mode adds up increments from frame to \
               frame, and their mean error is the column step_mm. With one camera depth comes from the frame's \
               size in the picture alone; paper mode gives no pose then, and knows no focal length."
            .to_owned(),
        tables: vec![table(&rows)],
        figures: vec![
            figure("figure-7", "Figure 7: a line of 0.3 m at 0.5 m/s seen by two cameras, and the errors along it", PATHS[0].0, traced),
            figure("figure-8", "Figure 8: a circle of 0.1 m radius at 0.5 m/s seen by two cameras, and the errors along it", PATHS[1].0, traced),
        ],
    };
    Outcome { section, headlines: headlines(&rows) }
}

fn table(rows: &[Row]) -> Table {
    let mut columns = vec!["path", "speed_m_s", "light", "seen_by", "mode"];
    columns.extend(Poses::COLUMNS);
    let row = |row: &Row| {
        let mut cells: Vec<Cell> = vec![
            row.path.0.into(),
            Cell::number(row.speed),
            row.light.into(),
            row.view.into(),
            row.mode.name().into(),
        ];
        cells.extend(row.poses.cells());
        cells
    };
    Table {
        name: "paths",
        caption: "Error of the pose along a known path".to_owned(),
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

/// The path from the side and from above, and the errors over time.
fn figure(name: &'static str, caption: &str, path: &str, traced: &[Traced]) -> Figure {
    let found = grid().into_iter().zip(traced).find(|((p, speed, ..), _)| p.0 == path && *speed == 0.5);
    let traces: &[Trace] = found.map_or(&[], |(_, traced)| &traced.traces);
    let of = |mode: Mode| {
        traces.iter().find(|t| t.variant == Variant::of(mode)).map_or(&[][..], |trace| &trace.frames)
    };
    let plane = |title: &str, (x, y): (usize, usize), labels: (&str, &str)| {
        let places = |mode: Mode, measured: bool| -> Vec<(f64, f64)> {
            let place = |frame: &super::trace::TraceFrame| {
                let hand = frame.hand.as_ref()?;
                let off = if measured { hand.error.as_ref()?.translation_m } else { Vector3::zeros() };
                let at = (hand.truth_m + off) * 1e3;
                Some((at[x], at[y]))
            };
            of(mode).iter().filter_map(place).collect()
        };
        let mut series = vec![Series::new("true", Look::Line, GREY, places(Mode::Refined, false))];
        for mode in MODES {
            series.push(Series::new(mode.name(), Look::Points, colour(mode), places(mode, true)));
        }
        Panel {
            title: title.to_owned(),
            x: Axis::linear(labels.0),
            y: Axis::linear(labels.1),
            equal: true,
            series,
        }
    };
    let error = |title: &str, label: &str, value: fn(&super::trace::PoseError) -> f64| Panel {
        title: title.to_owned(),
        x: Axis::linear("time, s"),
        y: Axis::log(label),
        equal: false,
        series: MODES
            .iter()
            .map(|&mode| {
                let frames = of(mode).iter();
                let points = frames.filter_map(|f| Some((f.t_s, value(f.hand.as_ref()?.error.as_ref()?))));
                Series::new(mode.name(), Look::Line, colour(mode), points.collect())
            })
            .collect(),
    };
    Figure {
        name,
        caption: format!("{caption}, even light. Axes are those of the feature frame at the start"),
        panels: vec![
            plane("E1 and E2", (0, 1), ("E1, mm", "E2, mm")),
            plane("E1 and E3", (0, 2), ("E1, mm", "E3, mm")),
            error("Distance from the true place", "mm", |e| e.translation_m.norm() * 1e3),
            error("Angle from the true orientation", "degrees", |e| e.rotation_rad.norm().to_degrees()),
        ],
    }
}

fn headlines(rows: &[Row]) -> Vec<Headline> {
    let of = |mode: Mode, own: &dyn Fn(&Row) -> bool, bounds: PoseBounds| {
        let fast = rows.iter().filter(|row| row.speed == 0.5 && row.mode == mode && own(row));
        Poses::worst(fast.map(|row| &row.poses), &bounds)
    };
    let mut lines = Vec::new();
    let promised = PoseBounds {
        edge_mm: Bound::Most(1.5),
        mean_mm: Bound::Most(0.6),
        turn_deg: Bound::Most(0.3),
        ..PoseBounds::FREE
    };
    for (path, name) in PATHS {
        let own = |row: &Row| row.path.0 == path && row.view == VIEWS[0].0;
        lines.push(Headline {
            what: format!("3D, {name}, 0.5 m/s, worst light"),
            published: "box 6 x 6 x 6 mm",
            promised: "box 1.5 x 1.5 x 1.5 mm; mean 0.6 mm; turn at most 0.3\u{b0}",
            refined: of(Mode::Refined, &own, promised),
            paper: of(Mode::Paper, &own, PoseBounds::FREE),
        });
    }
    let wrong = |row: &Row| row.view.contains("focal");
    lines.push(Headline {
        what: "3D, both focal lengths told wrong by 10 %, worst path and light".to_owned(),
        published: NOTHING,
        promised: "box 2.5 mm",
        refined: of(Mode::Refined, &wrong, PoseBounds { edge_mm: Bound::Most(2.5), ..PoseBounds::FREE }),
        paper: Told::words("is told none"),
    });
    let one = |row: &Row| row.view == VIEWS[3].0;
    lines.push(Headline {
        what: "3D, one camera only, worst path and light".to_owned(),
        published: NOTHING,
        promised: "under 6 mm",
        refined: of(Mode::Refined, &one, PoseBounds { max_mm: Bound::Under(6.0), ..PoseBounds::FREE }),
        paper: Told::words("gives no pose"),
    });
    lines
}
