//! Seeded stereo scenes of four coloured balls, with exact ground truth.
//!
//! The path of one frame:
//!
//! | stage | file | in -> out |
//! |---|---|---|
//! | scene by name | `scenes` | `"demo"` -> [`Scene`] |
//! | where the hand is | `motion` | time -> pose of the feature frame in the world |
//! | what a camera sees | `camera`, `outline` | spheres, fingers -> outlines in the picture |
//! | how bright it is | `light` | normal, light -> grey levels |
//! | what is behind | `background` | seed -> picture, kept between frames |
//! | the picture | `render`, `paint`, `noise` | outlines over background, blur, noise -> RGB888 |
//! | what is true | `truth` | the same outlines -> centre, diameter, visible share |
//! | as a device sends it | `formats` | RGB888 -> every pixel format of `tetrad-core` |
//! | what it was last time | `golden` | name, hash -> equal or not |
//!
//! Beside that, packets as stations send them ([`packets`]), tables of the arm ([`puma560`]), and a drive of one
//! ([`drive`]).
//!
//! Conventions: world x towards the cameras, y to the right as they see it, z up; metres, seconds,
//! radians. A camera looks along its z, x right, y down. Pixel centres are at integers, (0, 0) the
//! centre of the top-left pixel. Balls are ordered red, green, blue, yellow. A frame's time is the
//! middle of its exposure, and frame 0 is at time 0.
//!
//! A pixel's value is proportional to the light that fell on it (no gamma curve), so that a pixel
//! half covered by a ball has the mean of the ball's value and the background's.
//!
//! The same scene gives the same bytes on every machine and in every build: all arithmetic is IEEE
//! addition, multiplication, division and square root in a fixed order, every other function comes
//! from `libm`, every random number from a PCG generator with a fixed algorithm.
#![forbid(unsafe_code)]

mod background;
mod camera;
pub mod drive;
mod formats;
pub mod golden;
mod light;
mod motion;
mod noise;
mod occluder;
mod outline;
pub mod packets;
mod paint;
pub mod puma560;
mod render;
mod scene;
mod scenes;
mod truth;

pub use background::{Background, Picture};
pub use camera::Camera;
pub use formats::to_format;
pub use light::Light;
pub use motion::Motion;
pub use occluder::{Anchor, Occluder};
pub use scene::{Albedo, Distractor, Scene};
pub use truth::{BallTruth, HandTruth};

// The README's example is compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
