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

    /// Whether points are marked.
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
