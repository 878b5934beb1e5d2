//! The picture: things over the background, averaged over the exposure, with the sensor's noise.

use crate::background::fixed;
use crate::noise::SensorNoise;
use crate::paint::Painter;
use crate::scene::{Scene, Thing};

/// Moments at which a moving scene is drawn within one exposure, at least.
const MOMENTS: usize = 8;

/// More moments, so that nothing moves farther than this from one to the next, pixels.
const STEP_PX: f64 = 0.5;

/// Movement below this within an exposure is none, pixels.
const STILL_PX: f64 = 1e-6;

/// Parts of the light's level.
const LEVEL_ONE: i32 = 1 << 12;

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
        let columns = area.left..area.right;
        let mut painter = Painter::new(&self.cameras[camera], self.lamp(camera), columns.clone());
        let scale = level / moments.len() as f64;
        let stride = 3 * usize::from(self.width);
        let mut values = Vec::with_capacity(3 * columns.len() * area.rows().len());
        let [mut behind, mut row, mut sum] = [const { Vec::new() }; 3];
        // row by row, so that all moments of a row stay in the nearest cache
        for y in area.rows() {
            let here = y * stride + 3 * columns.start..y * stride + 3 * columns.end;
            behind.clear();
            behind.extend(backdrop[here].iter().map(|&value| f64::from(value) / 256.0));
            sum.clear();
            sum.resize(behind.len(), 0.0);
            for things in moments {
                row.clone_from(&behind);
                for thing in things {
                    painter.paint(thing, y, &mut row);
                }
                for (total, value) in sum.iter_mut().zip(&row) {
                    *total += value;
                }
            }
            values.extend(sum.iter().map(|total| fixed(total * scale)));
        }
        Patch { area, values }
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
