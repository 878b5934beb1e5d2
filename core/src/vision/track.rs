//! What is remembered of one ball between two frames of one camera.

use super::appearance::{Appearance, LearntBall, LearntBallError};
use super::centre::Clean;
use super::forecast::{Forecast, MAX_EXTRAPOLATION_US, Outcome};
use super::rim::RimMemory;
use crate::config::Retry;
use crate::geometry::ImagePoint;
use crate::observation::BALLS;

/// A global search for something better than a doubtful find is made once in this time, microseconds.
const SECOND_LOOK_US: u64 = 100_000;

/// Two measurements further apart than this say nothing about the present speed, microseconds.
const MAX_SPEED_BASE_US: u64 = 250_000;

/// Frames in a row in which a ball must look round before a sudden change of size is believed.
const ROUND_FRAMES: u8 = 2;

/// A find with so much of the last one's score is as good as that ...
const STEADY_SHARE: f32 = 0.9;

/// ... if it is not too poor a find anyway.
const STEADY_SCORE: f32 = 0.2;

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

/// The thresholds of eq. 1 that are tried in turn while a window gives no ball worth the name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Attempt {
    /// With the background of the previous frame.
    #[default]
    AsBefore,
    /// With the background around the place where the ball is expected now: it may have moved from
    /// in front of one thing to in front of another.
    BackgroundHere,
    /// Near the typical colour, whatever the background.
    Near(Retry),
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
    /// The rim as it was last found.
    pub(super) rim: Option<RimMemory>,
    /// How well it is known where nobody sees it.
    pub(super) forecast: Forecast,
    /// Where the others were when this one was last measured.
    pub(super) companions: [Option<ImagePoint>; BALLS],
    last: Option<Fix>,
    /// The standard deviation of that place, pixels.
    known: f32,
    /// Pixels a microsecond.
    velocity: ImagePoint,
    /// Where somebody said that it is: until the next frame.
    placed: Option<ImagePoint>,
    round: u8,
    /// Which threshold gave the last find in a window, and its score.
    settled: (Attempt, f32),
    /// Since when its finds have been doubtful.
    doubtful_since: Option<u64>,
    /// Frames in a row in which it was not found.
    missed: u32,
}

impl BallTrack {
    pub(super) fn new(learnt: LearntBall) -> Result<Self, LearntBallError> {
        Ok(Self {
            appearance: Appearance::new(learnt)?,
            clean: Clean::taught(learnt.diameter, learnt.aspect),
            rim: None,
            forecast: Forecast::new(learnt.diameter),
            companions: [None; BALLS],
            last: None,
            known: 0.0,
            velocity: ImagePoint::default(),
            placed: None,
            round: 0,
            settled: (Attempt::AsBefore, 0.0),
            doubtful_since: None,
            missed: 0,
        })
    }

    pub(super) fn place(&mut self, centre: ImagePoint) {
        self.placed = Some(centre);
        self.missed = 0;
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

    /// How far it is from where it was in the last frame, pixels; 0 where that is not known.
    pub(super) fn moved(&self, t_us: u64, to: ImagePoint) -> f32 {
        let recent = self.last.filter(|last| t_us.saturating_sub(last.t_us) <= MAX_SPEED_BASE_US);
        recent.map_or(0.0, |last| last.centre.distance(to))
    }

    /// As it was last seen whole, pixels: of the rim where one was found.
    pub(super) fn diameter(&self) -> f32 {
        self.rim.map_or(self.clean.diameter, |rim| rim.diameter())
    }

    pub(super) fn last_centre(&self) -> Option<ImagePoint> {
        self.last.map(|fix| fix.centre)
    }

    /// Microseconds since it was measured; `None` if it never was.
    pub(super) fn absent_us(&self, t_us: u64) -> Option<u64> {
        self.last.map(|fix| t_us.saturating_sub(fix.t_us))
    }

    /// Compares its prediction with where it was measured, before [`Self::measured`].
    pub(super) fn judge_prediction(
        &mut self,
        t_us: u64,
        measured: ImagePoint,
        variance: f32,
        (predicted, carried): (Option<ImagePoint>, Option<ImagePoint>),
    ) {
        let absent = self.absent_us(t_us).filter(|us| (1..=MAX_SPEED_BASE_US).contains(us));
        if let (Some(before), Some(us), Some(predicted)) = (self.last_centre(), absent, predicted) {
            let s = us as f32 * 1e-6;
            self.forecast.learn(&Outcome { measured, before, predicted, carried, variance, s });
        } else {
            self.forecast.interrupted();
        }
    }

    /// Frames in a row in which it was not found.
    pub(super) const fn missed(&self) -> u32 {
        self.missed
    }

    /// The standard deviation of its place where it is expected and nobody sees it, pixels.
    pub(super) fn predicted_to(&self, absent_us: u64) -> f32 {
        let strayed = self.forecast.sigma(self.diameter(), absent_us);
        libm::sqrtf(self.known * self.known + strayed * strayed)
    }

    /// The same where the others have carried it.
    pub(super) fn carried_to(&self, absent_us: u64) -> f32 {
        let strayed = self.forecast.carried_sigma(self.diameter(), absent_us);
        libm::sqrtf(self.known * self.known + strayed * strayed)
    }

    /// Notes how well the last place is known: a standard deviation, pixels.
    pub(super) const fn known_to(&mut self, sigma: f32) {
        self.known = sigma;
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
        self.missed = 0;
    }

    pub(super) fn missing(&mut self) {
        self.placed = None;
        self.missed = self.missed.wrapping_add(1);
        self.round = 0;
        self.appearance.doubt();
    }

    /// Counts frames in which it looks round though its size has changed at once; says whether that
    /// has lasted long enough to believe it.
    pub(super) fn looks_round(&mut self, round: bool) -> bool {
        self.round = if round { self.round.saturating_add(1) } else { 0 };
        self.round > ROUND_FRAMES
    }

    /// Which threshold gave the last find in a window.
    pub(super) const fn usual_attempt(&self) -> Attempt {
        self.settled.0
    }

    /// Whether a find is as good as the last one, by the same threshold: then no other is tried.
    pub(super) fn is_as_good(&self, attempt: Attempt, score: f32) -> bool {
        let (usual, last) = self.settled;
        attempt == usual && score >= STEADY_SHARE * last && score >= STEADY_SCORE
    }

    pub(super) const fn settle(&mut self, attempt: Attempt, score: f32) {
        self.settled = (attempt, score);
    }

    /// Notes whether its find is doubtful. Says whether it is time to look for a better one in the
    /// whole picture: when doubt has lasted for `patience_us`, and then now and again.
    pub(super) fn doubt(&mut self, doubtful: bool, t_us: u64, patience_us: u64) -> bool {
        if !doubtful {
            self.doubtful_since = None;
            return false;
        }
        let since = *self.doubtful_since.get_or_insert(t_us);
        let due = t_us.saturating_sub(since) > patience_us;
        if due {
            // The next look is due a while after this one.
            self.doubtful_since = Some(t_us.saturating_sub(patience_us).saturating_add(SECOND_LOOK_US));
        }
        due
    }

    pub(super) fn forget(&mut self) {
        self.last = None;
        self.velocity = ImagePoint::default();
        self.appearance.forget();
    }
}
