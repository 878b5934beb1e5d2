//! What the pages are told of the operator's loop, at one moment. Plain numbers and words, made into JSON by
//! the console's thread.

mod arm;

use crate::link::LinkStats;
use crate::station::camera::Windows;
use crate::station::delays::{Delays, Spread, Stage};
use crate::station::operator::OperatorStep;
pub(super) use arm::silence;
pub use arm::{ArmView, GoalView, SILENT_US, SlaveView, is_engaged};
use serde::Serialize;
use tetrad_core::observation::{Ball, ObservationState, Observations};
use tetrad_core::vision::search::Region;

/// Everything at one moment.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Snapshot {
    /// Counts the snapshots.
    pub sequence: u64,
    /// When it was so, by the operator's clock, microseconds.
    pub time_us: u64,
    /// The hand; `None` before the first instant.
    pub hand: Option<HandView>,
    /// The cameras that see it, in their order.
    pub cameras: Vec<CameraView>,
    /// The arm; `None` until it was heard.
    pub arm: Option<ArmView>,
    /// Share of the time since the arm was first heard in which it followed the hand, 0 to 1.
    pub engaged_share: f64,
    /// How the slave follows, as it has announced; `None` until it was heard.
    pub slave: Option<SlaveView>,
    /// Where the hand asks the tool to be; `None` while the arm does not follow, or is silent.
    pub goal: Option<GoalView>,
    /// The stations of the link.
    pub links: Vec<LinkView>,
    /// How long each stage took, since the start and lately.
    pub delays: Vec<DelayView>,
    /// The pictures of the slave's cameras: of as many as it has announced, of two before that.
    pub pictures: Vec<PictureView>,
    /// The session that is recorded; `None`: nothing is.
    pub recording: Option<RecordingView>,
    /// What was told last, the newest at the end.
    pub lines: Vec<Line>,
}

/// Where the hand is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HandView {
    /// How the pose is known, in one word.
    pub state: &'static str,
    /// Microseconds since the instant it is of.
    pub age_us: u64,
    /// Millimetres, in the axes of the first complete instant; `None` without a pose.
    pub position_mm: Option<[f32; 3]>,
    /// The rotation row by row.
    pub rotation: Option<[f32; 9]>,
    /// Standard deviation along each axis, millimetres.
    pub sigma_mm: Option<[f32; 3]>,
    /// Standard deviation about each axis, degrees.
    pub sigma_deg: Option<[f32; 3]>,
    /// The covariance of the position row by row, mm^2.
    pub covariance_mm2: Option<[f32; 9]>,
}

/// One camera of the hand.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CameraView {
    /// As the station's file calls it.
    pub name: String,
    /// Its place among the views whose pictures can be looked at; `None`: it has none.
    pub view: Option<usize>,
    /// Why there is no picture to look at, where that is known.
    pub no_picture: Option<&'static str>,
    /// Microseconds since its last observations came; `None`: never.
    pub age_us: Option<u64>,
    /// Pictures a second; `None` where it is not known yet.
    pub rate: Option<f64>,
    /// Pixels.
    pub width: u16,
    /// Pixels.
    pub height: u16,
    /// The balls of its last picture.
    pub balls: Vec<BallView>,
}

/// One ball in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BallView {
    /// Which.
    pub name: &'static str,
    /// How its centre is known, in one word.
    pub state: &'static str,
    /// Pixels; `None` where it has no place.
    pub centre: Option<[f32; 2]>,
    /// Pixels.
    pub diameter: f32,
    /// The share of its rim that was seen, 0 to 1.
    pub visible: f32,
    /// Where it was looked for first: first column and row, one past the last column and row, pixels;
    /// `None` where it was searched in the whole picture, or nobody says.
    pub window: Option<[i32; 4]>,
}

/// One station of the link.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LinkView {
    /// Its name.
    pub name: String,
    /// Whether anybody is at the other end.
    pub connected: bool,
    /// Microseconds since it was last heard; `None`: never.
    pub age_us: Option<u64>,
    /// Share of the packets that were lost on the way there on this connection, 0 to 1; `None` within one process.
    pub loss: Option<f64>,
    /// The same of those that were sent in about the last 10 s; `None` where none were.
    pub loss_lately: Option<f64>,
    /// There and back, microseconds.
    pub round_trip_us: Option<u64>,
    /// The packets that were sent there on this connection; `None` within one process, as of all below.
    pub sent_packets: Option<u64>,
    /// How many of those were lost.
    pub lost_packets: Option<u64>,
    /// How far the station's clock is ahead of the operator's, microseconds; `None` until it is known.
    pub clock_offset_us: Option<i64>,
    /// How wrong that may be, microseconds.
    pub clock_error_us: Option<u64>,
}

impl LinkView {
    /// A peer of the link by what is known of it now.
    #[must_use]
    pub fn of(name: &str, connected: bool, stats: &LinkStats, now_us: u64) -> Self {
        let (sent, lost) = (stats.sent_packets, stats.lost_packets);
        Self {
            name: name.to_owned(),
            connected,
            age_us: stats.heard_us.map(|heard_us| now_us.saturating_sub(heard_us)),
            loss: (sent > 0).then(|| lost as f64 / sent as f64),
            loss_lately: None,
            round_trip_us: stats.round_trip_us,
            sent_packets: Some(sent),
            lost_packets: Some(lost),
            clock_offset_us: stats.clock.map(|clock| clock.offset_us),
            clock_error_us: stats.clock.map(|clock| clock.error_us),
        }
    }
}

