//! A session in one page: what is in it, and how everything went over time.

use super::convert;
use super::error::SessionError;
use super::reader::{Entry, Reader};
use super::schema::tetrad as msg;
use super::topic::Topic;
use crate::report::ink::{BLUE, GREEN, GREY, ORANGE, RED, VIOLET};
use crate::report::{Axis, Cell, Figure, Look, Panel, Report, Section, Series, Table};
use std::collections::BTreeMap;
use tetrad_core::observation::{BALLS, Ball};

const COLOURS: [&str; 6] = [RED, GREEN, BLUE, ORANGE, VIOLET, GREY];

/// How a ball's curve is drawn, and the height that tells it from the others.
const BALL_COLOURS: [&str; BALLS] = [RED, GREEN, BLUE, ORANGE];

type Points = Vec<(f64, f64)>;

/// The most points of a curve: of longer ones every second is left out, again and again.
const MOST_POINTS: usize = 4096;

/// A curve that grows, and stays short enough to be looked at.
#[derive(Clone)]
struct Curve {
    points: Points,
    /// One of so many is kept.
    every: usize,
    seen: usize,
}

impl Default for Curve {
    fn default() -> Self {
        Self { points: Points::new(), every: 1, seen: 0 }
    }
}

impl Curve {
    fn push(&mut self, point: (f64, f64)) {
        if self.seen.is_multiple_of(self.every) {
            if self.points.len() >= MOST_POINTS {
                let mut at = 0;
                self.points.retain(|_| {
                    at += 1;
                    at % 2 == 1
                });
                self.every *= 2;
            }
            self.points.push(point);
        }
        self.seen += 1;
    }

    fn points(&self) -> Points {
        self.points.clone()
    }
}

