//! Light and how a ball reflects it.

use nalgebra::Vector3;

/// The exponent of the highlight is 2 to this power: five squarings, a spot about a quarter of the
/// ball wide.
const HIGHLIGHT_SQUARINGS: usize = 5;

/// One distant lamp and light from everywhere. All shares are of full light, under which a ball has
/// its albedo's grey levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Towards the lamp, in the world; of any length but zero.
    pub towards: Vector3<f64>,
    /// Share that comes from everywhere: what the shadow side has.
    pub ambient: f64,
    /// Share that comes from the lamp (Lambert's cosine law).
    pub diffuse: f64,
    /// The highlight's peak, as a share of white.
    pub specular: f64,
    /// The level of all light over time, (second, factor), straight between keys, constant outside.
    pub level: Vec<(f64, f64)>,
}

impl Light {
    /// The same from every side, without a highlight.
    #[must_use]
    pub fn even() -> Self {
        Self { towards: Vector3::x(), ambient: 1.0, diffuse: 0.0, specular: 0.0, level: Vec::new() }
    }

    /// A room: most light from everywhere, a lamp above, a highlight.
    #[must_use]
    pub fn room() -> Self {
        Self {
            towards: Vector3::new(0.6, 0.25, 0.75),
            ambient: 0.68,
            diffuse: 0.32,
            specular: 0.35,
            level: Vec::new(),
        }
    }

    /// A lamp at the side: the shadow side has `shadow` of full light.
    #[must_use]
    pub fn side(shadow: f64) -> Self {
        Self {
            towards: Vector3::new(0.35, -0.85, 0.4),
            ambient: shadow,
            diffuse: 1.0 - shadow,
            specular: 0.0,
            level: Vec::new(),
        }
    }

    /// The level at `time_s`.
    #[must_use]
    pub fn level_at(&self, time_s: f64) -> f64 {
        between_keys(&self.level, time_s).unwrap_or(1.0)
    }
}

/// The value at `t` of keys (t, value) in order of time: straight between, constant outside.
pub(crate) fn between_keys(keys: &[(f64, f64)], t: f64) -> Option<f64> {
    let after = keys.iter().position(|&(key, _)| key > t);
    match after {
        None => keys.last().map(|&(_, value)| value),
        Some(0) => keys.first().map(|&(_, value)| value),
        Some(i) => {
            let ((t0, v0), (t1, v1)) = (keys[i - 1], keys[i]);
            Some(v0 + (v1 - v0) * (t - t0) / (t1 - t0))
        }
    }
}

/// [`Light`] seen from one camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lamp {
    pub(crate) towards_in_camera: Vector3<f64>,
    pub(crate) ambient: f64,
    pub(crate) diffuse: f64,
    pub(crate) specular: f64,
}

impl Lamp {
    /// Grey levels of a sphere's surface: `normal` and `view` (towards the camera) are unit vectors.
    pub(crate) fn reflected(&self, albedo: [f64; 3], normal: &Vector3<f64>, view: &Vector3<f64>) -> [f64; 3] {
        let towards = &self.towards_in_camera;
        let cosine = normal.dot(towards).max(0.0);
        let share = self.ambient + self.diffuse * cosine;
        let mut white = 0.0;
        if self.specular > 0.0 {
            // Blinn's half-way vector
            let half = towards + view;
            let length2 = half.norm_squared();
            if length2 > 0.0 {
                let mut spot = normal.dot(&half).max(0.0) / libm::sqrt(length2);
                for _ in 0..HIGHLIGHT_SQUARINGS {
                    spot *= spot;
                }
                white = 255.0 * self.specular * spot;
            }
        }
        albedo.map(|a| a * share + white)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn level_is_straight_between_keys_and_constant_outside() {
        let light = Light { level: vec![(1.0, 1.0), (5.0, 0.5)], ..Light::even() };
        assert_eq!(light.level_at(0.0), 1.0);
        assert_eq!(light.level_at(3.0), 0.75);
        assert_eq!(light.level_at(9.0), 0.5);
        assert_eq!(Light::even().level_at(2.0), 1.0);
    }
}
