//! What is remembered of one ball between two frames of one camera.

use super::appearance::{Appearance, LearntBall, LearntBallError};
use super::centre::Clean;
use crate::geometry::ImagePoint;
use crate::observation::BALLS;

/// How far ahead the linear prediction reaches, microseconds: past that a hand has turned round.
const MAX_EXTRAPOLATION_US: u64 = 150_000;

/// Two measurements further apart than this say nothing about the present speed, microseconds.
const MAX_SPEED_BASE_US: u64 = 250_000;

/// Frames in a row in which a ball must look round before a sudden change of size is believed.
const ROUND_FRAMES: u8 = 2;

/// Which search found a ball, or why none did (figure 4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// Not taught yet: it is not searched for.
    #[default]
    Learning,
    /// In the window around its prediction.
    Tracking,
    /// In the larger window.
    Widened,
    /// By a global search.
    Global,
    /// Not found.
    Lost,
}

impl Mode {
    /// The word for it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Learning => "learning",
            Self::Tracking => "tracking",
            Self::Widened => "widened",
            Self::Global => "global",
            Self::Lost => "lost",
        }
    }
}

/// A place at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Fix {
    t_us: u64,
    centre: ImagePoint,
}

/// The balls that are tracked, ordered as `Ball::ALL`.
pub(super) type Tracks = [Option<BallTrack>; BALLS];

/// One ball in one camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BallTrack {
    pub(super) appearance: Appearance,
    pub(super) clean: Clean,
    /// Where the others were when this one was last measured.
    pub(super) companions: [Option<ImagePoint>; BALLS],
    last: Option<Fix>,
    /// Pixels a microsecond.
    velocity: ImagePoint,
    /// Where somebody said that it is: until the next frame.
    placed: Option<ImagePoint>,
    round: u8,
    /// Since when its finds have been doubtful.
    doubtful_since: Option<u64>,
}

impl BallTrack {
    pub(super) fn new(learnt: LearntBall) -> Result<Self, LearntBallError> {
        Ok(Self {
            appearance: Appearance::new(learnt)?,
            clean: Clean::taught(learnt.diameter, learnt.aspect),
            companions: [None; BALLS],
            last: None,
            velocity: ImagePoint::default(),
            placed: None,
            round: 0,
            doubtful_since: None,
        })
    }

    pub(super) fn place(&mut self, centre: ImagePoint) {
        self.placed = Some(centre);
        self.last = None;
        self.velocity = ImagePoint::default();
    }

    /// The linear prediction of section 3.2.
    pub(super) fn predict(&self, t_us: u64) -> Option<ImagePoint> {
        self.placed.or_else(|| {
            let last = self.last?;
            let ahead = t_us.saturating_sub(last.t_us).min(MAX_EXTRAPOLATION_US);
            Some(last.centre + self.velocity * ahead as f32)
        })
    }

    pub(super) fn last_centre(&self) -> Option<ImagePoint> {
        self.last.map(|fix| fix.centre)
    }

    /// Microseconds since it was measured; `None` if it never was.
    pub(super) fn absent_us(&self, t_us: u64) -> Option<u64> {
        self.last.map(|fix| t_us.saturating_sub(fix.t_us))
    }

    /// The ball was measured. `trusted` is false where the place alone is good, not the motion: after
    /// a jump found by a global search.
    pub(super) fn measured(&mut self, t_us: u64, centre: ImagePoint, trusted: bool) {
        self.velocity = match self.last {
            Some(last) if trusted && t_us > last.t_us && t_us - last.t_us <= MAX_SPEED_BASE_US => {
                (centre - last.centre) * (1.0 / (t_us - last.t_us) as f32)
            }
            _ => ImagePoint::default(),
        };
        self.last = Some(Fix { t_us, centre });
        self.placed = None;
    }

    pub(super) fn missing(&mut self) {
        self.placed = None;
        self.round = 0;
        self.appearance.doubt();
    }

    /// Counts frames in which it looks round though its size has changed at once; says whether that
    /// has lasted long enough to believe it.
    pub(super) fn looks_round(&mut self, round: bool) -> bool {
        self.round = if round { self.round.saturating_add(1) } else { 0 };
        self.round > ROUND_FRAMES
    }

    /// For how long its finds have been doubtful, this one included, microseconds.
    pub(super) fn doubted_us(&mut self, doubtful: bool, t_us: u64) -> u64 {
        self.doubtful_since = if doubtful { self.doubtful_since.or(Some(t_us)) } else { None };
        self.doubtful_since.map_or(0, |since| t_us.saturating_sub(since))
    }

    pub(super) fn forget(&mut self) {
        self.last = None;
        self.velocity = ImagePoint::default();
        self.appearance.forget();
    }
}
