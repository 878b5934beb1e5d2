//! The picture: things over the background, averaged over the exposure, with the sensor's noise.

use crate::background::fixed;
use crate::camera::Camera;
use crate::light::Lamp;
use crate::noise::SensorNoise;
use crate::outline::{LINES_PER_ROW, Outline};
use crate::scene::{Scene, Surface, Thing};
use nalgebra::Vector3;

/// Moments at which a moving scene is drawn within one exposure, at least.
const MOMENTS: usize = 8;

/// More moments, so that nothing moves farther than this from one to the next, pixels.
const STEP_PX: f64 = 0.5;

/// Movement below this within an exposure is none, pixels.
const STILL_PX: f64 = 1e-6;

/// Parts of the light's level.
const LEVEL_ONE: i32 = 1 << 12;

/// How much darker a finger is at its rim than at its middle.
const RIM_SHADE: f64 = 0.3;

impl Scene {
    /// Renders a frame as packed rows of RGB888 into `out`, whose memory is used again. Depends on
    /// nothing but the scene, the frame and the camera.
    ///
    /// # Panics
    /// When there is no such camera.
    pub fn render_rgb(&self, frame: usize, camera: usize, out: &mut Vec<u8>) {
        let (width, height) = (usize::from(self.width), usize::from(self.height));
        let backdrop = self.kept.get(&self.background, self.width, self.height, camera);
        let level = self.light.level_at(self.time_s(frame)).clamp(0.0, 8.0);
        let level_fixed = (level * f64::from(LEVEL_ONE) + 0.5) as i32;

        let moments = self.moments(frame, camera);
        let patches: Vec<Patch> = boxes(&moments, width, height)
            .into_iter()
            .map(|area| self.patch(area, &moments, camera, &backdrop, level))
            .collect();

        out.resize(width * height * 3, 0);
        let mut noise = SensorNoise::new(self.seed, frame, camera, self.noise_sigma);
        let mut row = vec![0u16; width * 3];
        let rows = backdrop.chunks_exact(width * 3).zip(out.chunks_exact_mut(width * 3));
        for (y, (behind, bytes)) in rows.enumerate() {
            if level_fixed == LEVEL_ONE {
                row.copy_from_slice(behind);
            } else {
                for (value, &behind) in row.iter_mut().zip(behind) {
                    // at most 65,535 * 2^15, below 2^31
                    *value = ((i32::from(behind) * level_fixed) >> 12).min(65_535) as u16;
                }
            }
            for patch in patches.iter().filter(|patch| patch.area.rows().contains(&y)) {
                patch.overlay(y, &mut row);
            }
            noise.develop(&row, bytes);
        }
    }

    /// What is before the camera at each moment of the exposure.
    fn moments(&self, frame: usize, camera: usize) -> Vec<Vec<Thing>> {
        let middle = self.time_s(frame);
        let at = |share: f64| self.things(camera, middle + self.exposure_s * (share - 0.5));
        let now = at(0.5);
        let moved = [at(0.0), at(1.0)].iter().map(|then| farthest(&now, then)).fold(0.0, f64::max);
        if moved < STILL_PX {
            return vec![now];
        }
        let count = MOMENTS.max((2.0 * moved / STEP_PX).min(64.0) as usize);
        (0..count).map(|i| at((i as f64 + 0.5) / count as f64)).collect()
    }

    /// The pixels of `area`: the background and all that is before it, averaged over the moments.
    fn patch(
        &self,
        area: Area,
        moments: &[Vec<Thing>],
        camera: usize,
        backdrop: &[u16],
        level: f64,
    ) -> Patch {
        let lamp = self.lamp(camera);
        let stride = usize::from(self.width) * 3;
        let behind: Vec<f64> = area
            .rows()
            .flat_map(|y| &backdrop[y * stride + 3 * area.left..y * stride + 3 * area.right])
            .map(|&value| f64::from(value) / 256.0)
            .collect();
        let mut sum = vec![0.0; behind.len()];
        let mut canvas = Vec::with_capacity(behind.len());
        for things in moments {
            canvas.clear();
            canvas.extend_from_slice(&behind);
            for thing in things {
                paint(thing, &self.cameras[camera], &lamp, &area, &mut canvas);
            }
            for (total, value) in sum.iter_mut().zip(&canvas) {
                *total += value;
            }
        }
        let scale = level / moments.len() as f64;
        Patch { area, values: sum.iter().map(|total| fixed(total * scale)).collect() }
    }
}

/// A rectangle of whole pixels, right and bottom excluded.
#[derive(Clone, Copy, Debug)]
struct Area {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

impl Area {
    fn rows(&self) -> core::ops::Range<usize> {
        self.top..self.bottom
    }

    fn touches(&self, other: &Self) -> bool {
        self.left <= other.right
            && other.left <= self.right
            && self.top <= other.bottom
            && other.top <= self.bottom
    }