/// What a session comes to, gathered while it is read.
#[derive(Default)]
pub struct Summary {
    counts: BTreeMap<String, (&'static str, u64)>,
    first_s: Option<f64>,
    last_s: f64,
    visible: BTreeMap<usize, [Curve; BALLS]>,
    place: [Curve; 3],
    filtered: [Curve; 3],
    residual: Curve,
    set_point: [Curve; 6],
    measured: [Curve; 6],
    share: Curve,
    pressed: Curve,
    /// Whether the button was pressed last.
    is_pressed: f64,
    /// Median and 99th percentile of a stage.
    delays: BTreeMap<String, [Curve; 2]>,
}

/// The page of a session; `title` stands above it.
///
/// # Errors
/// A file that cannot be read on.
pub fn report(reader: &mut Reader, title: &str) -> Result<Report, SessionError> {
    let mut summary = Summary::default();
    while let Some(entry) = reader.next_entry()? {
        summary.take(reader, &entry)?;
    }
    Ok(summary.report(reader, title))
}

/// A point for each of three numbers.
fn push<const N: usize>(all: &mut [Curve; N], t_s: f64, values: &[f32], scale: f64) {
    for (curve, value) in all.iter_mut().zip(values) {
        curve.push((t_s, f64::from(*value) * scale));
    }
}

impl Summary {
    /// Takes the next message.
    ///
    /// # Errors
    /// One that cannot be understood.
    pub fn take(&mut self, reader: &Reader, entry: &Entry) -> Result<(), SessionError> {
        let name = entry.topic.name(reader.names());
        let counted = self.counts.entry(name).or_insert((entry.topic.schema(), 0));
        counted.1 += 1;
        let clock_s = entry.time_us as f64 * 1e-6;
        let t_s = clock_s - *self.first_s.get_or_insert(clock_s);
        self.last_s = self.last_s.max(clock_s);
        match entry.topic {
            Topic::Observations(camera) => {
                let seen: msg::Observations = reader.decode(entry)?;
                let all = self.visible.entry(camera).or_default();
                for (curve, ball) in all.iter_mut().zip(convert::observations(&seen.balls)) {
                    curve.push((t_s, f64::from(ball.visible)));
                }
            }
            Topic::Hand => {
                let hand: msg::Hand = reader.decode(entry)?;
                for (all, pose) in [(&mut self.place, &hand.pose), (&mut self.filtered, &hand.filtered)] {
                    match pose {
                        Some(pose) => push(all, t_s, &pose.translation, 1e3),
                        // a gap
                        None => push(all, t_s, &[f32::NAN; 3], 1.0),
                    }
                }
                let residual = hand.motion.map_or(f64::NAN, |motion| f64::from(motion.residual_px));
                self.residual.push((t_s, residual));
            }
            Topic::Buttons => {
                let buttons: msg::Buttons = reader.decode(entry)?;
                let now = f64::from(u8::from(buttons.pressed));
                let before = std::mem::replace(&mut self.is_pressed, now);
                self.pressed.push((t_s, before));
                self.pressed.push((t_s, now));
            }
            Topic::Arm => {
                let arm: msg::Arm = reader.decode(entry)?;
                push(&mut self.set_point, t_s, &arm.set_point, 1.0);
                push(&mut self.measured, t_s, &arm.measured, 1.0);
                self.share.push((t_s, f64::from(arm.speed_share)));
            }
            Topic::Delays => {
                let delays: msg::Delays = reader.decode(entry)?;
                for stage in delays.stages.into_iter().filter(|stage| stage.name.starts_with("total")) {
                    let [p50, p99] = self.delays.entry(stage.name).or_default();
                    p50.push((t_s, stage.p50_us as f64 / 1e3));
                    p99.push((t_s, stage.p99_us as f64 / 1e3));
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// The page; `title` stands above it. `reader` has been read.
    #[must_use]
    pub fn report(mut self, reader: &Reader, title: &str) -> Report {
        let names = reader.names();
        self.counts.insert(Topic::Configuration.name(names), (Topic::Configuration.schema(), 1));
        let cut = if reader.cut() { " The file has no end: this is as much of it as there is." } else { "" };
        let lead = format!(
            "Recorded by tetrad {}, {:.1} s.{cut} Times are seconds since the first message.",
            reader.version(),
            self.last_s - self.first_s.unwrap_or(self.last_s)
        );
        let rows = self
            .counts
            .iter()
            .map(|(topic, (schema, count))| {
                vec![Cell::from(topic.as_str()), Cell::from(*schema), Cell::count(*count as usize)]
            })
            .collect();
        let headlines = Table {
            name: "channels",
            caption: "What is in the session".to_owned(),
            columns: vec!["channel", "schema", "messages"],
            rows,
        };
        let mut sections = Vec::new();
        sections.extend(self.seen(names));
        sections.extend(self.hand());
        sections.extend(self.arm());
        sections.extend(self.delays());
        Report { title: title.to_owned(), lead, about: Vec::new(), headlines, sections }
    }

    fn seen(&self, names: &[String]) -> Option<Section> {
        let panel = |(camera, all): (&usize, &[Curve; BALLS])| {
            let series = Ball::ALL.into_iter().zip(all).zip(BALL_COLOURS);
            Panel {
                title: names.get(*camera).cloned().unwrap_or_default(),
                series: series
                    .map(|((ball, curve), colour)| {
                        Series::new(ball.name(), Look::Line, colour, curve.points())
                    })
                    .collect(),
                ..axes("visible share of the rim")
            }
        };
        let panels: Vec<Panel> = self.visible.iter().map(panel).collect();
        section("balls", "The balls", "How much of each ball's rim was seen.", "balls", panels)
    }

    fn hand(&self) -> Option<Section> {
        if self.place.iter().all(|curve| curve.seen == 0) {
            return None;
        }
        let axis_names = ["x", "y", "z"];
        let curves = |all: &[Curve; 3], what: &str, look| -> Vec<Series> {
            let named = axis_names.into_iter().zip(all).zip(COLOURS);
            named
                .map(|((name, curve), colour)| {
                    Series::new(&format!("{name}{what}"), look, colour, curve.points())
                })
                .collect()
        };
        let mut place = curves(&self.place, "", Look::Line);
        place.extend(curves(&self.filtered, " filtered", Look::Dashed));
        let residual = vec![Series::new("residual", Look::Line, BLUE, self.residual.points())];
        let panels = vec![
            Panel { title: "Where the hand is".to_owned(), series: place, ..axes("mm from where it began") },
            Panel { title: "How well it fits".to_owned(), series: residual, ..axes("residual, px") },
        ];
        section("hand", "The hand", "Measured, and as it was filtered.", "hand", panels)
    }

    fn arm(&self) -> Option<Section> {
        if self.share.seen == 0 {
            return None;
        }
        let joints = |all: &[Curve; 6], what: &str, look| -> Vec<Series> {
            let named = all.iter().zip(COLOURS).enumerate();
            named
                .map(|(at, (curve, colour))| {
                    Series::new(&format!("q{}{what}", at + 1), look, colour, curve.points())
                })
                .collect()
        };
        let mut both = joints(&self.set_point, " told", Look::Dashed);
        both.extend(joints(&self.measured, "", Look::Line));
        let pace = vec![
            Series::new("share of its speed", Look::Line, BLUE, self.share.points()),
            Series::new("hold-to-run", Look::Line, ORANGE, self.pressed.points()),
        ];
        let panels = vec![
            Panel { title: "Joints".to_owned(), series: both, ..axes("rad") },
            Panel { title: "Pace and button".to_owned(), series: pace, ..axes("share") },
        ];
        section("arm", "The arm", "What it was told and what its joints did.", "arm", panels)
    }

    fn delays(&self) -> Option<Section> {
        let mut series = Vec::new();
        for ((name, [p50, p99]), colour) in self.delays.iter().zip(COLOURS) {
            let name = name.trim_start_matches("total ");
            series.push(Series::new(&format!("{name}, p50"), Look::Line, colour, p50.points()));
            series.push(Series::new(&format!("{name}, p99"), Look::Dashed, colour, p99.points()));
        }
        let title = "Delays so far".to_owned();
        let panels = if series.is_empty() { Vec::new() } else { vec![Panel { title, series, ..axes("ms") }] };
        section("delays", "Delays", "Of everything since the session began.", "delays", panels)
    }
}

/// A panel over time without anything in it.
fn axes(label: &str) -> Panel {
    Panel {
        title: String::new(),
        x: Axis::linear("s"),
        y: Axis::linear(label),
        equal: false,
        series: Vec::new(),
    }
}

fn section(
    id: &'static str,
    title: &str,
    text: &str,
    name: &'static str,
    panels: Vec<Panel>,
) -> Option<Section> {
    if panels.is_empty() {
        return None;
    }
    let figures = vec![Figure { name, caption: text.to_owned(), panels }];
    Some(Section { id, title: title.to_owned(), text: text.to_owned(), tables: Vec::new(), figures })
}
