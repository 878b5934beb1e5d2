//! Seeded random numbers, and the sensor's noise.
//!
//! The generator is PCG XSH RR 64/32, whose output for a state is fixed by its publication; nothing
//! here uses a distribution of another crate, whose algorithm might change.

use crate::golden::Fnv1a;
use core::f64::consts::TAU;
use rand_pcg::{Pcg32, rand_core::Rng as _};
use std::sync::OnceLock;

/// Numbers that depend on a purpose, a seed and a few indices, and on nothing else: frames can be
/// rendered in any order.
pub(crate) struct Seeded(Pcg32);

impl Seeded {
    pub(crate) fn new(purpose: &str, seed: u64, indices: &[u64]) -> Self {
        let mut key = Fnv1a::default();
        key.write(&seed.to_le_bytes());
        for index in indices {
            key.write(&index.to_le_bytes());
        }
        let mut stream = Fnv1a::default();
        stream.write(purpose.as_bytes());
        Self(Pcg32::new(key.finish(), stream.finish()))
    }

    pub(crate) fn next_u32(&mut self) -> u32 {
        self.0.next_u32()
    }

    /// Evenly between 0 and 1, both excluded.
    pub(crate) fn unit(&mut self) -> f64 {
        (f64::from(self.next_u32()) + 0.5) / 4_294_967_296.0
    }

    /// Evenly between two values.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// How many independent normal numbers the table holds.
const TABLE: usize = 1 << 18;

/// The table's unit: sigma is this many.
const SIGMA: f64 = 4096.0;

/// Normally distributed numbers, sigma = 4096: computed once, then every row of every frame reads
/// on from a place of its own.
fn table() -> &'static [i16] {
    static VALUES: OnceLock<Vec<i16>> = OnceLock::new();
    VALUES.get_or_init(|| {
        let mut random = Seeded::new("noise table", 0, &[]);
        let mut values = Vec::with_capacity(TABLE);
        while values.len() < TABLE {
            // Box and Muller; the least unit is 2^-33, so no value is beyond 6.8 sigma
            let radius = SIGMA * libm::sqrt(-2.0 * libm::log(random.unit()));
            let angle = TAU * random.unit();
            values.push(libm::round(radius * libm::cos(angle)) as i16);
            values.push(libm::round(radius * libm::sin(angle)) as i16);
        }
        values
    })
}

/// The noise of one frame of one camera.
pub(crate) struct SensorNoise {
    random: Seeded,
    /// In 1/256 grey level.
    sigma_256: i32,
}

impl SensorNoise {
    pub(crate) fn new(seed: u64, frame: usize, camera: usize, sigma: f64) -> Self {
        Self {
            random: Seeded::new("sensor", seed, &[frame as u64, camera as u64]),
            sigma_256: libm::round(256.0 * sigma.clamp(0.0, 128.0)) as i32,
        }
    }

    /// Adds the next row's noise to `row` (in 1/256 grey level), rounds and clips.
    pub(crate) fn develop(&mut self, row: &[u16], out: &mut [u8]) {
        let round = |value: i32| ((value + 128) >> 8).clamp(0, 255) as u8;
        if self.sigma_256 == 0 {
            for (byte, &value) in out.iter_mut().zip(row) {
                *byte = round(i32::from(value));
            }
            return;
        }
        let mut start = self.random.next_u32() as usize % TABLE;
        let (mut row, mut out) = (row, out);
        // at most one turn past the table's end for any width below its length
        while !row.is_empty() {
            let noise = &table()[start..];
            let n = noise.len().min(row.len());
            for ((byte, &value), &noise) in out.iter_mut().zip(row).zip(noise) {
                *byte = round(i32::from(value) + ((i32::from(noise) * self.sigma_256) >> 12));
            }
            row = &row[n..];
            out = &mut out[n..];
            start = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_is_normal() {
        let n = TABLE as f64;
        let mean = table().iter().map(|&v| f64::from(v)).sum::<f64>() / n / SIGMA;
        let square = table().iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / n / SIGMA / SIGMA;
        let fourth = table().iter().map(|&v| (f64::from(v) / SIGMA).powi(4)).sum::<f64>() / n;
        assert!(mean.abs() < 0.01, "{mean}");
        assert!((square - 1.0).abs() < 0.01, "{square}");
        assert!((fourth - 3.0).abs() < 0.05, "{fourth}");
    }

    #[test]
    fn noise_has_the_sigma_asked_for_and_is_new_in_every_frame_and_camera() {
        let flat = vec![128 * 256; 64_000];
        let mut pictures = Vec::new();
        for (frame, camera) in [(0, 0), (1, 0), (0, 1)] {
            let mut out = vec![0; flat.len()];
            SensorNoise::new(7, frame, camera, 2.0).develop(&flat, &mut out);
            let n = out.len() as f64;
            let mean = out.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
            let variance = out.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n;
            assert!((mean - 128.0).abs() < 0.05, "{mean}");
            // rounding to whole levels adds 1/12
            assert!((variance - 4.0 - 1.0 / 12.0).abs() < 0.1, "{variance}");
            pictures.push(out);
        }
        assert_ne!(pictures[0], pictures[1]);
        assert_ne!(pictures[0], pictures[2]);
    }

    #[test]
    fn no_noise_only_rounds() {
        let mut out = [0; 4];
        SensorNoise::new(7, 0, 0, 0.0).develop(&[0, 127, 128, 65_535], &mut out);
        assert_eq!(out, [0, 0, 1, 255]);
    }
}
