//! A ball that is partly or wholly hidden: section 3.4 and eq. 3.

use super::centre::{Blob, Clean};
use super::colour::Matcher;
use super::frame::FrameView;
use crate::config::OcclusionConfig;
use crate::geometry::{ImagePoint, round_to_i32};
use core::f32::consts::FRAC_PI_4;

/// Step along the ray of eq. 3, pixels.
const RAY_STEP: f32 = 0.5;

/// A ball as the pair rule sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Where its visible part has its centre.
    pub centre: ImagePoint,
    /// Its visible area over that of the last clean pass.
    pub area_share: f32,
    /// Width and height when last seen whole.
    pub clean: Clean,
}

/// Whether two balls are closer than (D_x + D_y) / 2, so that one may hide the other.
#[must_use]
pub fn touch(
    x: ImagePoint,
    x_clean: &Clean,
    y: ImagePoint,
    y_clean: &Clean,
    config: &OcclusionConfig,
) -> bool {
    x.distance(y) < (mean_diameter(x_clean) + mean_diameter(y_clean)) * 0.5 + config.margin
}

/// Of two balls that [`touch`], whether `x` is the hidden one: the one that has lost more of its area
/// against the last clean pass.
#[must_use]
pub fn is_hidden_by(x: &Seen, y: &Seen, config: &OcclusionConfig) -> bool {
    x.area_share < y.area_share && x.area_share < config.hidden_under
}

/// Eq. 3: the true centre of ball X of which only a part shows beside ball Y, which is whole.
///
/// From Y's centre C along U towards X's visible part, X shows from Y's rim, D / 2 away, over D_E up
/// to its own far rim; its centre is half its diameter D_X back from there: C + U (D / 2 + D_E -
/// D_X / 2). The far rim is the last pixel on the ray that matches X. Where the visible centre all
/// but coincides with C there is no direction: then C itself.
#[must_use]
pub fn centre_behind(
    frame: &FrameView<'_>,
    matcher: &Matcher,
    x: &Blob,
    x_clean: &Clean,
    y_centre: ImagePoint,
    y_clean: &Clean,
    tested: &mut u32,
) -> ImagePoint {
    let towards = x.centre - y_centre;
    let length = x.centre.distance(y_centre);
    if length < 1.0 {
        return y_centre;
    }
    let unit = towards * (1.0 / length);
    let (d, d_x) = (mean_diameter(y_clean), mean_diameter(x_clean));
    // X's far rim cannot be further than its whole diameter beyond Y's rim.
    let farthest = d * 0.5 + d_x + 2.0;
    let mut far_rim = None;
    let mut at = 0.0f32;
    while at <= farthest {
        let p = y_centre + unit * at;
        let pixel = frame.pixel(round_to_i32(p.u), round_to_i32(p.v));
        *tested += 1;
        if pixel.is_some_and(|c| matcher.accepts(c)) {
            // The rim lies between this sample and the next.
            far_rim = Some(at + RAY_STEP * 0.5);
        }
        at += RAY_STEP;
    }
    match far_rim {
        Some(far) => {
            let d_e = far - d * 0.5;
            y_centre + unit * (d_e + 0.5 * (d - d_x))
        }
        None => x.centre,
    }
}

/// The centre of a ball that the picture's edge cuts: the rim that is inside, half the last clean
/// diameter away. May lie outside the picture.
#[must_use]
pub fn centre_beyond_the_edge(frame: &FrameView<'_>, blob: &Blob, clean: &Clean) -> ImagePoint {
    let (min_x, max_x, first_row, last_row) = blob.bounds;
    ImagePoint::new(
        inner_half(min_x, max_x, i32::from(frame.width()), clean.diameter, blob.centre.u),
        inner_half(first_row, last_row, i32::from(frame.height()), clean.height, blob.centre.v),
    )
}

fn inner_half(first: i32, last: i32, side: i32, extent: f32, measured: f32) -> f32 {
    match (first <= 0, last >= side - 1) {
        (true, false) => last as f32 + 0.5 - extent * 0.5,
        (false, true) => first as f32 - 0.5 + extent * 0.5,
        _ => measured,
    }
}

/// The diameter of the disc of the same area: steadier than the largest N_r.
fn mean_diameter(clean: &Clean) -> f32 {
    libm::sqrtf(clean.area / FRAC_PI_4)
}
