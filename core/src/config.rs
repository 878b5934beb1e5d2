//! What can be set: capacities and thresholds, each with value, unit and origin, one type a stage.
//!
//! A stage takes its configuration as an argument, so that a microcontroller, a test and a desktop
//! can be told the same. Numbers that nobody is meant to turn (weights inside a score, how far a
//! prediction is trusted) are named constants at the top of the file that uses them.

mod arm;
mod canopen;
mod centre;
mod drives;
mod filter;
mod governor;
mod hand;
mod learn;
mod slave;
mod teleop;

pub use arm::{FLANGE_M, JOINTS, JointConfig, PumaConfig, PumaConfigError, PumaLengths};
pub use canopen::{CanopenConfig, CanopenConfigError, Homing};
pub use centre::{CentreConfig, CentreMode};
pub use drives::{DriveConfig, DrivesConfig, DrivesConfigError};
pub use filter::{
    FilterConfig, FilterConfigError, MAX_COAST_US, MAX_LEAD_US, OneEuroConfig, Prediction, Smoothing,
};
pub use governor::{
    AllowedPassages, DRIVEN_RAD_S2, GovernorConfig, GovernorConfigError, SlowedByUncertainty,
};
pub use hand::{HandConfig, MAX_ARM_M, MIN_ARM_M, PoseConfig};
pub use learn::{LearnConfig, ProposeConfig};
pub use slave::{SlaveConfig, SlaveConfigError};
pub use teleop::{BelievedMotion, TeleopConfig, TeleopConfigError, TeleopMode, Turning, Workspace};

use core::fmt;

/// The most cameras that may look at one hand: eight, or two where core is built without the feature
/// `eight-views`. Most of the refined pose's state and stack grows with their number or its square.
pub const MAX_VIEWS: usize = if cfg!(feature = "eight-views") { 8 } else { 2 };

/// The largest ball that is measured, pixels. The paper goes to 65; close-ups in footage reach 116.
pub const MAX_DIAMETER: f32 = 128.0;

/// Rows that the edges of one ball may span: three times [`MAX_DIAMETER`], since the spiral may
/// start on any pixel of the ball and is bounded by a square of three diameters (section 3.2).
pub const MAX_ROWS: usize = 384;

/// Candidates a global search keeps of one ball.
pub const MAX_CANDIDATES: usize = 4;

/// Thresholds tried after that of eq. 1.
pub const RETRIES: usize = 4;

/// Thresholds that a global search tries on top of them.
pub const GLOBAL_RETRIES: usize = 2;

/// A threshold near the ball's last typical colour, whatever the background.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Retry {
    /// How far under the V of that colour the threshold lies, in units of M. Measured on hand-held
    /// footage: a shaded ball spans 0.17, skin begins 0.2 below a red ball.
    pub margin: f32,
    /// Whether the threshold is on M; else it is on V alone, which does not mind how bright the ball
    /// is now.
    pub by_distance: bool,
}

/// Section 2 and eq. 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ColourConfig {
    /// alpha of eq. 1 in 1/256: where between background and ball the threshold lies. The paper
    /// leaves it open (0 < alpha <= 1); half way makes the two sides of a blurred rim alike.
    pub alpha_256: u16,
    /// What is tried in turn where eq. 1 finds no ball worth the name, because something like the
    /// ball touches it (skin and a red ball) or the exposure has jumped.
    pub retries: [Retry; RETRIES],
    /// What a global search tries on top: by V alone, since a ball that comes back from somewhere
    /// else may be lit otherwise.
    pub global_retries: [Retry; GLOBAL_RETRIES],
    /// Of 16 pixels around the ball, the rank (by M, 0 the least) that stands for the background.
    /// Above the middle, so that a finger or a face beside the ball moves the threshold.
    pub background_rank: usize,
}

/// Section 3.2.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SearchConfig {
    /// Side of the window in tracking mode, diameters (section 3.2: three).
    pub window_diameters: f32,
    /// Side of the larger window, diameters (section 3.2: "a larger search area").
    pub widened_diameters: f32,
    /// The spiral ends when it has scanned the square of so many diameters (section 3.2: 9 d^2).
    pub spiral_diameters: f32,
    /// Share of matched among visited pixels under which a spiral is inconsistent, 1/256. A ball
    /// wholly seen from its own rim fills a fifth of the spiral; a quarter of that is left for
    /// occlusion.
    pub min_match_256: u32,
    /// Pixels a global search may test with one threshold, as a multiple of the region's own. It
    /// bounds the worst case, a picture in which everything has the ball's colour: this times the
    /// picture, times 2 (1 + [`RETRIES`] + [`GLOBAL_RETRIES`]) thresholds, for each lost ball; a third
    /// of that where it has been lost for longer than two frames.
    pub global_budget: f32,
    /// Spirals that one search may start. With the bound of each it bounds the work of a search in a
    /// picture made of specks: this times (spiral_diameters x d + 2)^2 coordinates.
    pub max_spirals: u32,
}

