//! A figure: panels of curves and points, told apart from how they are drawn.

/// One or more panels under one caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// The SVG file's name without its ending.
    pub name: &'static str,
    /// Below the figure.
    pub caption: String,
    /// From left to right.
    pub panels: Vec<Panel>,
}

/// Curves in one pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Above the axes.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// Whether a unit is as long on both axes.
    pub equal: bool,
    /// Drawn in order.
    pub series: Vec<Series>,
}

impl Panel {
    /// What its curves are marked with beside their colours, in the order of the series: curves of one colour have
    /// one shape, and differ in their look. `None` where all have one colour.
    #[must_use]
    pub fn shapes(&self) -> Option<Vec<Shape>> {
        let mut colours = Vec::new();
        let shapes = self.series.iter().map(|series| {
            let known = colours.iter().position(|colour| *colour == series.colour);
            let at = known.unwrap_or_else(|| {
                colours.push(series.colour);
                colours.len() - 1
            });
            Shape::ALL[at % Shape::ALL.len()]
        });
        let shapes: Vec<Shape> = shapes.collect();
        (colours.len() > 1).then_some(shapes)
    }
}

/// What a curve is marked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A disc.
    Circle,
    /// On its side.
    Square,
    /// Upwards.
    Triangle,
    /// On its corner.
    Diamond,
    /// An x.
    Cross,
    /// Downwards.
    Wedge,
}

impl Shape {
    /// All, in the order in which colours get them.
    pub const ALL: [Self; 6] =
        [Self::Circle, Self::Square, Self::Triangle, Self::Diamond, Self::Cross, Self::Wedge];
}

/// One axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// What and in which unit.
    pub label: String,
    /// Whether steps are factors; values that are not positive are then left out.
    pub log: bool,
    /// Whether values grow downwards or to the left, as rows of a picture do.
    pub down: bool,
    /// The least range shown: an axis of errors includes zero.
    pub include: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis as long as its values need.
    #[must_use]
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), log: false, down: false, include: None }
    }

    /// A linear axis that shows zero.
    #[must_use]
    pub fn from_zero(label: &str) -> Self {
        Self { include: Some((0.0, 0.0)), ..Self::linear(label) }
    }

    /// A logarithmic axis.
    #[must_use]
    pub fn log(label: &str) -> Self {
        Self { log: true, ..Self::linear(label) }
    }
}

/// So many marks, about, tell a curve of many points from the others.
pub(super) const MARKS: usize = 12;

/// One curve. A point that is not finite breaks it.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// In the legend.
    pub name: String,
    /// How it is drawn.
    pub look: Look,
    /// `#rrggbb`, to be told apart on white and on black.
    pub colour: &'static str,
    /// (x, y)
    pub points: Vec<(f64, f64)>,
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// A line.
    Line,
    /// A dashed line.
    Dashed,
    /// A line with a dot at every point.
    Dotted,
    /// Dots only.
    Points,
}

impl Look {
    /// Whether points are joined.
    #[must_use]
    pub const fn joined(self) -> bool {
        !matches!(self, Self::Points)
    }

    /// Whether every point is marked.
    #[must_use]
    pub const fn marked(self) -> bool {
        matches!(self, Self::Dotted | Self::Points)
    }
}

impl Series {
    /// The diameter of its dots: smaller where there are many.
    #[must_use]
    pub fn dot(&self) -> f64 {
        if self.look == Look::Points && self.points.len() > 20 { 4.0 } else { 7.0 }
    }

    /// A curve.
    #[must_use]
    pub fn new(name: &str, look: Look, colour: &'static str, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_owned(), look, colour, points }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(colours: &[&'static str]) -> Panel {
        let series = colours.iter().map(|colour| Series::new("a", Look::Line, colour, Vec::new()));
        Panel {
            title: String::new(),
            x: Axis::linear("x"),
            y: Axis::linear("y"),
            equal: false,
            series: series.collect(),
        }
    }

    #[test]
    fn a_colour_is_never_all_that_tells_curves_apart() {
        use Shape::{Circle, Square, Triangle};
        let shapes = panel(&["#000001", "#000002", "#000001", "#000003"]).shapes();
        assert_eq!(shapes.as_deref(), Some(&[Circle, Square, Circle, Triangle][..]));
        assert_eq!(panel(&["#000001", "#000001"]).shapes(), None, "their looks have to do");
        let many = ["#000001", "#000002", "#000003", "#000004", "#000005", "#000006"];
        let mut shapes = panel(&many).shapes().unwrap();
        shapes.dedup();
        assert_eq!(shapes.len(), many.len());
    }
}
