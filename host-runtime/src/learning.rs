//! Learning in words a person can act on: which ball, where, why not, and how safe its colour is.

mod judged;

pub use judged::{Disc, Judged, judge, mistaken};

use crate::colours::BallColours;
use crate::pipeline::CameraStart;
use crate::scene_file::Seeds;
use std::fmt;
use tetrad_core::config::{LearnConfig, TrackerConfig};
use tetrad_core::geometry::ImagePoint;
use tetrad_core::observation::{BALLS, Ball};
use tetrad_core::vision::appearance::LearntBall;
use tetrad_core::vision::colour::Primary;
use tetrad_core::vision::frame::FrameView;
use tetrad_core::vision::learn::{LearnError, Learnt, learn};
use tetrad_core::vision::tracker::CameraTracker;

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

/// Learns every ball that has a seed, and makes sure that the tracker finds them all again with what was
/// learnt: in this one picture, so that it costs the frames that follow nothing.
///
/// # Errors
/// [`Refused`] with every ball that taught nothing, or nothing it could be found with.
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
    if refused.is_empty() {
        refused = lost_again(frame, &taught);
    }
    if refused.is_empty() { Ok(taught) } else { Err(Refused(refused)) }
}

/// The balls that the tracker does not find in the very picture they were learnt from.
fn lost_again(frame: &FrameView<'_>, taught: &Taught) -> Vec<(Ball, ImagePoint, LearnError)> {
    // each ball for itself: that they do not stand like one rigid frame is not a matter of colours
    let config = TrackerConfig { rigid: false, ..TrackerConfig::paper() };
    let start = start_with(taught);
    // a ball that cannot be tracked at all is refused by name where its tracker is made
    let Ok(mut tracker) = CameraTracker::new(config, start.balls) else { return Vec::new() };
    let mut places = Vec::new();
    for (ball, place) in Ball::ALL.into_iter().zip(start.places) {
        if let Some(place) = place {
            tracker.place(ball, place);
            places.push((ball, place));
        }
    }
    let report = tracker.step(frame, 0, &[None; BALLS]);
    let is_lost = |ball: Ball| !report.observations[ball.index()].state.is_measured();
    places.retain(|(ball, _)| is_lost(*ball));
    places.into_iter().map(|(ball, place)| (ball, place, LearnError::NotFoundAgain)).collect()
}

/// What the tracker takes of what was learnt: the size as eq. 1 shows it where it shows the ball, else
/// the outline's.
#[must_use]
pub fn tracked_as(learnt: &Learnt) -> LearntBall {
    LearntBall::of(learnt)
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

#[cfg(test)]
mod tests {
    use super::*;
    use tetrad_core::vision::frame::{PixelFormat, Rgb};
    use tetrad_fixtures::{Light, Scene};

    /// A lamp overhead lets the camera see the shadow side of every ball: there a typical pixel from the
    /// small bright part makes yellow look like red.
    #[test]
    fn a_ball_that_would_be_taken_for_another_is_refused() {
        let mut scene = Scene::named("static-32px").unwrap();
        scene.light = Light::side(0.45);
        scene.light.towards = [0.1, 0.1, 1.0].into();
        let mut rgb = Vec::new();
        scene.render_rgb(0, 1, &mut rgb);
        let frame = FrameView::packed(&rgb, scene.width, scene.height, PixelFormat::Rgb888).unwrap();
        let at = scene.truth(0, 1).map(|ball| {
            let (u, v) = ball.outline_centre;
            Some(ImagePoint::new(u as f32, v as f32))
        });
        let mut taught = learn_at(&frame, &at, &LearnConfig::default()).unwrap();
        let [Some(red), .., Some(yellow)] = &mut taught else { panic!("all four are taught") };
        red.reference.typical = Rgb::new(188, 29, 36);
        yellow.reference.typical = Rgb::new(221, 193, 44);
        let lost = lost_again(&frame, &taught);
        assert!(matches!(lost[..], [(Ball::Yellow, _, LearnError::NotFoundAgain)]), "{lost:?}");
        // alone it is taken for no other
        taught[Ball::Red.index()] = None;
        assert_eq!(lost_again(&frame, &taught), []);
    }
}
