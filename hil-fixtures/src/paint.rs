//! Things painted over a row of the picture, with exact cover.

use crate::camera::Camera;
use crate::light::Lamp;
use crate::outline::{LINES_PER_ROW, Outline};
use crate::scene::{Albedo, Surface, Thing};
use core::ops::Range;

/// How much darker a finger is at its rim than at its middle.
const RIM_SHADE: f64 = 0.3;

/// Cover below this is rounding.
const NO_COVER: f64 = 1e-9;

/// Paints rows of things, each pixel by the share that an outline covers of it. A pixel has the
/// surface's colour at its centre, or at the nearest rim if that is outside.
pub(crate) struct Painter<'a> {
    camera: &'a Camera,
    lamp: Lamp,
    /// The columns painted.
    columns: Range<usize>,
    /// Change of the covered share from each pixel to the next, summed over the row's lines.
    change: Vec<f64>,
}

impl<'a> Painter<'a> {
    pub(crate) fn new(camera: &'a Camera, lamp: Lamp, columns: Range<usize>) -> Self {
        let change = vec![0.0; columns.len() + 2];
        Self { camera, lamp, columns, change }
    }

    /// Paints row `y` of a thing over `row`, three values a pixel.
    pub(crate) fn paint(&mut self, thing: &Thing, y: usize, row: &mut [f64]) {
        let (camera, lamp) = (self.camera, self.lamp);
        let pixel_y = y as f64;
        match thing.surface {
            Surface::Sphere { centre, radius, albedo } => {
                let k = centre.norm_squared() - radius * radius;
                self.cover(&thing.outline, y, row, |pixel_x| {
                    let ray = camera.ray_through(pixel_x, pixel_y);
                    let along = ray.dot(&centre);
                    let hit = ray * (along - libm::sqrt((along * along - k).max(0.0)));
                    lamp.reflected(albedo, &((hit - centre).normalize()), &-ray)
                });
            }
            Surface::Round { outline, albedo } => self.cover(&thing.outline, y, row, |pixel_x| {
                let shade = 1.0 - RIM_SHADE * outline.off_axis_squared(pixel_x, pixel_y);
                albedo.map(|a| a * shade)
            }),
        }
    }

    fn cover(&mut self, outline: &Outline, y: usize, row: &mut [f64], colour_at: impl Fn(f64) -> Albedo) {
        let Some((first, last)) = cover_row(outline, y, &self.columns, &mut self.change) else {
            return;
        };
        let pixels = row.as_chunks_mut::<3>().0[first..=last].iter_mut();
        let mut covered = 0.0;
        for (x, (pixel, step)) in (self.columns.start + first..).zip(pixels.zip(&self.change[first..=last])) {
            covered += step;
            if covered > NO_COVER {
                let share = f64::min(covered, 1.0);
                for (value, colour) in pixel.iter_mut().zip(colour_at(x as f64)) {
                    *value += share * (colour - *value);
                }
            }
        }
        self.change[first..=last + 2].fill(0.0);
    }
}

/// The height and weight of each line on which a row's cover is taken; the weights add up to the
/// part of the row between `top` and `bottom`, the outline's highest and lowest points.
fn lines(y: usize, top: f64, bottom: f64) -> [(f64, f64); LINES_PER_ROW] {
    let (upper, lower) = (y as f64 - 0.5, y as f64 + 0.5);
    let (from, to) = (upper.max(top), lower.min(bottom));
    let (height, n) = ((to - from).max(0.0), LINES_PER_ROW as f64);
    core::array::from_fn(|i| {
        let share = (i as f64 + 0.5) / n;
        // An outline widens as a square root from its highest point: lines at the squares of even
        // steps make that a straight line, which the sum gets right.
        match (top > upper, bottom < lower) {
            (true, false) => (from + height * share * share, height * 2.0 * share / n),
            (false, true) => (to - height * share * share, height * 2.0 * share / n),
            _ => (from + height * share, height / n),
        }
    })
}

/// Adds up the exact cover of a row's lines as changes from pixel to pixel, and returns the first and
/// the last pixel (from the first column) that may be covered. Pixel x reaches from x - 1/2 to
/// x + 1/2.
fn cover_row(
    outline: &Outline,
    y: usize,
    columns: &Range<usize>,
    change: &mut [f64],
) -> Option<(usize, usize)> {
    let [.., top, bottom] = outline.bounds();
    if y as f64 + 0.5 <= top || y as f64 - 0.5 >= bottom {
        return None;
    }
    let width = columns.len();
    let mut touched: Option<(usize, usize)> = None;
    for (y, weight) in lines(y, top, bottom) {
        let Some((left, right)) = outline.interval(y) else { continue };
        let from_first = |x: f64| (x + 0.5 - columns.start as f64).clamp(0.0, width as f64);
        let (left, right) = (from_first(left), from_first(right));
        if left >= right {
            continue;
        }
        for (edge, sign) in [(left, weight), (right, -weight)] {
            let pixel = edge as usize;
            let into = edge - pixel as f64;
            change[pixel] += sign * (1.0 - into);
            change[pixel + 1] += sign * into;
        }
        let (first, last) = (left as usize, (right as usize).min(width - 1));
        touched = Some(touched.map_or((first, last), |(a, b)| (a.min(first), b.max(last))));
    }
    touched
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::SphereOutline;
    use nalgebra::Vector3;

    #[test]
    fn every_pixel_has_its_exact_share_of_a_disc() {
        let camera = Camera::looking_at(Vector3::x(), Vector3::zeros(), 800.0, 640, 480);
        let columns = 300..340;
        for (x, y, radius) in [(0.0, 0.0, 0.003), (0.0003, 0.0004, 0.0031), (-0.0007, 0.0002, 0.01)] {
            let sphere =
                SphereOutline::new(&camera, Vector3::new(x, y, 1.0), radius).expect("in front of the camera");
            let outline = Outline::Sphere(sphere);
            for row in 220..260 {
                let mut change = vec![0.0; columns.len() + 2];
                cover_row(&outline, row, &columns, &mut change);
                let mut covered = 0.0;
                for column in columns.clone() {
                    covered += change[column - columns.start];
                    let expected = share_of_disc(&sphere, column as f64, row as f64);
                    assert!((covered - expected).abs() < 0.002, "{column}, {row}: {covered}, {expected}");
                }
            }
        }
    }

    /// By counting 200 x 200 points; so near the axis the outline is a circle to 1e-5 px.
    fn share_of_disc(sphere: &SphereOutline, x: f64, y: f64) -> f64 {
        let step = |i: i32| (f64::from(i) + 0.5) / 200.0 - 0.5;
        let inside = |dx: f64, dy: f64| dx * dx + dy * dy < sphere.diameter * sphere.diameter / 4.0;
        let (x, y) = (x - sphere.centre.0, y - sphere.centre.1);
        let count = (0..40_000).filter(|&i| inside(x + step(i % 200), y + step(i / 200))).count();
        count as f64 / 40_000.0
    }
}
