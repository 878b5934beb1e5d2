//! The refined centre ([`crate::vision::rim`]).

/// Which centre is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CentreMode {
    /// The paper's: eq. 2 over the rows' edges, eq. 3 where a ball hides another.
    RowEdge,
    /// The rim to a small part of a pixel, and a robust curve through it.
    #[default]
    Refined,
}

/// The centre of a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CentreConfig {
    /// Which centre is measured.
    pub mode: CentreMode,
    /// The most times the rim is scanned, each time around the last fit.
    pub passes: u8,
    /// A fit that moves the centre and the radius no more than this is not repeated, pixels: a scan
    /// has so much to spare on either side.
    pub settled_pixels: f32,
    /// A curve that is thought to be nearer than this to the rim is scanned with the least reach,
    /// pixels.
    pub near_pixels: f32,
    /// How far inside the expected rim a scan starts, pixels; half the radius of small balls.
    pub inside_pixels: i32,
    /// How far outside it ends, pixels: two of background beyond the blur of the rim, and no more,
    /// since what is behind a ball is not one colour.
    pub outside_pixels: i32,
    /// By how much of the movement since the last frame scans reach farther in and out: half of what
    /// is blurred where the shutter is open a quarter of the time.
    pub blur_share: f32,
    /// The most by which they do, pixels.
    pub most_blur: f32,
    /// From this roundness on a blob may be a ball in even light.
    pub round: f32,
    /// From this share of the rim on there is nothing to ask about it ...
    pub clear_visible: f32,
    /// ... and below it, where it is more than this under the share of the area that was matched,
    /// another start is tried.
    pub share_slack: f32,
    /// A blob whose width and height are within so many pixels ...
    pub warm_pixels: f32,
    /// ... and this share of the last one's starts from where the last rim was.
    pub warm_share: f32,
    /// How far the radius may be from the remembered one where rays look for the rim, a ratio.
    pub known_range: f32,
    /// The same where none is remembered but the row edges' diameter.
    pub unknown_range: f32,
    /// How far the radius is thought to change between frames: this share ...
    pub radius_share: f32,
    /// ... and so many pixels.
    pub radius_pixels: f32,
    /// How far it may be from the rays' first circle, as a share, where nothing is remembered.
    pub unknown_share: f32,
    /// How far the rim may be from a circle, as a share of the radius: perspective at the edge of a
    /// wide picture.
    pub harmonic_share: f32,
    /// Fewest edges on the curve.
    pub least_edges: u32,
    /// The least share of the rim on the curve.
    pub least_visible: f32,
    /// From this share on the radius is remembered.
    pub whole_visible: f32,
    /// What no fit is better than, pixels: measured.
    pub floor_pixels: f32,
    /// How much more the variance of the centre is than the edges' residuals say, since what is
    /// behind a ball moves its whole rim: measured on plain and cluttered scenes ...
    pub inflation: f32,
    /// ... and so much more where all of the rim were hidden, in proportion to what is.
    pub hidden_inflation: f32,
}

impl CentreConfig {
    /// The paper's centre.
    #[must_use]
    pub fn paper() -> Self {
        Self { mode: CentreMode::RowEdge, ..Self::default() }
    }
}

impl CentreConfig {
    /// Whether every number is finite and none negative.
    pub(super) fn is_usable(&self) -> bool {
        let numbers = [
            self.settled_pixels,
            self.near_pixels,
            self.blur_share,
            self.most_blur,
            self.round,
            self.clear_visible,
            self.share_slack,
            self.warm_pixels,
            self.warm_share,
            self.known_range,
            self.unknown_range,
            self.radius_share,
            self.radius_pixels,
            self.unknown_share,
            self.harmonic_share,
            self.least_visible,
            self.whole_visible,
            self.floor_pixels,
            self.inflation,
            self.hidden_inflation,
        ];
        numbers.iter().all(|x| x.is_finite() && *x >= 0.0)
            && (0..=8).contains(&self.inside_pixels)
            && (2..=8).contains(&self.outside_pixels)
            && self.passes >= 1
    }
}

impl Default for CentreConfig {
    fn default() -> Self {
        Self {
            mode: CentreMode::Refined,
            passes: 5,
            settled_pixels: 0.5,
            near_pixels: 1.0,
            inside_pixels: 2,
            outside_pixels: 3,
            blur_share: 0.12,
            most_blur: 2.0,
            round: 0.8,
            clear_visible: 0.85,
            share_slack: 0.15,
            warm_pixels: 1.5,
            warm_share: 0.1,
            known_range: 1.15,
            unknown_range: 1.8,
            radius_share: 0.01,
            radius_pixels: 0.03,
            unknown_share: 0.3,
            harmonic_share: 0.01,
            least_edges: 6,
            least_visible: 0.15,
            whole_visible: 0.75,
            floor_pixels: 0.004,
            inflation: 1.4,
            hidden_inflation: 2.5,
        }
    }
}