/// Sections 3.2 (scores) and 3.5 (shape).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShapeConfig {
    /// Fewest matched pixels that count as a ball. 5 px across is 20 pixels; a third may be hidden.
    pub min_area: u32,
    /// The shape rules hold from this diameter on, pixels (section 3.5: "when d is large enough").
    pub min_diameter: f32,
    /// How far area / (width x height) may be from pi/4, relative, for a ball seen whole.
    pub fill_tolerance: f32,
    /// The least overlap of a ball seen whole with the disc in its box (see `Blob::roundness`).
    pub min_roundness: f32,
    /// How far height / width may be from what was learnt, as a ratio above 1.
    pub aspect_tolerance: f32,
    /// Pixels by which digitisation may move either side on top of that.
    pub digitisation: f32,
    /// How much larger or smaller than last time a ball in its window may be, as a ratio above 1.
    pub size_step: f32,
    /// How much larger or smaller than last time a ball found by global search may be.
    pub size_range: f32,
    /// From this score on (0 to 1) a find in the window is taken at once.
    pub good_score: f32,
    /// Under this score a find is not the whole ball, whatever its size.
    pub whole_score: f32,
    /// Under this score a find is doubtful: believed in the window for [`ShapeConfig::doubt_us`], as
    /// a ball about to vanish behind something; not believed in a larger window.
    pub doubtful_score: f32,
    /// How far from its prediction a doubtful find may be, diameters: the rest of a ball that is half
    /// hidden has its centre a quarter of a diameter off, and the prediction errs too.
    pub doubtful_reach: f32,
    /// The least score of a find of the global search.
    pub global_score: f32,
    /// How much of the way to the present size the last clean size goes in a frame in which a ball
    /// is found well (from `whole_score` on) but not whole: fingers over the rim, nearer or further.
    pub size_follow: f32,
    /// How long doubtful finds are believed before the whole picture is searched for a better one,
    /// microseconds.
    pub doubt_us: u64,
}

/// Section 3.4.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OcclusionConfig {
    /// Under this share of the last clean area a ball counts as occluded.
    pub area_share: f32,
    /// Under this share of the last clean diameter (width or height) a ball counts as occluded.
    pub diameter_share: f32,
    /// Under this share of the last clean area nothing of it is taken as measured: it is hidden.
    pub hidden_share: f32,
    /// Of two balls that touch, the one under this share of its last clean area may be behind the
    /// other.
    pub hidden_under: f32,
    /// Pixels by which two balls may be further apart than (D_x + D_y) / 2 and still touch.
    pub margin: f32,
    /// How long a hidden ball is predicted before it is lost, microseconds.
    pub predict_us: u64,
}

/// Section 3.5.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ValidationConfig {
    /// The largest d(measured, predicted) of section 3.5, a mean over the pairs of balls.
    pub max_mismatch: f32,
    /// Frames in a row that must hold before the reference colours follow.
    pub confirmations: u8,
    /// How much of the way to the measured colour a reference goes each frame, 1/256.
    pub follow_256: u16,
    /// How far (D of section 2, brightness taken out) a reference or typical colour may drift from the
    /// learnt one. Measured on footage: at 0.12 a red ball that passed an orange one is not followed
    /// into it, and every change of light is.
    pub max_drift: f32,
    /// Radius around the place that the other balls suggest in which a lost ball may come back,
    /// in largest distances between two balls.
    pub gate_spread: f32,
    /// Growth of that radius with the square of the seconds of absence, in the same unit: how far an
    /// unseen turn of the hand may have carried it.
    pub gate_growth: f32,
}

/// All stages of one camera.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TrackerConfig {
    /// Section 2 and eq. 1.
    pub colour: ColourConfig,
    /// Section 3.2.
    pub search: SearchConfig,
    /// Section 3.3.
    pub centre: CentreConfig,
    /// Shape.
    pub shape: ShapeConfig,
    /// Section 3.4.
    pub occlusion: OcclusionConfig,
    /// Section 3.5.
    pub validation: ValidationConfig,
    /// Whether the balls are one rigid frame: the geometric rules of section 3.5 hold only then.
    /// False for balls that move on their own.
    pub rigid: bool,
}

