//! Figure 9: where the time of a frame goes, as far as the stages exist.

use super::run::Variant;
use super::scenes::named;
use super::trace::{Case, TraceFrame};
use super::{Outcome, Plan, Traced};
use crate::output::Spread;
use crate::report::ink::{BLUE, GREEN, GREY, ORANGE};
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use std::time::Duration;

/// The table's name: the only one that is not the same in every run.
pub(super) const TABLE: &str = "delays";

type Stage = (&'static str, &'static str, fn(&TraceFrame) -> Duration);

const STAGES: [Stage; 4] = [
    ("rendering both pictures", GREY, |frame| frame.times.rendering),
    ("left tracker", BLUE, |frame| frame.times.tracking.first().copied().unwrap_or_default()),
    ("right tracker", GREEN, |frame| frame.times.tracking.get(1).copied().unwrap_or_default()),
    ("pose of the hand", ORANGE, |frame| frame.times.hand),
];

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let mut scene = named("demo");
    scene.frames = plan.pick(600, 150);
    vec![Case::new("delays".to_owned(), scene, plan.seed, &[Variant::of(Mode::Refined)])]
}

pub(super) fn outcome(_: Plan, traced: &[Traced]) -> Outcome {
    let frames: &[TraceFrame] = traced.iter().flat_map(|t| &t.traces).next().map_or(&[], |t| &t.frames);
    let microseconds =
        |&(_, _, time): &Stage| frames.iter().map(move |frame| time(frame).as_secs_f64() * 1e6);
    let rows = STAGES.iter().filter_map(|stage| {
        let spread = Spread::of(microseconds(stage))?;
        let mut cells: Vec<Cell> = vec![stage.0.into()];
        cells.extend(
            [spread.min, spread.mean, spread.p50, spread.p99, spread.max].map(|us| Cell::Number(us, 1)),
        );
        Some(cells)
    });
    let series = STAGES.iter().map(|stage| {
        let points = frames.iter().map(|frame| frame.t_s).zip(microseconds(stage)).collect();
        Series::new(stage.0, Look::Line, stage.1, points)
    });
    let section = Section {
        id: "delays",
        title: "Delays".to_owned(),
        text: "The paper's figure 9 shows the client, the network, the server and the robot. Of these only the \
               client's part exists here, and its pictures are rendered, not captured: the grey line is what \
               the simulation takes and no delay of the system. The demo's scene in refined mode, other \
               experiments running beside it on the other cores. The paper: some 0.2 s in all at about 9 Hz."
            .to_owned(),
        tables: vec![Table {
            name: TABLE,
            caption: "Microseconds a frame".to_owned(),
            columns: vec!["stage", "min_us", "mean_us", "p50_us", "p99_us", "max_us"],
            rows: rows.collect(),
        }],
        figures: vec![Figure {
            name: "figure-9",
            caption: "Figure 9: how long each stage takes over the run; times of this machine, different in every run"
                .to_owned(),
            panels: vec![Panel {
                title: "Stages of a frame".to_owned(),
                x: Axis::linear("time in the scene, s"),
                y: Axis::log("microseconds"),
                equal: false,
                series: series.collect(),
            }],
        }],
    };
    Outcome { section, headlines: Vec::new() }
}
