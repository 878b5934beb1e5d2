//! A figure as SVG: panels two abreast, axes with round numbers, curves, a legend below.
//!
//! A writer of its own rather than a plotting library: plotly's pictures need a browser, and a second
//! library for axes and polylines is more to keep than these are.

use super::figure::{Axis, Figure, MARKS, Panel, Series, Shape};
use std::fmt::Write as _;

/// A panel with its axes, title and legend, units of the picture.
const PANEL: (f64, f64) = (460.0, 340.0);
/// Around the axes: left, right, top. Below it is what axis and legend need.
const MARGIN: (f64, f64, f64) = (64.0, 14.0, 34.0);
/// Below the axes without a legend, and each of its lines.
const FOOT: (f64, f64) = (46.0, 17.0);
/// How wide a letter of the legend is taken to be.
const LETTER: f64 = 6.3;
/// Around how many numbers stand on an axis.
const TICKS: f64 = 5.0;
/// More points than that are thinned out: no picture shows them.
const MOST_POINTS: usize = 1500;

/// The whole figure.
pub(super) fn draw(figure: &Figure) -> String {
    let columns = figure.panels.len().clamp(1, 2);
    let rows = figure.panels.len().div_ceil(columns).max(1);
    let (width, height) = (PANEL.0 * columns as f64, PANEL.1 * rows as f64);
    let mut svg = Svg(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"system-ui, sans-serif\" font-size=\"12\" role=\"img\">\n\
         <title>{}</title>\n<rect class=\"paper\" width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n",
        escape(&figure.caption)
    ));
    for (index, panel) in figure.panels.iter().enumerate() {
        let (x, y) = ((index % columns) as f64 * PANEL.0, (index / columns) as f64 * PANEL.1);
        let _ = writeln!(svg.0, "<g transform=\"translate({x} {y})\">");
        svg.panel(panel);
        svg.0.push_str("</g>\n");
    }
    svg.0.push_str("</svg>\n");
    svg.0
}

/// Text with what XML reserves written out.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

struct Svg(String);

impl Svg {
    fn panel(&mut self, panel: &Panel) {
        let legend = legend_lines(panel);
        let bottom = PANEL.1 - FOOT.0 - FOOT.1 * legend.len() as f64;
        let points = || panel.series.iter().flat_map(|series| &series.points);
        let mut x = Scale::new(&panel.x, points().map(|p| p.0), (MARGIN.0, PANEL.0 - MARGIN.1));
        let mut y = Scale::new(&panel.y, points().map(|p| p.1), (bottom, MARGIN.2));
        if panel.equal {
            Scale::equalise(&mut x, &mut y);
        }
        self.text(((MARGIN.0 + PANEL.0 - MARGIN.1) / 2.0, 20.0), "middle", "ink", &panel.title, 14.0);
        self.axes(panel, &x, &y, bottom);
        let shapes = panel.shapes();
        let shape = |at: usize| shapes.as_ref().map(|shapes| shapes[at]);
        for (at, series) in panel.series.iter().enumerate() {
            self.series(series, shape(at), at, (&x, &y));
        }
        for (line, entries) in legend.iter().enumerate() {
            let at = bottom + FOOT.0 + FOOT.1 * (line as f64 + 0.3);
            let mut from = MARGIN.0;
            for (index, series) in entries {
                let colour = series.colour;
                if series.look.joined() {
                    let dash = dash(series);
                    let _ = writeln!(
                        self.0,
                        "<path d=\"M{from:.1} {at:.1}h18\" stroke=\"{colour}\" stroke-width=\"2\"{dash}/>"
                    );
                }
                if series.look.marked() || shapes.is_some() {
                    self.mark(shape(*index), (from + 9.0, at), 3.0, colour);
                }
                self.text((from + 23.0, at + 4.0), "start", "ink", &series.name, 12.0);
                from += entry_width(series);
            }
        }
    }

    fn axes(&mut self, panel: &Panel, x: &Scale, y: &Scale, bottom: f64) {
        for (value, label) in x.ticks() {
            let at = x.at(value);
            let _ = writeln!(
                self.0,
                "<path class=\"grid\" d=\"M{at:.1} {:.1}V{bottom:.1}\" stroke=\"#d8dade\"/>",
                MARGIN.2
            );
            self.text((at, bottom + 16.0), "middle", "ink", &label, 12.0);
        }
        for (value, label) in y.ticks() {
            let at = y.at(value);
            let _ = writeln!(
                self.0,
                "<path class=\"grid\" d=\"M{:.1} {at:.1}H{:.1}\" stroke=\"#d8dade\"/>",
                MARGIN.0,
                PANEL.0 - MARGIN.1
            );
            self.text((MARGIN.0 - 6.0, at + 4.0), "end", "ink", &label, 12.0);
        }
        self.text(
            ((MARGIN.0 + PANEL.0 - MARGIN.1) / 2.0, bottom + 34.0),
            "middle",
            "ink",
            &panel.x.label,
            12.0,
        );
        let middle = (MARGIN.2 + bottom) / 2.0;
        let _ = writeln!(
            self.0,
            "<text class=\"ink\" transform=\"translate(14 {middle:.1}) rotate(-90)\" text-anchor=\"middle\" \
             fill=\"#333333\">{}</text>",
            escape(&panel.y.label)
        );
    }

