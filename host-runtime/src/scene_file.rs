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
use std::ops::RangeInclusive;
use tetrad_core::config::{MAX_ARM_M, MIN_ARM_M};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};

/// Where the balls are in one camera's first frame, ordered as [`Ball::ALL`].
pub type Seeds = [Option<ImagePoint>; BALLS];

/// The frame rates a scene may give, in frames/s: beyond them a figure is a mistake of units.
pub const FPS: RangeInclusive<f64> = 0.1..=1000.0;

/// The balls a scene may have, by diameter in metres.
pub const BALL_DIAMETER_M: RangeInclusive<f64> = 0.001..=1.0;

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
        let raw: Raw = serde_json::from_str(text).map_err(|error| {
            not_finite(text, &error)
                .map_or_else(|| at("", error.to_string()), |(key, problem)| at(key, problem))
        })?;
        let in_range = |key: &str, value: Option<f64>, range: RangeInclusive<f64>, unit: &str| match value {
            Some(x) if !range.contains(&x) => {
                let (least, most) = range.into_inner();
                Err(at(key, format!("a number from {least} to {most} {unit} is needed, not {x:?}")))
            }
            x => Ok(x),
        };
        let fps = in_range("fps", raw.fps, FPS, "frames/s")?;
        let ball_diameter_m = in_range("ball_diameter_m", raw.ball_diameter_m, BALL_DIAMETER_M, "m")?;
        let arm_m = raw.arm_m.map(|x| x as f32);
        if let Some(x) = arm_m.filter(|x| !(MIN_ARM_M..=MAX_ARM_M).contains(x)) {
            return Err(at(
                "arm_m",
                format!("a number from {MIN_ARM_M} to {MAX_ARM_M} m is needed, not {x:?}"),
            ));
        }

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
        let ball_diameter_m = ball_diameter_m.map(|x| x as f32);
        Ok(Self { fps, arm_m, ball_diameter_m, rigid, left, right })
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

/// The key and the problem where the parser stumbled over a number that JSON does not have.
fn not_finite<'a>(text: &'a str, error: &serde_json::Error) -> Option<(&'a str, String)> {
    let line_at: usize = text.split_inclusive('\n').take(error.line().checked_sub(1)?).map(str::len).sum();
    // the parser counts bytes and stops at the word's first or, after a sign, its second
    let near = line_at + error.column();
    let is_part = |c: char| c.is_ascii_alphabetic() || c == '-' || c == '+';
    let (at, word) = [near.checked_sub(1)?, near].into_iter().find_map(|inside| {
        let (before, after) = text.split_at_checked(inside)?;
        let start = before.trim_end_matches(is_part).len();
        let length = after.find(|c| !is_part(c)).unwrap_or(after.len());
        let word = text.get(start..inside + length)?;
        let name = word.trim_start_matches(['-', '+']).to_ascii_lowercase();
        matches!(name.as_str(), "nan" | "inf" | "infinity").then_some((start, word))
    })?;
    let key = text[..at].rsplit_once(':').and_then(|(before, _)| before.rsplit('"').nth(1)).unwrap_or("");
    let (line, column) = (error.line(), at - line_at + 1);
    Some((key, format!("JSON has no {word}: a number is needed at line {line} column {column}")))
}

fn seeds(raw: &RawBalls) -> Seeds {
    // a coordinate beyond f32 becomes infinite and is outside every picture
    [raw.red, raw.green, raw.blue, raw.yellow]
        .map(|seed| seed.map(|[u, v]| ImagePoint::new(u as f32, v as f32)))
}

#[cfg(test)]
mod tests;
