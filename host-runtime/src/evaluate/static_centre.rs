//! The error of a resting ball's centre against its diameter, the light and the pixel format.

use super::run::{MODES, Variant};
use super::scenes::{GREY, colour, lights, named};
use super::trace::{Case, Trace};
use super::{Headline, Outcome, Plan, Traced};
use crate::output::Spread;
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use tetrad_core::observation::ObservationState;
use tetrad_core::vision::frame::PixelFormat;

/// The paper's range, section 5, pixels.
const SIZES_PX: [u32; 8] = [5, 8, 12, 16, 24, 32, 48, 65];

/// Mean and upper bound of section 5, pixels.
const PUBLISHED_PX: (f64, f64) = (0.1, 0.2);

const FORMATS: [(&str, PixelFormat); 2] = [("RGB", PixelFormat::Rgb888), ("YUYV", PixelFormat::Yuyv)];

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let variants: Vec<Variant> = FORMATS
        .iter()
        .flat_map(|&(_, format)| MODES.map(|mode| Variant { format, ..Variant::of(mode) }))
        .collect();
    let mut cases = Vec::new();
    for (name, light) in lights() {
        for size in SIZES_PX {
            let mut scene = named(&format!("static-{size}px"));
            scene.light = light.clone();
            scene.frames = plan.pick(60, 15);
            cases.push(Case::new(format!("static {size} px, {name}"), scene, plan.seed, &variants));
        }
    }
    cases
}

/// One row of the table.
struct Row {
    light: &'static str,
    size: u32,
    format: &'static str,
    mode: Mode,
    errors: Vec<f64>,
    /// Balls in sight.
    in_sight: usize,
}

pub(super) fn outcome(plan: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    let places = lights().map(|(light, _)| SIZES_PX.map(|size| (light, size)));
    for ((light, size), Traced { traces, .. }) in places.into_iter().flatten().zip(traced) {
        for trace in traces {
            let format = FORMATS.iter().find(|(_, format)| *format == trace.variant.format);
            let (errors, in_sight) = errors_px(trace);
            let format = format.map_or("", |(name, _)| name);
            rows.push(Row { light, size, format, mode: trace.variant.mode, errors, in_sight });
        }
    }
    let figure = Figure {
        name: "static-error",
        caption:
            "Mean error of the centre against the ball's diameter, both axes logarithmic; dashed: YUYV; \
                  grey: the mean the paper reports"
                .to_owned(),
        panels: lights().map(|(light, _)| panel(light, &rows)).to_vec(),
    };
    let section = Section {
        id: "static",
        title: "Static error of the centre".to_owned(),
        text: format!(
            "Four balls at a time rest before both cameras, moved by a fraction of a pixel from frame to frame \
             ({} frames a cell), against a plain background. The error is the distance of the reported centre \
             from that of the true outline, for every ball reported visible. Side light: a lamp from the side, \
             and the shadow side has 70 % or 45 % of full light. YUYV is what most cameras send: two pixels \
             share one colour.",
            plan.pick(60, 15)
        ),
        tables: vec![table(&rows)],
        figures: vec![figure],
    };
    Outcome { section, headlines: headlines(&rows) }
}

/// Errors of the balls that are wholly in sight and reported so, and how many are in sight.
fn errors_px(trace: &Trace) -> (Vec<f64>, usize) {
    let balls = || {
        let balls = trace.frames.iter().flat_map(|frame| frame.cameras.iter().flatten());
        balls.filter(|ball| ball.truth.visible_fraction > 0.999)
    };
    let seen = balls().filter(|ball| ball.seen.state == ObservationState::Visible);
    (seen.map(|ball| ball.error_px()).collect(), balls().count())
}

fn table(rows: &[Row]) -> Table {
    Table {
        name: "static",
        caption: "Error of a resting ball's centre, pixels".to_owned(),
        columns: vec![
            "light",
            "diameter_px",
            "format",
            "mode",
            "balls",
            "measured_share",
            "mean_px",
            "p99_px",
            "max_px",
        ],
        rows: rows
            .iter()
            .map(|row| {
                let spread = Spread::of(row.errors.iter().copied());
                let figure =
                    |value: fn(&Spread) -> f64| Cell::Number(spread.as_ref().map_or(f64::NAN, value), 4);
                vec![
                    row.light.into(),
                    Cell::count(row.size as usize),
                    row.format.into(),
                    row.mode.name().into(),
                    Cell::count(row.in_sight),
                    Cell::Number(row.errors.len() as f64 / row.in_sight as f64, 3),
                    figure(|s| s.mean),
                    figure(|s| s.p99),
                    figure(|s| s.max),
                ]
            })
            .collect(),
    }
}

fn panel(light: &'static str, rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    for (format, _) in FORMATS {
        for mode in MODES {
            let own =
                rows.iter().filter(|row| row.light == light && row.format == format && row.mode == mode);
            let points = own
                .filter_map(|row| Some((f64::from(row.size), Spread::of(row.errors.iter().copied())?.mean)))
                .collect();
            let look = if format == "RGB" { Look::Dotted } else { Look::Dashed };
            series.push(Series::new(&format!("{} {format}", mode.name()), look, colour(mode), points));
        }
    }
    let published = vec![(5.0, PUBLISHED_PX.0), (65.0, PUBLISHED_PX.0)];
    series.push(Series::new("published", Look::Line, GREY, published));
    Panel {
        title: format!("Light: {light}"),
        x: Axis::log("diameter, px"),
        y: Axis::log("mean error, px"),
        equal: false,
        series,
    }
}

fn headlines(rows: &[Row]) -> Vec<Headline> {
    let line = |what: String, light: &str, format: &str, sizes: fn(u32) -> bool, published| {
        let of = |mode: Mode| {
            let own = rows.iter().filter(|row| {
                row.light == light && row.format == format && row.mode == mode && sizes(row.size)
            });
            // a mean of every size by itself: the worst stands for them
            let spreads: Vec<Spread> = own.filter_map(|row| Spread::of(row.errors.iter().copied())).collect();
            let worst = |value: fn(&Spread) -> f64| spreads.iter().map(value).fold(0.0, f64::max);
            format!("{:.3} px, max {:.2} px", worst(|s| s.mean), worst(|s| s.max))
        };
        Headline { what, published, refined: of(Mode::Refined), paper: of(Mode::Paper) }
    };
    vec![
        line(
            "Static centre, 8 to 65 px, even light (mean of the worst size)".into(),
            "even",
            "RGB",
            |d| d >= 8,
            "0.1 px, at most 0.2 px",
        ),
        line("the same in side light, shadow side 45 %".into(), "side 45 %", "RGB", |d| d >= 8, "\u{2013}"),
        line("the same in side light 45 %, YUYV".into(), "side 45 %", "YUYV", |d| d >= 8, "\u{2013}"),
        line("Static centre, 5 px, even light".into(), "even", "RGB", |d| d == 5, "0.1 px, at most 0.2 px"),
    ]
}
