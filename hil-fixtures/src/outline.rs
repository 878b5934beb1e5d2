//! The outline of a thing in a picture, as exact intervals on horizontal lines.
//!
//! Every thing is convex, so a line cuts it in one interval. Renderer and ground truth use the same
//! intervals, which is why they agree.

use crate::camera::Camera;
use nalgebra::Vector3;

/// Horizontal lines per pixel row on which intervals are taken. Along a line coverage is exact, so
/// only the direction across lines is sampled.
pub(crate) const LINES_PER_ROW: usize = 16;

/// A convex outline in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outline {
    Sphere(SphereOutline),
    Capsule(CapsuleOutline),
}

impl Outline {
    /// Where the horizontal line at `y` enters and leaves the outline.
    pub(crate) fn interval(&self, y: f64) -> Option<(f64, f64)> {
        match self {
            Self::Sphere(s) => s.interval(y),
            Self::Capsule(c) => c.interval(y),
        }
    }

    /// Least and greatest x, least and greatest y.
    pub(crate) fn bounds(&self) -> [f64; 4] {
        match self {
            Self::Sphere(s) => s.bounds,
            Self::Capsule(c) => c.bounds(),
        }
    }
}

/// The picture of a sphere: an ellipse, exactly.
///
/// A ray d = (X, Y, 1) meets the sphere of centre C and radius R when (d.C)^2 >= k |d|^2, with
/// k = |C|^2 - R^2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereOutline {
    centre_in_camera: Vector3<f64>,
    k: f64,
    focal: f64,
    principal: (f64, f64),
    /// Least and greatest x, least and greatest y.
    pub(crate) bounds: [f64; 4],
    /// The centre of the ellipse, pixels: not the picture of the sphere's centre.
    pub(crate) centre: (f64, f64),
    /// The diameter of the disc of equal area, pixels.
    pub(crate) diameter: f64,
}

impl SphereOutline {
    /// `None` when the sphere is not wholly in front of the camera.
    pub(crate) fn new(camera: &Camera, centre_in_camera: Vector3<f64>, radius: f64) -> Option<Self> {
        let c = centre_in_camera;
        let r2 = radius * radius;
        let depth = c.z * c.z - r2;
        if c.z <= radius || radius <= 0.0 {
            return None;
        }
        let k = c.norm_squared() - r2;
        let (focal, principal) = (camera.focal_px, camera.principal_px);
        let centre = (principal.0 + focal * c.x * c.z / depth, principal.1 + focal * c.y * c.z / depth);
        // semi-axes: R sqrt(k) / depth along the line to the principal point, R / sqrt(depth) across
        let along = radius * libm::sqrt(k) / depth;
        let across = radius / libm::sqrt(depth);
        // where the discriminants of the conic vanish
        let half_x = focal * radius * libm::sqrt(c.x * c.x + depth) / depth;
        let half_y = focal * radius * libm::sqrt(c.y * c.y + depth) / depth;
        Some(Self {
            centre_in_camera: c,
            k,
            focal,
            principal,
            bounds: [centre.0 - half_x, centre.0 + half_x, centre.1 - half_y, centre.1 + half_y],
            centre,
            diameter: 2.0 * focal * libm::sqrt(along * across),
        })
    }

    fn interval(&self, y: f64) -> Option<(f64, f64)> {
        let c = &self.centre_in_camera;
        let yn = (y - self.principal.1) / self.focal;
        let m = yn * c.y + c.z;
        // a X^2 + 2 b X + e >= 0 between its roots, for a < 0
        let a = c.x * c.x - self.k;
        let b = c.x * m;
        let e = m * m - self.k * (yn * yn + 1.0);
        let discriminant = b * b - a * e;
        if discriminant <= 0.0 {
            return None;
        }
        let root = libm::sqrt(discriminant);
        let (left, right) = ((-b + root) / a, (-b - root) / a);
        Some((self.principal.0 + self.focal * left, self.principal.0 + self.focal * right))
    }
}

/// Two discs and all that lies between them: a finger or a rod.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CapsuleOutline {
    ends: [Point; 2],
    radii: [f64; 2],
    /// From the first end to the second, and one over its squared length (0 for a disc).
    along: Point,
    per_length2: f64,
    /// The two straight sides, each from its upper to its lower point; none when one disc holds the
    /// other.
    sides: Option<[(Point, Point); 2]>,
}

type Point = (f64, f64);

impl CapsuleOutline {
    pub(crate) fn new(ends: [Point; 2], radii: [f64; 2]) -> Self {
        let [a, b] = ends;
        let [r, s] = radii;
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let length = libm::sqrt(dx * dx + dy * dy);
        let sides = (length > (r - s).abs()).then(|| {
            // a side touches both discs where its normal does: leaning forward by `slope`
            let (ux, uy) = (dx / length, dy / length);
            let slope = (r - s) / length;
            let rise = libm::sqrt(1.0 - slope * slope);
            [-rise, rise].map(|rise| {
                let normal = (ux * slope - uy * rise, uy * slope + ux * rise);
                let p = (a.0 + r * normal.0, a.1 + r * normal.1);
                let q = (b.0 + s * normal.0, b.1 + s * normal.1);
                if p.1 <= q.1 { (p, q) } else { (q, p) }
            })
        });
        let per_length2 = if length > 0.0 { 1.0 / (length * length) } else { 0.0 };
        Self { ends, radii, along: (dx, dy), per_length2, sides }
    }

