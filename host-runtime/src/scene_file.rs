//! `scene.json`: where each ball is in the first frame of a recording, and its facts.
//!
//! ```json
//! {"fps": 30, "arm_m": 0.08, "ball_diameter_m": 0.03, "rigid": true,
//!  "seeds": {"left": {"red": [312.4, 201.9], "green": [352, 204]},
//!            "right": {"red": [298.1, 203.3], "green": [340, 206]}}}
//! ```
//!
//! `seeds.left` is needed. A scene may name fewer than four balls: only those are tracked. `rigid` says
//! whether the balls are one frame that moves as a whole; without it they are when all four are there.
//! `fps` is needed for a source that has no times of its own.

use crate::balls::BallSet;
use serde::Deserialize;
use std::fmt;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};

/// Where the balls are in one camera's first frame, ordered as [`Ball::ALL`].
pub type Seeds = [Option<ImagePoint>; BALLS];

/// The largest frame rate a scene may give, in frames/s.
pub const MAX_FPS: f64 = 10_000.0;

/// The largest length a scene may give, in metres: a hand-held frame is far smaller.
pub const MAX_LENGTH_M: f64 = 10.0;

/// A checked scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// Frames per second, where the source has no times of its own.
    pub fps: Option<f64>,
    /// The length of E1, E2 and E3, in metres.
    pub arm_m: Option<f32>,
    /// A ball's diameter, in metres.
    pub ball_diameter_m: Option<f32>,
    /// Whether the balls are one rigid frame; `None` leaves it to the number of balls.
    pub rigid: Option<bool>,
    /// The left (or only) camera's seeds.
    pub left: Seeds,
    /// The right camera's seeds.
    pub right: Option<Seeds>,
}

/// Why a scene file is refused: the file, the key in it, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct SceneError {
    /// The file as it was named.
    pub file: String,
    /// The key, as `seeds.left.red`; empty when the whole file is meant.
    pub key: String,
    /// What is wrong, in words that say what would be right.
    pub problem: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, key, problem } = self;
        if key.is_empty() { write!(f, "{file}: {problem}") } else { write!(f, "{file}: {key}: {problem}") }
    }
}

/// The file as it is written, before any check of values.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    fps: Option<f64>,
    arm_m: Option<f64>,
    ball_diameter_m: Option<f64>,
    rigid: Option<bool>,
    seeds: RawSeeds,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSeeds {
    left: RawBalls,
    right: Option<RawBalls>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawBalls {
    red: Option<[f64; 2]>,
    green: Option<[f64; 2]>,
    blue: Option<[f64; 2]>,
    yellow: Option<[f64; 2]>,
}

impl SceneFile {
    /// Reads the text of a scene; `file` is only for messages.
    ///
    /// # Errors
    /// [`SceneError`] for text that is not JSON, unknown keys, values out of range, a camera without
    /// seeds, and two cameras that do not name the same balls.
    pub fn parse(text: &str, file: &str) -> Result<Self, SceneError> {
        let at = |key: &str, problem: String| SceneError { file: file.into(), key: key.into(), problem };
        let raw: Raw = serde_json::from_str(text).map_err(|e| at("", e.to_string()))?;
        let in_range = |key: &str, value: Option<f64>, max: f64, unit: &str| match value {
            Some(x) if !(x > 0.0 && x <= max) => {
                Err(at(key, format!("a number above 0 and up to {max} {unit} is needed, not {x}")))
            }
            x => Ok(x),
        };
        let fps = in_range("fps", raw.fps, MAX_FPS, "frames/s")?;
        let arm_m = in_range("arm_m", raw.arm_m, MAX_LENGTH_M, "m")?;
        let ball_diameter_m = in_range("ball_diameter_m", raw.ball_diameter_m, MAX_LENGTH_M, "m")?;

        let left = seeds(&raw.seeds.left);
        let right = raw.seeds.right.as_ref().map(seeds);
        for (camera, seeds) in [("left", Some(&left)), ("right", right.as_ref())] {
            if seeds.is_some_and(|seeds| BallSet::known(seeds).is_none()) {
                return Err(at(
                    &format!("seeds.{camera}"),
                    "it names no ball: at least one is needed".into(),
                ));
            }
        }
        if let Some(right) = &right {
            for ball in Ball::ALL {
                let (in_left, in_right) = (left[ball.index()].is_some(), right[ball.index()].is_some());
                if in_left != in_right {
                    let (has, lacks) = if in_left { ("left", "right") } else { ("right", "left") };
                    let name = ball.name();
                    return Err(at(
                        &format!("seeds.{lacks}.{name}"),
                        format!("the {name} ball is missing here and given in {has}: both cameras need it"),
                    ));
                }
            }
        }
        let rigid = raw.rigid;
        let metres = |x: Option<f64>| x.map(|x| x as f32);
        Ok(Self { fps, arm_m: metres(arm_m), ball_diameter_m: metres(ball_diameter_m), rigid, left, right })
    }

    /// The balls the scene names.
    #[must_use]
    pub fn balls(&self) -> BallSet {
        BallSet::known(&self.left).unwrap_or(BallSet::ALL)
    }
}

/// Checks that every seed lies in the picture.
///
/// # Errors
/// [`SceneError`] naming the ball and the picture's size.
pub fn check_seeds(seeds: &Seeds, camera: &str, size: (u16, u16), file: &str) -> Result<(), SceneError> {
    let (width, height) = size;
    for ball in Ball::ALL {
        let Some(seed) = seeds[ball.index()] else { continue };
        // pixel centres are integers, so the picture reaches half a pixel beyond the first and the last
        let inside = |x: f32, side: u16| x >= -0.5 && x < f32::from(side) - 0.5;
        if !(inside(seed.u, width) && inside(seed.v, height)) {
            return Err(SceneError {
                file: file.into(),
                key: format!("seeds.{camera}.{}", ball.name()),
                problem: format!(
                    "the {} ball's seed ({}, {}) is outside the {camera} picture of {width}x{height} pixels",
                    ball.name(),
                    seed.u,
                    seed.v
                ),
            });
        }
    }
    Ok(())
}

fn seeds(raw: &RawBalls) -> Seeds {
    // a coordinate beyond f32 becomes infinite and is outside every picture
    [raw.red, raw.green, raw.blue, raw.yellow]
        .map(|seed| seed.map(|[u, v]| ImagePoint::new(u as f32, v as f32)))
}

#[cfg(test)]
mod tests;
