//! Figures 1, 2 and 5: the horizontal scan through a red ball.

use super::run::RunError;
use super::scenes::named;
use super::trace::Case;
use super::{Outcome, Plan, Traced};
use crate::learning;
use crate::report::ink::{BLUE, GREEN, GREY, ORANGE, RED};
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::frame::{FrameView, PixelFormat};
use tetrad_core::vision::learn::{HorizontalScan, ScanColumn};
use tetrad_fixtures::{Background, Light, Scene};

/// The left camera.
const CAMERA: usize = 0;

/// The widest scan kept, columns.
const COLUMNS: usize = 256;

pub(super) fn cases(_: Plan) -> Vec<Case> {
    // single pictures, learnt from and not tracked
    Vec::new()
}

/// A ball of 48 px with nothing near it.
fn alone() -> Scene {
    let mut scene = named("static-48px");
    scene.arm_m = 0.2;
    scene
}

/// Before white paper.
fn on_white() -> Scene {
    let mut scene = alone();
    scene.background = Background::Plain(232.0);
    scene.light = Light::room();
    scene
}

/// Before grey, with a lamp beside the camera whose reflection is white in its middle.
fn with_a_reflection() -> Scene {
    let mut scene = alone();
    scene.light = Light { towards: scene.cameras[CAMERA].position_m, specular: 1.0, ..Light::room() };
    scene
}

pub(super) fn outcome(plan: Plan, _: &[Traced]) -> Result<Outcome, RunError> {
    let white = scan(on_white(), plan)?;
    let shining = scan(with_a_reflection(), plan)?;
    let components = Panel {
        title: format!("Row {}", white.row),
        x: Axis::linear("column"),
        y: Axis::from_zero("share of full scale"),
        equal: false,
        series: vec![
            curve("R", RED, &white, |c| c.r),
            curve("G", GREEN, &white, |c| c.g),
            curve("B", BLUE, &white, |c| c.b),
        ],
    };
    let figure = |name, caption: &str, panels| Figure { name, caption: caption.to_owned(), panels };
    let section = Section {
        id: "scans",
        title: "Colour metrics along a row".to_owned(),
        text: "A red ball of 48 px is taught by pointing at it, and the row of pixels through its centre is shown \
               with R, G, B, the luminance function V, the distance D, the matching function M = V - D, the \
               threshold of eq. 1 and the borders at which the row leaves the ball. M tells the ball from white \
               paper better than V or D alone; a reflection makes a hole in the matched row and leaves its \
               borders where they are."
            .to_owned(),
        tables: vec![table("figure-1-2", "The scan of figures 1 and 2", &white), table("figure-5", "The scan of figure 5", &shining)],
        figures: vec![
            figure("figure-1", "Figure 1: R, G and B along a row through a red ball before a white background", vec![components]),
            figure("figure-2", "Figure 2: V, D and M along the same row", vec![metrics(&white)]),
            figure("figure-5", "Figure 5: V, D and M along a row through a red ball with a reflection", vec![metrics(&shining)]),
        ],
    };
    Ok(Outcome { section, headlines: Vec::new() })
}

type Scan = HorizontalScan<COLUMNS>;

fn scan(mut scene: Scene, plan: Plan) -> Result<Scan, RunError> {
    let camera = CAMERA;
    scene.seed = plan.seed;
    let mut rgb = Vec::new();
    scene.render_rgb(0, camera, &mut rgb);
    let format = PixelFormat::Rgb888;
    let frame = FrameView::packed(&rgb, scene.width, scene.height, format)
        .map_err(|cause| RunError::Picture { scene: scene.name.clone(), format, cause })?;
    let (u, v) = scene.truth(0, camera)[Ball::Red.index()].outline_centre;
    let at = ImagePoint::new(u as f32, v as f32);
    // beside the reflection, as anybody would point
    let beside = ImagePoint::new(at.u, at.v + 12.0);
    let refused = |cause| RunError::Learn { scene: scene.name.clone(), camera, format, cause };
    let taught = learning::learn_at(&frame, &[Some(beside), None, None, None], &LearnConfig::default())
        .map_err(refused)?;
    let nothing = |error| refused(learning::Refused(vec![(Ball::Red, at, error)]));
    let learnt = taught[Ball::Red.index()].ok_or_else(|| refused(learning::Refused(Vec::new())))?;
    let alpha_256 = TrackerConfig::default().colour.alpha_256;
    Scan::through(&frame, &learnt.reference, alpha_256, at, learnt.diameter).map_err(nothing)
}

fn curve(name: &str, colour: &'static str, scan: &Scan, value: fn(&ScanColumn) -> f32) -> Series {
    let points = scan.columns.iter().map(|c| (f64::from(c.x), f64::from(value(c)))).collect();
    Series::new(name, Look::Line, colour, points)
}

fn metrics(scan: &Scan) -> Panel {
    let ends = || scan.columns.first().zip(scan.columns.last()).map(|(a, b)| [a.x, b.x]);
    let threshold = f64::from(scan.threshold);
    let level = ends().into_iter().flatten().map(|x| (f64::from(x), threshold)).collect();
    let mut series = vec![
        curve("V", GREEN, scan, |c| c.v),
        curve("D", ORANGE, scan, |c| c.d),
        curve("M", BLUE, scan, |c| c.m),
        Series::new("threshold", Look::Dashed, GREY, level),
    ];
    if let Some((first, last)) = scan.borders {
        // pixels reach half a column beyond their centres
        let at = |x: f64| [(x, 0.0), (x, 1.0), (x, f64::NAN)];
        let lines = [at(f64::from(first) - 0.5), at(f64::from(last) + 0.5)].concat();
        series.push(Series::new("borders", Look::Line, GREY, lines));
    }
    Panel {
        title: format!("Row {}", scan.row),
        x: Axis::linear("column"),
        y: Axis::from_zero("share of full scale"),
        equal: false,
        series,
    }
}

fn table(name: &'static str, caption: &str, scan: &Scan) -> Table {
    let border = |x: u16| match scan.borders {
        Some((first, _)) if i32::from(first) == i32::from(x) => "first",
        Some((_, last)) if i32::from(last) == i32::from(x) => "last",
        _ => "",
    };
    let row = |c: &ScanColumn| {
        let mut cells = vec![Cell::count(usize::from(c.x))];
        let values = [c.r, c.g, c.b, c.v, c.d, c.m, scan.threshold];
        cells.extend(values.map(|value| Cell::Number(f64::from(value), 4)));
        cells.push(border(c.x).into());
        cells
    };
    Table {
        name,
        caption: caption.to_owned(),
        columns: vec!["x", "r", "g", "b", "v", "d", "m", "threshold", "border"],
        rows: scan.columns.iter().map(row).collect(),
    }
}
