//! Teaching a colour: section 3.1, and the proposal that needs no point.

use super::MAX_DIAMETER;

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
