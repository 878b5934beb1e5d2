//! Errors against one condition at a time: noise, a finger over the rim, the focal length, the angle
//! between the cameras.

use super::headline::{Bound, Headline, NOTHING, largest};
use super::run::{MODES, Variant};
use super::scenes::{colour, named};
use super::sensor::Sensor;
use super::statistics::{Centres, Poses};
use super::trace::{Case, Trace};
use super::{Outcome, Plan, Traced};
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use nalgebra::Vector3;
use std::f64::consts::PI;
use tetrad_core::observation::Ball;
use tetrad_fixtures::{Anchor, Camera, Light, Occluder, Scene};

const NOISES: [f64; 6] = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0];
/// Shares of the green ball's rim behind a finger.
const HIDDEN: [f64; 6] = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
const FOCAL_SHARES: [f64; 5] = [0.8, 0.9, 1.0, 1.1, 1.25];
const ANGLES_DEG: [f64; 5] = [30.0, 45.0, 60.0, 90.0, 120.0];

/// The finger's tip in diameters of the ball.
const TIP: f64 = 0.9;
/// When it has arrived, seconds; it comes from outside in the last third of a second before.
const ARRIVAL_S: f64 = 0.6;

/// Where the finger comes from, degrees from right to down, and whether the light is from the side.
const FINGERS: [(f64, bool); 12] = {
    let mut fingers = [(0.0, false); 12];
    let mut number = 0;
    while number < fingers.len() {
        fingers[number] = ((number / 2 * 60) as f64, number % 2 == 1);
        number += 1;
    }
    fingers
};

/// Which condition, and its value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Condition {
    Noise(f64),
    Hidden { share: f64, from_deg: f64, side: bool },
    Focal,
    Angle(f64),
    Camera(&'static str, Sensor),
}

/// What takes the pictures.
const SENSORS: [(&str, Sensor); 5] = [
    ("as rendered", Sensor { soft: false, mosaic: false, tone: false }),
    ("soft lens", Sensor { soft: true, mosaic: false, tone: false }),
    ("Bayer mosaic", Sensor { soft: false, mosaic: true, tone: false }),
    ("tone curve", Sensor { soft: false, mosaic: false, tone: true }),
    ("all three", Sensor::REAL),
];

fn grid(plan: Plan) -> Vec<Condition> {
    let noises = NOISES.map(Condition::Noise).into_iter();
    let fingers = &FINGERS[..plan.pick(FINGERS.len(), 4)];
    let hidden = HIDDEN.into_iter().flat_map(|share| {
        fingers.iter().map(move |&(from_deg, side)| Condition::Hidden { share, from_deg, side })
    });
    let sensors = SENSORS.map(|(name, sensor)| Condition::Camera(name, sensor));
    noises
        .chain(hidden)
        .chain([Condition::Focal])
        .chain(ANGLES_DEG.map(Condition::Angle))
        .chain(sensors)
        .collect()
}

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let both = MODES.map(Variant::of);
    let case = |condition| {
        let (mut scene, variants) = match condition {
            Condition::Noise(noise_sigma) => {
                let mut scene = named("circular-0.25-30fps");
                scene.noise_sigma = noise_sigma;
                (scene, both.to_vec())
            }
            Condition::Hidden { share, from_deg, side } => {
                (under_a_finger(share, from_deg, side), both.to_vec())
            }
            Condition::Focal => {
                let refined =
                    FOCAL_SHARES.map(|focal_share| Variant { focal_share, ..Variant::of(Mode::Refined) });
                (named("circular-0.25-30fps"), [&[Variant::of(Mode::Paper)][..], &refined].concat())
            }
            Condition::Angle(degrees) => (seen_from(degrees), both.to_vec()),
            Condition::Camera(..) => (named("circular-0.25-30fps"), both.to_vec()),
        };
        scene.frames = match condition {
            Condition::Hidden { .. } => plan.pick(48, 27),
            _ => plan.pick(150, 60),
        };
        let sensor = match condition {
            Condition::Camera(_, sensor) => sensor,
            _ => Sensor::default(),
        };
        Case { sensor, ..Case::new(format!("{condition:?}"), scene, plan.seed, &variants) }
    };
    grid(plan).into_iter().map(case).collect()
}