    fn series(&mut self, series: &Series, shape: Option<Shape>, index: usize, (x, y): (&Scale, &Scale)) {
        let every = series.points.len().div_ceil(MOST_POINTS).max(1);
        let inside = |p: &(f64, f64)| x.shows(p.0) && y.shows(p.1);
        let points = || series.points.iter().step_by(every);
        let colour = series.colour;
        if series.look.joined() {
            let mut path = String::new();
            let mut drawing = false;
            for point in points() {
                if inside(point) {
                    let letter = if drawing { 'L' } else { 'M' };
                    let _ = write!(path, "{letter}{:.1} {:.1}", x.at(point.0), y.at(point.1));
                }
                drawing = inside(point);
            }
            let dash = dash(series);
            let _ = writeln!(
                self.0,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\" \
                 stroke-linejoin=\"round\"{dash}/>"
            );
        }
        let radius = series.dot() / 2.2;
        let marks: Vec<(f64, f64)> =
            points().filter(|point| inside(point)).map(|point| (x.at(point.0), y.at(point.1))).collect();
        let (first, every) = match (series.look.marked(), shape) {
            (true, _) => (0, 1),
            // those of curves that lie on each other do not
            (false, Some(_)) => (3 * index, marks.len().div_ceil(MARKS).max(1)),
            (false, None) => return,
        };
        for centre in marks.into_iter().skip(first % every).step_by(every) {
            self.mark(shape, centre, radius, colour);
        }
    }

    /// A curve's mark, about as large as a disc of that radius.
    fn mark(&mut self, shape: Option<Shape>, (x, y): (f64, f64), radius: f64, colour: &str) {
        let r = radius;
        let path = match shape.unwrap_or(Shape::Circle) {
            Shape::Circle => {
                let _ = writeln!(
                    self.0,
                    "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\"/>"
                );
                return;
            }
            Shape::Square => format!("m{:.1} {:.1}h{:.1}v{:.1}h{:.1}z", -r, -r, 2.0 * r, 2.0 * r, -2.0 * r),
            Shape::Triangle => format!("m0 {:.1}l{:.1} {:.1}h{:.1}z", -1.2 * r, 1.2 * r, 2.2 * r, -2.4 * r),
            Shape::Wedge => format!("m0 {:.1}l{:.1} {:.1}h{:.1}z", 1.2 * r, 1.2 * r, -2.2 * r, -2.4 * r),
            Shape::Diamond => {
                let d = 1.4 * r;
                format!("m0 {:.1}l{d:.1} {d:.1}l{:.1} {d:.1}l{:.1} {:.1}z", -d, -d, -d, -d)
            }
            Shape::Cross => {
                let path = format!(
                    "m{:.1} {:.1}l{w:.1} {w:.1}m0 {:.1}l{:.1} {w:.1}",
                    -r,
                    -r,
                    -2.0 * r,
                    -2.0 * r,
                    w = 2.0 * r
                );
                let _ = writeln!(
                    self.0,
                    "<path d=\"M{x:.1} {y:.1}{path}\" stroke=\"{colour}\" stroke-width=\"1.6\"/>"
                );
                return;
            }
        };
        let _ = writeln!(self.0, "<path d=\"M{x:.1} {y:.1}{path}\" fill=\"{colour}\"/>");
    }

    fn text(&mut self, (x, y): (f64, f64), anchor: &str, class: &str, text: &str, size: f64) {
        let _ = writeln!(
            self.0,
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" \
             fill=\"#333333\">{}</text>",
            escape(text)
        );
    }
}

fn dash(series: &Series) -> &'static str {
    if series.look == super::Look::Dashed { " stroke-dasharray=\"6 4\"" } else { "" }
}

fn entry_width(series: &Series) -> f64 {
    40.0 + LETTER * series.name.chars().count() as f64
}

