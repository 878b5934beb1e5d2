//! What the backdrop does: centres and poses before dark and cluttered ones. Measured, and nothing is
//! promised: every other section has a light and smooth backdrop.

use super::headline::{Bound, Headline, NOTHING, largest};
use super::run::{MODES, Variant};
use super::scenes::named;
use super::statistics::{Centres, PoseBounds, Poses};
use super::trace::Case;
use super::uncertainty::over_sigma;
use super::{Outcome, Plan, Traced};
use crate::report::{Cell, Section, Table};
use crate::settings::Mode;
use tetrad_core::vision::frame::PixelFormat;
use tetrad_fixtures::{Background, Light};

/// Grey levels of a dark backdrop.
const DARK: [f64; 2] = [20.0, 40.0];
const SIZES_PX: [u32; 4] = [5, 8, 16, 32];
/// Cluttered desks, by the seed of their clutter.
const DESKS: [u64; 4] = [11, 31, 32, 33];
const PATHS: [&str; 2] = ["linear", "circular"];

fn lights() -> [(&'static str, Light); 2] {
    [("even", Light::even()), ("side 45 %", Light::side(0.45))]
}

/// What stands behind what.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Backdrop {
    /// Resting balls of so many pixels before so many grey levels.
    Dark(u32, f64),
    /// A hand at 0.5 m/s on a path over a desk.
    Desk(&'static str, u64),
}

fn grid(plan: Plan) -> Vec<(Backdrop, &'static str, Light)> {
    let dark = DARK.into_iter().flat_map(|grey| SIZES_PX.map(|size| Backdrop::Dark(size, grey)));
    let desks = DESKS.into_iter().take(plan.pick(DESKS.len(), 1));
    let desks = desks.flat_map(|desk| PATHS.map(|path| Backdrop::Desk(path, desk)));
    let all = dark.chain(desks).collect::<Vec<_>>();
    lights()
        .into_iter()
        .flat_map(|(name, light)| {
            all.clone().into_iter().map(move |backdrop| (backdrop, name, light.clone()))
        })
        .collect()
}

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let rgb = MODES.map(Variant::of);
    let yuyv = rgb.map(|variant| Variant { format: PixelFormat::Yuyv, ..variant });
    let case = |(backdrop, name, light)| {
        let (mut scene, variants) = match backdrop {
            Backdrop::Dark(size, grey) => {
                let mut scene = named(&format!("static-{size}px"));
                scene.background = Background::Plain(grey);
                scene.frames = plan.pick(30, 8);
                (scene, [rgb, yuyv].concat())
            }
            Backdrop::Desk(path, seed) => {
                let mut scene = named(&format!("{path}-0.5-30fps"));
                scene.background = Background::Clutter { seed };
                scene.frames = plan.pick(150, 45);
                (scene, rgb.to_vec())
            }
        };
        scene.light = light;
        Case::new(format!("backdrop {backdrop:?}, {name}"), scene, plan.seed, &variants)
    };
    grid(plan).into_iter().map(case).collect()
}

struct Row {
    backdrop: Backdrop,
    light: &'static str,
    variant: Variant,
    centres: Centres,
    poses: Poses,
    over_sigma: [f64; 2],
}

pub(super) fn outcome(plan: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    for ((backdrop, light, _), Traced { traces, .. }) in grid(plan).into_iter().zip(traced) {
        for trace in traces {
            rows.push(Row {
                backdrop,
                light,
                variant: trace.variant,
                centres: Centres::of(trace, |_| true),
                poses: Poses::of(trace),
                over_sigma: over_sigma(trace),
            });
        }
    }
    let section = Section {
        id: "backdrops",
        title: "Dark and cluttered backdrops".to_owned(),
        text: "What the promises above are not made for. Resting balls before a plain backdrop of 20 and of 40 grey \
               levels (168 in the other sections), and the hand on its line and its circle at 0.5 m/s over \
               cluttered desks, whose things lie behind the rims and have the balls' colours in part. Before \
               a dark backdrop a rim has less contrast, and in YUYV, where two pixels share one colour, the \
               luma alone tells a dark ball from it. over_sigma: errors over reported deviations, root mean \
               square, of centres in full sight and of poses from both cameras; 1 is honest, below 1 too modest."
            .to_owned(),
        tables: vec![table(&rows)],
        figures: Vec::new(),
    };
    Outcome { section, headlines: headlines(&rows) }
}