    fn around(&self, other: &Self) -> Self {
        Self {
            left: self.left.min(other.left),
            right: self.right.max(other.right),
            top: self.top.min(other.top),
            bottom: self.bottom.max(other.bottom),
        }
    }
}

/// A part of the picture that is not background.
struct Patch {
    area: Area,
    values: Vec<u16>,
}

impl Patch {
    fn overlay(&self, y: usize, row: &mut [u16]) {
        let stride = 3 * (self.area.right - self.area.left);
        let start = (y - self.area.top) * stride;
        row[3 * self.area.left..3 * self.area.right].copy_from_slice(&self.values[start..start + stride]);
    }
}

/// How far the outlines of two lists are apart at most, pixels; far if they are not the same things.
fn farthest(now: &[Thing], then: &[Thing]) -> f64 {
    if now.len() != then.len() {
        return f64::from(u16::MAX);
    }
    let apart = |(a, b): (&Thing, &Thing)| {
        let (a, b) = (a.outline.bounds(), b.outline.bounds());
        a.iter().zip(b).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
    };
    now.iter().zip(then).map(apart).fold(0.0, f64::max)
}

/// Rectangles that hold every thing at every moment and do not touch each other.
fn boxes(moments: &[Vec<Thing>], width: usize, height: usize) -> Vec<Area> {
    let mut found: Vec<Area> = Vec::new();
    for thing in moments.iter().flatten() {
        let [left, right, top, bottom] = thing.outline.bounds();
        let low = |value: f64, end: usize| libm::floor(value + 0.5).clamp(0.0, end as f64) as usize;
        let high = |value: f64, end: usize| (libm::floor(value + 0.5) + 1.0).clamp(0.0, end as f64) as usize;
        let mut area = Area {
            left: low(left, width),
            right: high(right, width),
            top: low(top, height),
            bottom: high(bottom, height),
        };
        if area.left >= area.right || area.top >= area.bottom {
            continue;
        }
        while let Some(i) = found.iter().position(|other| area.touches(other)) {
            area = area.around(&found.swap_remove(i));
        }
        found.push(area);
    }
    found
}

/// Paints a thing over a canvas of `area`, each pixel by the share that the outline covers of it.
fn paint(thing: &Thing, camera: &Camera, lamp: &Lamp, area: &Area, canvas: &mut [f64]) {
    let [.., top, bottom] = thing.outline.bounds();
    let width = area.right - area.left;
    // change of the covered share from each pixel to the next, summed over the row's lines
    let mut change = vec![0.0; width + 2];
    for y in area.rows() {
        if (y as f64) + 0.5 <= top || (y as f64) - 0.5 >= bottom {
            continue;
        }
        let lines = lines(y, top, bottom);
        let Some((first, last)) = cover_row(&thing.outline, &lines, area, &mut change) else { continue };
        let row = &mut canvas[3 * (y - area.top) * width..][..3 * width];
        let mut covered = 0.0;
        for x in first..=last {
            covered += change[x];
            let share = covered.clamp(0.0, 1.0);
            if share < 1e-9 {
                continue;
            }
            let colour = colour_at(&thing.surface, camera, lamp, (area.left + x) as f64, y as f64);
            for (value, colour) in row[3 * x..3 * x + 3].iter_mut().zip(colour) {
                *value += share * (colour - *value);
            }
        }
        change[first..=last + 2].fill(0.0);
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
/// the last pixel (from the left of `area`) that may be covered. Pixel x reaches from x - 1/2 to
/// x + 1/2.
fn cover_row(
    outline: &Outline,
    lines: &[(f64, f64); LINES_PER_ROW],
    area: &Area,
    change: &mut [f64],
) -> Option<(usize, usize)> {
    let width = area.right - area.left;
    let mut touched: Option<(usize, usize)> = None;
    for &(y, weight) in lines {
        let Some((left, right)) = outline.interval(y) else { continue };
        let from_area = |x: f64| (x + 0.5 - area.left as f64).clamp(0.0, width as f64);
        let (left, right) = (from_area(left), from_area(right));
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

/// A surface's grey levels at a pixel's centre; outside the outline, those at the nearest rim.
fn colour_at(surface: &Surface, camera: &Camera, lamp: &Lamp, x: f64, y: f64) -> [f64; 3] {
    match *surface {
        Surface::Sphere { centre, radius, albedo } => {
            let ray = Vector3::new(
                (x - camera.principal_px.0) / camera.focal_px,
                (y - camera.principal_px.1) / camera.focal_px,
                1.0,
            )
            .normalize();
            let along = ray.dot(&centre);
            let inside = along * along - (centre.norm_squared() - radius * radius);
            let hit = ray * (along - libm::sqrt(inside.max(0.0)));
            lamp.reflected(albedo, &((hit - centre).normalize()), &-ray)
        }
        Surface::Round { outline, albedo } => {
            let shade = 1.0 - RIM_SHADE * outline.off_axis_squared(x, y);
            albedo.map(|a| a * shade)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::SphereOutline;

    #[test]
    fn every_pixel_has_its_exact_share_of_a_disc() {
        let camera = Camera::looking_at(Vector3::x(), Vector3::zeros(), 800.0, 640, 480);
        let area = Area { left: 300, right: 340, top: 220, bottom: 260 };
        for (x, y, radius) in [(0.0, 0.0, 0.003), (0.0003, 0.0004, 0.0031), (-0.0007, 0.0002, 0.01)] {
            let sphere =
                SphereOutline::new(&camera, Vector3::new(x, y, 1.0), radius).expect("in front of the camera");
            let [.., top, bottom] = sphere.bounds;
            let outline = Outline::Sphere(sphere);
            for row in area.rows() {
                let mut change = vec![0.0; area.right - area.left + 2];
                cover_row(&outline, &lines(row, top, bottom), &area, &mut change);
                let mut covered = 0.0;
                for column in area.left..area.right {
                    covered += change[column - area.left];
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
