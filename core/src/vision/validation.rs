//! The rules of section 3.5: does what was found look like a ball, and do the balls stand to each
//! other as they should?

use super::centre::{Blob, Clean};
use crate::config::{OcclusionConfig, ShapeConfig};
use crate::geometry::ImagePoint;
use crate::observation::BALLS;
use core::f32::consts::FRAC_PI_4;

/// The shape rule: area / (width x height) near pi/4 and height / width as learnt. For square pixels
/// this is the paper's area / d^2. Always true below the diameter from which digitisation allows it.
#[must_use]
pub fn shape_holds(blob: &Blob, aspect: f32, config: &ShapeConfig) -> bool {
    if blob.diameter < config.min_diameter {
        return true;
    }
    let (w, h) = (blob.diameter.max(1.0), blob.height.max(1.0));
    let slack = config.digitisation / w;
    let fill = blob.area / (w * h) / FRAC_PI_4;
    let stretch = h / w / aspect.max(1e-3);
    let limit = config.aspect_tolerance + slack;
    libm::fabsf(fill - 1.0) <= config.fill_tolerance + slack
        && blob.roundness >= config.min_roundness - slack
        && stretch <= limit
        && stretch * limit >= 1.0
}

/// Whether a blob is the whole ball: round, not cut by the picture, and not suddenly smaller than
/// when it was last seen whole (section 3.4: area and diameter against the last clean pass).
#[must_use]
pub fn is_whole(
    blob: &Blob,
    clean: &Clean,
    aspect: f32,
    shape: &ShapeConfig,
    occlusion: &OcclusionConfig,
) -> bool {
    let slack = shape.digitisation;
    !blob.cut
        && blob.area >= occlusion.area_share * clean.area - slack * clean.diameter
        && blob.diameter + slack >= occlusion.diameter_share * clean.diameter
        && blob.height + slack >= occlusion.diameter_share * clean.height
        && shape_holds(blob, aspect, shape)
}

/// d(measured, predicted) of section 3.5, divided by the number of pairs: the mean relative error
/// of the distances between every two of the four balls. `None` with fewer than two of them, or
/// where two coincide.
#[must_use]
pub fn geometric_mismatch(
    measured: &[Option<ImagePoint>; BALLS],
    predicted: &[Option<ImagePoint>; BALLS],
) -> Option<f32> {
    let (mut sum, mut pairs) = (0.0f32, 0u32);
    let all = || measured.iter().zip(predicted).enumerate();
    for (k, (x, x_star)) in all() {
        for (l, (y, y_star)) in all() {
            if l <= k {
                continue;
            }
            if let (Some(x), Some(y), Some(x_star), Some(y_star)) = (x, y, x_star, y_star) {
                let (is, should) = (x.distance(*y), x_star.distance(*y_star));
                let least = is.min(should);
                if least < 1.0 {
                    return None;
                }
                sum += libm::fabsf(is - should) / least;
                pairs += 1;
            }
        }
    }
    (pairs > 0).then(|| sum / pairs as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::TrackerConfig;
    use crate::vision::frame::Rgb;

    fn blob(w: f32, h: f32, fill: f32) -> Blob {
        Blob {
            centre: ImagePoint::new(50.0, 50.0),
            diameter: w,
            height: h,
            area: w * h * fill,
            matched: (w * h * fill) as u32,
            roundness: if libm::fabsf(fill - FRAC_PI_4) < 0.05 { 0.95 } else { 0.75 },
            colour: Rgb::default(),
            bounds: (40, 60, 40, 60),
            cut: false,
        }
    }

    #[test]
    fn discs_pass_and_squares_bars_and_half_discs_do_not() {
        let c = TrackerConfig::default().shape;
        assert!(shape_holds(&blob(16.0, 16.0, FRAC_PI_4), 1.0, &c));
        assert!(shape_holds(&blob(30.0, 40.0, FRAC_PI_4), 1.3, &c), "pixels that are not square");
        assert!(!shape_holds(&blob(16.0, 16.0, 1.0), 1.0, &c));
        assert!(!shape_holds(&blob(30.0, 15.0, FRAC_PI_4), 1.0, &c));
        assert!(!shape_holds(&blob(15.0, 30.0, FRAC_PI_4), 1.0, &c));
        assert!(!shape_holds(&blob(16.0, 16.0, 0.5), 1.0, &c));
        assert!(shape_holds(&blob(5.0, 5.0, 1.0), 1.0, &c), "too small to tell");
    }

    #[test]
    fn a_ball_that_shrinks_at_once_or_is_cut_is_not_whole() {
        let c = TrackerConfig::default();
        let clean = Clean::taught(20.0, 1.0);
        let whole = |b: &Blob| is_whole(b, &clean, 1.0, &c.shape, &c.occlusion);
        assert!(whole(&blob(20.0, 20.0, FRAC_PI_4)));
        assert!(whole(&blob(19.0, 19.0, FRAC_PI_4)));
        assert!(!whole(&blob(14.0, 14.0, FRAC_PI_4)));
        assert!(!whole(&Blob { cut: true, ..blob(20.0, 20.0, FRAC_PI_4) }));
    }

    #[test]
    fn mismatch_is_the_mean_over_the_pairs_and_symmetric() {
        let p = |u: f32, v: f32| Some(ImagePoint::new(u, v));
        let a = [p(0.0, 0.0), p(10.0, 0.0), p(0.0, 10.0), p(10.0, 10.0)];
        assert_eq!(geometric_mismatch(&a, &a), Some(0.0));
        let doubled = a.map(|x| x.map(|x| x * 2.0));
        assert!((geometric_mismatch(&a, &doubled).unwrap() - 1.0).abs() < 1e-6);
        assert_eq!(geometric_mismatch(&a, &doubled), geometric_mismatch(&doubled, &a));
        assert_eq!(geometric_mismatch(&[p(0.0, 0.0), None, None, None], &a), None);
        let coincide = [p(0.0, 0.0), p(0.0, 0.0), None, None];
        assert_eq!(geometric_mismatch(&coincide, &a), None);
    }
}
