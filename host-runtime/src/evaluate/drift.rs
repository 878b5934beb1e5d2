//! Ten minutes of moving in all six degrees of freedom, and returning to the start.

use super::run::{MODES, Variant};
use super::scenes::{colour, named};
use super::trace::{Case, Trace, TraceFrame};
use super::{Headline, Outcome, Plan, Traced};
use crate::output::Spread;
use crate::report::{Axis, Cell, Figure, Look, Panel, Section, Series, Table};
use crate::settings::Mode;
use tetrad_fixtures::{Background, Light};

/// The movement of the demo is back where it began after this, and stands still for a second before
/// and after.
const PERIOD_S: f64 = 120.0;

/// Around a return, frames within this count as returned.
const RETURNED_S: f64 = 0.9;

fn lights() -> [(&'static str, Light); 2] {
    [("even", Light::even()), ("side 45 %", Light::side(0.45))]
}

fn periods(plan: Plan) -> usize {
    plan.pick(5, 1)
}

pub(super) fn cases(plan: Plan) -> Vec<Case> {
    let case = |(name, light): (&str, Light)| {
        let mut scene = named("demo");
        scene.light = light;
        scene.background = Background::Gradient(186.0, 138.0);
        scene.frames = ((periods(plan) as f64 * PERIOD_S + RETURNED_S) * scene.fps) as usize;
        Case::new(format!("drift, {name}"), scene, plan.seed, &MODES.map(Variant::of))
    };
    lights().map(case).to_vec()
}

pub(super) fn outcome(plan: Plan, traced: &[Traced]) -> Outcome {
    let minutes = periods(plan) as f64 * PERIOD_S / 60.0;
    let lights = lights().map(|(name, _)| name);
    let panel = |(light, traced): (&str, &Traced)| Panel {
        title: format!("Light: {light}"),
        x: Axis::from_zero("time, minutes"),
        y: Axis::log("distance from the true place, mm"),
        equal: false,
        series: traced.traces.iter().map(curve).collect(),
    };
    let section = Section {
        id: "drift",
        title: format!("Drift over {minutes:.0} minutes"),
        text: format!(
            "The movement of the demo, all six degrees of freedom with a reach of up to 22 cm, at 30 frames a second \
             for {minutes:.0} minutes; every frame was rendered and tracked. Every two minutes the hand is back \
             where it started and stands still: the error there, told from the first frame on, is what has \
             drifted. The figure shows the largest error of each two seconds."
        ),
        tables: vec![table(plan, &lights, traced)],
        figures: vec![Figure {
            name: "drift",
            caption: "Distance of the pose from the true one; paper mode adds up its increments".to_owned(),
            panels: lights.into_iter().zip(traced).map(panel).collect(),
        }],
    };
    let back = |mode: Mode| {
        let traces = traced.iter().flat_map(|t| &t.traces).filter(|trace| trace.variant.mode == mode);
        let worst = traces.map(|trace| returned(trace, periods(plan)).0).fold(0.0, f64::max);
        format!("{worst:.2} mm")
    };
    let headlines = vec![Headline {
        what: format!("Back at the start after {minutes:.0} minutes, worst light"),
        published: "\u{2013}",
        promised: "under 0.3 mm",
        refined: back(Mode::Refined),
        paper: back(Mode::Paper),
    }];
    Outcome { section, headlines }
}

fn errors(frame: &TraceFrame) -> Option<(f64, f64)> {
    let error = frame.hand.as_ref()?.error.as_ref()?;
    Some((error.translation_m.norm() * 1e3, error.rotation_rad.norm().to_degrees()))
}

/// Mean error in millimetres and degrees while the hand stands at the start after so many periods.
fn returned(trace: &Trace, periods: usize) -> (f64, f64) {
    let back_s = periods as f64 * PERIOD_S;
    let there = || trace.frames.iter().filter(|f| (f.t_s - back_s).abs() <= RETURNED_S).filter_map(errors);
    let mean = |value: fn((f64, f64)) -> f64| Spread::of(there().map(value)).map_or(f64::NAN, |s| s.mean);
    (mean(|e| e.0), mean(|e| e.1))
}

fn curve(trace: &Trace) -> Series {
    const EVERY_S: f64 = 2.0;
    let mut points: Vec<(f64, f64)> = Vec::new();
    for frame in &trace.frames {
        let at = (frame.t_s / EVERY_S).floor() * EVERY_S / 60.0;
        let error = errors(frame).map_or(f64::NAN, |e| e.0);
        match points.last_mut() {
            Some(last) if last.0 == at => last.1 = last.1.max(error),
            _ => points.push((at, error)),
        }
    }
    let mode = trace.variant.mode;
    Series::new(mode.name(), Look::Line, colour(mode), points)
}

fn table(plan: Plan, lights: &[&'static str], traced: &[Traced]) -> Table {
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (light, Traced { traces, .. }) in lights.iter().zip(traced) {
        for trace in traces {
            for period in 1..=periods(plan) {
                let (mm, deg) = returned(trace, period);
                rows.push(vec![
                    (*light).into(),
                    trace.variant.mode.name().into(),
                    Cell::Number(period as f64 * PERIOD_S, 0),
                    Cell::Number(mm, 3),
                    Cell::Number(deg, 4),
                ]);
            }
        }
    }
    Table {
        name: "drift",
        caption: "Error of the pose while the hand stands where it started".to_owned(),
        columns: vec!["light", "mode", "after_s", "mean_mm", "mean_deg"],
        rows,
    }
}
