//! A panel as plotly.js takes it: a JSON object of data and layout.

use super::figure::{Axis, Look, Panel, Series};
use plotly::common::{DashType, Font, Line, Marker, Mode, Orientation, Title};
use plotly::layout::{Axis as PlotlyAxis, AxisType, Legend, Margin};
use plotly::{Layout, Plot, Scatter};

/// Readable on white and on black.
const INK: &str = "#7a7f87";
const GRID: &str = "rgba(128,128,128,0.25)";
const CLEAR: &str = "rgba(0,0,0,0)";

/// The script that draws the plots: plotly.js without what the crate adds for formulas, which no plot here
/// has.
pub(crate) fn script() -> String {
    // the crate gives it as elements of a page, this one first
    const BEGIN: &str = ">";
    const END: &str = "</script>";
    let mut sources = Plot::offline_js_sources();
    if let Some(end) = sources.find(END) {
        sources.truncate(end);
    }
    if let Some(begin) = sources.find(BEGIN) {
        sources.drain(..begin + BEGIN.len());
    }
    sources.shrink_to_fit();
    sources
}

/// The panel's data and layout.
pub(super) fn json(panel: &Panel) -> String {
    let mut plot = Plot::new();
    for series in &panel.series {
        plot.add_trace(trace(series));
    }
    let mut y = axis(&panel.y, panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.1)));
    if panel.equal {
        y = y.scale_anchor("x").scale_ratio(1.0);
    }
    plot.set_layout(
        Layout::new()
            .title(Title::with_text(&panel.title).font(Font::new().size(15)).x(0.02))
            .x_axis(axis(&panel.x, panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.0))))
            .y_axis(y)
            .font(Font::new().color(INK).size(12))
            .paper_background_color(CLEAR)
            .plot_background_color(CLEAR)
            .legend(Legend::new().orientation(Orientation::Horizontal).y(-0.22))
            .margin(Margin::new().left(60).right(12).top(42).bottom(48)),
    );
    // an end tag inside a string would end the element that holds it
    plot.to_json().replace("</", "<\\/")
}

fn trace(series: &Series) -> Box<Scatter<f64, Option<f64>>> {
    let (x, y): (Vec<f64>, Vec<Option<f64>>) = series
        .points
        .iter()
        .filter(|p| p.0.is_finite())
        .map(|&(x, y)| (x, y.is_finite().then_some(y)))
        .unzip();
    let mode = match series.look {
        Look::Line | Look::Dashed => Mode::Lines,
        Look::Dotted => Mode::LinesMarkers,
        Look::Points => Mode::Markers,
    };
    let dash = if series.look == Look::Dashed { DashType::Dash } else { DashType::Solid };
    Scatter::new(x, y)
        .name(&series.name)
        .mode(mode)
        .line(Line::new().color(series.colour).width(1.8).dash(dash))
        .marker(Marker::new().color(series.colour).size(series.dot() as usize))
        .connect_gaps(false)
}

fn axis(axis: &Axis, values: impl Iterator<Item = f64>) -> PlotlyAxis {
    let plotly = PlotlyAxis::new()
        .title(Title::with_text(&axis.label))
        .grid_color(GRID)
        .zero_line_color(GRID)
        .line_color(INK)
        .auto_margin(true);
    if axis.log {
        let ticks = (-4..=4).flat_map(|decade| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(decade)));
        return plotly.type_(AxisType::Log).tick_values(ticks.collect());
    }
    // without a range of its own an axis is as long as its values
    let (low, high) = match (axis.include, axis.down) {
        (Some(include), _) => include,
        (None, true) => (f64::INFINITY, f64::NEG_INFINITY),
        (None, false) => return plotly,
    };
    let (low, high) = values.filter(|v| v.is_finite()).fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
    if !(low.is_finite() && high.is_finite()) {
        return plotly;
    }
    let room = 0.05 * (high - low);
    let low = if axis.include.is_some_and(|(least, _)| least == low) { low } else { low - room };
    plotly.range(if axis.down { vec![high + room, low] } else { vec![low, high + room] })
}
