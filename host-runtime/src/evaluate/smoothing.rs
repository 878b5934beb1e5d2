//! What the smoothing filter takes out and how late it makes the pose.

use super::trace::Case;
use super::{Outcome, Plan, Traced};
use crate::filter_quality::{FilterQuality, SimulatedHand, measure};
use crate::report::ink::{BLUE, GREEN, GREY};
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use tetrad_core::config::{FilterConfig, Prediction, Smoothing};

const LEADS_MS: [u32; 4] = [0, 33, 50, 100];
const COLOURS: [&str; 3] = [GREY, BLUE, GREEN];

pub(super) fn cases(_: Plan) -> Vec<Case> {
    // poses are simulated, not pictures
    Vec::new()
}

struct Row {
    smoothing: &'static str,
    prediction: &'static str,
    lead_ms: u32,
    quality: FilterQuality,
}

pub(super) fn outcome(plan: Plan, _: &[Traced]) -> Outcome {
    let hand = SimulatedHand { seed: plan.seed, ..SimulatedHand::default() };
    let smoothed = FilterConfig::default().smoothing;
    let settings = [
        ("off", Smoothing::Off, "velocity", Prediction::Velocity),
        ("one-euro", smoothed, "velocity", Prediction::Velocity),
        ("one-euro", smoothed, "acceleration", Prediction::Acceleration),
    ];
    let mut rows = Vec::new();
    for (name, smoothing, prediction_name, prediction) in settings {
        for lead_ms in LEADS_MS {
            let config =
                FilterConfig { smoothing, prediction, lead_us: lead_ms * 1000, ..FilterConfig::default() };
            // settings that cannot be worked with have no row
            if let Ok(quality) = measure(&config, &hand) {
                rows.push(Row { smoothing: name, prediction: prediction_name, lead_ms, quality });
            }
        }
    }
    let section = Section {
        id: "smoothing",
        title: "Lag and noise of the smoothing filter".to_owned(),
        text: "The hand rests and then goes round a circle of 0.1 m at 0.5 m/s turning at 1 rad/s, measured 30 times a \
               second with 0.5 mm and 5 mrad of normally distributed noise on each axis. Rest: the share of the \
               noise that is left. Lag: the delay against the pose at the time asked for, that is `lead` later \
               than the measurement; negative is ahead."
            .to_owned(),
        tables: vec![table(&rows)],
        figures: vec![figure(&rows)],
    };
    Outcome { section, headlines: Vec::new() }
}

fn rest(row: &Row) -> f64 {
    row.quality.rest_out.place_m / row.quality.rest_in.place_m
}

fn table(rows: &[Row]) -> Table {
    let row = |row: &Row| {
        let FilterQuality { rest_in, rest_out, moving } = row.quality;
        vec![
            row.smoothing.into(),
            row.prediction.into(),
            Cell::count(row.lead_ms as usize),
            Cell::number(rest(row)),
            Cell::number(rest_out.turn_rad / rest_in.turn_rad),
            Cell::Number(moving.lag_s * 1e3, 1),
            Cell::Number(moving.turn_lag_s * 1e3, 1),
            Cell::number(moving.error_m * 1e3),
            Cell::number(moving.error_rad.to_degrees()),
        ]
    };
    Table {
        name: "smoothing",
        caption: "What is left of the noise at rest, and lag and error in motion".to_owned(),
        columns: vec![
            "smoothing",
            "prediction",
            "lead_ms",
            "rest_place",
            "rest_turn",
            "lag_ms",
            "turn_lag_ms",
            "error_rms_mm",
            "error_rms_deg",
        ],
        rows: rows.iter().map(row).collect(),
    }
}

fn figure(rows: &[Row]) -> Figure {
    let panel = |title: &str, label: &str, value: fn(&Row) -> f64| {
        let kinds = [("off", "velocity"), ("one-euro", "velocity"), ("one-euro", "acceleration")];
        let curve = |((smoothing, prediction), colour): ((&str, &str), &'static str)| {
            let own = rows.iter().filter(|row| row.smoothing == smoothing && row.prediction == prediction);
            let points = own.map(|row| (f64::from(row.lead_ms), value(row))).collect();
            Series::new(&format!("{smoothing}, {prediction}"), Look::Dotted, colour, points)
        };
        Panel {
            title: title.to_owned(),
            x: Axis::from_zero("lead, ms"),
            y: Axis::from_zero(label),
            equal: false,
            series: kinds.into_iter().zip(COLOURS).map(curve).collect(),
        }
    };
    Figure {
        name: "smoothing",
        caption: "Noise left at rest and lag in motion against the lead that is made up for".to_owned(),
        panels: vec![
            panel("At rest", "share of the noise left", rest),
            panel("In motion", "lag, ms", |row| row.quality.moving.lag_s * 1e3),
        ],
    }
}
