//! A panel as plotly.js takes it: a JSON object of data and layout. Letters and grid get their colours from the page
//! that shows it: no one colour can be read on white and on black.

use super::figure::{Axis, Look, MARKS, Panel, Series, Shape};
use plotly::common::{DashType, Font, Line, Marker, MarkerSymbol, Mode, Orientation, Title};
use plotly::layout::{Axis as PlotlyAxis, AxisType, Legend, Margin};
use plotly::{Layout, Plot, Scatter};

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
    let shapes = panel.shapes();
    for (at, series) in panel.series.iter().enumerate() {
        plot.add_trace(trace(series, shapes.as_ref().map(|shapes| shapes[at])));
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
            .font(Font::new().size(12))
            .paper_background_color(CLEAR)
            .plot_background_color(CLEAR)
            .legend(Legend::new().orientation(Orientation::Horizontal).y(-0.22))
            .margin(Margin::new().left(60).right(12).top(42).bottom(48)),
    );
    // an end tag inside a string would end the element that holds it
    plot.to_json().replace("</", "<\\/")
}

fn trace(series: &Series, shape: Option<Shape>) -> Box<Scatter<f64, Option<f64>>> {
    let (x, y): (Vec<f64>, Vec<Option<f64>>) = series
        .points
        .iter()
        .filter(|p| p.0.is_finite())
        .map(|&(x, y)| (x, y.is_finite().then_some(y)))
        .unzip();
    let mode = match series.look {
        Look::Line | Look::Dashed if shape.is_none() => Mode::Lines,
        Look::Line | Look::Dashed | Look::Dotted => Mode::LinesMarkers,
        Look::Points => Mode::Markers,
    };
    let symbol = symbol(shape.unwrap_or(Shape::Circle));
    let mut marker = Marker::new().color(series.colour).size(series.dot() as usize).symbol(symbol);
    if !series.look.marked() {
        marker = marker.max_displayed(MARKS);
    }
    let dash = if series.look == Look::Dashed { DashType::Dash } else { DashType::Solid };
    Scatter::new(x, y)
        .name(&series.name)
        .mode(mode)
        .line(Line::new().color(series.colour).width(1.8).dash(dash))
        .marker(marker)
        .connect_gaps(false)
}

const fn symbol(shape: Shape) -> MarkerSymbol {
    match shape {
        Shape::Circle => MarkerSymbol::Circle,
        Shape::Square => MarkerSymbol::Square,
        Shape::Triangle => MarkerSymbol::TriangleUp,
        Shape::Diamond => MarkerSymbol::Diamond,
        Shape::Cross => MarkerSymbol::X,
        Shape::Wedge => MarkerSymbol::TriangleDown,
    }
}

fn axis(axis: &Axis, values: impl Iterator<Item = f64>) -> PlotlyAxis {
    let plotly = PlotlyAxis::new().title(Title::with_text(&axis.label)).auto_margin(true);
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    fn told(series: Vec<Series>) -> Value {
        let panel = Panel {
            title: "Joints".to_owned(),
            x: Axis::linear("s"),
            y: Axis::from_zero("rad"),
            equal: false,
            series,
        };
        serde_json::from_str(&json(&panel)).unwrap()
    }

    #[test]
    fn curves_of_different_colours_have_different_marks() {
        let points = vec![(0.0, 1.0), (1.0, 2.0)];
        let curve = |name, look, colour| Series::new(name, look, colour, points.clone());
        let told = told(vec![
            curve("q1", Look::Line, "#000001"),
            curve("q1 told", Look::Dashed, "#000001"),
            curve("q2", Look::Line, "#000002"),
        ]);
        let of = |at: usize| {
            let trace = &told["data"][at];
            (trace["mode"].clone(), trace["marker"]["symbol"].clone(), trace["line"]["dash"].clone())
        };
        assert_eq!(of(0).0, "lines+markers");
        assert_eq!(of(0).1, of(1).1);
        assert_ne!(of(0).2, of(1).2);
        assert_ne!(of(0).1, of(2).1);
        assert_eq!(told["data"][0]["marker"]["maxdisplayed"], MARKS);
    }

    #[test]
    fn letters_and_grid_have_the_colours_of_the_page() {
        let layout = &told(vec![Series::new("", Look::Line, "#000001", vec![(0.0, 1.0)])])["layout"];
        assert!(layout["font"]["color"].is_null() && layout["title"]["font"]["color"].is_null(), "{layout}");
        for axis in ["xaxis", "yaxis"] {
            for part in ["color", "gridcolor", "linecolor", "zerolinecolor"] {
                assert!(layout[axis][part].is_null(), "{axis} {part}");
            }
        }
    }
}