fn table(rows: &[Row]) -> Table {
    let mut columns = vec!["backdrop", "scene", "light", "format", "mode"];
    columns.extend(Centres::COLUMNS);
    columns.extend(["centre_over_sigma", "box_x_mm", "box_y_mm", "box_z_mm", "pose_mean_mm", "turn_max_deg"]);
    columns.push("pose_over_sigma");
    let row = |row: &Row| {
        let (backdrop, scene) = match row.backdrop {
            Backdrop::Dark(size, grey) => (format!("grey {grey}"), format!("resting, {size} px")),
            Backdrop::Desk(path, seed) => (format!("desk {seed}"), format!("{path}, 0.5 m/s")),
        };
        let format = if row.variant.format == PixelFormat::Yuyv { "YUYV" } else { "RGB" };
        let mut cells: Vec<Cell> = vec![
            backdrop.as_str().into(),
            scene.as_str().into(),
            row.light.into(),
            format.into(),
            row.variant.mode.name().into(),
        ];
        cells.extend(row.centres.cells());
        let [centre, pose] = row.over_sigma.map(|ratio| Cell::Number(ratio, 2));
        cells.push(centre);
        let figures = row.poses.box_mm.iter().copied().chain([row.poses.mean_mm, row.poses.turn_max_deg]);
        cells.extend(figures.map(|value| Cell::Number(value, 3)));
        cells.push(pose);
        cells
    };
    Table {
        name: "backdrops",
        caption: "Errors before dark and cluttered backdrops; nothing is promised".to_owned(),
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

fn headlines(rows: &[Row]) -> Vec<Headline> {
    type Is = fn(&Row) -> bool;
    let of = |mode: Mode, is: Is| rows.iter().filter(move |row| row.variant.mode == mode && is(row));
    let line = |what: &str, is: Is| {
        let told = |mode| {
            let own = of(mode, is).map(|row| &row.centres);
            Centres::worst(own, (Bound::Free, Bound::Free))
        };
        let (refined, paper) = (told(Mode::Refined), told(Mode::Paper));
        Headline { what: what.to_owned(), published: NOTHING, promised: NOTHING, refined, paper }
    };
    let desk: Is = |row| matches!(row.backdrop, Backdrop::Desk(..));
    let pose = |mode| {
        let told = Poses::worst(of(mode, desk).map(|row| &row.poses), &PoseBounds::FREE);
        let ratio = largest(of(mode, desk).map(|row| row.over_sigma[1]));
        // paper mode says nothing of its pose
        if ratio.is_finite() { told.note(&format!("; error over sigma up to {ratio:.2}")) } else { told }
    };
    vec![
        line("Resting centre before a dark backdrop (grey 20, 40), 8 to 32 px, worst light", |row| {
            matches!(row.backdrop, Backdrop::Dark(8.., _)) && row.variant.format == PixelFormat::Rgb888
        }),
        line("The same in YUYV", |row| {
            matches!(row.backdrop, Backdrop::Dark(8.., _)) && row.variant.format == PixelFormat::Yuyv
        }),
        line("Resting centre before a dark backdrop, 5 px, worst light and format", |row| {
            matches!(row.backdrop, Backdrop::Dark(..8, _))
        }),
        line("Moving centre at 0.5 m/s, 4 ms, over cluttered desks, worst path and light", desk),
        Headline {
            what: "Line and circle at 0.5 m/s over cluttered desks, two cameras".to_owned(),
            published: NOTHING,
            promised: NOTHING,
            refined: pose(Mode::Refined),
            paper: pose(Mode::Paper),
        },
    ]
}
