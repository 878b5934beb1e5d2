//! Ten minutes of moving in all six degrees of freedom, and returning to the start.

use super::headline::{Bound, Headline, NOTHING, Told, largest};
use super::run::{MODES, Variant};
use super::scenes::{colour, named};
use super::statistics::Poses;
use super::trace::{Case, Trace, TraceFrame};
use super::{Outcome, Plan, Traced};
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
        let traces = traced.iter().flat_map(|t| &t.traces).filter(move |trace| trace.variant.mode == mode);
        told(traces, periods(plan))
    };
    let headlines = vec![Headline {
        what: format!("Back at the start after {minutes:.0} minutes, worst light"),
        published: NOTHING,
        promised: "under 0.3 mm",
        refined: back(Mode::Refined),
        paper: back(Mode::Paper),
    }];
    Outcome { section, headlines }
}

/// Distance in millimetres and angle in degrees of a pose measured in this frame.
fn errors(frame: &TraceFrame) -> Option<(f64, f64)> {
    let error = frame.hand.as_ref()?.measured()?;
    Some((error.translation_m.norm() * 1e3, error.rotation_rad.norm().to_degrees()))
}

/// Errors while the hand stands at the start after so many periods; not a number without a pose.
struct Returned {
    share: f64,
    mean_mm: f64,
    max_mm: f64,
    mean_deg: f64,
}

impl Returned {
    fn of(trace: &Trace, periods: usize) -> Self {
        let back_s = periods as f64 * PERIOD_S;
        let there = || trace.frames.iter().filter(|f| (f.t_s - back_s).abs() <= RETURNED_S);
        let measured: Vec<(f64, f64)> = there().filter_map(errors).collect();
        let count = measured.len() as f64;
        Self {
            share: count / there().count() as f64,
            mean_mm: measured.iter().map(|e| e.0).sum::<f64>() / count,
            max_mm: largest(measured.iter().map(|e| e.0)),
            mean_deg: measured.iter().map(|e| e.1).sum::<f64>() / count,
        }
    }
}

/// The worst of several runs after so many periods; the share is the lowest of the whole runs and of
/// the returns.
fn told<'a>(traces: impl Iterator<Item = &'a Trace>, periods: usize) -> Told {
    const PROMISED_MM: Bound = Bound::Under(0.3);
    let runs: Vec<(Returned, Poses)> =
        traces.map(|trace| (Returned::of(trace, periods), Poses::of(trace))).collect();
    let worst = |value: fn(&Returned) -> f64| largest(runs.iter().map(|(returned, _)| value(returned)));
    Told::default()
        .figure(("", ""), worst(|returned| returned.mean_mm), 2, PROMISED_MM)
        .figure((", at most ", " mm"), worst(|returned| returned.max_mm), 2, PROMISED_MM)
        .share(-worst(|returned| -returned.share))
        .share(-largest(runs.iter().map(|(_, poses)| -poses.share())))
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
                let returned = Returned::of(trace, period);
                rows.push(vec![
                    (*light).into(),
                    trace.variant.mode.name().into(),
                    Cell::Number(period as f64 * PERIOD_S, 0),
                    Cell::Number(returned.share, 3),
                    Cell::Number(returned.mean_mm, 3),
                    Cell::Number(returned.max_mm, 3),
                    Cell::Number(returned.mean_deg, 4),
                ]);
            }
        }
    }
    Table {
        name: "drift",
        caption: "Error of the pose while the hand stands where it started".to_owned(),
        columns: vec!["light", "mode", "after_s", "measured_share", "mean_mm", "max_mm", "mean_deg"],
        rows,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::statistics::tests::{pose_mm, trace};
    use tetrad_core::hand::state::PoseState;

    /// A frame with a pose at each of these errors and states, the last of them at the return.
    fn run(last: Option<(PoseState, f64)>) -> Trace {
        let mut run = trace(vec![pose_mm(Some((PoseState::Both, 0.1))), pose_mm(last)]);
        run.frames[1].t_s = PERIOD_S;
        run
    }

    fn line(runs: &[Trace]) -> Vec<String> {
        let headline = Headline {
            what: String::new(),
            published: NOTHING,
            promised: "under 0.3 mm",
            refined: told(runs.iter(), 1),
            paper: Told::words(""),
        };
        super::super::headline::table(&[headline]).rows[0].iter().map(Cell::text).collect()
    }

    #[test]
    fn a_hand_that_is_lost_or_held_at_the_return_has_no_figure_and_breaks_the_promise() {
        let good = run(Some((PoseState::Both, 0.2)));
        let cells = line(std::slice::from_ref(&good));
        assert_eq!((cells[2].as_str(), cells[4].as_str()), ("0.20, at most 0.20 mm", "held"));
        for lost in [None, Some((PoseState::Held, 0.1)), Some((PoseState::Both, f64::NAN))] {
            let cells = line(&[run(lost), good.clone()]);
            assert!(cells[2].starts_with("not measured"), "{cells:?}");
            assert_eq!(cells[4], "NOT held");
        }
        assert_eq!(line(&[good, run(Some((PoseState::One, 0.4)))])[4], "NOT held");
        assert_eq!(line(&[])[4], "NOT held");
    }
}