    fn bounds(&self) -> [f64; 4] {
        let [a, b] = self.ends;
        let [r, s] = self.radii;
        [(a.0 - r).min(b.0 - s), (a.0 + r).max(b.0 + s), (a.1 - r).min(b.1 - s), (a.1 + r).max(b.1 + s)]
    }

    fn interval(&self, y: f64) -> Option<(f64, f64)> {
        let mut found: Option<(f64, f64)> = None;
        let mut take = |l: f64, r: f64| {
            found = Some(found.map_or((l, r), |(a, b)| (a.min(l), b.max(r))));
        };
        for (end, radius) in self.ends.iter().zip(self.radii) {
            let dy = y - end.1;
            let half2 = radius * radius - dy * dy;
            if half2 > 0.0 {
                let half = libm::sqrt(half2);
                take(end.0 - half, end.0 + half);
            }
        }
        for (upper, lower) in self.sides.iter().flatten() {
            if y >= upper.1 && y < lower.1 {
                let x = upper.0 + (lower.0 - upper.0) * (y - upper.1) / (lower.1 - upper.1);
                take(x, x);
            }
        }
        found
    }

    /// The square of how far from the axis a point is: 0 on it and 1 at the rim and beyond.
    pub(crate) fn off_axis_squared(&self, x: f64, y: f64) -> f64 {
        let (a, d) = (self.ends[0], self.along);
        let (ex, ey) = (x - a.0, y - a.1);
        let along = ((ex * d.0 + ey * d.1) * self.per_length2).clamp(0.0, 1.0);
        let (ex, ey) = (ex - along * d.0, ey - along * d.1);
        let radius = self.radii[0] + along * (self.radii[1] - self.radii[0]);
        ((ex * ex + ey * ey) / (radius * radius)).min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Area and centroid by lines as the renderer takes them.
    fn moments(outline: &Outline) -> (f64, f64, f64) {
        let [.., top, bottom] = outline.bounds();
        let lines = ((bottom - top) * LINES_PER_ROW as f64) as usize;
        let step = (bottom - top) / lines as f64;
        let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
        for i in 0..lines {
            let at = top + step * (i as f64 + 0.5);
            if let Some((l, r)) = outline.interval(at) {
                area += (r - l) * step;
                x += (r - l) * step * (l + r) / 2.0;
                y += (r - l) * step * at;
            }
        }
        (area, x / area, y / area)
    }

    #[test]
    fn lines_add_up_to_the_ellipse() {
        let camera = Camera::looking_at(Vector3::x(), Vector3::zeros(), 800.0, 640, 480);
        for (x, y, z, r) in [(0.0, 0.0, 1.0, 0.01), (0.3, -0.2, 0.9, 0.04), (-0.35, 0.25, 0.7, 0.003)] {
            let sphere = SphereOutline::new(&camera, Vector3::new(x, y, z), r).expect("in front");
            let (area, u, v) = moments(&Outline::Sphere(sphere));
            let ideal = core::f64::consts::PI * sphere.diameter * sphere.diameter / 4.0;
            assert!((area / ideal - 1.0).abs() < 1e-3, "{area} {ideal}");
            let off = (u - sphere.centre.0).abs().max((v - sphere.centre.1).abs());
            assert!(off < 1e-6, "{off}");
        }
        assert!(SphereOutline::new(&camera, Vector3::new(0.0, 0.0, 0.005), 0.01).is_none());
    }

    #[test]
    fn a_sphere_on_the_axis_is_a_disc_at_the_principal_point() {
        let camera = Camera::looking_at(Vector3::x(), Vector3::zeros(), 800.0, 640, 480);
        let sphere = SphereOutline::new(&camera, Vector3::new(0.0, 0.0, 1.0), 0.01).expect("in front");
        assert_eq!(sphere.centre, (319.5, 239.5));
        // tan(asin(r / z)), twice, times the focal length
        let ideal = 1600.0 * 0.01 / libm::sqrt(1.0 - 0.0001);
        assert!((sphere.diameter - ideal).abs() < 1e-9);
        let [left, right, top, bottom] = sphere.bounds;
        for side in [right - left, bottom - top] {
            assert!((side - ideal).abs() < 1e-9);
        }
    }

    #[test]
    fn a_capsule_is_two_half_discs_and_a_rectangle() {
        for (dx, dy) in [(40.0, 0.0), (0.0, 40.0), (24.0, 32.0), (24.0, -32.0)] {
            let capsule = CapsuleOutline::new([(100.0, 100.0), (100.0 + dx, 100.0 + dy)], [10.0, 10.0]);
            let (area, x, y) = moments(&Outline::Capsule(capsule));
            let ideal = 100.0 * core::f64::consts::PI + 800.0;
            assert!((area / ideal - 1.0).abs() < 1e-3, "{dx} {dy}: {area} {ideal}");
            assert!((x - 100.0 - dx / 2.0).abs() < 1e-2 && (y - 100.0 - dy / 2.0).abs() < 1e-2);
        }
        let one_in_the_other = CapsuleOutline::new([(100.0, 100.0), (103.0, 100.0)], [10.0, 2.0]);
        assert!((moments(&Outline::Capsule(one_in_the_other)).0 - 100.0 * core::f64::consts::PI).abs() < 0.3);
    }
}