/// The legend's entries, as many on a line as have room; none for a single curve without a name.
fn legend_lines(panel: &Panel) -> Vec<Vec<(usize, &Series)>> {
    let mut lines: Vec<Vec<(usize, &Series)>> = Vec::new();
    let mut used = f64::INFINITY;
    for (at, series) in panel.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty()) {
        let width = entry_width(series);
        if used + width > PANEL.0 - MARGIN.0 {
            lines.push(Vec::new());
            used = 0.0;
        }
        used += width;
        if let Some(line) = lines.last_mut() {
            line.push((at, series));
        }
    }
    lines
}

/// From values to places along an axis.
struct Scale {
    log: bool,
    /// Of the values, or of their logarithms.
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, (from, to): (f64, f64)) -> Self {
        let (from, to) = if axis.down { (to, from) } else { (from, to) };
        let known = |value: &f64| value.is_finite() && (!axis.log || *value > 0.0);
        let included = axis.include.into_iter().flat_map(|(low, high)| [low, high]);
        let values = values.chain(included).filter(known);
        let values = values.map(|value| if axis.log { value.log10() } else { value });
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = match high - low {
            span if span > 0.0 => {
                let room = 0.04 * span;
                // an axis that starts at zero starts there
                let starts_at_zero = axis.include.is_some_and(|(least, _)| least == low);
                (if starts_at_zero { low } else { low - room }, high + room)
            }
            // one value, or none
            0.0 => (low - 0.5, high + 0.5),
            _ => (0.0, 1.0),
        };
        Self { log: axis.log, low, high, from, to }
    }

    fn equalise(x: &mut Self, y: &mut Self) {
        let unit = |scale: &Self| (scale.high - scale.low) / (scale.to - scale.from).abs();
        let coarser = unit(x).max(unit(y));
        for scale in [x, y] {
            let middle = (scale.low + scale.high) / 2.0;
            let half = coarser * (scale.to - scale.from).abs() / 2.0;
            (scale.low, scale.high) = (middle - half, middle + half);
        }
    }

    fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }

    fn at(&self, value: f64) -> f64 {
        let value = if self.log { value.log10() } else { value };
        self.from + (self.to - self.from) * (value - self.low) / (self.high - self.low)
    }

    /// Round values inside the axis with their text.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.log {
            let span = self.high - self.low;
            let digits: &[f64] = if span > 2.5 { &[1.0] } else { &[1.0, 2.0, 5.0] };
            let decades = self.low.floor() as i32..=self.high.ceil() as i32;
            let values = decades.flat_map(|decade| digits.iter().map(move |d| d * 10f64.powi(decade)));
            let inside = values.filter(|value| (self.low..=self.high).contains(&value.log10()));
            return inside.map(|value| (value, format!("{value}"))).collect();
        }
        let rough = (self.high - self.low) / TICKS;
        let decade = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * decade).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(10.0 * decade);
        let places = (-step.log10().floor()).max(0.0) as usize;
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        let value = |i: i64| i as f64 * step;
        (first..=last).map(|i| (value(i), format!("{:.places$}", value(i)))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(axis: &Axis, values: &[f64]) -> Scale {
        Scale::new(axis, values.iter().copied(), (0.0, 100.0))
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let texts = |s: &Scale| s.ticks().into_iter().map(|(_, text)| text).collect::<Vec<_>>();
        assert_eq!(
            texts(&scale(&Axis::from_zero("a"), &[0.01, 0.24])),
            ["0.00", "0.05", "0.10", "0.15", "0.20"]
        );
        assert_eq!(texts(&scale(&Axis::linear("a"), &[-150.0, 150.0])), ["-100", "0", "100"]);
        assert_eq!(texts(&scale(&Axis::log("a"), &[0.02, 0.3])), ["0.02", "0.05", "0.1", "0.2"]);
        assert_eq!(texts(&scale(&Axis::log("a"), &[0.002, 3.0])), ["0.01", "0.1", "1"]);
    }

    #[test]
    fn no_values_and_one_value_have_an_axis_too() {
        for values in [&[][..], &[3.0], &[f64::NAN]] {
            let scale = scale(&Axis::linear("a"), values);
            assert!(scale.low < scale.high, "{values:?}");
            assert!(scale.ticks().len() > 1);
        }
    }

    #[test]
    fn equal_axes_have_units_of_one_length() {
        let mut x = Scale::new(&Axis::linear("x"), [0.0, 10.0].into_iter(), (0.0, 300.0));
        let mut y = Scale::new(&Axis::linear("y"), [0.0, 2.0].into_iter(), (200.0, 0.0));
        Scale::equalise(&mut x, &mut y);
        let (right, up) = (x.at(1.0) - x.at(0.0), y.at(0.0) - y.at(1.0));
        assert!((right - up).abs() < 1e-9, "{right} {up}");
    }
}
