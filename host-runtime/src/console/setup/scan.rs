//! The horizontal scan of a row: figures 1, 2 and 5 of the paper.

use super::refused::Refused;
use serde::Serialize;
use tetrad_core::config::TrackerConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::Ball;
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::{HorizontalScan, ScanColumn};

/// The most columns that are told; of wider pictures some are left out.
const COLUMNS: usize = 640;

type Row = HorizontalScan<COLUMNS>;

/// A row of a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct ScanTold {
    /// Whose V, D, M and threshold they are.
    pub(super) ball: &'static str,
    /// The row in the picture.
    pub(super) row: u16,
    /// Pixels.
    pub(super) width: u16,
    /// Columns of the picture.
    pub(super) x: Vec<u16>,
    /// Components, V and D from 0 to 1, M from -1 to 1.
    pub(super) r: Vec<f64>,
    pub(super) g: Vec<f64>,
    pub(super) b: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) d: Vec<f64>,
    pub(super) m: Vec<f64>,
    /// The right-hand side of eq. 1.
    pub(super) threshold: f64,
    /// The first and last column of what matches at the pointer or nearest to it in the row.
    pub(super) borders: Option<[i16; 2]>,
}

/// The whole row through a place, and the borders of a ball near it.
pub(super) fn scan(
    frame: &FrameView<'_>,
    ball: Ball,
    learnt: &LearntBall,
    at: ImagePoint,
) -> Result<ScanTold, Refused> {
    let alpha_256 = TrackerConfig::default().colour.alpha_256;
    let (width, height) = (frame.width(), frame.height());
    let through = |diameter| {
        Row::through(frame, &learnt.reference, alpha_256, at, diameter).map_err(|error| match error {
            tetrad_core::vision::learn::LearnError::Outside => Refused::Outside(at.u, at.v, width, height),
            error => Refused::Wrong(format!("{}: {error}", ball.name())),
        })
    };
    let row = through(f32::from(width))?;
    let near = through(learnt.diameter)?;
    let column = |value: fn(&ScanColumn) -> f32| row.columns.iter().map(|c| rounded(value(c))).collect();
    Ok(ScanTold {
        ball: ball.name(),
        row: row.row,
        width,
        x: row.columns.iter().map(|c| c.x).collect(),
        r: column(|c| c.r),
        g: column(|c| c.g),
        b: column(|c| c.b),
        v: column(|c| c.v),
        d: column(|c| c.d),
        m: column(|c| c.m),
        threshold: rounded(row.threshold),
        borders: near.borders.map(|(first, last)| [first, last]),
    })
}

/// To a thousandth: what a plot shows, in few letters.
fn rounded(value: f32) -> f64 {
    (f64::from(value) * 1000.0).round() / 1000.0
}