/// Balls of 16 px, and a finger over a share of the green one's rim.
fn under_a_finger(share: f64, from_deg: f64, side: bool) -> Scene {
    let mut scene = named("static-16px");
    if side {
        scene.light = Light::side(0.45);
    }
    // The rim's point at the angle pi * share from the finger's direction lies on the tip's circle:
    // c^2 - c cos(pi share) + 1/4 = TIP^2 for the distance c of the two centres.
    let cosine = (PI * share).cos();
    let apart = (cosine + (cosine * cosine - 4.0 * (0.25 - TIP * TIP)).sqrt()) / 2.0;
    let reach = vec![(ARRIVAL_S - 0.33, -40.0), (ARRIVAL_S, TIP - apart)];
    scene.occluders = vec![Occluder::finger(Anchor::Ball(Ball::Green), from_deg.to_radians(), TIP, reach)];
    scene
}

/// Two cameras 1 m away, so many degrees apart, at the height of the other scenes' cameras.
fn seen_from(degrees: f64) -> Scene {
    let mut scene = named("circular-0.25-30fps");
    let height = 12.0_f64.to_radians();
    // the angle between two directions of one height is less than that between their azimuths
    let azimuth = ((degrees / 2.0).to_radians().sin() / height.cos()).asin();
    for (camera, side) in scene.cameras.iter_mut().zip([-1.0, 1.0]) {
        let azimuth = side * azimuth;
        let direction =
            Vector3::new(height.cos() * azimuth.cos(), height.cos() * azimuth.sin(), height.sin());
        *camera = Camera::looking_at(direction, Vector3::zeros(), camera.focal_px, scene.width, scene.height);
    }
    scene
}

struct Row {
    condition: Condition,
    variant: Variant,
    centres: Centres,
    poses: Poses,
}

pub(super) fn outcome(plan: Plan, traced: &[Traced]) -> Outcome {
    let mut rows = Vec::new();
    for (condition, Traced { traces, .. }) in grid(plan).into_iter().zip(traced) {
        for trace in traces {
            let centres = match condition {
                Condition::Hidden { .. } => covered(trace),
                _ => Centres::of(trace, |_| true),
            };
            rows.push(Row { condition, variant: trace.variant, centres, poses: Poses::of(trace) });
        }
    }
    let section = Section {
        id: "conditions",
        title: "Noise, fingers, focal length, camera angle, sensor".to_owned(),
        text: "One condition is changed at a time. Noise, focal length and angle: a circle of 0.1 m radius at 0.25 m/s \
               in room light; the pose's error is the mean distance from the true place. Finger: a finger \
               of 1.8 ball diameters comes over a share of the green ball's rim, 16 px wide and otherwise \
               at rest, before both cameras, from six sides in even light and lit from the side (45 %); only \
               the covered ball counts, from the finger's arrival on, and the worst side and light stand in \
               the figure and in the first table. Which side the finger comes from, and so where its edges \
               cross the rim, matters more than how much it hides: from one side alone 10 % may well look \
               worse than 40 %. The \
               focal length is the one the refined pose is told, as a share of the true one. Camera: what real \
               cameras do to a picture and the renderer does not, on the same circle: a lens that spreads a \
               point over 2 px, a Bayer mosaic with bilinear interpolation, a tone curve of 1 / 2.2."
            .to_owned(),
        tables: vec![table(&rows)],
        figures: vec![figure(&rows)],
    };
    let of = |mode: Mode, wanted: fn(Condition) -> bool| {
        rows.iter().filter(move |row| wanted(row.condition) && row.variant.mode == mode)
    };
    let forty = |mode| {
        let own = of(mode, |condition| matches!(condition, Condition::Hidden { share: 0.4, .. }));
        Centres::worst(own.map(|row| &row.centres), (Bound::Under(0.4), Bound::Free))
    };
    let real = |mode| {
        let own = of(mode, |condition| matches!(condition, Condition::Camera(_, Sensor::REAL)));
        let place = largest(own.clone().map(|row| row.poses.mean_mm));
        let share = -largest(own.clone().map(|row| -row.poses.share()));
        Centres::worst(own.map(|row| &row.centres), (Bound::Free, Bound::Free))
            .figure(("; place ", " mm"), place, 2, Bound::Free)
            .share(share)
    };
    let headlines = vec![
        Headline {
            what: "With a soft lens, a Bayer mosaic and a tone curve: circle at 0.25 m/s".to_owned(),
            published: NOTHING,
            promised: NOTHING,
            refined: real(Mode::Refined),
            paper: real(Mode::Paper),
        },
        Headline {
            what: "Centre of a ball of 16 px, 40 % of its rim behind a finger; worst side and light"
                .to_owned(),
            published: NOTHING,
            promised: "under 0.4 px",
            refined: forty(Mode::Refined),
            paper: forty(Mode::Paper),
        },
    ];
    Outcome { section, headlines }
}

