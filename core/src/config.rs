//! What can be set: capacities and thresholds, each with value, unit and origin, one type a stage.
//!
//! A stage takes its configuration as an argument, so that a microcontroller, a test and a desktop
//! can be told the same. Numbers that nobody is meant to turn (weights inside a score, how far a
//! prediction is trusted) are named constants at the top of the file that uses them.

use core::fmt;

/// The most cameras that may look at one hand (DESIGN: one to eight).
pub const MAX_VIEWS: usize = 8;

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
    /// picture, times 2 (1 + [`RETRIES`] + [`GLOBAL_RETRIES`]) thresholds, for each lost ball.
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

/// Section 3.1: learning a colour from a point inside a ball, and proposing balls without one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LearnConfig {
    /// alpha of eq. 1 in 1/256, as the tracker will use it: the background pixel is chosen so that
    /// eq. 1 with this alpha puts the threshold where it separates best.
    pub alpha_256: u16,
    /// The smallest ball that is learnt, pixels: below it a rim of 32 directions has no 32 pixels.
    pub least_diameter: f32,
    /// The largest ball that is learnt, pixels; at most [`MAX_DIAMETER`].
    pub most_diameter: f32,
    /// Below this diameter, pixels, the area of the rows sets the outline: the rim has fewer pixels
    /// than directions there.
    pub area_diameter: f32,
    /// By how many levels (0 to 255) the weakest component a colour has must exceed the strongest
    /// it has not. Twice the noise of compressed footage on a black curtain; a dull red ball there
    /// has 20 to 45.
    pub least_chroma: i32,
    /// How much of the ball's saturation (chroma over brightness, which shading leaves alone) a pixel
    /// inside the rim must have, 1/256. Half: skin beside a red ball has 0.4 of its saturation.
    pub saturation_share_256: u16,
    /// How far from the point a highlight may reach, pixels: a quarter of a ball of 64 pixels.
    pub seed_reach: i32,
    /// The contrast of saturation across the rim, 0 to 1, at which a direction counts half. It bounds
    /// what a few strong directions can outvote.
    pub half_contrast: f32,
    /// The least contrast of saturation, 0 to 1, of a direction that supports the rim.
    pub least_contrast: f32,
    /// The least contrast over the whole rim, 0 to 1. Labelled balls of real footage: 0.31 to 0.74;
    /// three of four points on a background stay below 0.22.
    pub least_rim: f32,
    /// Directions of 32 that must support a rim: half. Labelled balls of real footage: 19 to 32;
    /// three of four points on a background stay below 13.
    pub least_support: u16,
    /// Share of the ball less share of the neighbourhood that the best threshold must keep apart.
    /// Labelled balls of real footage: 0.73 to 1; three of four points on a background stay below 0.63.
    pub least_separation: f32,
    /// How much worse a passing pixel of the neighbourhood is than a missed one of the ball, tried in
    /// this order until what eq. 1 matches is the ball that the outline shows.
    pub ring_weights: [f32; 4],
    /// How often the outline is sought again with the colours of the last one. Once lets a point in
    /// a dark corner of the ball end with the same outline as one in its middle.
    pub passes: u8,
    /// At most about so many pixels of the rest of the picture are tried for the clash score.
    pub clash_samples: u16,
}

impl Default for LearnConfig {
    fn default() -> Self {
        Self {
            alpha_256: 128,
            least_diameter: 4.0,
            most_diameter: MAX_DIAMETER,
            area_diameter: 10.0,
            least_chroma: 12,
            saturation_share_256: 128,
            seed_reach: 16,
            half_contrast: 0.15,
            least_contrast: 0.05,
            least_rim: 0.22,
            least_support: 16,
            least_separation: 0.6,
            ring_weights: [1.0, 2.0, 3.0, 5.0],
            passes: 1,
            clash_samples: 4096,
        }
    }
}

/// Section 3.1 without a point: how the four balls are proposed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProposeConfig {
    /// How each candidate is learnt.
    pub learn: LearnConfig,
    /// At most about so many pixels of a picture are looked at for seeds. 19,200 is every fourth
    /// column and row of 640 x 480: balls from 8 pixels across are met.
    pub grid_samples: u32,
    /// The least quality of a candidate, 0 to 1.
    pub least_quality: f32,
    /// How much larger the largest of the four may be than the smallest: they are equal balls, and
    /// the frame is small beside its distance.
    pub size_ratio: f32,
    /// The greatest distance between two balls, in their diameters.
    pub spread: f32,
    /// Lengths of the arms E1, E2, E3, in any unit.
    pub arms: [f32; 3],
    /// How far the four may be from a frame of right angles seen from afar: abs(sum z^2) / sum
    /// abs(z)^2 of the arms' projections, 0 to 1. Perspective makes it up to 0.17 where arms of 0.2 m are
    /// seen from 1 m, and 0.08 for arms of 80 mm; four scattered balls have 0.5 or so.
    pub skew: f32,
    /// By what ratio the arm in ball diameters may differ between two views.
    pub arm_ratio: f32,
    /// Share of the best score from which on the next best makes it ambiguous.
    pub ambiguity: f32,
}

impl Default for ProposeConfig {
    fn default() -> Self {
        Self {
            learn: LearnConfig::default(),
            grid_samples: 19_200,
            least_quality: 0.05,
            size_ratio: 2.0,
            spread: 20.0,
            arms: [1.0; 3],
            skew: 0.25,
            arm_ratio: 1.4,
            ambiguity: 0.95,
        }
    }
}

/// The shortest arm the hand stages accept, metres: below it the balls themselves would touch.
pub const MIN_ARM_M: f32 = 0.005;

/// The longest arm the hand stages accept, metres. A hand-held frame is a tenth of it; the bound is
/// there to catch an arm given in millimetres.
pub const MAX_ARM_M: f32 = 2.0;

/// Thresholds of the hand stages ([`crate::hand`]).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HandConfig {
    /// The least ratio of the smallest to the largest singular value of M (eq. 7), no unit.
    ///
    /// For two cameras an angle t apart it is sin(t / 2), and its inverse is how much worse depth
    /// is known than the sideways place. 0.03 is 3.4 degrees, or cameras 6 cm apart at 1 m.
    pub min_conditioning: f32,
    /// The least length in pixels of each arm in the view that shows it longest.
    ///
    /// At 2 px the 0.1 px of a ball's centre (section 5) is 7 % of the arm's length.
    pub min_arm_px: f32,
    /// The least sine of the angle between an arm and what the arms before it span, no unit.
    ///
    /// The arms of a feature frame are at right angles (section 4), so it is near 1 for a real
    /// one; 0.5 is 30 degrees, which only wrong centres give.
    pub min_arm_sine: f32,
    /// The most frames after the last complete one for which a prediction is made (section 3.5).
    ///
    /// Five is a sixth of a second at 30 frames/s, about what a hand takes to turn round.
    pub max_predicted_frames: u32,
}

impl Default for HandConfig {
    fn default() -> Self {
        Self { min_conditioning: 0.03, min_arm_px: 2.0, min_arm_sine: 0.5, max_predicted_frames: 5 }
    }
}
