//! The error of a resting ball's centre against its diameter, the light and the pixel format.

use super::headline::{Bound, Headline, NOTHING};
use super::run::{MODES, Variant};
use super::scenes::{colour, lights, named};
use super::statistics::Centres;
use super::trace::Case;
use super::{Outcome, Plan, Traced};
use crate::report::ink::GREY;
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
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
    centres: Centres,
}

pub(super) fn outcome(plan: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    let places = lights().map(|(light, _)| SIZES_PX.map(|size| (light, size)));
    for ((light, size), Traced { traces, .. }) in places.into_iter().flatten().zip(traced) {
        for trace in traces {
            let format = FORMATS.iter().find(|(_, format)| *format == trace.variant.format);
            let format = format.map_or("", |(name, _)| name);
            let centres = Centres::of(trace, |_| true);
            rows.push(Row { light, size, format, mode: trace.variant.mode, centres });
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
             from that of the true outline, for every ball reported seen, whole or in part. Side light: a lamp from the side, \
             and the shadow side has 70 % or 45 % of full light. YUYV is what most cameras send: two pixels \
             share one colour.",
            plan.pick(60, 15)
        ),
        tables: vec![table(&rows)],
        figures: vec![figure],
    };
    Outcome { section, headlines: headlines(&rows) }
}

fn table(rows: &[Row]) -> Table {
    let mut columns = vec!["light", "diameter_px", "format", "mode"];
    columns.extend(Centres::COLUMNS);
    let row = |row: &Row| {
        let mut cells: Vec<Cell> =
            vec![row.light.into(), Cell::count(row.size as usize), row.format.into(), row.mode.name().into()];
        cells.extend(row.centres.cells());
        cells
    };
    Table {
        name: "static",
        caption: "Error of a resting ball's centre, pixels".to_owned(),
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

fn panel(light: &'static str, rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    for (format, _) in FORMATS {
        for mode in MODES {
            let own =
                rows.iter().filter(|row| row.light == light && row.format == format && row.mode == mode);
            let points = own.map(|row| (f64::from(row.size), row.centres.mean())).collect();
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
    type Is<T> = fn(T) -> bool;
    /// What is published, what is promised, and its mean and maximum in pixels.
    type Promise = (&'static str, &'static str, (f64, f64));
    let line = |what: &str,
                format: &str,
                lights: Is<&str>,
                sizes: Is<u32>,
                (published, promised, bounds): Promise| {
        let of = |mode: Mode| {
            let own = rows.iter().filter(|row| {
                row.format == format && row.mode == mode && sizes(row.size) && lights(row.light)
            });
            // every size and light by itself, and the worst stands for them
            Centres::worst(own.map(|row| &row.centres), (Bound::Most(bounds.0), Bound::Most(bounds.1)))
        };
        Headline {
            what: what.to_owned(),
            published,
            promised,
            refined: of(Mode::Refined),
            paper: of(Mode::Paper),
        }
    };
    const PUBLISHED: &str = "0.1 px, at most 0.2";
    const PROMISED: &str = "0.04 px, at most 0.12";
    const BOUNDS: (f64, f64) = (0.04, 0.12);
    let (even, side, any): (Is<&str>, Is<&str>, Is<&str>) = (|l| l == "even", |l| l != "even", |_| true);
    let (large, small): (Is<u32>, Is<u32>) = (|d| d >= 8, |d| d < 8);
    vec![
        line(
            "Resting centre, 8 to 65 px, even light; mean of the worst size",
            "RGB",
            even,
            large,
            (PUBLISHED, PROMISED, BOUNDS),
        ),
        line(
            "Resting centre, 8 to 65 px, lit from the side",
            "RGB",
            side,
            large,
            (NOTHING, PROMISED, BOUNDS),
        ),
        line(
            "Resting centre, 8 to 65 px, YUYV, worst light",
            "YUYV",
            any,
            large,
            (NOTHING, "0.06 px, at most 0.18", (0.06, 0.18)),
        ),
        line(
            "Resting centre, 5 px, worst light",
            "RGB",
            any,
            small,
            (PUBLISHED, "0.08 px, at most 0.25", (0.08, 0.25)),
        ),
    ]
}