/// The green ball while the finger is over it.
fn covered(trace: &Trace) -> Centres {
    let mut centres = Centres::default();
    for frame in trace.frames.iter().filter(|frame| frame.t_s > ARRIVAL_S) {
        for balls in &frame.cameras {
            let green = &balls[Ball::Green.index()];
            centres.add(green, green.seen.state.is_measured());
        }
    }
    centres
}

fn table(rows: &[Row]) -> Table {
    let mut columns = vec!["condition", "value", "mode"];
    columns.extend(Centres::COLUMNS);
    columns.extend([
        "pose_share",
        "box_x_mm",
        "box_y_mm",
        "box_z_mm",
        "pose_mean_mm",
        "pose_max_mm",
        "turn_max_deg",
    ]);
    let row = |row: &Row| {
        let (name, value) = match row.condition {
            Condition::Noise(sigma) => ("noise, grey levels".to_owned(), sigma),
            Condition::Hidden { share, from_deg, side } => {
                let light = if side { "side 45 %" } else { "even" };
                (format!("share of the rim behind a finger from {from_deg} degrees, {light}"), share)
            }
            Condition::Focal => {
                ("focal length told, share of the true one".to_owned(), row.variant.focal_share)
            }
            Condition::Angle(degrees) => ("angle between the cameras, degrees".to_owned(), degrees),
            Condition::Camera(name, _) => (name.to_owned(), f64::NAN),
        };
        let mut cells: Vec<Cell> =
            vec![name.as_str().into(), Cell::number(value), row.variant.mode.name().into()];
        cells.extend(row.centres.cells());
        let poses = &row.poses;
        cells.push(Cell::Number(poses.share(), 3));
        let millimetres = poses.box_mm.iter().copied().chain([poses.mean_mm, poses.max_mm]);
        cells.extend(millimetres.chain([poses.turn_max_deg]).map(|value| Cell::Number(value, 3)));
        cells
    };
    Table {
        name: "conditions",
        caption: "Errors against one condition at a time".to_owned(),
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

fn figure(rows: &[Row]) -> Figure {
    type Value = fn(&Row) -> f64;
    let curves = |at: fn(&Row) -> Option<f64>, value: Value| -> Vec<Series> {
        let curve = |mode: Mode| {
            let own = rows.iter().filter(|row| row.variant.mode == mode);
            let points = own.filter_map(|row| Some((at(row)?, value(row)))).collect();
            Series::new(mode.name(), Look::Dotted, colour(mode), points)
        };
        MODES.map(curve).to_vec()
    };
    let panel = |title: &str, x: &str, y: Axis, series| Panel {
        title: title.to_owned(),
        x: Axis::linear(x),
        y,
        equal: false,
        series,
    };
    let noise = |row: &Row| match row.condition {
        Condition::Noise(sigma) => Some(sigma),
        _ => None,
    };
    let hidden = MODES.map(|mode| {
        let worst = |wanted: f64| {
            let own = rows.iter().filter(|row| {
                row.variant.mode == mode
                    && matches!(row.condition, Condition::Hidden { share, .. } if share == wanted)
            });
            (wanted, largest(own.map(|row| row.centres.mean())))
        };
        Series::new(mode.name(), Look::Dotted, colour(mode), HIDDEN.map(worst).to_vec())
    });
    let focal = |row: &Row| (row.condition == Condition::Focal).then_some(row.variant.focal_share);
    let angle = |row: &Row| match row.condition {
        Condition::Angle(degrees) => Some(degrees),
        _ => None,
    };
    let (centre, pose): (Value, Value) = (|row| row.centres.mean(), |row| row.poses.mean_mm);
    let log = |label: &str| Axis::log(label);
    let mut focal_curves = curves(focal, pose);
    for series in &mut focal_curves {
        // a mode that is told no focal length is a line across
        if let [(_, value)] = series.points[..] {
            series.points = FOCAL_SHARES.map(|share| (share, value)).to_vec();
        }
    }
    Figure {
        name: "conditions",
        caption: "Mean errors against noise, cover, focal length and camera angle; paper mode is told no focal length"
            .to_owned(),
        panels: vec![
            panel("Noise", "grey levels", log("mean error of the centre, px"), curves(noise, centre)),
            panel("Noise", "grey levels", log("mean error of the place, mm"), curves(noise, pose)),
            panel("Finger, worst side and light", "share of the rim hidden", log("mean error of the centre, px"), hidden.to_vec()),
            panel("Focal length", "share of the true one", log("mean error of the place, mm"), focal_curves),
            panel("Camera angle", "degrees", log("mean error of the place, mm"), curves(angle, pose)),
        ],
    }
}
