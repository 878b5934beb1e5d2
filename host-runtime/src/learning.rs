//! Learning in words a person can act on: which ball, where, why not, and how safe its colour is.

use crate::colours::BallColours;
use crate::pipeline::CameraStart;
use crate::scene_file::Seeds;
use std::fmt;
use tetrad_core::config::LearnConfig;
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::{LearnError, Learnt, learn};

/// Up to four balls taught in one camera, ordered as [`Ball::ALL`].
pub type Taught = [Option<Learnt>; BALLS];

/// The points at which nothing was learnt, by ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Refused(pub Vec<(Ball, ImagePoint, LearnError)>);

impl Refused {
    /// Whether a point lies outside the picture: then the argument is wrong, not the picture.
    #[must_use]
    pub fn outside(&self) -> bool {
        self.0.iter().any(|(.., error)| *error == LearnError::Outside)
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (ball, at, error)) in self.0.iter().enumerate() {
            let separator = if i > 0 { "\n" } else { "" };
            let name = ball.name();
            write!(f, "{separator}{name} at ({}, {}): {error}", at.u, at.v)?;
            // a background a little of the ball's colour is an outline too, and a large one
            if matches!(error, LearnError::TooLarge | LearnError::NoContrast) {
                write!(f, " (is the point inside the {name} ball?)")?;
            }
        }
        Ok(())
    }
}

impl std::error::Error for Refused {}

/// Learns every ball that has a seed.
///
/// # Errors
/// [`Refused`] with every ball that taught nothing.
pub fn learn_at(frame: &FrameView<'_>, seeds: &Seeds, config: &LearnConfig) -> Result<Taught, Refused> {
    let mut taught = [None; BALLS];
    let mut refused = Vec::new();
    for ball in Ball::ALL {
        let Some(at) = seeds[ball.index()] else { continue };
        match learn(frame, Primary::of(ball), at, config) {
            Ok(learnt) => taught[ball.index()] = Some(learnt),
            Err(error) => refused.push((ball, at, error)),
        }
    }
    if refused.is_empty() { Ok(taught) } else { Err(Refused(refused)) }
}

/// What the tracker takes of what was learnt: the size as eq. 1 shows it where it shows the ball, else
/// the outline's.
#[must_use]
pub fn tracked_as(learnt: &Learnt) -> LearntBall {
    let (diameter, aspect) = match &learnt.blob {
        Ok(blob) if !blob.cut => (blob.diameter, blob.height / blob.diameter),
        _ => (learnt.diameter, 1.0),
    };
    LearntBall { reference: learnt.reference, diameter, aspect }
}

/// A camera that starts on the very frame its balls were learnt from.
#[must_use]
pub fn start_with(taught: &Taught) -> CameraStart {
    CameraStart {
        balls: taught.map(|learnt| learnt.as_ref().map(tracked_as)),
        places: taught.map(|learnt| learnt.map(|learnt| learnt.centre)),
        focal_px: None,
    }
}

/// The entry of colours.toml for what was learnt.
#[must_use]
pub fn as_colours(learnt: &Learnt) -> BallColours {
    BallColours { learnt: tracked_as(learnt), at: Some(learnt.centre) }
}

/// The clash score in words: how much of the rest of the picture has the ball's colour too.
#[must_use]
pub fn clash_in_words(permille: u16) -> &'static str {
    match permille {
        0 => "nothing else in the picture looks like it",
        1..=9 => "little else in the picture looks like it",
        10..=49 => "some of the rest of the picture looks like it",
        50..=149 => "much of the rest of the picture looks like it: a plainer background is safer",
        _ => "most of what is around has its colour: change the background, the light or the ball",
    }
}
