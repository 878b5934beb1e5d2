//! Where a point is, in the axes of the feature frame, from two or more uncalibrated views: the
//! affine invariant of section 4 (eq. 5 to 8).
//!
//! Under weak perspective a point alpha (metres, in the axes of the reference frame R(t)) is seen
//! at `x = x_0 + M alpha`, where M's columns `(x_i - x_0) / l_i` are the pictures of the unit
//! vectors E_i in px per metre. One view gives two equations for three unknowns; n views give 2n,
//! solved by least squares. No camera is calibrated, and none is told apart.

use crate::config::{HandConfig, MAX_ARM_M, MAX_VIEWS, MIN_ARM_M};
use crate::geometry::ImagePoint;
use crate::observation::BALLS;
use nalgebra::{Matrix3, Vector3};

#[cfg(test)]
mod tests;

/// The centres of the four balls in one picture, px, ordered as [`crate::observation::Ball::ALL`].
pub type Centres = [ImagePoint; BALLS];

/// Why no place could be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AffineRefusal {
    /// An arm's length is not between [`MIN_ARM_M`] and [`MAX_ARM_M`] metres.
    BadArmLength,
    /// Fewer than two views: two equations for three unknowns (section 4).
    TooFewViews,
    /// More than [`MAX_VIEWS`] views.
    TooManyViews,
    /// The number of points is not the number of reference views.
    UnequalViews,
    /// A centre, or what follows from it, is not a finite number.
    NotFinite,
    /// A ball and the red one coincide in every view.
    CoincidentBalls,
    /// The views do not fix all three directions: they look along (nearly) parallel lines, or
    /// the balls lie in (nearly) one plane.
    IllConditioned,
}

impl core::fmt::Display for AffineRefusal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::BadArmLength => "an arm length is not between 0.005 and 2 metres",
            Self::TooFewViews => "a place needs at least two views",
            Self::TooManyViews => "more views than there may be",
            Self::UnequalViews => "a point must be given in each of the reference views",
            Self::NotFinite => "a ball centre is not a finite number",
            Self::CoincidentBalls => "a ball and the red ball coincide in every view",
            Self::IllConditioned => "the views are too nearly parallel, or the balls lie in one plane",
        })
    }
}

impl core::error::Error for AffineRefusal {}

/// The distances of the green, blue and yellow ball from the red one: l_1, l_2, l_3 in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arms {
    lengths_m: [f32; 3],
}

impl Arms {
    /// Three lengths in metres.
    ///
    /// # Errors
    /// [`AffineRefusal::BadArmLength`] outside [`MIN_ARM_M`] to [`MAX_ARM_M`].
    pub fn new(lengths_m: [f32; 3]) -> Result<Self, AffineRefusal> {
        // NaN is in no range
        if lengths_m.iter().all(|l| (MIN_ARM_M..=MAX_ARM_M).contains(l)) {
            Ok(Self { lengths_m })
        } else {
            Err(AffineRefusal::BadArmLength)
        }
    }

    /// Three arms of one length in metres.
    ///
    /// # Errors
    /// As [`Arms::new`].
    pub fn equal(length_m: f32) -> Result<Self, AffineRefusal> {
        Self::new([length_m; 3])
    }

    /// l_1, l_2, l_3 in metres.
    #[must_use]
    pub const fn lengths_m(&self) -> [f32; 3] {
        self.lengths_m
    }

    /// The four balls in the axes of their own feature frame, metres: the origin and l_i E_i.
    #[must_use]
    pub fn balls_in_frame(&self) -> [Vector3<f32>; BALLS] {
        let [l1, l2, l3] = self.lengths_m;
        [Vector3::zeros(), Vector3::new(l1, 0.0, 0.0), Vector3::new(0.0, l2, 0.0), Vector3::new(0.0, 0.0, l3)]
    }
}

/// One camera's picture of the reference frame: two rows of M and where its origin is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AffineView {
    /// x_0, px.
    origin: ImagePoint,
    /// e_1, e_2, e_3: the pictures of the unit vectors, px per metre.
    axes: [ImagePoint; 3],
}

impl AffineView {
    /// The view in which the four balls of the reference frame have these centres.
    #[must_use]
    pub fn new(centres: &Centres, arms: Arms) -> Self {
        let [origin, c1, c2, c3] = *centres;
        let [l1, l2, l3] = arms.lengths_m;
        let axis = |centre: ImagePoint, length_m: f32| (centre - origin) * (1.0 / length_m);
        Self { origin, axes: [axis(c1, l1), axis(c2, l2), axis(c3, l3)] }
    }

    /// Where this camera sees the point alpha (metres, in the axes of the reference frame): eq. 6.
    #[must_use]
    pub fn project(&self, alpha: &Vector3<f32>) -> ImagePoint {
        let [e1, e2, e3] = self.axes;
        self.origin + e1 * alpha.x + e2 * alpha.y + e3 * alpha.z
    }

    /// The two rows of M this camera gives (eq. 6), px per metre.
    fn rows(&self) -> [Vector3<f32>; 2] {
        let [e1, e2, e3] = self.axes;
        [Vector3::new(e1.u, e2.u, e3.u), Vector3::new(e1.v, e2.v, e3.v)]
    }
}