/// One stage's delay.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DelayView {
    /// From what to what.
    pub stage: &'static str,
    /// Since the start.
    #[serde(flatten)]
    pub all: SpreadView,
    /// In about the last 10 s; `None` where it was not measured in them.
    pub lately: Option<SpreadView>,
}

/// How long something took.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpreadView {
    /// How often it was measured.
    pub count: u64,
    /// Milliseconds.
    pub p50_ms: f64,
    /// Milliseconds.
    pub p99_ms: f64,
    /// Milliseconds.
    pub max_ms: f64,
}

/// The session that is recorded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RecordingView {
    /// The file.
    pub file: String,
    /// Messages that were left out so far, for the disk was behind.
    pub left_out: u64,
    /// Whether writing has failed: nothing more is recorded.
    pub failed: bool,
}

/// A picture of the slave's scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureView {
    /// Which eye.
    pub name: &'static str,
    /// Its place among the views.
    pub view: usize,
    /// Microseconds since it was taken; `None`: none has come.
    pub age_us: Option<u64>,
    /// Whether nobody should steer by it.
    pub stale: bool,
    /// How many came.
    pub count: u64,
}

/// Something that was told.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Line {
    /// Counts the lines.
    pub number: u64,
    /// What.
    pub text: String,
}

impl HandView {
    /// The hand of an instant.
    #[must_use]
    pub fn of(step: &OperatorStep, now_us: u64) -> Self {
        let report = &step.hand.report;
        let pose = step.hand.filtered.or(report.pose);
        let covariance = report.covariance.as_ref().filter(|_| pose.is_some());
        let rows = |matrix: &nalgebra::Matrix3<f32>, by: f32| {
            let mut rows = [0.0; 9];
            rows.iter_mut().zip(matrix.transpose().iter()).for_each(|(to, from)| *to = from * by);
            rows
        };
        let sigma = |first: usize, by: f32| {
            covariance.map(|k| [0, 1, 2].map(|axis| k[(first + axis, first + axis)].max(0.0).sqrt() * by))
        };
        Self {
            state: report.state.name(),
            age_us: now_us.saturating_sub(step.joined.t_us),
            position_mm: pose.map(|pose| (pose.translation * 1e3).into()),
            rotation: pose.map(|pose| rows(&pose.rotation, 1.0)),
            sigma_mm: sigma(0, 1e3),
            sigma_deg: sigma(3, 1f32.to_degrees()),
            covariance_mm2: covariance.map(|k| rows(&k.fixed_view::<3, 3>(0, 0).into_owned(), 1e6)),
        }
    }
}

impl BallView {
    /// The balls of a picture.
    #[must_use]
    pub fn all(balls: &Observations) -> Vec<Self> {
        let of = |(ball, seen): (Ball, &tetrad_core::observation::Observation)| Self {
            name: ball.name(),
            state: seen.state.name(),
            centre: (seen.state != ObservationState::Lost).then_some([seen.centre.u, seen.centre.v]),
            diameter: seen.diameter,
            visible: seen.visible,
            window: None,
        };
        Ball::ALL.into_iter().zip(balls).map(of).collect()
    }

    /// The same, with where they were looked for.
    #[must_use]
    pub fn all_in(balls: &Observations, windows: &Windows) -> Vec<Self> {
        let window = |region: Region| [region.x0, region.y0, region.x1, region.y1];
        let all = Self::all(balls).into_iter().zip(windows);
        all.map(|(ball, region)| Self { window: region.map(window), ..ball }).collect()
    }
}

impl DelayView {
    /// A stage, if it was measured.
    #[must_use]
    pub fn of(stage: Stage, delays: &Delays, now_us: u64) -> Option<Self> {
        let all = SpreadView::of(delays.of(stage)?);
        let lately = delays.lately(stage, now_us).map(SpreadView::of);
        Some(Self { stage: stage.name(), all, lately })
    }
}

impl SpreadView {
    fn of(spread: Spread) -> Self {
        let Spread { count, p50_us, p99_us, max_us } = spread;
        let [p50_ms, p99_ms, max_ms] = [p50_us, p99_us, max_us].map(|us| us as f64 / 1e3);
        Self { count, p50_ms, p99_ms, max_ms }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::observation::BALLS;

    #[test]
    fn a_ball_is_told_with_where_it_was_looked_for() {
        let mut windows = [None; BALLS];
        windows[2] = Some(Region { x0: 3, y0: 4, x1: 30, y1: 40 });
        let balls = BallView::all_in(&Observations::default(), &windows);
        let told: Vec<_> = balls.iter().map(|ball| (ball.name, ball.window)).collect();
        assert_eq!(told, [("red", None), ("green", None), ("blue", Some([3, 4, 30, 40])), ("yellow", None)]);
        assert!(BallView::all(&Observations::default()).iter().all(|ball| ball.window.is_none()));
    }
}