impl Default for TrackerConfig {
    fn default() -> Self {
        Self {
            colour: ColourConfig {
                alpha_256: 128,
                retries: [
                    Retry { margin: 0.2, by_distance: true },
                    Retry { margin: 0.15, by_distance: true },
                    Retry { margin: 0.1, by_distance: true },
                    Retry { margin: 0.07, by_distance: true },
                ],
                global_retries: [
                    Retry { margin: 0.05, by_distance: false },
                    Retry { margin: 0.03, by_distance: false },
                ],
                background_rank: 9,
            },
            search: SearchConfig {
                window_diameters: 3.0,
                widened_diameters: 7.0,
                spiral_diameters: 3.0,
                min_match_256: 12,
                global_budget: 4.0,
                max_spirals: 400,
            },
            centre: CentreConfig::default(),
            shape: ShapeConfig {
                min_area: 7,
                min_diameter: 8.0,
                fill_tolerance: 0.14,
                min_roundness: 0.86,
                aspect_tolerance: 1.22,
                digitisation: 1.0,
                size_step: 1.7,
                size_range: 2.5,
                good_score: 0.65,
                whole_score: 0.35,
                doubtful_score: 0.15,
                doubtful_reach: 0.8,
                global_score: 0.3,
                size_follow: 0.25,
                doubt_us: 40_000,
            },
            occlusion: OcclusionConfig {
                area_share: 0.8,
                diameter_share: 0.85,
                hidden_share: 0.08,
                hidden_under: 0.9,
                margin: 1.5,
                predict_us: 500_000,
            },
            validation: ValidationConfig {
                max_mismatch: 0.15,
                confirmations: 5,
                follow_256: 16,
                max_drift: 0.12,
                gate_spread: 0.35,
                gate_growth: 0.1,
            },
            rigid: true,
        }
    }
}

/// Which setting cannot be worked with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ConfigError {
    /// alpha of eq. 1 must lie in 1..=256 (in 1/256).
    Alpha,
    /// The background rank must be below 16.
    BackgroundRank,
    /// A window or spiral must be finite, at least one diameter and at most 16.
    Window,
    /// The share of matched pixels under which a spiral is inconsistent must be at most 256 (1/256).
    MatchShare,
    /// The budget of a global search must be finite and between 1 and 64 pictures.
    Budget,
    /// A ratio, share or tolerance is not finite or is negative.
    Tolerance,
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Alpha => "alpha of eq. 1 must be between 1/256 and 1",
            Self::BackgroundRank => "the background rank must be below 16",
            Self::Window => "windows and spirals must be between 1 and 16 diameters",
            Self::MatchShare => "the least share of matched pixels must be at most 256/256",
            Self::Budget => "the budget of a global search must be between 1 and 64 pictures",
            Self::Tolerance => "a ratio, share or tolerance is negative or not a number",
        })
    }
}

impl core::error::Error for ConfigError {}

impl TrackerConfig {
    /// `paper` mode: the row-edge centre of eq. 2.
    #[must_use]
    pub fn paper() -> Self {
        Self { centre: CentreConfig::paper(), ..Self::default() }
    }

    /// Whether every setting can be worked with.
    ///
    /// # Errors
    /// The first [`ConfigError`] met.
    pub fn check(&self) -> Result<(), ConfigError> {
        if !(1..=256).contains(&self.colour.alpha_256) {
            return Err(ConfigError::Alpha);
        }
        if self.colour.background_rank >= 16 {
            return Err(ConfigError::BackgroundRank);
        }
        let s = &self.search;
        if ![s.window_diameters, s.widened_diameters, s.spiral_diameters]
            .iter()
            .all(|d| (1.0..=16.0).contains(d))
        {
            return Err(ConfigError::Window);
        }
        if s.min_match_256 > 256 {
            return Err(ConfigError::MatchShare);
        }
        if !(1.0..=64.0).contains(&s.global_budget) {
            return Err(ConfigError::Budget);
        }
        if !self.centre.is_usable() {
            return Err(ConfigError::Tolerance);
        }
        let (h, o, v) = (&self.shape, &self.occlusion, &self.validation);
        let tolerances = [
            h.min_diameter,
            h.fill_tolerance,
            h.min_roundness,
            h.aspect_tolerance,
            h.digitisation,
            h.size_step,
            h.size_range,
            h.good_score,
            h.whole_score,
            h.doubtful_score,
            h.global_score,
            h.doubtful_reach,
            h.size_follow,
            o.area_share,
            o.diameter_share,
            o.hidden_share,
            o.hidden_under,
            o.margin,
            v.max_mismatch,
            v.max_drift,
            v.gate_spread,
            v.gate_growth,
        ];
        let retries = self.colour.retries.iter().chain(&self.colour.global_retries).map(|r| r.margin);
        if tolerances.iter().copied().chain(retries).all(|t| t.is_finite() && t >= 0.0) {
            Ok(())
        } else {
            Err(ConfigError::Tolerance)
        }
    }
}