/// A point solved for (eq. 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// The point's coordinates along E_1, E_2, E_3 of the reference frame, metres.
    pub alpha: Vector3<f32>,
    /// The root mean square, over the 2n image coordinates, of measured minus projected, px.
    ///
    /// With two views there is one equation too many, so it is half of the centres' own error.
    pub residual_px: f32,
}

/// A reference frame seen by two to eight cameras, ready to locate points in its axes.
#[derive(Clone, Debug)]
pub struct AffineFrame {
    views: heapless::Vec<AffineView, MAX_VIEWS>,
    /// (M^t M)^-1, m^2 per px^2.
    inverse: Matrix3<f32>,
    conditioning: f32,
}

impl AffineFrame {
    /// Builds M^t M from the four balls of the reference frame in each view and checks that it
    /// can be inverted.
    ///
    /// # Errors
    /// Any [`AffineRefusal`] but `BadArmLength` and `UnequalViews`.
    pub fn new(reference: &[Centres], arms: Arms, config: &HandConfig) -> Result<Self, AffineRefusal> {
        if reference.len() < 2 {
            return Err(AffineRefusal::TooFewViews);
        }
        if reference.iter().flatten().any(|centre| !centre.is_finite()) {
            return Err(AffineRefusal::NotFinite);
        }
        if !every_arm_is_seen(reference, config.min_arm_px) {
            return Err(AffineRefusal::CoincidentBalls);
        }
        let mut views = heapless::Vec::new();
        let mut normal = Matrix3::zeros();
        for centres in reference {
            let view = AffineView::new(centres, arms);
            for row in view.rows() {
                normal += row * row.transpose();
            }
            views.push(view).map_err(|_| AffineRefusal::TooManyViews)?;
        }
        let conditioning = singular_value_ratio(&normal).ok_or(AffineRefusal::NotFinite)?;
        match normal.try_inverse() {
            Some(inverse) if conditioning >= config.min_conditioning => {
                Ok(Self { views, inverse, conditioning })
            }
            _ => Err(AffineRefusal::IllConditioned),
        }
    }

    /// The smallest over the largest singular value of M, 0 to 1: the worst direction's share of
    /// the best one's accuracy.
    #[must_use]
    pub const fn conditioning(&self) -> f32 {
        self.conditioning
    }

    /// Where the point is that the cameras see at `points`, one for each reference view in the
    /// same order: the least squares solution of eq. 8.
    ///
    /// # Errors
    /// [`AffineRefusal::UnequalViews`] or [`AffineRefusal::NotFinite`].
    pub fn locate(&self, points: &[ImagePoint]) -> Result<Located, AffineRefusal> {
        if points.len() != self.views.len() {
            return Err(AffineRefusal::UnequalViews);
        }
        let mut right_hand_side = Vector3::zeros();
        for (view, point) in self.views.iter().zip(points) {
            // the paper prints x_0 on the left of eq. 7; eq. 6 makes it x - x_0
            let offset = *point - view.origin;
            let [row_u, row_v] = view.rows();
            right_hand_side += row_u * offset.u + row_v * offset.v;
        }
        let alpha = self.inverse * right_hand_side;

        let mut squares = 0.0;
        let mut coordinates = 0.0;
        for (view, point) in self.views.iter().zip(points) {
            let error = *point - view.project(&alpha);
            squares += error.u * error.u + error.v * error.v;
            coordinates += 2.0;
        }
        let residual_px = libm::sqrtf(squares / coordinates);
        if alpha.iter().all(|a| a.is_finite()) && residual_px.is_finite() {
            Ok(Located { alpha, residual_px })
        } else {
            Err(AffineRefusal::NotFinite)
        }
    }
}

/// Whether each of the three arms is at least so long in one view or another.
fn every_arm_is_seen(reference: &[Centres], min_px: f32) -> bool {
    let mut longest = [0.0_f32; 3];
    for [origin, ends @ ..] in reference {
        for (longest, end) in longest.iter_mut().zip(ends) {
            *longest = longest.max(end.distance(*origin));
        }
    }
    longest.iter().all(|l| *l >= min_px)
}

/// The smallest over the largest singular value of M, from M^t M; None when it is not a number.
///
/// The eigenvalues of a symmetric 3x3 matrix in closed form: with q the mean of the diagonal they
/// are q + 2 p cos(phi + 2 pi k / 3), where p and phi follow from the matrix less q I. An iterative
/// decomposition would do no better here and may not end.
fn singular_value_ratio(normal: &Matrix3<f32>) -> Option<f32> {
    use core::f32::consts::FRAC_PI_3;
    let q = (normal.m11 + normal.m22 + normal.m33) / 3.0;
    let scaled = normal / q;
    let deviation = scaled - Matrix3::identity();
    let p = libm::sqrtf(deviation.norm_squared() / 6.0);
    if !p.is_finite() {
        return None;
    }
    // eigenvalues equal to within rounding: no direction is worse than another
    if p < 1e-6 {
        return Some(1.0);
    }
    let r = ((deviation / p).determinant() / 2.0).clamp(-1.0, 1.0);
    let phi = libm::acosf(r) / 3.0;
    let largest = 1.0 + 2.0 * p * libm::cosf(phi);
    let smallest = 1.0 + 2.0 * p * libm::cosf(phi + 2.0 * FRAC_PI_3);
    // rounding may leave a singular matrix's smallest eigenvalue just below zero
    let ratio = libm::sqrtf(smallest.max(0.0) / largest);
    ratio.is_finite().then_some(ratio)
}
